//! # fsi-spectral: incompressible flow by spectral elements
//!
//! A solver of the incompressible Navier-Stokes equations on a mesh that may move: hexahedra with velocity of degree 3
//! to 8 and pressure of one less, swept along a line or conforming in any way. Each time step is one linear system for
//! velocity and pressure together. It knows no vessel and no wall: positions of the nodes and conditions on the
//! boundary are handed in.
//!
//! ## A guided tour
//!
//! 1. [`taylor_hood_space`]: a plane mesh of quadrilaterals ([`Plane`](taylor_hood_space::Plane)) swept over layers
//!    numbers the unknowns, section by section; or any conforming
//!    [`Hexahedra`](taylor_hood_space::Hexahedra) do.
//! 2. [`basis`] has the polynomials of an element, [`contraction`] their products, [`kernel`] its operations, and
//!    [`spectral_elements`] all of these together.
//! 3. [`metric`] is the geometry of the elements at a moment, [`surface`] has integrals over the boundary.
//! 4. [`rheology`] is the viscosity by rate of shear, [`shear_thinning`] takes it to the elements.
//! 5. [`flow`] takes a step: [`Flow::solve`] gives a trial from a [`FlowState`] under [`BoundaryConditions`],
//!    [`Flow::accept`] makes it the new state. The schemes are in [`time_scheme`]; [`open_inflow`] is what enters at
//!    open ends.
//! 6. Its equations are [`oseen`], solved by [`gmres`] with the [`preconditioner`](flow::preconditioner) and its inverse
//!    for the [`pressure`], made from the matrix of the [`divergence`] and applied with the operators of [`local`].
//! 7. [`wall_traction`] says what the flow does to a wall. [`clock`] knows where the seconds go, [`patience`] when a
//!    solution is given up.
//!
//! `examples/kovasznay.rs` computes a flow with an exact solution, and shows how the error falls with the degree;
//! `examples/tube.rs` measures seconds, memory and iterations by the number of elements.

pub mod basis;
pub mod clock;
pub mod contraction;
pub mod divergence;
pub mod flow;
pub mod flux;
pub mod gmres;
pub mod kernel;
pub mod local;
pub mod metric;
pub mod open_inflow;
pub mod oseen;
pub mod patience;
pub mod pressure;
pub mod quality;
pub mod rheology;
pub mod shear_thinning;
pub mod spectral_elements;
pub mod surface;
pub mod taylor_hood_space;
pub mod time_scheme;
pub mod wall_traction;

pub use flow::{BoundaryConditions, Flow, FlowSettings, FlowSolution, FlowState};
pub use fsi_numerics::{Mat3, Vec3};
pub use open_inflow::{OpenEnd, OpenInflow};
pub use rheology::Rheology;
pub use time_scheme::TimeScheme;

/// Why the flow could not be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlowError {
    /// The problem is not well posed.
    #[error("{0}")]
    Model(String),
    /// The mesh became inside out.
    #[error(
        "element {element} of the fluid's mesh is inside out at ({:.4e}, {:.4e}, {:.4e}) m (Jacobian {jacobian:.3e}): the wall has moved too far",
        .position[0], .position[1], .position[2]
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
