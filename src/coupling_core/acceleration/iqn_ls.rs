//! Interface quasi-Newton with the inverse Jacobian from least squares (Degroote, Bathe and Vierendeels 2009, called
//! IQN-ILS since), with columns of earlier steps in the same fit.

use super::{Columns, Filter, JacobianModel, LeastSquares, Prediction, SecantPair};
use nalgebra::DVector;

/// One fit with all columns: this step's first, then those of the last `reuse` steps.
///
/// With the identity for the rest the next trial is `d_tilde + W c`, as the source has it.
#[derive(Debug, Clone, PartialEq)]
pub struct IqnLs {
    reuse: usize,
    max_columns: usize,
    fit: LeastSquares,
}

impl IqnLs {
    /// Remembers `reuse` steps and at most `max_columns` columns, drops columns by `filter`.
    pub fn new(reuse: usize, filter: Filter, max_columns: usize) -> Self {
        Self {
            reuse,
            max_columns,
            fit: LeastSquares::new(filter),
        }
    }
}

impl JacobianModel for IqnLs {
    fn add(&mut self, column: SecantPair) {
        self.fit.add(column);
        self.fit.truncate(self.max_columns);
    }

    fn predict(&mut self, residual: &DVector<f64>) -> Prediction {
        self.fit.predict(residual)
    }

    fn finish_step(&mut self) {
        self.fit.grow_older(self.reuse);
    }

    fn reset(&mut self) {
        self.fit.take();
    }

    fn believe(&mut self) {
        self.fit.believe();
    }

    fn columns(&self) -> Columns {
        Columns {
            used: self.fit.len(),
            dropped: self.fit.dropped(),
        }
    }

    fn fits(&self) -> Vec<Vec<SecantPair>> {
        vec![self.fit.columns()]
    }

    fn recall(&mut self, fits: Vec<Vec<SecantPair>>) {
        self.fit.put(fits.into_iter().flatten());
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::reference::Linear;
    use super::super::tests::{error, iterate};
    use super::super::{Aitken, QuasiNewton};
    use super::*;

    #[test]
    fn a_linear_problem_takes_an_iteration_per_unknown() {
        let mut problem = Linear::new(5, 8.0);
        let mut model = QuasiNewton::new(IqnLs::new(0, Filter::exact(1e-12), 100), 0.1);
        let (iterations, d) = iterate(&mut problem, &mut model, 20).unwrap();
        assert!(error(&problem, 0, &d) < 1e-8);
        assert!(iterations <= 7, "{iterations}");
    }

    /// IQN-ILS needs far fewer iterations than Aitken's relaxation, and fewer still with columns of earlier steps.
    #[test]
    fn needs_far_fewer_iterations_than_aitken() {
        let (aitken, _) =
            iterate(&mut Linear::new(60, 20.0), &mut Aitken::new(0.05), 1000).unwrap();
        let mut problem = Linear::new(60, 20.0);
        let mut model = QuasiNewton::new(IqnLs::new(3, Filter::exact(1e-8), 100), 0.05);
        let (first, _) = iterate(&mut problem, &mut model, 100).unwrap();
        let (second, d) = iterate(&mut problem, &mut model, 100).unwrap();
        assert!(error(&problem, 1, &d) < 1e-8);
        assert!(
            2 * first < aitken && second < first,
            "Aitken {aitken}, first {first}, second {second}"
        );
    }

    #[test]
    fn columns_older_than_q_steps_and_beyond_the_cap_are_forgotten() {
        let column = |i: usize| {
            let mut v = DVector::zeros(9);
            v[i] = 1.0;
            SecantPair::new(v.clone(), v, 1.0).unwrap()
        };
        let mut model = IqnLs::new(1, Filter::exact(1e-3), 4);
        for (steps, held) in [(0..3, 3), (3..5, 2), (5..9, 4)] {
            steps.for_each(|i| model.add(column(i)));
            model.finish_step();
            assert_eq!(model.columns().used, held);
        }
    }
}
