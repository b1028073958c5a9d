//! Time integration: velocity and acceleration at the end of a step from the displacement there.

use fsi_numerics::words;
use serde::{Deserialize, Serialize};

words! {
    /// How the wall's velocity and acceleration follow from its displacement.
    #[derive(Default)]
    pub enum TimeScheme {
        /// Newmark's method as the trapezoidal rule: second order, no numerical damping.
        Newmark = "newmark" (default),
        /// Newmark's method with `β = 0.3025`, `γ = 0.6`: first order, damps what changes from step to step.
        DampedNewmark = "damped_newmark",
        /// Wood, Bossak and Zienkiewicz's method: second order, halves what changes from step to step.
        Bossak = "bossak",
        /// First order; damps what is not resolved, and some of what is.
        ImplicitEuler = "implicit_euler",
    }
}

/// Displacement, velocity and acceleration coefficients of all functions, held ones included.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Displacement, m.
    pub d: Vec<f64>,
    /// Velocity, m/s.
    pub v: Vec<f64>,
    /// Acceleration, m/s².
    pub a: Vec<f64>,
}

/// Wood, Bossak and Zienkiewicz's parameter with which the highest frequencies fall to `(1 - α)/(1 + α)` = 1/2 a step.
const BOSSAK: f64 = 1.0 / 3.0;

impl TimeScheme {
    /// Newmark's parameters `(β, γ)`, if it is his method. With `γ > 1/2` and `β = (γ + 1/2)²/4` all frequencies are
    /// damped, the highest most: by `|γ - 3/2| / (γ + 1/2)` a step (Hughes, *The Finite Element Method*, 1987, section
    /// 9.3), 0.82 for `γ = 0.6`.
    fn newmark(self) -> Option<(f64, f64)> {
        match self {
            Self::Newmark => Some((0.25, 0.5)),
            Self::DampedNewmark => Some((0.3025, 0.6)),
            Self::Bossak => Some((0.25 * (1.0 + BOSSAK).powi(2), 0.5 + BOSSAK)),
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

    /// The acceleration (m/s²) that the equation of motion is to balance, from those at both ends of a step. Bossak's
    /// method goes beyond the end, `(1 + α) a - α a_old`, which with its β and γ damps and stays of second order (Wood,
    /// Bossak and Zienkiewicz, *Int. J. Numer. Methods Eng.* 15, 1980); with the other methods it is that at the end.
    pub(super) fn balanced(self, old: &State, a: Vec<f64>) -> Vec<f64> {
        match self {
            Self::Bossak => (a.iter().zip(&old.a))
                .map(|(a, old)| (1.0 + BOSSAK) * a - BOSSAK * old)
                .collect(),
            _ => a,
        }
    }

    /// Derivatives of velocity (1/s) and balanced acceleration (1/s²) with respect to the displacement.
    pub(super) fn slopes(self, dt: f64) -> (f64, f64) {
        let share = match self {
            Self::Bossak => 1.0 + BOSSAK,
            _ => 1.0,
        };
        match self.newmark() {
            Some((beta, gamma)) => (gamma / (beta * dt), share / (beta * dt * dt)),
            None => (1.0 / dt, 1.0 / (dt * dt)),
        }
    }
}
