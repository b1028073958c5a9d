//! Constant relaxation.

use super::{Acceleration, AccelerationMemory, Identity, Surrogate};
use nalgebra::DVector;

/// `d + omega P r` with a fixed factor; `P` is the identity unless a surrogate is given.
pub struct Constant {
    omega: f64,
    surrogate: Box<dyn Surrogate>,
    /// The `d` of the last call.
    last: Option<DVector<f64>>,
}

impl Constant {
    /// Relaxation by the factor `omega` in (0, 1].
    pub fn new(omega: f64) -> Self {
        Self {
            omega,
            surrogate: Box::new(Identity),
            last: None,
        }
    }

    /// The same with the surrogate `P` in place of the identity.
    pub fn with_surrogate(self, surrogate: Box<dyn Surrogate>) -> Self {
        Self { surrogate, ..self }
    }
}

impl Acceleration for Constant {
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64> {
        self.last = Some(d.clone());
        d + self.omega * self.surrogate.predict(&(d_tilde - d))
    }

    fn begin_step(&mut self, end: f64, length: f64) {
        self.surrogate.begin_step(end, length);
    }

    fn finish_step(&mut self) {
        if let Some(d) = self.last.take() {
            self.surrogate.finish_step(&d);
        }
    }

    fn reset(&mut self) {
        self.last = None;
    }

    fn set_relaxation(&mut self, factor: f64) {
        self.omega = factor;
    }

    fn memory(&self) -> AccelerationMemory {
        AccelerationMemory::default()
    }

    fn recall(&mut self, _: AccelerationMemory, d: &DVector<f64>) {
        self.reset();
        self.surrogate.finish_step(d);
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::reference::Linear;
    use super::super::tests::{error, iterate};
    use super::*;

    #[test]
    fn converges_when_the_factor_is_small_enough() {
        let mut problem = Linear::new(30, 8.0);
        assert!(iterate(&mut problem, &mut Constant::new(1.0), 200).is_none());
        let (_, d) = iterate(&mut problem, &mut Constant::new(0.15), 1000).unwrap();
        assert!(error(&problem, 0, &d) < 1e-8);
    }
}
