//! Hexahedra with curved shape, as the structural solver takes them.

mod block;
mod tube;

pub use block::block_mesh;
pub use tube::{Surfaces, WallGrid, equal_stations, tube_mesh};

use crate::Vec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Exact position of a point of an element; the structural solver interpolates it along the edges.
pub trait HexShape: Send + Sync {
    /// Position (m) of the point with local coordinates `xi` in [-1, 1]³ of `element`.
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3;
}

/// A face of a hexahedron: the one where local coordinate `axis` (0, 1, 2) is -1 or +1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct HexFace {
    /// The local coordinate that is constant on the face.
    pub axis: u8,
    /// `true` for the face at +1, `false` for the face at -1.
    pub upper: bool,
}

/// Directions of a wall, from which those of its fibres follow.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum WallDirections {
    /// Local coordinate 0 runs along the vessel, 1 around it.
    #[default]
    Local,
    /// The direction along the vessel at the vertices of each element, trilinear in between; what of it lies in the
    /// surface of the local coordinates 0 and 1 counts.
    Axial(Vec<[Vec3; 8]>),
    /// Directions along the vessel and around it in each element.
    Given(Vec<[Vec3; 2]>),
}

impl WallDirections {
    /// Two tangents at the point `xi` of an element whose local coordinates 0 and 1 run along `g0` and `g1`: the first
    /// along the vessel, the second to that side of it to which the way around goes.
    pub fn tangents(&self, element: usize, xi: [f64; 3], g0: Vec3, g1: Vec3) -> [Vec3; 2] {
        match self {
            Self::Local => [g0, g1],
            Self::Axial(vertices) => {
                let weight = |v: usize| -> f64 {
                    let half =
                        |d: usize| 0.5 * (1.0 + if v >> d & 1 == 1 { xi[d] } else { -xi[d] });
                    (0..3).map(half).product()
                };
                let corners = vertices[element].iter().enumerate();
                let along: Vec3 = corners.map(|(v, direction)| direction * weight(v)).sum();
                let normal = g0.cross(&g1).normalize();
                let along = along - normal * normal.dot(&along);
                match along.norm() > 1e-9 {
                    true => [along, normal.cross(&along)],
                    false => [g0, g1],
                }
            }
            Self::Given(directions) => directions[element],
        }
    }
}

/// An unstructured mesh of hexahedra with curved shape.
///
/// The vertex `i + 2 j + 4 k` of an element lies at `xi = (2i-1, 2j-1, 2k-1)`. In meshes of vessels the local
/// coordinates run along the axis (0), around the circumference (1) and outward through the wall (2); fibre
/// directions are derived from them where [`HexMesh::directions`] says nothing else.
#[derive(Clone)]
pub struct HexMesh {
    /// Reference positions of the vertices, m.
    pub vertices: Vec<Vec3>,
    /// Vertices of each element.
    pub hexes: Vec<[usize; 8]>,
    /// Material region of each element, an index into the materials that the solver is given.
    pub regions: Vec<usize>,
    /// Named parts of the boundary: `inner`, `outer`, `start`, `end` for vessels.
    pub surfaces: BTreeMap<String, Vec<(usize, HexFace)>>,
    /// Directions along and around.
    pub directions: WallDirections,
    /// Exact shape of the elements.
    pub shape: Arc<dyn HexShape>,
}
