//! # fsi-driver: blood and wall of an artery, solved together
//!
//! Blood pulsing through a soft artery bends the wall, and the wall bends the flow. This library couples a
//! p-version finite element solver for the wall to OpenFOAM's `pimpleFoam` for the blood by a partitioned,
//! implicit iteration, after Radtke, König and Düster, *The influence of geometric imperfections in
//! cardiovascular FSI simulations* (Comput. Math. Appl., 2017), called "the paper" throughout.
//!
//! ## The way of the data
//! ```text
//! case.toml ─► case ─► geometry ─┬─► pfem  (Solid: load at quadrature points ─► displacement)       ┐
//!                                └─► fluid (Fluid: displacement of wall points ─► traction at faces) ┤
//!                                                                                                    ▼
//!                       coupling: one time step = repeat { transfer, solve, accelerate } until converged
//!                                                                                                    ▼
//!             simulation: clock, rescue, checkpoint ─► observers: history, fields, hemodynamics ─► report
//! ```
//! Nothing flows back except through the coupling loop: a module knows the ones on its left, nothing on its right.
//!
//! Three of the parts are crates of their own, which can be used alone: [`fsi_pfem`] (the wall), [`fsi_spectral`] (the
//! core of the native fluid) and [`fsi_coupling`] (the fixed point of two solvers), on [`fsi_numerics`]. What a case is
//! read from is in two more, [`fsi_data`] and [`fsi_case`], which the compiler optimizes while it checks the driver.
//!
//! ## Vocabulary
//! * **Interface** or **wet surface**: where blood touches the deformable wall. The fluid sees it as the patch
//!   `wallFsi` (points and faces of its mesh), the structure as the inner faces of its elements (quadrature points).
//! * **Traction**: force per *deformed* area that the fluid exerts on the wall, in Pa.
//! * **Coupling iteration**: one application of the fluid and of the structure to a trial displacement of the
//!   interface; **time step**: coupling iterations until the trial is a fixed point, then both sides accept it.
//! * **Trial** and **state**: what a repeated iteration throws away, and what an accepted step keeps; two types.
//!
//! All quantities are in SI units. Names carry a unit only at the border (`case.toml`, headers of CSV files).

#![warn(clippy::print_stdout, clippy::print_stderr)] // panic where nobody reads: see output::terminal

pub mod analysis;
pub mod commands;
pub mod coupling;
pub mod fluid;
pub mod geometry;
pub mod hemodynamics;
mod measurement;
mod numbers;
pub mod output;
pub mod paper;
pub mod processes;
pub mod proposal;
mod run;
pub mod simulation;

pub use fsi_case as case;
pub use fsi_data::files::{Fault, FileError};
pub use fsi_data::{curve, interpolation, polydata};
pub(crate) use fsi_data::{files, tabular, uncertainty};
pub use fsi_numerics::{Mat3, Vec3};
pub(crate) use fsi_numerics::{lagrange, quadrature};
pub use fsi_pfem as pfem;
