//! A wall that grows outward from quadrilaterals: layers of hexahedra over any surface, with branches or without.
//!
//! Over each group of n by n faces stands a stack of elements. Its inner side passes through all points of the group:
//! it is their interpolation of degree n in both directions. The outer surfaces lie at the distances of the thicknesses
//! along the normals, which are interpolated likewise. A group of a single face has curved sides as well: cubics that
//! leave its corners at right angles to the normals there. On a lumen that is known between the points as well, the
//! elements are moved onto it there.

mod axis;
mod fitted;
mod grouping;
mod surface;

#[cfg(test)]
use grouping::Quads;
pub use grouping::{Group, Ungrouped};
pub use surface::{SurfaceError, WetQuads};

use super::tree::Lumen;
use super::{HexFace, HexMesh, HexShape, WallDirections};
use crate::Vec3;
use fitted::Fit;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Most faces along a side of an element where the user says nothing.
const MOST_FACES: usize = 4;

/// How a wall grows from a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// Faces along each side of an element; the most that fit up to 4 if not given.
    pub faces: Option<usize>,
    /// Elements through each layer.
    pub elements_per_layer: usize,
    /// Thickness (m) of each layer at each point of the surface.
    pub thicknesses: Vec<Vec<f64>>,
    /// Region of each layer, for each of the surface's patches.
    pub regions: Vec<Vec<usize>>,
    /// What each of these patches is called in the names of [parts of the outer side](outer_side_of).
    pub parts: Vec<String>,
    /// Outward unit normals at the points of the surface.
    pub normals: Vec<Vec3>,
    /// Directions along the vessel at the points; if there are none, elements follow the rows of faces along which the
    /// surface bends less.
    pub axes: Option<Vec<Vec3>>,
}

/// Why no wall grows.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum GrowthError {
    /// The faces cannot be grouped as asked.
    #[error(
        "the faces of the wet patches cannot be grouped {asked} by {asked} into elements: near ({:.4e}, {:.4e}, {:.4e}) m, \
         {}; {}", .found.near.x, .found.near.y, .found.near.z, .found.reason, possible(.fitting)
    )]
    Ungrouped {
        /// Faces along each side of an element.
        asked: usize,
        /// Where, and why.
        found: Ungrouped,
        /// Numbers that are possible.
        fitting: Vec<usize>,
    },
    /// A name of a rim that the wall itself has.
    #[error(
        "a patch that the wall ends at is called {0:?}, as a surface of every extruded wall is: give the patch another name"
    )]
    Name(String),
}

/// Name of the outer side of an extruded wall over one part of its surface.
pub fn outer_side_of(part: &str) -> String {
    format!("outer:{part}")
}

/// Whether a surface of an extruded wall is one of its sides, not a rim.
pub fn is_side(name: &str) -> bool {
    matches!(name, "inner" | "outer") || name.starts_with("outer:")
}

fn possible(fitting: &[usize]) -> String {
    let numbers: Vec<String> = fitting.iter().map(usize::to_string).collect();
    match &numbers[..] {
        [] => "no number is possible".into(),
        numbers => format!("possible are {}", numbers.join(", ")),
    }
}

impl WetQuads {
    /// A wall on this surface. Its surfaces are `inner`, `outer`, the [parts](outer_side_of) of that, and its rims by the
    /// names of the patches there. Local
    /// coordinates of an element: 0 and 1 along the surface, 0 the one along which it bends less; 2 outward. If the
    /// points lie on a known lumen, the elements' inner side does so between them as well.
    ///
    /// # Errors
    /// See [`GrowthError`].
    pub fn wall(&self, growth: &Growth, lumen: Option<&Lumen>) -> Result<HexMesh, GrowthError> {
        let (n, groups) = self.groups(growth.faces)?;
        let groups: Vec<Group> = groups
            .into_iter()
            .map(|group| along_the_lesser_bend(group, n, &self.quads.points, &growth.normals))
            .collect();
        let mut shape = Layers::new(self, growth, n, &groups);
        shape.fit = lumen.map(|lumen| Fit::new(self, &groups, n, &shape, lumen));
        let (layers, per_layer) = (growth.thicknesses.len(), growth.elements_per_layer);
        let through = layers * per_layer;

        let mut corners: HashMap<usize, usize> = HashMap::new();
        let corner_of =
            |group: &Group, v: usize| group.points[(v & 1) * n + (v >> 1 & 1) * n * (n + 1)];
        for group in &groups {
            for v in 0..4 {
                let next = corners.len();
                corners.entry(corner_of(group, v)).or_insert(next);
            }
        }
        let mut mesh = HexMesh {
            vertices: vec![Vec3::zeros(); corners.len() * (through + 1)],
            hexes: Vec::new(),
            regions: Vec::new(),
            surfaces: BTreeMap::from([("inner".into(), vec![]), ("outer".into(), vec![])]),
            directions: WallDirections::Local,
            shape: Arc::new(shape.clone()),
        };
        if let Some(axes) = &growth.axes {
            let of = |group: &Group| std::array::from_fn(|v| axes[corner_of(group, v & 3)]);
            let stacks = groups.iter().flat_map(|group| vec![of(group); through]);
            mesh.directions = WallDirections::Axial(stacks.collect());
        }
        for group in &groups {
            let rims = self.rims_of(group, n);
            for k in 0..through {
                let element = mesh.hexes.len();
                let hex: [usize; 8] = std::array::from_fn(|v| {
                    corners[&corner_of(group, v)] * (through + 1) + k + (v >> 2 & 1)
                });
                for (v, &vertex) in hex.iter().enumerate() {
                    let xi = [v & 1, v >> 1 & 1, v >> 2 & 1].map(|bit| 2.0 * bit as f64 - 1.0);
                    mesh.vertices[vertex] = shape.position(element, xi);
                }
                mesh.hexes.push(hex);
                mesh.regions
                    .push(growth.regions[self.patches[group.face]][k / per_layer]);
                let mut name = |name: &str, axis: u8, upper: bool| {
                    let faces = mesh.surfaces.entry(name.to_owned()).or_default();
                    faces.push((element, HexFace { axis, upper }));
                };
                if k == 0 {
                    name("inner", 2, false);
                }
                if k == through - 1 {
                    name("outer", 2, true);
                    let part = &growth.parts[self.patches[group.face]];
                    name(&outer_side_of(part), 2, true);
                }
                for (patch, axis, upper) in &rims {
                    if is_side(patch) {
                        return Err(GrowthError::Name((*patch).to_owned()));
                    }
                    name(patch, *axis, *upper);
                }
            }
        }
        Ok(mesh)
    }

