//! What is known of a centre-line before a case is made of it, whatever the distances between its points.

use super::CentreLine;
use crate::LengthUnit;
use crate::Vec3;
use crate::curve::SpaceCurve;
use crate::files::{Fault, fault};
use crate::interpolation::SmoothingSpline;
use std::path::Path;

/// Places along a line, in equal distances, for its median radius and what scatters.
const PLACES: usize = 2000;
/// A line scatters if half of it leaves the one in which waves of so many radii are halved ...
const PROBE: f64 = 2.0;
/// ... by more than this share of the radius.
const SCATTERS: f64 = 0.005;
/// Waves that are halved, in radii, in a line that scatters, and in one that does not.
const SMOOTHING: [f64; 2] = [4.0, 1.0];

/// What a file with a centre-line holds.
#[derive(Debug, Clone, PartialEq)]
pub struct LineSurvey {
    line: CentreLine,
}

impl LineSurvey {
    /// Looks into a file of lengths in `unit`; of several lines into the one that is called `branch`.
    ///
    /// # Errors
    /// What is wrong with the file, in a sentence.
    pub fn read(path: &Path, branch: Option<&str>, unit: LengthUnit) -> Result<Self, Fault> {
        let mut line = CentreLine::read(path, branch)?.without_repeated();
        let count = line.points.len();
        if count < 2 {
            return Err(fault!("expected 2 points at least, found {count}"));
        }
        let metres = unit.metres();
        line.points.iter_mut().flatten().for_each(|x| *x *= metres);
        line.radii.iter_mut().for_each(|r| *r *= metres);
        Ok(Self { line })
    }

    /// The points, m.
    pub fn points(&self) -> impl ExactSizeIterator<Item = Vec3> {
        self.line.points.iter().map(|point| (*point).into())
    }

    /// Radii of the lumen at the points (m); empty if the file does not know them.
    pub fn radii(&self) -> &[f64] {
        &self.line.radii
    }

    /// Length of the polygon through all points, m.
    pub fn polygon(&self) -> f64 {
        *self.line.places().last().unwrap_or(&0.0)
    }

    /// Median radius of the lumen (m) over the length, if the file knows it.
    pub fn radius(&self) -> Option<f64> {
        let (places, radii) = (self.line.places(), self.radii());
        if radii.is_empty() {
            return None;
        }
        Some(median(&places, radii))
    }

    /// Length of the waves (m) to be halved around a lumen of this radius (m): that of a radius, or of several if the
    /// points scatter.
    pub fn smoothing(&self, radius: f64) -> f64 {
        let places = self.line.places();
        let points = &self.line.points;
        let smooth = SmoothingSpline::new(&places, points, PROBE * radius);
        let moved = points.iter().zip(smooth.values());
        let moved: Vec<f64> = moved
            .map(|(a, b)| (Vec3::from(*a) - Vec3::from(*b)).norm())
            .collect();
        let [scattering, quiet] = SMOOTHING;
        match median(&places, &moved) > SCATTERS * radius {
            true => scattering * radius,
            false => quiet * radius,
        }
    }

    /// Length (m) of the line in which waves of the length `halved` (m) are halved.
    pub fn length(&self, halved: f64) -> f64 {
        let smooth = self.line.smooth(halved, None);
        let points: Vec<Vec3> = smooth.points.iter().map(|point| (*point).into()).collect();
        SpaceCurve::through(&points, Vec3::y()).ends()[1]
    }
}

/// Median over the length of values that are linear between ascending places.
fn median(places: &[f64], values: &[f64]) -> f64 {
    let length = places[places.len() - 1];
    let at = |i: usize| {
        let x = length * (i as f64 + 0.5) / PLACES as f64;
        let after = places.partition_point(|place| *place <= x);
        let j = after.clamp(1, places.len() - 1);
        let share = (x - places[j - 1]) / (places[j] - places[j - 1]);
        values[j - 1] + share * (values[j] - values[j - 1])
    };
    let mut all: Vec<f64> = (0..PLACES).map(at).collect();
    all.sort_by(f64::total_cmp);
    all[PLACES / 2]
}
