//! The structural solver: p-version finite elements for large deformations. It does not know that a fluid exists.
//!
//! From one-dimensional functions to a moving body: [`basis`] and [`space`] say which modes an element has,
//! [`numbering`] joins them across elements, [`mapping`] gives the elements their shape, [`material`] their stress;
//! [`elements`] integrates, [`sparse`] and [`factor`] hold and solve the linear equations, [`newton`] the nonlinear ones;
//! [`structure`] moves the body in time and is what the coupling sees through the trait [`Solid`].

// Tensors are named as in the paper: F, C, P, J.
#![allow(non_snake_case)]

pub mod basis;
pub mod discretization;
pub mod elements;
pub mod equation_of_motion;
pub mod extremes;
pub mod factor;
pub mod locate;
pub mod mapping;
pub mod material;
pub mod modes;
pub mod newton;
pub mod numbering;
pub mod ordering;
mod pool;
pub mod prolongation;
pub mod quasi_newton;
pub mod samples;
pub mod shapes;
pub mod solid;
pub mod space;
pub mod sparse;
pub mod stability;
mod stability_watch;
pub mod statics;
pub mod stats;
pub mod stress;
pub mod structure;
mod substitution;
pub mod sum_factorization;
pub mod supports;
pub mod surface;
pub mod time_scheme;
pub mod volume;

pub use discretization::Discretization;
pub use samples::{Sampler, Samples};
pub use solid::{Solid, SolidError, SurfaceLoad, SurfacePoint};
pub use space::{Space, SpaceKind};
pub use structure::{Structure, StructureOptions};
pub use volume::Formulation;
