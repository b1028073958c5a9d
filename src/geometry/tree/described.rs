//! A tree as the table `[tree]` of a case describes it.

use super::{CentreLine, Lumen, SectionGrid, Tree, TreeError};
use crate::Vec3;
use crate::case::TreeKeys;
use crate::curve::SpaceCurve;
use crate::geometry::{PolyMesh, WallPolygons};

/// The lumen of a case in cells.
pub struct TreeMeshes {
    /// The corners of the wall's faces lie outside the surface, so that polygons enclose what the round wall does.
    pub outside: PolyMesh,
    /// The same mesh with these on the surface.
    pub surface: PolyMesh,
    /// Which of them are those of a cross-section.
    pub polygons: WallPolygons,
    /// Centre-lines of the branches, each with the patch of its wall.
    pub lines: Vec<(String, SpaceCurve)>,
}

impl Tree {
    /// In the cells of a case.
    ///
    /// # Errors
    /// If the lumen cannot be meshed.
    pub fn of_cells(keys: &TreeKeys) -> Result<Self, TreeError> {
        let grid = SectionGrid::of_cells(
            keys.core.unwrap_or(6),
            keys.radial.unwrap_or(5),
            keys.wall_grading.unwrap_or(3.0),
        );
        Self::new(lumen(keys), grid, keys.length.unwrap_or(0.4))
    }

    /// The lumen of a case in cells.
    ///
    /// # Errors
    /// If it cannot be meshed.
    pub fn meshes(keys: &TreeKeys) -> Result<TreeMeshes, TreeError> {
        let tree = Self::of_cells(keys)?;
        let [names, walls] = [keys.names(), keys.walls()];
        let outside = tree.mesh(&names, &walls, tree.grid().growth_of_polygon())?;
        let (points, numbers) = tree.points(1.0);
        let polygons = tree.polygons(&points, &numbers);
        let surface = PolyMesh {
            points,
            ..outside.clone()
        };
        let lines = tree.lines().into_iter();
        Ok(TreeMeshes {
            outside,
            surface,
            polygons,
            lines: lines
                .map(|(wall, line)| (walls[wall].clone(), line))
                .collect(),
        })
    }

    /// In the elements of a case, whose nodes lie at `nodes` in [-1, 1].
    ///
    /// # Errors
    /// If the lumen cannot be meshed.
    pub fn of_elements(keys: &TreeKeys, nodes: &[f64]) -> Result<Self, TreeError> {
        let elements = keys.elements();
        let grid = SectionGrid::of_elements(
            elements.core.unwrap_or(2),
            elements.radial.unwrap_or(2),
            elements.wall_grading.unwrap_or(1.5),
            nodes,
        );
        Self::new(lumen(keys), grid, elements.length.unwrap_or(1.0))
    }
}

fn lumen(keys: &TreeKeys) -> Lumen {
    let lines = keys.line.iter().flatten().map(|line| {
        let points: Vec<Vec3> = line.points.iter().map(|x| Vec3::from(*x)).collect();
        CentreLine::new(&points, &line.radii)
    });
    Lumen {
        lines: lines.collect(),
    }
}
