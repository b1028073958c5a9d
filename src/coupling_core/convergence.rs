//! Criterion (14).

use fsi_numerics::words;
use nalgebra::DVector;

words! {
    /// What must be small for a coupling iteration to have converged.
    #[derive(Default)]
    pub enum ConvergenceQuantity {
        /// The change of the accelerated displacement: criterion (14).
        Change = "change" (default),
        /// The residual of the fixed point, by which most published numbers of iterations are counted.
        Residual = "residual",
    }
}

/// A change below the limit does not count while the residual is this many times above it. The state that is
/// accepted is the image `S∘F(d)`: its distance to the solution is about the residual, which with much added mass is 20
/// times the change, and a wrong Jacobian can make the change small by chance.
const MISTRUST: f64 = 2.0;

/// A step has not converged while its error is more than this share of what it moves, however small both are.
const SHARE_OF_MOTION: f64 = 0.1;
/// The solvers answer to this share of the relative limit, of all that the wall is displaced: nothing smaller is asked
/// of them.
const ANSWERED: f64 = 1e-2;
/// Nor is this share of the absolute limit, where the wall does not move at all.
const NOTHING: f64 = 1e-4;

/// When a coupling iteration counts as converged: `|x| / |d_k| < relative`, or the root mean square of `x` over the
/// points below `absolute`, where `x` is the change `d_{k+1} - d_k` (14) or the residual `S∘F(d_k) - d_k`. A change
/// counts only while the residual does not contradict it, and both limits only as far as they are a small share of what
/// the step moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criterion {
    /// Which of the two.
    pub quantity: ConvergenceQuantity,
    /// e_rel of equation (14).
    pub relative: f64,
    /// e_abs of equation (14) as root mean square over the points, m.
    pub absolute: f64,
    /// Root mean square over the points of how far the wall is from its unloaded shape where the displacement is zero,
    /// m.
    pub displaced: f64,
    /// Most iterations of a step.
    pub max_iterations: usize,
    /// Share of the usual relaxation factor that is being used: a small factor makes the change of a relaxed trial
    /// small, but not its error.
    pub share: f64,
}

/// Distance of a coupling iteration to convergence.
///
/// Criterion (14) tests the change of the *accelerated* displacement, which a small relaxation factor makes small by
/// itself; the residual of the fixed point is recorded next to it so that one can tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResidualMeasure {
    /// |d_{k+1} - d_k| / |d_k|.
    pub change: f64,
    /// Root mean square of d_{k+1} - d_k over the points, m.
    pub change_rms: f64,
    /// |S∘F(d_k) - d_k| / |d_k|.
    pub residual: f64,
    /// Root mean square of S∘F(d_k) - d_k over the points, m.
    pub residual_rms: f64,
    /// Whether the criterion is met.
    pub converged: bool,
}

impl Criterion {
    /// By the residual relative to the displacement alone.
    pub fn of_residual(relative: f64, max_iterations: usize) -> Self {
        Self {
            quantity: ConvergenceQuantity::Residual,
            relative,
            absolute: 0.0,
            displaced: 0.0,
            max_iterations,
            share: 1.0,
        }
    }

    /// Measures the iteration that went from `d` by `d_tilde = S∘F(d)` to `d_next`, which is `relaxed` or was found by
    /// a quasi-Newton model. The step begins at the displacement `last`.
    pub fn measure(
        &self,
        d: &DVector<f64>,
        d_tilde: &DVector<f64>,
        d_next: &DVector<f64>,
        relaxed: bool,
        last: &DVector<f64>,
    ) -> ResidualMeasure {
        let points = (d.len() as f64 / 3.0).sqrt();
        // A run that starts from rest has nothing else to compare with than the first image.
        let size = if d.norm() > 0.0 {
            d.norm()
        } else {
            d_tilde.norm()
        };
        let relative = |x: f64| if x > 0.0 { x / size } else { 0.0 };
        let limit = self.limit(size, (d_tilde - last).norm(), points);
        let share = if relaxed { self.share } else { 1.0 };
        let (change, residual) = ((d_next - d).norm() / share, (d_tilde - d).norm());
        let converged = match self.quantity {
            ConvergenceQuantity::Change => change <= limit && residual <= MISTRUST * limit,
            ConvergenceQuantity::Residual => residual < limit,
        };
        ResidualMeasure {
            change: relative(change),
            change_rms: change / points,
            residual: relative(residual),
            residual_rms: residual / points,
            converged,
        }
    }

