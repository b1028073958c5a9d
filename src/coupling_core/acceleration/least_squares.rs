//! The least-squares fit that all quasi-Newton models are made of: what the columns say about a residual, and what
//! they leave unsaid.

use nalgebra::{Cholesky, DMatrix, DVector};
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
pub struct SecantPair {
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

impl SecantPair {
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

/// A dense vector as a plain list of numbers.
mod dense {
    use nalgebra::DVector;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(
        vector: &DVector<f64>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        vector.as_slice().serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<DVector<f64>, D::Error> {
        Vec::deserialize(deserializer).map(DVector::from_vec)
    }
}

/// What a model says about a residual.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// The change of the displacement that would remove what the model knows of the residual.
    pub correction: DVector<f64>,
    /// What it knows nothing about.
    pub rest: DVector<f64>,
}

/// How columns are judged: which are dropped because newer ones say the same, and how far the others are believed. The
/// newest is always kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filter {
    /// A column is dropped if less than this share of it is orthogonal to all newer ones (Haelterman et al. 2016).
    pub dependence: f64,
    /// A column is dropped if its part orthogonal to all newer ones is below this share of the displacement: both
    /// solvers answer to a tolerance only, and what is smaller than their error says nothing about the Jacobian. The
    /// tolerance of the coupling is a good value, since nothing smaller has to be resolved.
    pub resolution: f64,
    /// Error of what a new column says about the Jacobian over that of whatever answers for the rest. Older columns are
    /// doubted more.
    pub doubt: f64,
}

/// Doubt of a new column with a surrogate. Measured on the elastic tube and on S-0.25, where from 0.003 to 0.02 made
/// little difference.
const DOUBT: f64 = 0.01;

/// Growth of a column's doubt with each step, relative to that of a new one.
const AGING: f64 = 0.3;

/// Shares of a column below this are rounding errors: they come from products, so that they are exact to the root of
/// the machine's precision.
const ROUNDING: f64 = 1e-6;

impl Filter {
    /// The filter of models with a surrogate, or without: what a fixed-point iteration makes of the rest is so wrong
    /// where there is much added mass that any column is better.
    pub fn new(dependence: f64, resolution: f64, surrogate: bool) -> Self {
        Self {
            dependence,
            resolution,
            doubt: if surrogate { DOUBT } else { 0.0 },
        }
    }

    /// A filter for a linear problem and solvers without error.
    pub fn exact(dependence: f64) -> Self {
        Self::new(dependence, 0.0, false)
    }

    /// The share of `column` that newer ones must leave.
    fn threshold(&self, column: &SecantPair) -> f64 {
        self.dependence
            .max(self.resolution / column.size)
            .max(ROUNDING)
    }

    /// The weight of a column's coefficient in the fit.
    fn weight(&self, column: &SecantPair) -> f64 {
        self.doubt * (1.0 + AGING * column.age as f64)
    }
}

/// Columns, newest first.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquares {
    filter: Filter,
    columns: VecDeque<SecantPair>,
    /// **V**ᵀ**V**, the products of the residuals of `columns`.
    gram: DMatrix<f64>,
    /// Whether `columns` are independent.
    filtered: bool,
    dropped: usize,
}

