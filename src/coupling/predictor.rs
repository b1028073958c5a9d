//! First guess of a time step by extrapolation of the accepted displacements.

use nalgebra::DVector;
use std::collections::VecDeque;

/// Extrapolates the polynomial of a given degree through the last accepted displacements; of a lower degree as long
/// as there are too few of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictor {
    degree: usize,
    /// Newest first; at least one.
    history: VecDeque<DVector<f64>>,
}

impl Predictor {
    /// A predictor of `degree` (0, 1 or 2) that starts from `initial`, the displacement at rest.
    pub fn new(degree: usize, initial: DVector<f64>) -> Self {
        assert!(
            degree <= 2,
            "extrapolation of degree {degree}: only 0, 1 and 2 are useful"
        );
        Self {
            degree,
            history: VecDeque::from([initial]),
        }
    }

    /// The extrapolated displacement.
    pub fn first_guess(&self) -> DVector<f64> {
        let h = &self.history;
        match self.degree.min(h.len() - 1) {
            0 => h[0].clone(),
            1 => 2.0 * &h[0] - &h[1],
            _ => 3.0 * &h[0] - 3.0 * &h[1] + &h[2],
        }
    }

    /// Remembers an accepted displacement.
    pub fn accept(&mut self, displacement: DVector<f64>) {
        self.history.push_front(displacement);
        self.history.truncate(self.degree + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_of_its_degree_are_predicted_exactly() {
        for degree in 0..=2 {
            let value = |step: i32| {
                DVector::from_element(2, (0..=degree).map(|k| f64::from(step).powi(k)).sum())
            };
            let mut predictor = Predictor::new(degree as usize, value(0));
            for step in 1..6 {
                predictor.accept(value(step));
            }
            let expected = value(if degree == 0 { 5 } else { 6 });
            assert!((predictor.first_guess() - expected).norm() < 1e-12);
        }
    }
}
