//! Coupled problems with a known answer that need no flow solver: the proving ground of acceleration and prediction.
//!
//! * [`Linear`]: an interface problem whose spectrum is that of an added mass, with a dial for its size.
//! * [`PartitionedTube`]: a one-dimensional elastic tube. The [`Flow`] through it and its [`StringWall`] are two
//!   solvers that know nothing of each other; [`Monolithic`] solves both at once by Newton's method.
//!
//! [`march`] takes any of them through its time steps as the driver does.

pub mod combinations;
mod flow;
mod linear;
mod march;
mod monolithic;
mod tridiagonal;
mod tube;
mod wall;

pub use flow::{Flow, Inlet, Outlet, TubeFluid};
pub use linear::Linear;
pub use march::{History, march};
pub use monolithic::Monolithic;
pub use tube::{PartitionedTube, TubeSetup};
pub use wall::{StringWall, WallSetup};

use super::acceleration::Surrogate;
use nalgebra::DVector;

/// A coupled problem in time whose solution is known.
pub trait Reference: Send {
    /// Its name in tables.
    fn name(&self) -> &str;

    /// Number of time steps.
    fn steps(&self) -> usize;

    /// The interface displacement at the start.
    fn at_rest(&self) -> DVector<f64>;

    /// A factor with which constant relaxation converges.
    fn relaxation(&self) -> f64;

    /// `S∘F(d)` in the current time step.
    fn image(&mut self, d: &DVector<f64>) -> DVector<f64>;

    /// Ends the time step: the fluid keeps the state that belongs to `d`, the structure the one of `image(d)`.
    fn accept(&mut self, d: &DVector<f64>);

    /// A surrogate that is deliberately not exact, as it will be in real computations.
    fn surrogate(&self) -> Box<dyn Surrogate>;

    /// The displacement of every step, by solving fluid and structure together.
    fn exact(&self) -> Vec<DVector<f64>>;
}
