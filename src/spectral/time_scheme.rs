//! Backward differences in time, for steps of any length.

use fsi_numerics::words;

words! {
    /// How time derivatives of the blood are taken, in its equations and downstream of its outlet.
    pub enum TimeScheme {
        /// Implicit Euler: first order, damps waves.
        ImplicitEuler = "euler",
        /// Backward differences of second order; the first step is implicit Euler's.
        Bdf2 = "bdf2",
    }
}

/// Weights of `du/dt ≈ new u + old u_n + older u_(n-1)`, 1/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Of the value to be found.
    pub new: f64,
    /// Of the value at the beginning of the step.
    pub old: f64,
    /// Of the one a step earlier.
    pub older: f64,
}

/// Weights of a scheme for a step of length `dt` (s) after one of length `before` (s), if there was one.
pub fn weights(scheme: TimeScheme, dt: f64, before: Option<f64>) -> Weights {
    match (scheme, before) {
        (TimeScheme::Bdf2, Some(before)) => {
            let r = dt / before;
            Weights {
                new: (1.0 + 2.0 * r) / (1.0 + r) / dt,
                old: -(1.0 + r) / dt,
                older: r * r / (1.0 + r) / dt,
            }
        }
        _ => Weights {
            new: 1.0 / dt,
            old: -1.0 / dt,
            older: 0.0,
        },
    }
}

/// Weights of the linear extrapolation in time to the end of the step, of the last value and of the one before.
pub fn extrapolation(dt: f64, before: Option<f64>) -> [f64; 2] {
    before.map_or([1.0, 0.0], |before| [1.0 + dt / before, -dt / before])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials of the order are differentiated exactly with steps of any length.
    #[test]
    fn polynomials_are_differentiated_exactly() {
        let f = |t: f64| 1.0 + 3.0 * t + 5.0 * t * t;
        let (dt, before) = (0.3, 0.7);
        let w = weights(TimeScheme::Bdf2, dt, Some(before));
        let slope = w.new * f(dt) + w.old * f(0.0) + w.older * f(-before);
        assert!((slope - (3.0 + 10.0 * dt)).abs() < 1e-12, "{slope}");
        let w = weights(TimeScheme::ImplicitEuler, dt, Some(before));
        assert!((w.new * 7.0 * dt + w.old * 0.0 - 7.0).abs() < 1e-14 && w.older == 0.0);
        let [a, b] = extrapolation(dt, Some(before));
        assert!((a * 2.0 + b * (2.0 - 4.0 * before) - (2.0 + 4.0 * dt)).abs() < 1e-14);
    }
}
