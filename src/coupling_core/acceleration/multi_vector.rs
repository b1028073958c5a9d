//! The multi-vector update (Bogaers, Kok, Reddy and Franz 2014, MVQN; Lindner et al. 2015, IQN-IMVJ), without matrices
//! (compare Spenke, Hosters and Behr 2020).

use super::{Columns, Filter, JacobianModel, LeastSquares, Prediction, SecantPair};
use nalgebra::DVector;
use std::collections::VecDeque;

/// `C_n = C_{n-1} - (delta D_n + C_{n-1} V_n) V_n⁺` for `C = -(dr/dd)⁻¹`: the inverse Jacobian of step n - 1 is
/// changed as little as the columns of step n demand.
///
/// Applied to a residual this is a chain: the fit of step n answers for what its columns span and hands the rest to
/// the fit of step n - 1, and so on. No matrix is ever formed; cost and memory grow with the number of columns, so the
/// chain ends after `reuse` steps (all steps in Bogaers et al.). Columns are compared only within their step: nothing
/// is filtered between steps.
#[derive(Debug, Clone, PartialEq)]
pub struct MultiVector {
    reuse: usize,
    filter: Filter,
    max_columns: usize,
    /// The fits of the current step and of the earlier ones, newest first.
    chain: VecDeque<LeastSquares>,
}

impl MultiVector {
    /// Remembers `reuse` steps and at most about `max_columns` columns, drops columns by `filter` (see
    /// [`LeastSquares`]).
    pub fn new(reuse: usize, filter: Filter, max_columns: usize) -> Self {
        let chain = VecDeque::from([LeastSquares::new(filter)]);
        Self {
            reuse,
            filter,
            max_columns,
            chain,
        }
    }
}

impl JacobianModel for MultiVector {
    fn add(&mut self, column: SecantPair) {
        self.chain[0].add(column);
        while self.chain.len() > 1 && self.columns().used > self.max_columns {
            self.chain.pop_back();
        }
        self.chain[0].truncate(self.max_columns);
    }

    fn predict(&mut self, residual: &DVector<f64>) -> Prediction {
        let nothing = Prediction {
            correction: DVector::zeros(residual.len()),
            rest: residual.clone(),
        };
        self.chain.iter_mut().fold(nothing, |so_far, fit| {
            let Prediction { correction, rest } = fit.predict(&so_far.rest);
            Prediction {
                correction: so_far.correction + correction,
                rest,
            }
        })
    }

    fn finish_step(&mut self) {
        self.chain.truncate(self.reuse.max(1));
        if self.reuse == 0 {
            self.chain.clear();
        }
        self.chain.push_front(LeastSquares::new(self.filter));
    }

    fn reset(&mut self) {
        self.chain = VecDeque::from([LeastSquares::new(self.filter)]);
    }

    fn believe(&mut self) {
        self.filter.doubt = 0.0;
        self.chain.iter_mut().for_each(LeastSquares::believe);
    }

    fn columns(&self) -> Columns {
        Columns {
            used: self.chain.iter().map(LeastSquares::len).sum(),
            dropped: self.chain[0].dropped(),
        }
    }

    fn fits(&self) -> Vec<Vec<SecantPair>> {
        let earlier = self.chain.iter().skip(1);
        earlier.map(LeastSquares::columns).collect()
    }

    fn recall(&mut self, fits: Vec<Vec<SecantPair>>) {
        self.reset();
        for columns in fits {
            let mut fit = LeastSquares::new(self.filter);
            fit.put(columns);
            self.chain.push_back(fit);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::reference::Linear;
    use super::super::QuasiNewton;
    use super::super::tests::{error, iterate};
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn needs_fewer_iterations_from_step_to_step() {
        let mut problem = Linear::new(60, 20.0);
        let mut model = QuasiNewton::new(MultiVector::new(20, Filter::exact(1e-8), 500), 0.05);
        let (first, _) = iterate(&mut problem, &mut model, 100).unwrap();
        let (second, d) = iterate(&mut problem, &mut model, 100).unwrap();
        assert!(error(&problem, 1, &d) < 1e-8);
        assert!(second < first, "first {first}, second {second}");
    }

    #[test]
    fn the_chain_is_the_update_formula_with_matrices() {
        let n = 6;
        let random =
            |seed: f64| DVector::from_fn(n, |i, _| (seed * 12.9898 + i as f64 * 78.233).sin());
        let mut model = MultiVector::new(9, Filter::exact(0.0), 99);
        // The identity answers for the rest, so C_0 = 1.
        let mut c = DMatrix::identity(n, n);
        for step in 0..3 {
            let columns: Vec<_> = (0..2)
                .map(|k| {
                    SecantPair::new(
                        random(f64::from(4 * step + k)),
                        random(f64::from(50 + 4 * step + k)),
                        1.0,
                    )
                })
                .map(Option::unwrap)
                .collect();
            let v = DMatrix::from_columns(
                &columns
                    .iter()
                    .map(|c| c.residual.clone())
                    .collect::<Vec<_>>(),
            );
            let d =
                DMatrix::from_columns(&columns.iter().map(|c| c.trial.clone()).collect::<Vec<_>>());
            // delta d = -(dr/dd)⁻¹ (-delta r): a residual of -V is removed by delta D.
            c = &c - (&d + &c * &v) * v.clone().pseudo_inverse(1e-14).unwrap();
            if step > 0 {
                model.finish_step();
            }
            columns.into_iter().for_each(|column| model.add(column));
        }
        let r = random(99.0);
        let answer = model.predict(&r);
        assert!((answer.correction + answer.rest - c * r).norm() < 1e-10);
    }
}
