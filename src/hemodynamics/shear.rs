//! Time-averaged wall shear stress, oscillating shear index (10) and relative residence time.
//!
//! Equation (10) takes the wall shear stress `tau_w = rho nu symgrad(u) n`, half of the physical
//! `2 mu symgrad(u) n`; here it is the physical one. The index is the same for both, being a ratio.

use crate::Vec3;
use serde::{Deserialize, Serialize};

/// Integrals over time of the wall shear stress of each face of the wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShearStatistics {
    /// Integral of the vector, Pa s.
    vector: Vec<Vec3>,
    /// Integral of its magnitude, Pa s.
    magnitude: Vec<f64>,
    /// Length of the window so far, s.
    duration: f64,
}

impl ShearStatistics {
    /// Empty integrals for a wall of this many faces.
    pub fn new(faces: usize) -> Self {
        Self {
            vector: vec![Vec3::zeros(); faces],
            magnitude: vec![0.0; faces],
            duration: 0.0,
        }
    }

    /// Adds a time step of length `dt` (s) with the wall shear stress `shear` (Pa) at its end: the rectangle rule that
    /// belongs to implicit Euler.
    pub fn add(&mut self, shear: &[Vec3], dt: f64) {
        assert_eq!(
            shear.len(),
            self.vector.len(),
            "one shear stress for each face"
        );
        for ((vector, magnitude), shear) in
            self.vector.iter_mut().zip(&mut self.magnitude).zip(shear)
        {
            *vector += shear * dt;
            *magnitude += shear.norm() * dt;
        }
        self.duration += dt;
    }

    /// Length of the window so far, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Time average of the magnitude, Pa.
    pub fn time_averaged(&self) -> Vec<f64> {
        self.magnitude.iter().map(|m| m / self.duration).collect()
    }

    /// Time average of the vector, Pa.
    pub fn mean(&self) -> Vec<Vec3> {
        self.vector.iter().map(|v| v / self.duration).collect()
    }

    /// Oscillating shear index (10), from 0 (one direction) to 1/2 (no mean direction).
    pub fn oscillating_shear_index(&self) -> Vec<f64> {
        let index = |(vector, &magnitude): (&Vec3, &f64)| {
            if magnitude > 0.0 {
                // Where the direction never changes, rounding can make this less than zero.
                (0.5 * (1.0 - vector.norm() / magnitude)).max(0.0)
            } else {
                0.0
            }
        };
        self.vector.iter().zip(&self.magnitude).map(index).collect()
    }

    /// Relative residence time `1 / ((1 - 2 OSI) TAWSS)` (Himburg et al. 2004), 1/Pa: the inverse of the magnitude of
    /// the mean vector; infinite where that is zero.
    pub fn relative_residence_time(&self) -> Vec<f64> {
        self.vector
            .iter()
            .map(|vector| self.duration / vector.norm())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::{PI, TAU};

    /// tau(t) = mean + amplitude sin(2 pi t), over one period.
    fn pulsating(mean: f64, amplitude: f64) -> ShearStatistics {
        let mut statistics = ShearStatistics::new(1);
        let n = 20_000;
        for i in 0..n {
            let t = (i as f64 + 0.5) / n as f64;
            statistics.add(
                &[Vec3::new(mean + amplitude * (TAU * t).sin(), 0.0, 0.0)],
                1.0 / n as f64,
            );
        }
        statistics
    }

    #[test]
    fn steady_shear_does_not_oscillate() {
        let statistics = pulsating(0.7, 0.0);
        assert_relative_eq!(statistics.time_averaged()[0], 0.7, max_relative = 1e-12);
        assert!(statistics.oscillating_shear_index()[0].abs() < 1e-12);
        assert_relative_eq!(
            statistics.relative_residence_time()[0],
            1.0 / 0.7,
            max_relative = 1e-12
        );
    }

    #[test]
    fn shear_without_mean_has_the_largest_index() {
        let statistics = pulsating(0.0, 1.0);
        assert_relative_eq!(statistics.time_averaged()[0], 2.0 / PI, max_relative = 1e-6);
        assert_relative_eq!(
            statistics.oscillating_shear_index()[0],
            0.5,
            max_relative = 1e-6
        );
    }

    #[test]
    fn a_pulse_that_turns_back_agrees_with_the_integral_by_hand() {
        // mean 1, amplitude 2: negative for sin < -1/2, a third of the period; the mean of |1 + 2 sin| is
        // 1/3 + 2 sqrt(3)/pi.
        let statistics = pulsating(1.0, 2.0);
        let mean = 1.0 / 3.0 + 2.0 * 3.0_f64.sqrt() / PI;
        assert_relative_eq!(statistics.time_averaged()[0], mean, max_relative = 1e-6);
        assert_relative_eq!(
            statistics.oscillating_shear_index()[0],
            0.5 * (1.0 - 1.0 / mean),
            max_relative = 1e-6
        );
    }
}