    /// The residual relative to the displacement from the unloaded shape, which the loads on the wall go with.
    pub fn share_of_all(&self, measure: &ResidualMeasure) -> f64 {
        match self.displaced {
            0.0 => measure.residual,
            displaced => {
                let size = measure.residual_rms / measure.residual;
                measure.residual_rms / (size + displaced)
            }
        }
    }

    /// The norm below which a change or residual counts as nothing, in a step that moves `motion` to a displacement of
    /// this `size`; `points` is the root of their number.
    fn limit(&self, size: f64, motion: f64, points: f64) -> f64 {
        let answered = ANSWERED * self.relative * (size + self.displaced * points);
        let nothing = NOTHING * self.absolute * points;
        let wanted = (self.relative * size).max(self.absolute * points);
        wanted.min((SHARE_OF_MOTION * motion).max(answered).max(nothing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For one point, displaced by 1 m.
    fn measure(
        quantity: ConvergenceQuantity,
        limits: [f64; 2],
        change: f64,
        residual: f64,
    ) -> bool {
        let criterion = Criterion {
            quantity,
            relative: limits[0],
            absolute: limits[1],
            displaced: 0.0,
            max_iterations: 1,
            share: 1.0,
        };
        let d = DVector::from_vec(vec![1.0, 0.0, 0.0]);
        let [next, image] = [change, residual].map(|by| (1.0 + by) * &d);
        (criterion.measure(&d, &image, &next, false, &DVector::zeros(3))).converged
    }

    #[test]
    fn an_absolute_limit_does_not_accept_a_step_that_moves_less() {
        let criterion = Criterion {
            quantity: ConvergenceQuantity::Change,
            relative: 1e-5,
            absolute: 1e-9,
            displaced: 0.0,
            max_iterations: 1,
            share: 1.0,
        };
        let one = |x: f64| DVector::from_vec(vec![x, 0.0, 0.0]);
        let converged = |criterion: &Criterion, last: f64, d: f64, residual: f64| {
            let (d, image) = (one(d), one(d + residual));
            (criterion.measure(&d, &image, &image, false, &one(last))).converged
        };
        // From rest, by a tenth of the absolute limit.
        assert!(!converged(&criterion, 0.0, 1e-10, 2e-11));
        assert!(converged(&criterion, 0.0, 1e-10, 0.9e-11));
        // Less than what the relative limit would allow.
        assert!(!converged(&criterion, 1e-3, 1e-3 + 1e-8, 2e-9));
        assert!(converged(&criterion, 1e-3, 1e-3 + 1e-8, 0.9e-9));
        // A wall that stands still does so to the solvers' accuracy, from its unloaded shape or from the given one.
        assert!(converged(&criterion, 1e-3, 1e-3, 0.9e-10));
        assert!(!converged(&criterion, 1e-3, 1e-3, 2e-10));
        let loaded = Criterion {
            displaced: 1e-3,
            ..criterion
        };
        assert!(converged(&loaded, 0.0, 0.0, 0.9e-10));
        assert!(!converged(&loaded, 0.0, 0.0, 2e-10));
        assert!(converged(&criterion, 0.0, 0.0, 0.0) && converged(&criterion, 0.0, 0.0, 0.9e-13));
    }

    #[test]
    fn a_small_change_counts_unless_the_residual_contradicts() {
        for limits in [[1e-6, 1e-12], [1e-12, 1e-6]] {
            let converged =
                |change, residual| measure(ConvergenceQuantity::Change, limits, change, residual);
            assert!(converged(5e-7, 1.9e-6));
            assert!(!converged(2e-6, 1.9e-6));
            assert!(!converged(5e-7, 1e-4));
            assert!(!converged(1e-13, 1e-4));
        }
    }

    #[test]
    fn others_count_by_the_residual() {
        let converged = |change, residual| {
            measure(
                ConvergenceQuantity::Residual,
                [1e-6, 1e-12],
                change,
                residual,
            )
        };
        assert!(!converged(5e-7, 1e-5));
        assert!(converged(2e-6, 5e-7));
    }
}
