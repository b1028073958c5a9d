//! A tree as the table `[tree]` of a case describes it.

use super::{Carried, Lumen, SectionGrid, Tree, TreeError};
use crate::Vec3;
use crate::case::{TreeKeys, listed};
use crate::curve::{CentreLine, SpaceCurve};
use crate::geometry::{PolyMesh, WallPolygons};
use crate::polydata::SurfaceSearch;
use std::sync::Arc;

/// The lumen of a case in cells.
pub struct TreeMeshes {
    /// The corners of the wall's faces lie outside the surface, so that polygons enclose what the round wall does.
    pub outside: PolyMesh,
    /// The same mesh with these on the surface.
    pub surface: PolyMesh,
    /// Which of them are those of a cross-section.
    pub polygons: WallPolygons,
    /// What is meshed.
    pub lumen: Lumen,
    /// The smallest scaled Jacobian of a cell, and where that is, m.
    pub worst: (f64, Vec3),
    /// What a user should know of its junctions and lines, in sentences.
    pub notes: Vec<String>,
    /// Centre-lines of the branches, each with the patch of its wall.
    pub lines: Vec<(String, SpaceCurve)>,
}

/// Why the tree of a case has no mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{text}")]
pub struct TreeMistake {
    /// Where, and what is wrong.
    text: String,
    key: &'static str,
    error: TreeError,
}

impl TreeMistake {
    fn new(keys: &TreeKeys, error: TreeError) -> Self {
        let (text, key) = match (keys.off_centre(), &error) {
            (_, TreeError::Surface(_)) => (error.to_string(), "tree.lumen_triangles"),
            (_, TreeError::Beyond(..)) => (error.to_string(), "tree.feature"),
            (Some(cause), _) => (
                format!("{cause}; there is no mesh: {}", error.briefly()),
                "tree.lumen",
            ),
            (None, _) => (format!("{}{error}", branches(keys, &error)), "tree.lines"),
        };
        Self { text, key, error }
    }

    /// Whether smoother lines may help.
    pub fn is_of_shape(&self) -> bool {
        matches!(
            self.error,
            TreeError::Bend(..)
                | TreeError::InsideOut(_)
                | TreeError::Open(_)
                | TreeError::Apex(_)
                | TreeError::Angle(_)
                | TreeError::Neck(_)
                | TreeError::Parting(..)
                | TreeError::Close(..)
        )
    }

    /// The key to blame.
    pub fn key(&self) -> &'static str {
        self.key
    }
}

/// Where something is wrong, in words.
fn branches(keys: &TreeKeys, error: &TreeError) -> String {
    let names = keys.names();
    if let TreeError::Within(line, other, _) = error {
        let [line, other] = [line, other].map(|line| &names[1 + line]);
        return format!(
            "the line to \"{line}\" stays within the lumen around that to \"{other}\": leave it out (tree.leave_out = \
             [\"{line}\"]), or continue it; "
        );
    }
    let Some(x) = error.place() else {
        return String::new();
    };
    let is_there = |line: &CentreLine| {
        let foot = line.foot(&x);
        foot.distance < NEAR * foot.radius
    };
    let lines = lines(keys);
    let there = (lines.iter().zip(&names[1..])).filter(|(line, _)| is_there(line));
    let there: Vec<&str> = there.map(|(_, name)| name.as_str()).collect();
    match there.is_empty() {
        true => String::new(),
        false => format!("on the way to {}: ", few(&there)),
    }
}

/// The first of these ends, in a message.
fn few(names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    listed(&quoted, MOST_NAMED)
}

/// Most ends that a message names.
const MOST_NAMED: usize = 6;
/// A place belongs to the lines that are nearer than so many radii.
const NEAR: f64 = 1.2;

impl Tree {
    /// In the cells of a case.
    ///
    /// # Errors
    /// If the lumen cannot be meshed.
    pub fn of_cells(keys: &TreeKeys) -> Result<Self, TreeMistake> {
        let (grid, length) = cell_grid(keys);
        Self::described(keys, grid, length)
    }

    /// The lumen of a case in cells.
    ///
    /// # Errors
    /// If it cannot be meshed.
    pub fn meshes(keys: &TreeKeys) -> Result<TreeMeshes, TreeMistake> {
        let tree = Self::of_cells(keys)?;
        let [names, walls] = [keys.names(), keys.walls()];
        let outside = tree
            .mesh(&names, &walls, tree.grid().growth_of_polygon())
            .map_err(|error| TreeMistake::new(keys, error))?;
        let (points, numbers) = tree.points(1.0);
        let polygons = tree.polygons(&points, &numbers);
        let surface = PolyMesh {
            points,
            ..outside.clone()
        };
        let lines = tree.lines().into_iter();
        let qualities = tree.qualities().into_iter();
        let worst = qualities.min_by(|a, b| a.0.total_cmp(&b.0));
        Ok(TreeMeshes {
            outside,
            surface,
            polygons,
            lumen: tree.slicer.lumen.clone(),
            worst: worst.unwrap_or((1.0, Vec3::zeros())),
            notes: (tree.shared_junctions().iter())
                .map(|found| shared(found, &names))
                .chain(keys.off_centre())
                .collect(),
            lines: lines
                .map(|(wall, line)| (walls[wall].clone(), line))
                .collect(),
        })
    }

