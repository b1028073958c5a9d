//! The vessel: cross-sections, imperfection, centre-lines; hexahedra for the wall, O-grid for the lumen. No physics.

pub mod hex_mesh;
pub mod poly_mesh;
pub mod wall;

pub use hex_mesh::{HexFace, HexMesh, HexShape};
pub use poly_mesh::{Patch, PolyMesh};
pub use wall::tube_mesh;
