//! A lumen whose radius depends on the angle, as a table.

use crate::interpolation::{BicubicSurface, SplineEnds};
use std::f64::consts::{PI, TAU};

/// The radius `r(s, φ)` between equally spaced cross-sections and angles: a bicubic spline, natural along the vessel
/// and periodic around it. Beyond its ends the last cross-section becomes a circle of its mean radius, by half a cosine
/// over one diameter.
#[derive(Debug, Clone, PartialEq)]
pub struct LumenTable {
    surface: BicubicSurface,
    /// Arc lengths of the first cross-section and of the last, m.
    range: [f64; 2],
    /// Mean radii of these two, m.
    ends: [f64; 2],
}

/// Mean of a row.
fn mean(row: &[f64]) -> f64 {
    row.iter().sum::<f64>() / row.len() as f64
}

impl LumenTable {
    /// Rows of radii (m) in equal distances over `range`, columns in equal angles from 0.
    pub fn new(rows: &[Vec<f64>], range: [f64; 2]) -> Self {
        Self {
            surface: BicubicSurface::with_ends(rows, SplineEnds::Natural),
            range,
            ends: [mean(&rows[0]), mean(&rows[rows.len() - 1])],
        }
    }

    /// The radius (m) at the arc length `s` (m) and the angle `phi`.
    pub fn radius(&self, s: f64, phi: f64) -> f64 {
        let [from, to] = self.range;
        let radius = self.surface.value((s - from) / (to - from), phi / TAU);
        let (beyond, circle) = match s < from {
            true => (from - s, self.ends[0]),
            false => (s - to, self.ends[1]),
        };
        if beyond <= 0.0 {
            return radius;
        }
        let share = 0.5 * (1.0 + (PI * (0.5 * beyond / circle).min(1.0)).cos());
        circle + (radius - circle) * share
    }
}
