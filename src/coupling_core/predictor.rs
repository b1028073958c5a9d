//! First guess of a time step by extrapolation of the accepted displacements.

use fsi_numerics::words;
use nalgebra::DVector;
use std::collections::VecDeque;

words! {
    /// How accepted displacements are extrapolated to the next step of the same length; simplest first.
    pub enum Extrapolation {
        /// The last displacement.
        Constant = "constant",
        /// The line through the last two.
        Linear = "linear",
        /// The parabola through the last three.
        Quadratic = "quadratic",
        /// The parabola that fits the last five best: with Legendre's polynomials for equidistant points (Gram's).
        /// Where accepted displacements carry the scatter of the coupling tolerance it passes less of it on:
        /// `sqrt(sum w²)` is 2.1 against 4.4 for the parabola through three.
        LeastSquares = "least_squares",
    }
}

/// Displacements that the longest extrapolation needs.
const LONGEST: usize = 5;

impl Extrapolation {
    /// Weights of the displacements, newest first.
    fn weights(self) -> &'static [f64] {
        match self {
            Self::Constant => &[1.0],
            Self::Linear => &[2.0, -1.0],
            Self::Quadratic => &[3.0, -3.0, 1.0],
            // sum over k of P_k(3) P_k(t) / sum of P_k² for t = 2, 1, 0, -1, -2 with P = 1, t, t² - 2.
            Self::LeastSquares => &[1.8, 0.0, -0.8, -0.6, 0.6],
        }
    }

    /// The extrapolation of `history` (newest first), if that is long enough.
    fn apply(self, history: &VecDeque<DVector<f64>>) -> Option<DVector<f64>> {
        let weights = self.weights();
        (history.len() >= weights.len()).then(|| {
            let mut guess = DVector::zeros(history[0].len());
            for (weight, displacement) in weights.iter().zip(history) {
                guess.axpy(*weight, displacement, 1.0);
            }
            guess
        })
    }
}

/// Extrapolates, and falls back to something simpler where that would have served the last step better.
///
/// Only the first residual of the guess that was used can be seen, but once a step is accepted the error of *every*
/// guess is known: its distance to the accepted displacement, which the first residual is proportional to (by
/// `1 - d(S∘F)/dd`, whatever the guess). So each step begins with the extrapolation, up to the chosen one, whose error
/// was smallest in the last step; at a kink of the load (a valve that closes, the end of a ramp) this is the constant
/// one for a step or two. It costs two vector operations a candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Predictor {
    chosen: Extrapolation,
    falls_back: bool,
    /// Newest first; at least one.
    history: VecDeque<DVector<f64>>,
    /// Errors of the candidates in the last step, simplest first; infinite if the history was too short.
    errors: Vec<f64>,
}

impl Predictor {
    /// A predictor that starts from `initial`, the displacement at rest, and may fall back to what is simpler than
    /// `chosen`.
    pub fn new(chosen: Extrapolation, initial: DVector<f64>) -> Self {
        Self {
            chosen,
            falls_back: true,
            history: VecDeque::from([initial]),
            errors: Vec::new(),
        }
    }

    /// The same without the fall-back (to a shorter one only while the history is too short).
    #[cfg(test)]
    fn rigid(self) -> Self {
        Self {
            falls_back: false,
            ..self
        }
    }

    /// What the next guess is made with.
    pub fn current(&self) -> Extrapolation {
        let fits = |e: &Extrapolation| e.weights().len() <= self.history.len();
        let longest = self.candidates().filter(fits).last();
        let best = self
            .candidates()
            .zip(&self.errors)
            .filter(|(_, error)| error.is_finite())
            .min_by(|a, b| a.1.total_cmp(b.1))
            .map(|(candidate, _)| candidate);
        let choice = if self.falls_back {
            best.or(longest)
        } else {
            longest
        };
        choice.unwrap_or(Extrapolation::Constant)
    }

    /// The extrapolated displacement.
    pub fn first_guess(&self) -> DVector<f64> {
        let guess = self.current().apply(&self.history);
        guess.unwrap_or_else(|| self.history[0].clone())
    }

    /// Remembers an accepted displacement.
    pub fn accept(&mut self, displacement: DVector<f64>) {
        let error = |candidate: Extrapolation| {
            let guess = candidate.apply(&self.history);
            guess.map_or(f64::INFINITY, |guess| (guess - &displacement).norm())
        };
        self.errors = self.candidates().map(error).collect();
        self.history.push_front(displacement);
        self.history.truncate(LONGEST);
    }

