//! Aitken's dynamic relaxation (Irons and Tuck 1969; Küttler and Wall 2008).

use super::Acceleration;
use nalgebra::DVector;

/// `d + omega_k (d_tilde - d)` with `omega_k = -omega_{k-1} r_{k-1}·(r_k - r_{k-1}) / |r_k - r_{k-1}|²`.
#[derive(Debug, Clone, PartialEq)]
pub struct Aitken {
    /// Factor of the first iteration of a step.
    first: f64,
    omega: f64,
    previous: Option<DVector<f64>>,
}

impl Aitken {
    /// Each step starts with the factor `first`, or with the last one of the step before if that is smaller.
    pub fn new(first: f64) -> Self {
        Self {
            first,
            omega: first,
            previous: None,
        }
    }
}

impl Acceleration for Aitken {
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64> {
        let residual = d_tilde - d;
        if let Some(previous) = &self.previous {
            let difference = &residual - previous;
            let square = difference.norm_squared();
            if square > 0.0 {
                self.omega *= -previous.dot(&difference) / square;
            }
        }
        let next = d + self.omega * &residual;
        self.previous = Some(residual);
        next
    }

    fn finish_step(&mut self) {
        // Küttler and Wall: keep the sign of the last factor, but do not start with more than the given one.
        self.omega = self.omega.signum() * self.omega.abs().min(self.first);
        self.previous = None;
    }
}

#[cfg(test)]
mod tests {
    use super::super::Constant;
    use super::super::tests::LinearInterface;
    use super::*;

    #[test]
    fn needs_fewer_iterations_than_the_best_constant_factor() {
        let problem = LinearInterface::new(30, 8.0);
        let (aitken, d) = problem.iterate(&mut Aitken::new(0.1), 1000).unwrap();
        let (constant, _) = problem.iterate(&mut Constant::new(0.2), 1000).unwrap();
        assert!((d - problem.solution()).norm() < 1e-8);
        assert!(aitken < constant, "Aitken {aitken}, constant {constant}");
    }
}
