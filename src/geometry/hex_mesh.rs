//! Hexahedra with curved shape, as the structural solver takes them.

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

/// An unstructured mesh of hexahedra with curved shape.
///
/// The vertex `i + 2 j + 4 k` of an element lies at `xi = (2i-1, 2j-1, 2k-1)`. In meshes of vessels the local
/// coordinates run along the axis (0), around the circumference (1) and outward through the wall (2); fibre
/// directions are derived from them.
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
    /// Exact shape of the elements.
    pub shape: Arc<dyn HexShape>,
}
