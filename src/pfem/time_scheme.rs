//! Time integration: velocity and acceleration at the end of a step from the displacement there.

use super::equation_of_motion::State;

pub use crate::case::TimeScheme;

/// Newmark's parameters of the trapezoidal rule.
const BETA: f64 = 0.25;
const GAMMA: f64 = 0.5;

impl TimeScheme {
    /// Velocity (m/s) and acceleration (m/s²) coefficients at the end of a step of length `dt` (s) from `old` to the
    /// displacement `d` (m).
    pub(super) fn rates(self, old: &State, d: &[f64], dt: f64) -> (Vec<f64>, Vec<f64>) {
        let pair = |i: usize| match self {
            Self::Newmark => {
                let a = (d[i] - old.d[i]) / (BETA * dt * dt)
                    - old.v[i] / (BETA * dt)
                    - (0.5 / BETA - 1.0) * old.a[i];
                let v = old.v[i] + dt * ((1.0 - GAMMA) * old.a[i] + GAMMA * a);
                (v, a)
            }
            Self::ImplicitEuler => {
                let v = (d[i] - old.d[i]) / dt;
                (v, (v - old.v[i]) / dt)
            }
        };
        (0..d.len()).map(pair).unzip()
    }

    /// Derivatives of velocity (1/s) and acceleration (1/s²) with respect to the displacement.
    pub(super) fn slopes(self, dt: f64) -> (f64, f64) {
        match self {
            Self::Newmark => (GAMMA / (BETA * dt), 1.0 / (BETA * dt * dt)),
            Self::ImplicitEuler => (1.0 / dt, 1.0 / (dt * dt)),
        }
    }
}