impl LeastSquares {
    /// No columns yet.
    pub fn new(filter: Filter) -> Self {
        Self {
            filter,
            columns: VecDeque::new(),
            gram: DMatrix::zeros(0, 0),
            filtered: true,
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
    pub fn add(&mut self, column: SecantPair) {
        self.columns.push_front(column);
        let products = self.products(&self.columns[0].residual);
        let gram = std::mem::replace(&mut self.gram, DMatrix::zeros(0, 0));
        self.gram = gram.insert_row(0, 0.0).insert_column(0, 0.0);
        self.gram.set_row(0, &products.transpose());
        self.gram.set_column(0, &products);
        self.filtered = false;
    }

    /// Believes all columns.
    pub fn believe(&mut self) {
        self.filter.doubt = 0.0;
    }

    /// Keeps the newest `count` columns.
    pub fn truncate(&mut self, count: usize) {
        if count < self.columns.len() {
            self.columns.truncate(count);
            self.gram.resize_mut(count, count, 0.0);
        }
    }

    /// A step is over: every column is one step older, those of more than `oldest` steps are forgotten.
    pub fn grow_older(&mut self, oldest: usize) {
        self.columns.iter_mut().for_each(|column| column.age += 1);
        self.truncate(self.columns.partition_point(|column| column.age <= oldest));
        self.dropped = 0;
    }

    /// Takes all columns out, newest first.
    pub fn take(&mut self) -> VecDeque<SecantPair> {
        let taken = std::mem::take(&mut self.columns);
        *self = Self::new(self.filter);
        taken
    }

    /// All columns, newest first.
    pub fn columns(&self) -> Vec<SecantPair> {
        self.columns.iter().cloned().collect()
    }

    /// Replaces all columns, newest first.
    pub fn put(
        &mut self,
        columns: impl IntoIterator<Item = SecantPair, IntoIter: DoubleEndedIterator>,
    ) {
        *self = Self::new(self.filter);
        columns
            .into_iter()
            .rev()
            .for_each(|column| self.add(column));
    }

    /// `delta D c` with the `c` that minimizes `|V c + r|² + |Λ c|²`, and the rest `r + V c`.
    ///
    /// A coefficient `c_j` brings an error proportional to itself into the answer, and the rest one proportional to the
    /// rest: `Λ`, the doubts of the columns, balances the two (Tikhonov's regularization). Otherwise a nearly dependent
    /// combination of old columns, small differences with large coefficients, would be believed as much as a new one.
    pub fn predict(&mut self, residual: &DVector<f64>) -> Prediction {
        self.drop_dependent();
        let mut matrix = self.gram.clone();
        for (j, column) in self.columns.iter().enumerate() {
            matrix[(j, j)] += self.filter.weight(column).powi(2);
        }
        let mut c = -self.products(residual);
        let positive = "the products of independent columns are positive definite";
        Cholesky::new(matrix).expect(positive).solve_mut(&mut c);
        let mut correction = DVector::zeros(residual.len());
        let mut rest = residual.clone();
        for (column, c) in self.columns.iter().zip(c.iter()) {
            correction.axpy(*c, &column.trial, 1.0);
            rest.axpy(*c, &column.residual, 1.0);
        }
        Prediction { correction, rest }
    }

    /// The products of all columns with `residual`.
    fn products(&self, residual: &DVector<f64>) -> DVector<f64> {
        let products = self.columns.iter().map(|c| c.residual.dot(residual));
        DVector::from_iterator(self.columns.len(), products)
    }

    /// Drops columns that depend on newer ones: a Cholesky decomposition of the products, newest first.
    fn drop_dependent(&mut self) {
        if std::mem::replace(&mut self.filtered, true) {
            return;
        }
        let mut kept = Vec::new();
        let mut factor: Vec<Vec<f64>> = Vec::new();
        for (i, column) in self.columns.iter().enumerate() {
            let mut row = Vec::with_capacity(factor.len() + 1);
            for (above, j) in factor.iter().zip(&kept) {
                let known: f64 = row.iter().zip(above).map(|(a, b): (&f64, _)| a * b).sum();
                row.push((self.gram[(i, *j)] - known) / above[row.len()]);
            }
            let square = self.gram[(i, i)] - row.iter().map(|share| share * share).sum::<f64>();
            if kept.is_empty() || square > self.filter.threshold(column).powi(2) {
                row.push(square.sqrt());
                factor.push(row);
                kept.push(i);
            }
        }
        self.dropped += self.columns.len() - kept.len();
        self.gram = self.gram.select_rows(&kept).select_columns(&kept);
        let mut place = 0..;
        self.columns
            .retain(|_| place.next().is_some_and(|i| kept.binary_search(&i).is_ok()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(x: f64, y: f64) -> SecantPair {
        let residual = DVector::from_vec(vec![x, y]);
        SecantPair::new(2.0 * &residual, residual, 1.0).unwrap()
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

    /// A change below the resolution is dropped unless it is the newest.
    #[test]
    fn changes_below_the_resolution_are_dropped() {
        let mut fit = LeastSquares::new(Filter {
            resolution: 0.1,
            ..Filter::exact(1e-3)
        });
        for c in [column(0.0, 0.09), column(3.0, 0.0), column(0.01, 0.01)] {
            fit.add(c);
            fit.drop_dependent();
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
    fn coefficients_minimize_what_is_left_and_what_is_doubted() {
        let filter = Filter {
            doubt: 0.1,
            ..Filter::exact(1e-3)
        };
        let mut fit = LeastSquares::new(filter);
        fit.add(column(0.6, 0.8));
        (0..3).for_each(|_| fit.grow_older(9));
        fit.add(column(1.0, 0.0));
        let residual = DVector::from_vec(vec![0.3, -0.7]);
        let objective = |change: [f64; 2]| {
            // The trials are twice the residuals.
            let answer = fit.clone().predict(&residual).correction / -2.0;
            let c = [answer[0] - 0.75 * answer[1], answer[1] / 0.8];
            let c = [c[0] + change[0], c[1] + change[1]];
            let rest = [residual[0] - c[0] - 0.6 * c[1], residual[1] - 0.8 * c[1]];
            let doubts = [0.1 * c[0], 0.1 * (1.0 + 3.0 * AGING) * c[1]];
            rest.iter().chain(&doubts).map(|x| x * x).sum::<f64>()
        };
        let least = objective([0.0; 2]);
        for change in [[1e-3, 0.0], [-1e-3, 0.0], [0.0, 1e-3], [0.0, -1e-3]] {
            assert!(objective(change) > least);
        }
    }

    #[test]
    fn a_change_that_is_zero_or_non_finite_is_left_out() {
        let zero = DVector::zeros(2);
        assert!(SecantPair::new(zero.clone(), zero.clone(), 1.0).is_none());
        assert!(SecantPair::new(zero, DVector::from_element(2, f64::NAN), 1.0).is_none());
    }
}
