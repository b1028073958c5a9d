//! Interface quasi-Newton with an approximation of the inverse Jacobian from least squares (Degroote, Bathe and
//! Vierendeels 2009), columns of earlier steps, and a filter for dependent columns (Haelterman et al. 2016).

use super::Acceleration;
use nalgebra::DVector;
use std::collections::VecDeque;

/// Differences of two iterations of one step.
#[derive(Debug, Clone, PartialEq)]
struct Column {
    /// Difference of the residuals, a column of **V**.
    residual: DVector<f64>,
    /// Difference of the images `d_tilde`, a column of **W**.
    image: DVector<f64>,
}

/// `d_tilde + W c`, where `c` minimizes `|V c + r|`, `r = d_tilde - d`.
#[derive(Debug, Clone, PartialEq)]
pub struct IqnLs {
    /// Relaxation factor as long as there are no columns.
    relaxation: f64,
    /// Number of earlier steps whose columns are used.
    reuse: usize,
    /// A column is dropped if less than this share of it is orthogonal to the newer ones.
    filter: f64,
    /// Columns of this step, newest first.
    current: VecDeque<Column>,
    /// Columns of earlier steps, newest step first.
    earlier: VecDeque<VecDeque<Column>>,
    /// Residual and image of the iteration before.
    previous: Option<(DVector<f64>, DVector<f64>)>,
    used: usize,
}

impl IqnLs {
    /// A model that reuses the columns of the last `reuse` steps and drops columns by `filter` (relative, 0 keeps all
    /// that are not exactly dependent); `relaxation` is used for the very first iteration.
    pub fn new(relaxation: f64, reuse: usize, filter: f64) -> Self {
        Self {
            relaxation,
            reuse,
            filter,
            current: VecDeque::new(),
            earlier: VecDeque::new(),
            previous: None,
            used: 0,
        }
    }

    /// Removes columns that depend on newer ones; returns an orthonormal basis **Q** of the rest and **R** with
    /// **V** = **Q R**, column by column. The newest column is always kept.
    fn decompose(&mut self) -> (Vec<DVector<f64>>, Vec<Vec<f64>>) {
        let (mut q, mut r): (Vec<DVector<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
        let filter = self.filter;
        for columns in std::iter::once(&mut self.current).chain(&mut self.earlier) {
            columns.retain(|column| {
                let mut v = column.residual.clone();
                let size = v.norm();
                let mut coefficients = vec![0.0; q.len()];
                // Gram-Schmidt twice: once is not enough for nearly dependent columns.
                for _ in 0..2 {
                    for (basis, coefficient) in q.iter().zip(&mut coefficients) {
                        let share = basis.dot(&v);
                        v.axpy(-share, basis, 1.0);
                        *coefficient += share;
                    }
                }
                let rest = v.norm();
                let keep =
                    rest > 0.0 && (q.is_empty() || rest > filter * size) && q.len() < v.len();
                if keep {
                    coefficients.push(rest);
                    q.push(v / rest);
                    r.push(coefficients);
                }
                keep
            });
        }
        (q, r)
    }
}

impl Acceleration for IqnLs {
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64> {
        let residual = d_tilde - d;
        if let Some((residual_before, image_before)) = &self.previous {
            self.current.push_front(Column {
                residual: &residual - residual_before,
                image: d_tilde - image_before,
            });
        }
        let (q, r) = self.decompose();
        self.used = q.len();
        let next = if q.is_empty() {
            d + self.relaxation * &residual
        } else {
            // Back substitution R c = -Qᵀ r; r[j] holds column j of R.
            let mut c: Vec<f64> = q.iter().map(|basis| -basis.dot(&residual)).collect();
            for j in (0..c.len()).rev() {
                c[j] /= r[j][j];
                for i in 0..j {
                    c[i] -= r[j][i] * c[j];
                }
            }
            let columns = std::iter::once(&self.current)
                .chain(&self.earlier)
                .flatten();
            columns
                .zip(c)
                .fold(d_tilde.clone(), |sum, (column, c)| sum + c * &column.image)
        };
        self.previous = Some((residual, d_tilde.clone()));
        next
    }

    fn finish_step(&mut self) {
        self.previous = None;
        self.earlier.push_front(std::mem::take(&mut self.current));
        self.earlier.truncate(self.reuse);
    }

    fn columns(&self) -> usize {
        self.used
    }
}

#[cfg(test)]
mod tests {
    use super::super::Aitken;
    use super::super::tests::LinearInterface;
    use super::*;

    #[test]
    fn solves_a_linear_problem_in_as_many_iterations_as_it_has_unknowns() {
        let problem = LinearInterface::new(5, 8.0);
        let (iterations, d) = problem.iterate(&mut IqnLs::new(0.1, 0, 1e-12), 20).unwrap();
        assert!((d - problem.solution()).norm() < 1e-8);
        assert!(iterations <= 7, "{iterations}");
    }

    #[test]
    fn needs_far_fewer_iterations_than_aitken_and_fewer_still_with_reuse() {
        let mut problem = LinearInterface::new(60, 20.0);
        let (aitken, _) = problem.iterate(&mut Aitken::new(0.05), 1000).unwrap();
        let mut model = IqnLs::new(0.05, 3, 1e-8);
        let (first, _) = problem.iterate(&mut model, 100).unwrap();
        model.finish_step();
        problem.b *= 1.1;
        problem.b[7] += 0.3;
        let (second, d) = problem.iterate(&mut model, 100).unwrap();
        assert!((d - problem.solution()).norm() < 1e-8);
        assert!(
            2 * first < aitken && second < first,
            "Aitken {aitken}, first {first}, second {second}"
        );
    }

    #[test]
    fn a_dependent_column_is_dropped_and_the_newest_kept() {
        let mut model = IqnLs::new(0.5, 2, 1e-3);
        let column = |x: f64, y: f64| Column {
            residual: DVector::from_vec(vec![x, y]),
            image: DVector::zeros(2),
        };
        model.current = VecDeque::from([column(1.0, 1e-9), column(1.0, 0.0), column(0.0, 1.0)]);
        let (q, r) = model.decompose();
        assert_eq!(q.len(), 2);
        assert_eq!(model.current[0], column(1.0, 1e-9));
        assert_eq!(model.current[1], column(0.0, 1.0));
        assert!((r[1][1] - 1.0).abs() < 1e-6);
    }
}
