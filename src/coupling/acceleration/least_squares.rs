//! The least-squares fit that all quasi-Newton models are made of: what the columns say about a residual, and what
//! they leave unsaid.

use super::{Prediction, memory::dense};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// What a trial was built from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Columns {
    /// Columns in use.
    pub used: usize,
    /// Columns dropped since the step began, because newer ones say the same.
    pub dropped: usize,
}

/// Differences between two iterations of one step, both divided by `|delta r|`: the fit does not depend on the length
/// of a column, its rounding errors do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Column {
    /// `delta r`, a column of **V**; of length 1.
    #[serde(with = "dense")]
    pub residual: DVector<f64>,
    /// `delta d`, the change of the trial that caused it. (`W = delta d_tilde` of the literature is the sum of both.)
    #[serde(with = "dense")]
    pub trial: DVector<f64>,
    /// `|delta r|` relative to the displacement, before the division.
    pub size: f64,
    /// Steps since it was added.
    pub age: usize,
}

impl Column {
    /// The column of a change `trial` of the displacement and `residual` of the residual, where the displacement is of
    /// the length `displacement`; none if the residual did not change or is not a number.
    pub fn new(trial: DVector<f64>, residual: DVector<f64>, displacement: f64) -> Option<Self> {
        let size = residual.norm();
        let usable = size.is_normal() && trial.norm().is_finite();
        usable.then(|| Self {
            residual: residual / size,
            trial: trial / size,
            size: size / displacement,
            age: 0,
        })
    }
}

/// Which columns are dropped because newer ones say the same. The newest is always kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter {
    /// A column is dropped if less than this share of it is orthogonal to all newer ones (Haelterman et al. 2016).
    pub dependence: f64,
    /// A column is dropped if its part orthogonal to all newer ones is below this share of the displacement: both
    /// solvers answer to a tolerance only, and what is smaller than their error says nothing about the Jacobian. The
    /// tolerance of the coupling is a good value, since nothing smaller has to be resolved.
    pub resolution: f64,
}

impl Filter {
    /// A filter for solvers without error.
    pub fn exact(dependence: f64) -> Self {
        Self {
            dependence,
            resolution: 0.0,
        }
    }
}

/// Columns, newest first, and the decomposition **V** = **Q R** of their residuals.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquares {
    filter: Filter,
    columns: VecDeque<Column>,
    /// Orthonormal basis of the residuals of `columns`.
    q: Vec<DVector<f64>>,
    /// `r[j]` is column j of **R**, of length j + 1.
    r: Vec<Vec<f64>>,
    /// Whether **Q** and **R** belong to `columns`.
    decomposed: bool,
    dropped: usize,
}

impl LeastSquares {
    /// No columns yet.
    pub fn new(filter: Filter) -> Self {
        Self {
            filter,
            columns: VecDeque::new(),
            q: Vec::new(),
            r: Vec::new(),
            decomposed: true,
            dropped: 0,
        }
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.columns.len()
    }

    /// Whether there are no columns.
    pub fn is_empty(&self) -> bool {
        self.columns.is_empty()
    }

    /// Columns dropped so far.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// The newest column.
    pub fn add(&mut self, column: Column) {
        self.columns.push_front(column);
        self.decomposed = false;
    }

    /// Keeps the newest `count` columns.
    pub fn truncate(&mut self, count: usize) {
        if count < self.columns.len() {
            self.columns.truncate(count);
            self.q.truncate(count);
            self.r.truncate(count);
        }
    }

    /// A step is over: every column is one step older, those of more than `oldest` steps are forgotten.
    pub fn grow_older(&mut self, oldest: usize) {
        self.columns.iter_mut().for_each(|column| column.age += 1);
        self.truncate(self.columns.partition_point(|column| column.age <= oldest));
        self.dropped = 0;
    }

    /// Takes all columns out, newest first.
    pub fn take(&mut self) -> VecDeque<Column> {
        let taken = std::mem::take(&mut self.columns);
        *self = Self::new(self.filter);
        taken
    }

    /// All columns, newest first.
    pub fn columns(&self) -> Vec<Column> {
        self.columns.iter().cloned().collect()
    }

    /// Replaces all columns, newest first.
    pub fn put(&mut self, columns: impl IntoIterator<Item = Column>) {
        *self = Self::new(self.filter);
        self.columns.extend(columns);
        self.decomposed = self.columns.is_empty();
    }