    /// Steps are `ratio` times as long from now on: the history becomes what it would have been with such steps, by
    /// parabolas through the three displacements around each time, as far back as it reaches.
    pub fn resample(&mut self, ratio: f64) {
        let Some(last) = self.history.len().checked_sub(3) else {
            self.reset();
            return;
        };
        let at = |age: f64| {
            let first = (age.round() as usize).saturating_sub(1).min(last);
            let x = age - first as f64;
            let weights = [
                0.5 * (x - 1.0) * (x - 2.0),
                x * (2.0 - x),
                0.5 * x * (x - 1.0),
            ];
            let around = weights.iter().zip(self.history.range(first..));
            around.fold(DVector::zeros(self.history[0].len()), |sum, (weight, d)| {
                sum + *weight * d
            })
        };
        let ages = (0..LONGEST).map(|step| step as f64 * ratio);
        self.history = ages
            .take_while(|age| *age <= (last + 2) as f64)
            .map(at)
            .collect();
    }

    /// Forgets all but the last displacement, so that the next guess is the constant one.
    pub fn reset(&mut self) {
        self.history.truncate(1);
        self.errors.clear();
    }

    /// The displacement that was accepted last.
    pub fn last(&self) -> &DVector<f64> {
        &self.history[0]
    }

    /// What it knows of earlier steps: their displacements, newest first, and the errors of the candidates.
    pub fn memory(&self) -> (Vec<Vec<f64>>, Vec<f64>) {
        let history = self.history.iter().map(|d| d.as_slice().to_vec());
        (history.collect(), self.errors.clone())
    }

    /// Continues as the one whose memory this is; an empty history is ignored.
    pub fn recall(&mut self, history: Vec<Vec<f64>>, errors: Vec<f64>) {
        if !history.is_empty() {
            self.history = history.into_iter().map(DVector::from_vec).collect();
            self.errors = errors;
        }
    }

    /// From the constant one up to the chosen one.
    fn candidates(&self) -> impl Iterator<Item = Extrapolation> + use<> {
        let chosen = self.chosen;
        let simpler = Extrapolation::ALL
            .into_iter()
            .take_while(move |e| *e != chosen);
        simpler.chain([chosen])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Extrapolation::*;

    fn after(chosen: Extrapolation, steps: i32, value: impl Fn(i32) -> f64) -> Predictor {
        let value = |step| DVector::from_element(2, value(step));
        let mut predictor = Predictor::new(chosen, value(0));
        (1..=steps).for_each(|step| predictor.accept(value(step)));
        predictor
    }

    #[test]
    fn polynomials_of_its_degree_are_predicted_exactly() {
        for (chosen, degree) in [
            (Constant, 0),
            (Linear, 1),
            (Quadratic, 2),
            (LeastSquares, 2),
        ] {
            let value = |step: i32| (0..=degree).map(|k| f64::from(step).powi(k)).sum();
            for predictor in [after(chosen, 6, value), after(chosen, 6, value).rigid()] {
                let guess = predictor.first_guess();
                assert!((guess[0] - value(7)).abs() < 1e-12, "{chosen:?} {guess}");
            }
        }
    }

    #[test]
    fn a_parabola_is_predicted_exactly_after_the_step_has_changed() {
        let value = |t: f64| 1.0 + t * (2.0 + t);
        for ratio in [0.25, 0.5, 2.0] {
            let mut predictor = after(Quadratic, 6, |step| value(f64::from(step)));
            predictor.resample(ratio);
            let guess = predictor.first_guess();
            assert!((guess[0] - value(6.0 + ratio)).abs() < 1e-12, "{guess}");
            assert_eq!(predictor.last()[0], value(6.0));
        }
        let mut predictor = after(Quadratic, 1, f64::from);
        predictor.resample(0.5);
        assert_eq!(predictor.first_guess()[0], 1.0);
    }

    #[test]
    fn least_squares_pass_on_less_scatter_than_interpolation() {
        let size = |e: Extrapolation| e.weights().iter().map(|w| w * w).sum::<f64>().sqrt();
        assert!((size(Quadratic) - 4.36).abs() < 0.01 && (size(LeastSquares) - 2.14).abs() < 0.01);
    }

    #[test]
    fn a_kink_makes_it_fall_back_and_smoothness_brings_it_back() {
        let ramp = |step: i32| f64::from(step.min(10));
        assert_eq!(after(Quadratic, 10, ramp).current(), Linear);
        assert_eq!(after(Quadratic, 11, ramp).current(), Constant);
        assert_eq!(after(Quadratic, 11, ramp).rigid().current(), Quadratic);
        let wave = |step: i32| {
            if step < 10 {
                1.0
            } else {
                (0.05 * f64::from(step - 10)).cos()
            }
        };
        assert_eq!(after(Quadratic, 16, wave).current(), Quadratic);
    }
}