    /// In the elements of a case, whose nodes lie at `nodes` in [-1, 1].
    ///
    /// # Errors
    /// If the lumen cannot be meshed.
    pub fn of_elements(keys: &TreeKeys, nodes: &[f64]) -> Result<Self, TreeMistake> {
        let (grid, length) = element_grid(keys, nodes);
        let tree = Self::described(keys, grid, length)?;
        let valid = tree.validate();
        valid.map_err(|error| TreeMistake::new(keys, error))?;
        Ok(tree)
    }

    /// The ends of a case that have to be left out so that the others have a mesh in cells and in elements, whose nodes
    /// lie at `nodes` in [-1, 1], and why; and the smallest scaled
    /// Jacobian of what is left. `flows` are those through the ends.
    ///
    /// # Errors
    /// If less than two ends would be left.
    pub fn impossible_ends(
        keys: &TreeKeys,
        flows: Vec<f64>,
        nodes: &[f64],
    ) -> Result<(Vec<(String, TreeError)>, f64), TreeMistake> {
        let grids = [cell_grid(keys), element_grid(keys, nodes)];
        let lumen = lumen(keys).map_err(|error| TreeMistake::new(keys, error))?;
        let carried = Carried::new(lumen, flows, &grids);
        let carried = carried.map_err(|error| TreeMistake::new(keys, error))?;
        let names = keys.names();
        let left_out = carried.left_out.into_iter();
        let left_out = left_out.map(|(line, reason)| (names[1 + line].clone(), reason));
        Ok((left_out.collect(), carried.worst))
    }

    fn described(keys: &TreeKeys, grid: SectionGrid, length: f64) -> Result<Self, TreeMistake> {
        let tree = lumen(keys).and_then(|lumen| Self::new(lumen, grid, length));
        tree.map_err(|error| TreeMistake::new(keys, error))
    }
}

/// That more than two daughters leave at one place.
fn shared((x, daughters): &(Vec3, Vec<usize>), names: &[String]) -> String {
    let towards: Vec<&str> = (daughters.iter())
        .map(|line| names[1 + line].as_str())
        .collect();
    format!(
        "{} branches, on the way to {}, part within 1.5 radii: they leave at one junction, at ({:.4}, {:.4}, {:.4}) m",
        towards.len(),
        few(&towards),
        x.x,
        x.y,
        x.z
    )
}

/// In the dome of a sac the surface comes nearer by more than this share of the way along the line.
const NEARER: f64 = 0.5;

fn lines(keys: &TreeKeys) -> Vec<CentreLine> {
    let names = keys.names();
    let lines = keys.line.iter().flatten().zip(&names[1..]);
    let lines = lines.map(|(line, name)| {
        let points: Vec<Vec3> = line.points.iter().map(|x| Vec3::from(*x)).collect();
        let mut centre_line = CentreLine::new(&points, &line.radii);
        centre_line.is_closed = keys.closed.contains(name);
        centre_line
    });
    lines.collect()
}

fn lumen(keys: &TreeKeys) -> Result<Lumen, TreeError> {
    let surface = keys.lumen_surface().map_err(TreeError::Surface)?;
    let surface = surface.map(|surface| Arc::new(SurfaceSearch::new(surface)));
    let mut lines = lines(keys);
    if let Some(surface) = &surface {
        let closed = lines.iter_mut().filter(|line| line.is_closed);
        closed.for_each(|line| *line = within_dome(line, surface));
    }
    Lumen::new(lines, surface).with_features(keys)
}

/// A closed line as far as the middle of the dome at its end: beyond that the surface comes nearer along it.
fn within_dome(line: &CentreLine, surface: &SurfaceSearch) -> CentreLine {
    let places: Vec<f64> = line.places().collect();
    let room = |s: f64| {
        let x = line.at(s);
        (surface.nearest(&x) - x).norm()
    };
    let mut end = places.len() - 1;
    let mut ahead = room(places[end]);
    while end > 1 {
        let before = room(places[end - 1]);
        if before - ahead < NEARER * (places[end] - places[end - 1]) {
            break;
        }
        (end, ahead) = (end - 1, before);
    }
    let mut dome = line.part(0.0, places[end]);
    dome.is_closed = true;
    dome
}

/// Usual or given cells, and their length in radii.
pub(super) fn cell_grid(keys: &TreeKeys) -> (SectionGrid, f64) {
    let grid = SectionGrid::of_cells(
        keys.core.unwrap_or(6),
        keys.radial.unwrap_or(5),
        keys.wall_grading.unwrap_or(3.0),
    );
    (grid, keys.length.unwrap_or(0.4))
}

/// Usual or given elements, and their length in radii.
fn element_grid(keys: &TreeKeys, nodes: &[f64]) -> (SectionGrid, f64) {
    let elements = keys.elements();
    let grid = SectionGrid::of_elements(
        elements.core.unwrap_or(2),
        elements.radial.unwrap_or(2),
        elements.wall_grading.unwrap_or(1.5),
        nodes,
    );
    (grid, elements.length.unwrap_or(1.0))
}
