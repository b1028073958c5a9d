//! The vessel: cross-sections, imperfection, centre-lines; hexahedra for the wall, O-grid for the lumen. No physics.
//!
//! A [`Vessel`] knows its centre-line and the surfaces `r(s, φ)` around it, section by section; both meshes are made from it
//! and so fit together. The arc length `s` runs downstream, the elastic part begins at s = 0; in the paper's vessels it is
//! x, and φ turns from +y to +z.
//!
//! A case may have a [`Flag`](crate::case::Flag) in a channel instead, whose two meshes are made in [`flag`].

mod anastomosis;
pub(crate) mod blocks;
pub(crate) mod centre_shift;
mod described;
mod feature;
pub(crate) mod flag;
pub(crate) mod hex_mesh;
pub(crate) mod imperfection;
pub(crate) mod o_grid;
pub(crate) mod poly_mesh;
mod section;
mod size;
pub(crate) mod vessel;
pub(crate) mod wall;

pub use centre_shift::CentreShift;
pub use hex_mesh::{HexFace, HexMesh, HexShape};
pub use imperfection::{Imperfection, irregular_tube_mesh};
pub use o_grid::{elastic_pieces, fluid_mesh};
pub use poly_mesh::{Patch, PolyMesh};
pub use section::Section;
pub use size::centre_line;
pub use vessel::{AxialNumbers, Span, Vessel, solid_mesh};
pub use wall::{Surfaces, WallGrid, tube_mesh};
