//! The vessel: cross-sections, imperfection, centre-lines; hexahedra for the wall, O-grid for the lumen. No physics.
//!
//! A [`Vessel`] knows its centre-line and the surfaces `r(s, φ)` around it, section by section; both meshes are made
//! from it and so fit together. The arc length `s` runs downstream, the elastic part begins at s = 0; in the paper's
//! vessels it is x, and φ turns from +y to +z.
//!
//! A case may have a [`Flag`](crate::case::Flag) in a channel instead, whose two meshes are made in [`flag`]; or a
//! user-supplied OpenFOAM case, whose mesh is read ([`foam_files`]) and whose wall is [`extruded`] from it or read from
//! a file ([`wall_file`]); one that does not yield is a [`lining`].

mod anastomosis;
pub(crate) mod blocks;
pub(crate) mod centre_shift;
mod described;
mod extent;
pub(crate) mod extruded;
mod feature;
pub mod flag;
mod foam_files;
pub(crate) mod imperfection;
mod lining;
mod lumen;
mod mesh_quality;
pub(crate) mod o_grid;
pub(crate) mod poly_mesh;
mod random_radius;
mod section;
pub mod supports;
pub mod tree;
pub(crate) mod vessel;
mod wall_file;

pub use centre_shift::CentreShift;
pub use described::ANY as RIGID_MATERIAL;
pub use extruded::{Growth, GrowthError, SurfaceError, WetQuads, is_side, outer_side_of};
pub use fsi_pfem::mesh::{
    HexFace, HexMesh, HexShape, Surfaces, WallDirections, WallGrid, tube_mesh,
};
pub use imperfection::{Imperfection, irregular_tube_mesh};
pub use o_grid::{
    MotionBlend, WallPolygons, cell_widths, elastic_pieces, fluid_mesh, section_quads,
};
pub use poly_mesh::{Patch, PolyMesh};
pub use section::Section;
pub use vessel::{AxialNumbers, Span, Vessel, solid_mesh};
pub use wall_file::{WET, WallFile};

use crate::Vec3;

/// Coordinates (of a file, in its unit) beyond this cannot be meant; their cubes are finite.
const FARTHEST: f64 = 1e12;

/// Whether a point of a file can be meant.
fn is_a_place(x: &Vec3) -> bool {
    x.iter().all(|c| c.abs() <= FARTHEST)
}
