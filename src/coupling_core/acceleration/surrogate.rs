//! Surrogates: cheap models of both solvers that give the initial inverse Jacobian of the interface.
//!
//! Delaissé et al. 2022 (IQN-ISM, Comput. Struct. 260) show the idea: secants know nothing before they have been
//! bought with iterations, but a coarse model of the same physics knows the modes that cost them, those of long wave
//! length. It need not be accurate; its errors are corrected by the secants.

use nalgebra::DVector;

/// An initial inverse Jacobian of the residual `r(d) = S∘F(d) - d`.
pub trait Surrogate: Send {
    /// The change of the displacement that would remove the residual if the surrogate were exact: `-(dr/dd)⁻¹
    /// residual`.
    fn predict(&self, residual: &DVector<f64>) -> DVector<f64>;

    /// The next iterations are of a step of `length` (s) that ends at the time `end` (s).
    fn begin_step(&mut self, _end: f64, _length: f64) {}

    /// A step was accepted with the displacement `d`: time to linearize again.
    fn finish_step(&mut self, _d: &DVector<f64>) {}

    /// Whether there is none in truth.
    fn is_none(&self) -> bool {
        false
    }
}

/// No surrogate: `S∘F` does not depend on `d`, so that the residual is the change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity;

impl Surrogate for Identity {
    fn predict(&self, residual: &DVector<f64>) -> DVector<f64> {
        residual.clone()
    }

    fn is_none(&self) -> bool {
        true
    }
}
