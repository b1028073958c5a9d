//! Coupled problems with a known answer that need no flow solver: the proving ground of acceleration and prediction.
//!
//! * [`Linear`]: an interface problem whose spectrum is that of an added mass, with a dial for its size.
//! * [`PartitionedTube`]: a one-dimensional elastic tube. The [`Flow`] through it and its [`StringWall`] are two
//!   solvers that know nothing of each other; [`Monolithic`] solves both at once by Newton's method.
//!
//! [`march`] takes any of them through its time steps as the driver does.

pub mod combinations;
mod flow;
mod monolithic;
mod tridiagonal;
mod tube;
mod wall;

pub use flow::{Flow, Inlet, Outlet, TubeFluid};
pub use fsi_coupling::reference::{History, Linear, Reference, march};
pub use monolithic::Monolithic;
pub use tube::{PartitionedTube, TubeSetup};
pub use wall::{StringWall, WallSetup};
