//! Constant relaxation.

use super::Acceleration;
use nalgebra::DVector;

/// `d + omega (d_tilde - d)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    omega: f64,
}

impl Constant {
    /// Relaxation by the factor `omega` in (0, 1].
    pub fn new(omega: f64) -> Self {
        Self { omega }
    }
}

impl Acceleration for Constant {
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64> {
        d + self.omega * (d_tilde - d)
    }

    fn finish_step(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::super::tests::LinearInterface;
    use super::*;

    #[test]
    fn converges_when_the_factor_is_small_enough() {
        let problem = LinearInterface::new(30, 8.0);
        let (_, d) = problem.iterate(&mut Constant::new(0.15), 1000).unwrap();
        assert!((d - problem.solution()).norm() < 1e-8);
    }
}
