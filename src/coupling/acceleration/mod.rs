//! Convergence acceleration: from `d` and `d_tilde = S∘F(d)` to the next trial.
//!
//! Every model is a file of the same shape: a struct with its memory, [`Acceleration`], tests against the linear
//! interface problem of [`tests`].

mod aitken;
mod constant;
mod iqn_ls;

pub use aitken::Aitken;
pub use constant::Constant;
pub use iqn_ls::IqnLs;

use nalgebra::DVector;

/// Finds the next trial of a fixed-point iteration.
pub trait Acceleration: Send {
    /// The next trial after `d`, whose image under structure and fluid is `d_tilde`.
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64>;

    /// The step has converged; what was learnt in it becomes memory.
    fn finish_step(&mut self);

    /// Columns that the last trial was built from; 0 for models without.
    fn columns(&self) -> usize {
        0
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// `d_tilde = b - A d` with the spectrum of an added-mass operator: modes of long wave length have the largest
    /// eigenvalues, `added_mass` for the longest; plain fixed-point iteration diverges if that is above 1.
    pub struct LinearInterface {
        pub a: DMatrix<f64>,
        pub b: DVector<f64>,
    }

    impl LinearInterface {
        pub fn new(n: usize, added_mass: f64) -> Self {
            let mode = |i: usize, k: usize| {
                let x = (i as f64 + 1.0) / (n as f64 + 1.0);
                (2.0 / (n as f64 + 1.0)).sqrt()
                    * (std::f64::consts::PI * (k as f64 + 1.0) * x).sin()
            };
            let a = DMatrix::from_fn(n, n, |i, j| {
                (0..n)
                    .map(|k| added_mass / ((k + 1) * (k + 1)) as f64 * mode(i, k) * mode(j, k))
                    .sum()
            });
            Self {
                a,
                b: DVector::from_fn(n, |i, _| 1.0 + (i as f64).cos()),
            }
        }

        pub fn apply(&self, d: &DVector<f64>) -> DVector<f64> {
            &self.b - &self.a * d
        }

        pub fn solution(&self) -> DVector<f64> {
            let n = self.b.len();
            (DMatrix::identity(n, n) + &self.a)
                .lu()
                .solve(&self.b)
                .unwrap()
        }

        /// Iterates until the residual has fallen by 1e-10; returns the number of iterations and the solution.
        pub fn iterate(
            &self,
            model: &mut dyn Acceleration,
            most: usize,
        ) -> Option<(usize, DVector<f64>)> {
            let mut d = DVector::zeros(self.b.len());
            for k in 1..=most {
                let d_tilde = self.apply(&d);
                if (&d_tilde - &d).norm() < 1e-10 * self.b.norm() {
                    return Some((k, d));
                }
                d = model.next(&d, &d_tilde);
            }
            None
        }
    }

    #[test]
    fn the_linear_problem_defeats_plain_iteration() {
        assert!(
            LinearInterface::new(30, 8.0)
                .iterate(&mut Constant::new(1.0), 200)
                .is_none()
        );
    }
}
