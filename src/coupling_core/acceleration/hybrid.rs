//! Least squares on the current step's columns, with the remembered steps answering for what those do not span.

use super::{Columns, Filter, JacobianModel, LeastSquares, Prediction, SecantPair};
use nalgebra::DVector;

/// Two fits: one with the columns of this step, and one with all columns of the last `reuse` steps for its rest.
///
/// From [`IqnLs`](super::IqnLs) it has the joint fit of the remembered columns, filtered against each other; from
/// [`MultiVector`](super::MultiVector) that remembered columns, which belong to a slightly different Jacobian, never
/// compete with those of the current step. The remembered columns are decomposed once a step instead of once an
/// iteration.
#[derive(Debug, Clone, PartialEq)]
pub struct Hybrid {
    reuse: usize,
    max_columns: usize,
    current: LeastSquares,
    remembered: LeastSquares,
}

impl Hybrid {
    /// Remembers `reuse` steps and at most `max_columns` columns, drops columns by `filter`.
    pub fn new(reuse: usize, filter: Filter, max_columns: usize) -> Self {
        let (current, remembered) = (LeastSquares::new(filter), LeastSquares::new(filter));
        Self {
            reuse,
            max_columns,
            current,
            remembered,
        }
    }
}

impl JacobianModel for Hybrid {
    fn add(&mut self, column: SecantPair) {
        self.current.add(column);
        self.current.truncate(self.max_columns);
        self.remembered
            .truncate(self.max_columns - self.current.len());
    }

    fn predict(&mut self, residual: &DVector<f64>) -> Prediction {
        let now = self.current.predict(residual);
        let previous = self.remembered.predict(&now.rest);
        Prediction {
            correction: now.correction + previous.correction,
            rest: previous.rest,
        }
    }

    fn finish_step(&mut self) {
        let columns = self.current.take();
        columns
            .into_iter()
            .rev()
            .for_each(|column| self.remembered.add(column));
        self.remembered.grow_older(self.reuse);
    }

    fn reset(&mut self) {
        self.current.take();
        self.remembered.take();
    }

    fn believe(&mut self) {
        self.current.believe();
        self.remembered.believe();
    }

    fn columns(&self) -> Columns {
        Columns {
            used: self.current.len() + self.remembered.len(),
            dropped: self.current.dropped() + self.remembered.dropped(),
        }
    }

    fn fits(&self) -> Vec<Vec<SecantPair>> {
        vec![self.remembered.columns()]
    }

    fn recall(&mut self, fits: Vec<Vec<SecantPair>>) {
        self.current.take();
        self.remembered.put(fits.into_iter().flatten());
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::reference::Linear;
    use super::super::tests::{error, iterate};
    use super::super::{IqnLs, QuasiNewton};
    use super::*;

    #[test]
    fn needs_fewer_iterations_from_step_to_step() {
        let mut problem = Linear::new(60, 20.0);
        let mut model = QuasiNewton::new(Hybrid::new(20, Filter::exact(1e-8), 500), 0.05);
        let (first, _) = iterate(&mut problem, &mut model, 100).unwrap();
        let (second, d) = iterate(&mut problem, &mut model, 100).unwrap();
        assert!(error(&problem, 1, &d) < 1e-8);
        assert!(second < first, "first {first}, second {second}");
    }

    #[test]
    fn without_memory_it_is_iqn_ls() {
        let step = |model: &mut dyn super::super::Acceleration| {
            iterate(&mut Linear::new(30, 8.0), model, 100).unwrap()
        };
        assert_eq!(
            step(&mut QuasiNewton::new(
                Hybrid::new(0, Filter::exact(1e-6), 100),
                0.1
            )),
            step(&mut QuasiNewton::new(
                IqnLs::new(0, Filter::exact(1e-6), 100),
                0.1
            )),
        );
    }
}