    /// Groups of as many faces as asked, or of the most that fit.
    fn groups(&self, asked: Option<usize>) -> Result<(usize, Vec<Group>), GrowthError> {
        let numbers = match asked {
            Some(n) => vec![n],
            None => (1..=MOST_FACES).rev().collect(),
        };
        let mut refused = None;
        for &n in &numbers {
            match self.quads.grouped(n) {
                Ok(groups) => return Ok((n, groups)),
                Err(found) => drop(refused.get_or_insert((n, found))),
            }
        }
        let (asked, found) = refused.expect("one number was tried");
        let fitting = (1..asked).filter(|&n| self.quads.grouped(n).is_ok());
        Err(GrowthError::Ungrouped {
            asked,
            found,
            fitting: fitting.collect(),
        })
    }

    /// The sides of a group that lie at a rim: patch, axis, whether at its upper end.
    fn rims_of(&self, group: &Group, n: usize) -> Vec<(&str, u8, bool)> {
        let at = |i: usize, j: usize| group.points[i + (n + 1) * j];
        let sides = [
            ((at(0, 0), at(1, 0)), 1, false),
            ((at(n, 0), at(n, 1)), 0, true),
            ((at(n, n), at(n - 1, n)), 1, true),
            ((at(0, n), at(0, n - 1)), 0, false),
        ];
        let sides = sides.into_iter();
        sides
            .filter_map(|(edge, axis, upper)| Some((self.rim.get(&edge)?.as_str(), axis, upper)))
            .collect()
    }
}

/// The group turned so that its first direction is the one along which the normals turn less for each metre.
fn along_the_lesser_bend(group: Group, n: usize, points: &[Vec3], normals: &[Vec3]) -> Group {
    let at = |i: usize, j: usize| group.points[i + (n + 1) * j];
    let bend = |a: usize, b: usize| {
        (normals[a] - normals[b]).norm() / (points[a] - points[b]).norm().max(f64::MIN_POSITIVE)
    };
    let first = bend(at(0, 0), at(n, 0)) + bend(at(0, n), at(n, n));
    let second = bend(at(0, 0), at(0, n)) + bend(at(n, 0), at(n, n));
    if first <= second {
        return group;
    }
    // The first direction becomes the old second one, the second the opposite of the old first.
    let turned = (0..(n + 1) * (n + 1)).map(|p| {
        let (i, j) = (p % (n + 1), p / (n + 1));
        at(n - j, i)
    });
    Group {
        points: turned.collect(),
        ..group
    }
}

/// Shape of the elements over groups of faces.
#[derive(Debug, Clone)]
struct Layers {
    /// Faces along a side of a group.
    n: usize,
    /// Nodes of each group along a side, and where they lie from -1 to 1.
    nodes: Vec<f64>,
    /// Points and normals at the nodes of each group.
    surfaces: Vec<Vec<(Vec3, Vec3)>>,
    /// Distance (m) of the surfaces between layers at the nodes of each group, from the inner surface on.
    heights: Vec<Vec<Vec<f64>>>,
    elements_per_layer: usize,
    /// What is added to that on a known lumen.
    fit: Option<Fit>,
}

