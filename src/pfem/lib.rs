//! The structural solver: p-version finite elements for large deformations. It does not know that a fluid exists.
//!
//! A folder a matter: [`space`] has the modes of an element and joins them across elements, [`element`] gives the
//! elements their shape and integrates over them, [`material`] tells their stress, [`linear_algebra`] holds and solves
//! the linear equations, [`solution`] the nonlinear ones, at rest and in time, and [`evaluation`] tells what came out.
//! [`Discretization`] is a body ready to be solved for; [`Structure`] moves it in time and is what the coupling sees
//! through the trait [`Solid`].

// Tensors are named as in the paper: F, C, P, J.
#![allow(non_snake_case)]

pub mod discretization;
pub mod element;
pub(crate) mod evaluation;
pub(crate) mod linear_algebra;
pub mod material;
pub mod solid;
pub mod solution;
pub mod space;
pub mod supports;

pub use discretization::Discretization;
pub use element::volume::Formulation;
pub use evaluation::samples::{Sampler, Samples};
pub use evaluation::stress::StressState;
pub use solid::{Solid, SolidError, SurfaceLoad, SurfacePoint};
pub use solution::structure::{PrescribedMotion, Structure, StructureOptions};
pub use space::{Space, SpaceKind};
