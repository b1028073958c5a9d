//! Polynomial chaos of a field: one polynomial of the germs for each place, all fitted at once.

use super::Inputs;
use super::basis::{Polynomials, terms};
use super::chaos::{LEAST_SAMPLES, matrix};
use nalgebra::DMatrix;

/// Degrees that are tried, at most: a field has no need of more.
const HIGHEST: usize = 4;

/// For each place of a field the full polynomial of the highest degree that has a coefficient for at most each second
/// sample. No terms are chosen, unlike in a [`Chaos`](super::Chaos): neighbouring places then have the same ones, and
/// one factorization serves them all.
#[derive(Debug, Clone)]
pub struct FieldChaos {
    terms: Vec<Vec<usize>>,
    /// Terms x places.
    coefficients: DMatrix<f64>,
    left_out: Vec<f64>,
}

impl FieldChaos {
    /// Of `values`, samples x places, found at these germs; `None` if the samples are too few for a degree of 1.
    pub fn fit(inputs: &Inputs, germs: &[Vec<f64>], values: &DMatrix<f64>) -> Option<Self> {
        let samples = values.nrows();
        let even = vec![1.0; inputs.count()];
        let fits = |degree: &usize| LEAST_SAMPLES * terms(&even, *degree, 1.0).len() <= samples;
        let degree = (1..=HIGHEST).rev().find(fits)?;
        let terms = terms(&even, degree, 1.0);
        let laws = inputs.germs().into_iter();
        let polynomials: Vec<_> = laws.map(|germ| Polynomials::new(germ, degree)).collect();
        let qr = matrix(&polynomials, &terms, germs).qr();
        let q = qr.q();
        let along = q.transpose() * values;
        let coefficients = qr.r().solve_upper_triangular(&along)?;
        let rest = values - &q * along;
        let share: Vec<f64> = q.row_iter().map(|row| 1.0 - row.norm_squared()).collect();
        let left_out = (0..values.ncols()).map(|place| {
            let missed = (0..samples).map(|i| (rest[(i, place)] / share[i]).powi(2));
            missed.sum::<f64>() / (samples as f64 * values.column(place).variance())
        });
        Some(Self {
            left_out: left_out.collect(),
            terms,
            coefficients,
        })
    }

    /// The total degree of its polynomials.
    pub fn degree(&self) -> usize {
        let degrees = self.terms.iter().map(|term| term.iter().sum());
        degrees.max().unwrap_or(0)
    }

    /// Its mean at a place.
    pub fn mean(&self, place: usize) -> f64 {
        self.coefficients[(0, place)]
    }

    /// Its standard deviation at a place.
    pub fn deviation(&self, place: usize) -> f64 {
        self.variance_of(place, |_| true).sqrt()
    }

    /// The share of the variance at a place that the polynomial of all other samples misses at each.
    pub fn leave_one_out_error(&self, place: usize) -> f64 {
        self.left_out[place]
    }

    /// The share of the variance at a place that an input has with all its interactions; not a number where nothing
    /// varies.
    pub fn total_index(&self, input: usize, place: usize) -> f64 {
        self.variance_of(place, |term| term[input] > 0) / self.variance_of(place, |_| true)
    }

    fn variance_of(&self, place: usize, has: impl Fn(&[usize]) -> bool) -> f64 {
        let column = self.coefficients.column(place);
        let squares = self.terms.iter().zip(column.iter()).skip(1);
        squares
            .filter(|(term, _)| has(term))
            .map(|(_, c)| c * c)
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Design, Distribution};
    use super::*;

    /// At three places: a constant, a sum and a product of two inputs. With a = U(-1, 1) and b = N(0, 1) the variances
    /// of a + 2 b are 1/3 and 4, that of a b is 1/3, and both inputs have all of it.
    #[test]
    fn each_place_has_the_indices_of_its_own_function() {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        let inputs = vec![
            Distribution::uniform(-1.0, 1.0),
            Distribution::normal(0.0, 1.0, everywhere),
        ];
        let inputs = Inputs::new(inputs, &[]).unwrap();
        let points = "sobol:14".parse::<Design>().unwrap().points(2).unwrap();
        let germs: Vec<_> = points.iter().map(|p| inputs.germs_at(p)).collect();
        let value = |i: usize, place: usize| {
            let x = inputs.values_at(&points[i]);
            [3.0, 1.0 + x[0] + 2.0 * x[1], x[0] * x[1]][place]
        };
        let values = DMatrix::from_fn(14, 3, value);
        let field = FieldChaos::fit(&inputs, &germs, &values).unwrap();
        assert_eq!(field.degree(), 2); // six coefficients; ten of degree 3 would ask for 20 samples
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-10, "{a} is not {b}");
        near(field.mean(0), 3.0);
        near(field.deviation(0), 0.0);
        near(field.mean(1), 1.0);
        near(field.deviation(1), (1.0_f64 / 3.0 + 4.0).sqrt());
        near(field.total_index(0, 1), 1.0 / 13.0);
        near(field.total_index(1, 1), 12.0 / 13.0);
        near(field.deviation(2), (1.0_f64 / 3.0).sqrt());
        near(field.total_index(0, 2), 1.0);
        near(field.total_index(1, 2), 1.0);
        assert!(field.leave_one_out_error(2) < 1e-20);

        // What the degree does not hold is told by the error, and too few samples are refused.
        let cubic = DMatrix::from_fn(14, 1, |i, _| inputs.values_at(&points[i])[1].powi(3));
        let field = FieldChaos::fit(&inputs, &germs, &cubic).unwrap();
        assert!(field.leave_one_out_error(0) > 0.1);
        assert!(FieldChaos::fit(&inputs, &germs[..5], &values.rows(0, 5).into()).is_none());
    }
}