impl Layers {
    fn new(surface: &WetQuads, growth: &Growth, n: usize, groups: &[Group]) -> Self {
        let (points, normals) = (&surface.quads.points, &growth.normals);
        let mut below = vec![vec![0.0; points.len()]];
        for layer in &growth.thicknesses {
            let inner = below.last().expect("there is one");
            let outer = inner.iter().zip(layer).map(|(a, b)| a + b);
            below.push(outer.collect());
        }
        if n > 1 {
            let of = |group: &Group| {
                group
                    .points
                    .iter()
                    .map(|&p| (points[p], normals[p]))
                    .collect()
            };
            let heights = |group: &Group| {
                let level = |level: &Vec<f64>| group.points.iter().map(|&p| level[p]).collect();
                below.iter().map(level).collect()
            };
            return Self {
                n,
                nodes: equidistant(n),
                surfaces: groups.iter().map(of).collect(),
                heights: groups.iter().map(heights).collect(),
                elements_per_layer: growth.elements_per_layer,
                fit: None,
            };
        }
        // Curved by the normals: sampled as a group of three by three.
        let n = 3;
        let nodes = equidistant(n);
        let lattice = |corners: [f64; 4]| -> Vec<f64> {
            let at = |k: usize| 0.5 * (1.0 + nodes[k]);
            let points = (0..(n + 1) * (n + 1)).map(|p| (at(p % (n + 1)), at(p / (n + 1))));
            let [a, b, c, d] = corners;
            let value = |(s, t)| (1.0 - t) * ((1.0 - s) * a + s * b) + t * ((1.0 - s) * c + s * d);
            points.map(value).collect()
        };
        let heights = |group: &Group| {
            let level = |level: &Vec<f64>| lattice(std::array::from_fn(|v| level[group.points[v]]));
            below.iter().map(level).collect()
        };
        let of = |group: &Group| {
            let corner = |v: usize| (points[group.points[v]], normals[group.points[v]]);
            curved_face(std::array::from_fn(corner), &nodes)
        };
        Self {
            n,
            surfaces: groups.iter().map(of).collect(),
            heights: groups.iter().map(heights).collect(),
            nodes,
            elements_per_layer: growth.elements_per_layer,
            fit: None,
        }
    }

    /// A place of the inner side of a group before it is fitted, m.
    fn inner(&self, group: usize, xi: [f64; 2]) -> Vec3 {
        let [along, across] = xi.map(|x| crate::lagrange::values(&self.nodes, x));
        let points = self.surfaces[group].iter().enumerate();
        points.fold(Vec3::zeros(), |sum, (p, (x, _))| {
            sum + x * (along[p % (self.n + 1)] * across[p / (self.n + 1)])
        })
    }
}

pub(super) fn equidistant(n: usize) -> Vec<f64> {
    (0..=n).map(|i| 2.0 * i as f64 / n as f64 - 1.0).collect()
}

/// Points and unit normals of a face with curved sides at a lattice of nodes: cubics along the sides (Vlachos and
/// others, *Curved PN triangles*, 2001), blended (Coons); normals blended from the corners.
fn curved_face(corners: [(Vec3, Vec3); 4], nodes: &[f64]) -> Vec<(Vec3, Vec3)> {
    let side = |a: usize, b: usize, s: f64| {
        let ((x, m), (y, n)) = (corners[a], corners[b]);
        let chord = y - x;
        let after = x + (chord - m * chord.dot(&m)) / 3.0;
        let before = y - (chord - n * chord.dot(&n)) / 3.0;
        let r = 1.0 - s;
        x * r.powi(3) + after * (3.0 * r * r * s) + before * (3.0 * r * s * s) + y * s.powi(3)
    };
    let at = |s: f64, t: f64| {
        let [p, q] = [1.0 - s, 1.0 - t];
        let x = |v: usize| corners[v].0;
        let sides = side(0, 1, s) * q + side(2, 3, s) * t + side(0, 2, t) * p + side(1, 3, t) * s;
        let linear = (x(0) * p + x(1) * s) * q + (x(2) * p + x(3) * s) * t;
        let normal = |v: usize| corners[v].1;
        let across = (normal(0) * p + normal(1) * s) * q + (normal(2) * p + normal(3) * s) * t;
        (sides - linear, across.normalize())
    };
    let share = |k: usize| 0.5 * (1.0 + nodes[k]);
    let n = nodes.len();
    (0..n * n).map(|p| at(share(p % n), share(p / n))).collect()
}

impl HexShape for Layers {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let layers = self.heights[0].len() - 1;
        let through = layers * self.elements_per_layer;
        let (group, k) = (element / through, element % through);
        let layer = k / self.elements_per_layer;
        let step = (k % self.elements_per_layer) as f64 + 0.5 * (1.0 + xi[2]);
        let share = step / self.elements_per_layer as f64;
        let [along, across] = [0, 1].map(|d| crate::lagrange::values(&self.nodes, xi[d]));
        let [below, above] = [layer, layer + 1].map(|level| &self.heights[group][level]);
        let mut position = Vec3::zeros();
        for (p, (x, normal)) in self.surfaces[group].iter().enumerate() {
            let weight = along[p % (self.n + 1)] * across[p / (self.n + 1)];
            let height = (1.0 - share) * below[p] + share * above[p];
            position += (x + normal * height) * weight;
        }
        match &self.fit {
            Some(fit) => position + fit.at(group, [xi[0], xi[1]]),
            None => position,
        }
    }
}

#[cfg(test)]
mod tests;
