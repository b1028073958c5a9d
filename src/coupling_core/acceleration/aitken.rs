//! Aitken's dynamic relaxation (Irons and Tuck 1969; Küttler and Wall 2008).

use super::{Acceleration, AccelerationMemory, Identity, Surrogate};
use nalgebra::DVector;

/// `d + omega_k s_k` with `s = P r` and `omega_k = -omega_{k-1} s_{k-1}·(s_k - s_{k-1}) / |s_k - s_{k-1}|²`; `P` is the
/// identity unless a surrogate is given.
pub struct Aitken {
    /// Factor of the first iteration of a step.
    first: f64,
    surrogate: Box<dyn Surrogate>,
    omega: f64,
    /// `d` and `s` of the last call.
    last: Option<(DVector<f64>, DVector<f64>)>,
}

impl Aitken {
    /// Each step starts with the factor `first`, or with the last one of the step before if that is smaller.
    pub fn new(first: f64) -> Self {
        Self {
            first,
            surrogate: Box::new(Identity),
            omega: first,
            last: None,
        }
    }

    /// The same with the surrogate `P` in place of the identity.
    pub fn with_surrogate(self, surrogate: Box<dyn Surrogate>) -> Self {
        Self { surrogate, ..self }
    }
}

impl Acceleration for Aitken {
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64> {
        let s = self.surrogate.predict(&(d_tilde - d));
        if let Some((_, before)) = &self.last {
            let difference = &s - before;
            let square = difference.norm_squared();
            if square > 0.0 {
                self.omega *= -before.dot(&difference) / square;
            }
        }
        let next = d + self.omega * &s;
        self.last = Some((d.clone(), s));
        next
    }

    fn begin_step(&mut self, end: f64, length: f64) {
        self.surrogate.begin_step(end, length);
    }

    fn finish_step(&mut self) {
        // Küttler and Wall: keep the sign of the last factor, but do not start with more than the given one.
        self.omega = self.omega.signum() * self.omega.abs().min(self.first);
        if let Some((d, _)) = self.last.take() {
            self.surrogate.finish_step(&d);
        }
    }

    fn reset(&mut self) {
        self.omega = self.first;
        self.last = None;
    }

    fn set_relaxation(&mut self, factor: f64) {
        self.first = factor;
        self.omega = self.omega.signum() * self.omega.abs().min(factor);
    }

    fn memory(&self) -> AccelerationMemory {
        AccelerationMemory {
            factor: Some(self.omega),
            fits: Vec::new(),
            surrogate: Default::default(),
        }
    }

    fn recall(&mut self, memory: AccelerationMemory, d: &DVector<f64>) {
        self.reset();
        self.omega = memory.factor.unwrap_or(self.first);
        self.surrogate.finish_step(d);
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::reference::Linear;
    use super::super::Constant;
    use super::super::tests::{error, iterate};
    use super::*;

    #[test]
    fn needs_fewer_iterations_than_the_best_constant_factor() {
        let mut problem = Linear::new(30, 8.0);
        let (aitken, d) = iterate(&mut problem, &mut Aitken::new(0.1), 1000).unwrap();
        assert!(error(&problem, 0, &d) < 1e-8);
        let mut problem = Linear::new(30, 8.0);
        let (constant, _) = iterate(&mut problem, &mut Constant::new(0.2), 1000).unwrap();
        assert!(aitken < constant, "Aitken {aitken}, constant {constant}");
    }
}
