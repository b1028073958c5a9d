//! Face-based polyhedral meshes in OpenFOAM's layout.

use crate::Vec3;

/// A named part of the boundary: `size` faces from `start`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patch {
    /// Name, such as `inlet`.
    pub name: String,
    /// OpenFOAM's type, such as `patch` or `wall`.
    pub kind: String,
    /// First face.
    pub start: usize,
    /// Number of faces.
    pub size: usize,
}

/// A mesh as OpenFOAM's `polyMesh` folder holds it: internal faces first in upper-triangular order, then patch by patch.
#[derive(Debug, Clone, PartialEq)]
pub struct PolyMesh {
    /// Positions of the points, m.
    pub points: Vec<Vec3>,
    /// Points of each face; the normal points from owner to neighbour, or out of the domain.
    pub faces: Vec<Vec<usize>>,
    /// Owner cell of each face.
    pub owner: Vec<usize>,
    /// Neighbour cell of each internal face.
    pub neighbour: Vec<usize>,
    /// Boundary patches in order of their faces.
    pub patches: Vec<Patch>,
}
