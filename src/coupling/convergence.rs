//! Criterion (14), and words for a step that does not meet it.

use super::Iteration;
use nalgebra::DVector;

/// When a coupling iteration counts as converged: `|d_{k+1} - d_k| / |d_k| < relative`, or the root mean square of
/// `d_{k+1} - d_k` over the points below `absolute`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criterion {
    /// e_rel of equation (14).
    pub relative: f64,
    /// e_abs of equation (14) as root mean square over the points, m.
    pub absolute: f64,
    /// Most iterations of a step.
    pub max_iterations: usize,
    /// Share of the usual relaxation factor that is being used: a small factor makes the change of a relaxed trial
    /// small, but not its error.
    pub share: f64,
}

/// Distance of a coupling iteration to convergence.
///
/// Criterion (14) tests the change of the *accelerated* displacement, which a small relaxation factor makes small by
/// itself; the residual of the fixed point is recorded beside it so that one can tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// |d_{k+1} - d_k| / |d_k|.
    pub change: f64,
    /// Root mean square of d_{k+1} - d_k over the points, m.
    pub change_rms: f64,
    /// |S∘F(d_k) - d_k| / |d_k|.
    pub residual: f64,
    /// Root mean square of S∘F(d_k) - d_k over the points, m.
    pub residual_rms: f64,
    /// Whether criterion (14) is met.
    pub converged: bool,
}

impl Criterion {
    /// Measures the iteration that went from `d` by `d_tilde = S∘F(d)` to `d_next`, which is `relaxed` or was found by a
    /// quasi-Newton model.
    pub fn measure(
        &self,
        d: &DVector<f64>,
        d_tilde: &DVector<f64>,
        d_next: &DVector<f64>,
        relaxed: bool,
    ) -> Measure {
        let points = (d.len() as f64 / 3.0).sqrt();
        // A run that starts from rest has nothing else to compare with than the first image.
        let size = if d.norm() > 0.0 {
            d.norm()
        } else {
            d_tilde.norm()
        };
        let relative = |x: f64| if x > 0.0 { x / size } else { 0.0 };
        let share = if relaxed { self.share } else { 1.0 };
        let (change, residual) = ((d_next - d).norm() / share, (d_tilde - d).norm());
        Measure {
            change: relative(change),
            change_rms: change / points,
            residual: relative(residual),
            residual_rms: residual / points,
            converged: relative(change) < self.relative || change / points < self.absolute,
        }
    }
}

/// Says in words how a step failed to converge, and what to try.
pub fn diagnosis(iterations: &[Iteration]) -> String {
    let Some(last) = iterations.last() else {
        return "no iteration was allowed; raise coupling.max_iterations".into();
    };
    let residuals: Vec<f64> = iterations.iter().map(|i| i.measure.residual_rms).collect();
    let best = residuals.iter().copied().fold(f64::INFINITY, f64::min);
    let tail = &residuals[residuals.len() - residuals.len().div_ceil(3)..];
    let (low, high) = tail
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(l, h), &r| (l.min(r), h.max(r)));
    let what = if last.measure.residual_rms > 10.0 * residuals[0] {
        "the residual grows; try a smaller coupling.relaxation, or coupling.acceleration = \"iqn_ls\""
    } else if high < 3.0 * low {
        "the residual stagnates, which points to the tolerances of a solver; try a larger fluid.max_correctors or a smaller structure.newton_tolerance"
    } else {
        "the residual falls slowly; try a larger coupling.reuse_steps or coupling.max_iterations, or a smaller time.step_s"
    };
    format!(
        "residual {:.2e} m after {} iterations, {:.2e} m at the first (smallest {best:.2e} m), change {:.2e} of the displacement: {what}",
        last.measure.residual_rms,
        iterations.len(),
        residuals[0],
        last.measure.change
    )
}