    /// `delta D c` with the `c` that minimizes `|V c + r|`, and the rest `r + V c`.
    pub fn predict(&mut self, residual: &DVector<f64>) -> Prediction {
        self.decompose();
        let mut c: Vec<f64> = self.q.iter().map(|basis| -basis.dot(residual)).collect();
        let mut rest = residual.clone();
        for (basis, c) in self.q.iter().zip(&c) {
            rest.axpy(*c, basis, 1.0);
        }
        // Back substitution R c = -Qᵀ r.
        for j in (0..c.len()).rev() {
            c[j] /= self.r[j][j];
            for i in 0..j {
                c[i] -= self.r[j][i] * c[j];
            }
        }
        let mut correction = DVector::zeros(residual.len());
        for (column, c) in self.columns.iter().zip(c) {
            correction.axpy(c, &column.trial, 1.0);
        }
        Prediction { correction, rest }
    }

    /// Gram-Schmidt, newest column first, dropping the dependent ones.
    fn decompose(&mut self) {
        if self.decomposed {
            return;
        }
        self.decomposed = true;
        self.q.clear();
        self.r.clear();
        let (q, r, filter) = (&mut self.q, &mut self.r, self.filter);
        let before = self.columns.len();
        self.columns.retain(|column| {
            let mut v = column.residual.clone();
            let mut shares = vec![0.0; q.len()];
            // Twice: once is not enough for nearly dependent columns.
            for _ in 0..2 {
                for (basis, sum) in q.iter().zip(&mut shares) {
                    let share = basis.dot(&v);
                    v.axpy(-share, basis, 1.0);
                    *sum += share;
                }
            }
            let independent = v.norm();
            let keep = independent > 0.0
                && (q.is_empty()
                    || independent > filter.dependence.max(filter.resolution / column.size))
                && q.len() < v.len();
            if keep {
                shares.push(independent);
                q.push(v / independent);
                r.push(shares);
            }
            keep
        });
        self.dropped += before - self.columns.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(x: f64, y: f64) -> Column {
        let residual = DVector::from_vec(vec![x, y]);
        Column::new(2.0 * &residual, residual, 1.0).unwrap()
    }

    #[test]
    fn a_dependent_column_is_dropped_and_the_newest_kept() {
        let mut fit = LeastSquares::new(Filter::exact(1e-3));
        for c in [column(0.0, 3.0), column(1.0, 0.0), column(1.0, 1e-9)] {
            fit.add(c);
        }
        let answer = fit.predict(&DVector::from_vec(vec![1.0, 1.0]));
        assert_eq!((fit.len(), fit.dropped()), (2, 1));
        assert_eq!(fit.columns[0], column(1.0, 1e-9));
        assert_eq!(fit.columns[1], column(0.0, 3.0));
        assert!((answer.correction + DVector::from_vec(vec![2.0, 2.0])).norm() < 1e-12);
        assert!(answer.rest.norm() < 1e-12);
    }

    #[test]
    fn a_change_below_the_resolution_is_dropped_unless_it_is_the_newest() {
        let mut fit = LeastSquares::new(Filter {
            dependence: 1e-3,
            resolution: 0.1,
        });
        for c in [column(0.0, 0.09), column(3.0, 0.0), column(0.01, 0.01)] {
            fit.add(c);
            fit.decompose();
        }
        assert_eq!((fit.len(), fit.dropped()), (2, 1));
        assert_eq!(fit.columns[0], column(0.01, 0.01));
    }

    #[test]
    fn what_the_columns_do_not_span_is_left_as_rest() {
        let mut fit = LeastSquares::new(Filter::exact(1e-3));
        fit.add(column(2.0, 0.0));
        let answer = fit.predict(&DVector::from_vec(vec![0.5, 7.0]));
        assert_eq!(answer.correction, DVector::from_vec(vec![-1.0, 0.0]));
        assert_eq!(answer.rest, DVector::from_vec(vec![0.0, 7.0]));
    }

    #[test]
    fn a_change_that_is_zero_or_not_a_number_is_no_column() {
        let zero = DVector::zeros(2);
        assert!(Column::new(zero.clone(), zero.clone(), 1.0).is_none());
        assert!(Column::new(zero, DVector::from_element(2, f64::NAN), 1.0).is_none());
    }
}
