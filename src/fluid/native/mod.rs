//! Blood by spectral elements: a solver of the incompressible Navier-Stokes equations on a moving mesh, without any
//! program but this one.
//!
//! From one dimension to a time step: [`basis`] has the polynomials of an element, [`contraction`] their products,
//! [`kernel`] its operations, [`taylor_hood_space`] the numbering of the unknowns and [`spectral_elements`] all of
//! these together; [`vessel_mesh`] is the lumen of a vessel and how it follows the wall, [`metric`] the geometry of the
//! elements at a moment, [`surface`] integrals over the boundary. The equations of a step are [`oseen`], solved by
//! [`gmres`] with the [`preconditioner`] and its Schur complement of the [`pressure`] (factorized by
//! [`plane_cholesky`]); [`flow`] takes the step with one of the [`time_scheme`]s, [`wall_traction`] says what it does
//! to the wall, [`decay`] how well the elements resolve it, [`probes`] what it is at chosen points, and [`field`]
//! everywhere. [`ends`] is what is prescribed at inlet and outlet and [`open_inflow`] the blood that enters there,
//! [`clock`] knows where the seconds go, [`patience`] when a solution is given up, and [`blood`] puts it all into a
//! [`Fluid`](super::Fluid).
//!
//! The method, where it comes from, and what was measured: `docs/native-fluid.md`.

pub(crate) mod basis;
pub(crate) mod blood;
pub(crate) mod clock;
pub(crate) mod contraction;
pub(crate) mod decay;
pub(crate) mod ends;
pub(crate) mod field;
pub(crate) mod flow;
pub(crate) mod gmres;
pub(crate) mod kernel;
pub mod metric;
pub(crate) mod open_inflow;
pub(crate) mod oseen;
pub(crate) mod patience;
pub(crate) mod plane_cholesky;
pub mod preconditioner;
pub(crate) mod pressure;
pub(crate) mod probes;
pub(crate) mod shear_thinning;
pub mod spectral_elements;
pub(crate) mod surface;
pub mod taylor_hood_space;
pub(crate) mod time_scheme;
pub mod vessel_mesh;
pub mod wall_traction;

pub use blood::NativeFluid;
pub use flow::{BoundaryConditions, Flow, FlowSettings, FlowSolution, FlowState};
pub use open_inflow::{OpenEnd, OpenInflow};
pub use time_scheme::TimeScheme;

/// Why the flow could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlowError {
    /// The problem is not well posed.
    #[error("{0}")]
    Model(String),
    /// The mesh became inside out.
    #[error(
        "element {element} of the fluid's mesh is inside out at {position:?} m (Jacobian {jacobian:.3e}): the wall has moved too far"
    )]
    Inverted {
        /// Index of the element.
        element: usize,
        /// Determinant of its mapping where it is worst.
        jacobian: f64,
        /// About where, m.
        position: [f64; 3],
    },
    /// The linear solver did not converge.
    #[error(
        "the fluid's equations were not solved: after {iterations} iterations the error is {residual:.1e} of the solution, \
         most of it at {position:?} m"
    )]
    NotSolved {
        /// Iterations that were spent.
        iterations: usize,
        /// Estimated error, relative to the size of the solution.
        residual: f64,
        /// The node whose velocity is the worst, m.
        position: [f64; 3],
    },
    /// The solution is no longer needed.
    #[error("interrupted")]
    Interrupted,
    /// What is known is not a number.
    #[error(
        "the fluid's velocity is not a finite number at {position:?} m: it has been lost before this solution"
    )]
    NotFinite {
        /// The first such node, m.
        position: [f64; 3],
    },
}
