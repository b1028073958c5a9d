//! Time integration: velocity and acceleration at the end of a step from the displacement there.

use super::equation_of_motion::State;

pub use crate::case::TimeScheme;

impl TimeScheme {
    /// Newmark's parameters `(β, γ)`, if it is his method. With `γ > 1/2` and `β = (γ + 1/2)²/4` all frequencies are
    /// damped, the highest most: by `|γ - 3/2| / (γ + 1/2)` a step (Hughes, *The Finite Element Method*, 1987, section
    /// 9.3), 0.82 for `γ = 0.6`.
    fn newmark(self) -> Option<(f64, f64)> {
        match self {
            Self::Newmark => Some((0.25, 0.5)),
            Self::DampedNewmark => Some((0.3025, 0.6)),
            Self::ImplicitEuler => None,
        }
    }

    /// Velocity (m/s) and acceleration (m/s²) coefficients at the end of a step of length `dt` (s) from `old` to the
    /// displacement `d` (m).
    pub(super) fn rates(self, old: &State, d: &[f64], dt: f64) -> (Vec<f64>, Vec<f64>) {
        let parameters = self.newmark();
        let pair = |i: usize| match parameters {
            Some((beta, gamma)) => {
                let a = (d[i] - old.d[i]) / (beta * dt * dt)
                    - old.v[i] / (beta * dt)
                    - (0.5 / beta - 1.0) * old.a[i];
                let v = old.v[i] + dt * ((1.0 - gamma) * old.a[i] + gamma * a);
                (v, a)
            }
            None => {
                let v = (d[i] - old.d[i]) / dt;
                (v, (v - old.v[i]) / dt)
            }
        };
        (0..d.len()).map(pair).unzip()
    }

    /// Derivatives of velocity (1/s) and acceleration (1/s²) with respect to the displacement.
    pub(super) fn slopes(self, dt: f64) -> (f64, f64) {
        match self.newmark() {
            Some((beta, gamma)) => (gamma / (beta * dt), 1.0 / (beta * dt * dt)),
            None => (1.0 / dt, 1.0 / (dt * dt)),
        }
    }
}
