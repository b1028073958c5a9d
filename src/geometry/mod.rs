//! The vessel: cross-sections, imperfection, centre-lines; hexahedra for the wall, O-grid for the lumen. No physics.
//!
//! A [`Vessel`] knows the surfaces `r(x, φ)` and the [`CentreLine`]; both meshes are made from it and so fit together.
//! The x-axis runs downstream, the deformable part begins at x = 0, and φ turns from +y to +z.
//!
//! A case may have a [`Flag`](crate::case::Flag) in a channel instead, whose two meshes are made in [`flag`].

pub(crate) mod blocks;
pub(crate) mod centre_line;
pub(crate) mod centre_shift;
pub(crate) mod flag;
pub(crate) mod hex_mesh;
pub(crate) mod imperfection;
pub(crate) mod o_grid;
pub(crate) mod poly_mesh;
mod size;
pub(crate) mod vessel;
pub(crate) mod wall;

pub use centre_line::{CentreLine, Frame};
pub use centre_shift::CentreShift;
pub use hex_mesh::{HexFace, HexMesh, HexShape};
pub use imperfection::{Imperfection, irregular_tube_mesh};
pub use o_grid::fluid_mesh;
pub use poly_mesh::{Patch, PolyMesh};
pub use vessel::{Vessel, solid_mesh};
pub use wall::{Surfaces, WallGrid, tube_mesh};
