//! Blood by spectral elements: a solver without any program but this one.
//!
//! The equations and their solution are the crate [`fsi_spectral`]. Here it becomes a [`Fluid`](super::Fluid):
//! [`vessel_mesh`] is the lumen of a vessel and how it follows the wall ([`lumen_mesh`]), [`tree_mesh`] that of a
//! vessel that branches, [`ends`] what is prescribed at the openings, and [`blood`] puts it all together; [`decay`]
//! says how well the elements resolve the flow, [`probes`] what it is at chosen points, and [`field`] everywhere.
//!
//! The method, where it comes from, and what was measured: `docs/native-fluid.md`.

pub(crate) mod blood;
pub(crate) mod decay;
pub(crate) mod ends;
pub(crate) mod field;
pub mod lumen_mesh;
pub(crate) mod probes;
pub mod tree_mesh;
pub mod vessel_mesh;

pub use blood::NativeFluid;
pub use fsi_spectral::{
    BoundaryConditions, Flow, FlowError, FlowSettings, FlowSolution, FlowState, OpenEnd,
    OpenInflow, TimeScheme, metric, spectral_elements, taylor_hood_space, wall_traction,
};
use fsi_spectral::{basis, clock, flow, open_inflow, surface, time_scheme};
