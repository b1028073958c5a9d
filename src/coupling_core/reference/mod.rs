//! A coupled problem with a known answer that needs no solver: the proving ground of acceleration and prediction.

mod linear;
mod march;

pub use linear::Linear;
pub use march::{History, march};

use crate::acceleration::Surrogate;
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
