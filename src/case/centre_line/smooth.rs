//! A centre-line that scatters less than its points, and bends no more sharply than a wall can follow.

use super::CentreLine;
use crate::interpolation::{MonotoneCubic, SmoothingSpline};

/// A smooth line has so many points along the length whose waves are halved, along the least radius of a bend, and
/// along the narrowest radius of the lumen.
const POINTS_OF_A_WAVE: f64 = 4.0;
const POINTS_OF_A_BEND: f64 = 4.0;
const POINTS_OF_A_RADIUS: f64 = 6.0;
/// Where a line bends too sharply it is smoothed by so much more in a round, at most so often, and within so many of
/// the least radii around.
const MORE: f64 = 1.06;
const ROUNDS: usize = 150;
const AROUND: f64 = 2.0;
/// Radii may change by so many times their scatter.
const MOST_CHANGE: f64 = 3.0;
/// Waves of the radii are halved up to this share of the median radius: what is as long as a radius stays.
const OF_A_RADIUS: f64 = 0.5;

impl CentreLine {
    /// Lengths of the polygon from its beginning to each point.
    pub(super) fn places(&self) -> Vec<f64> {
        let mut places = vec![0.0];
        for pair in self.points.windows(2) {
            let step: f64 = (0..3).map(|c| (pair[1][c] - pair[0][c]).powi(2)).sum();
            places.push(places[places.len() - 1] + step.sqrt());
        }
        places
    }

    /// The smoothing spline in the length of the polygon: waves of the path of the length `halved` keep half of their
    /// height, and where it bends with less than the radius `least_bend` it is smoothed as much more as it takes. Radii
    /// change by their own scatter at most. Where there are more points than that needs, the line is given by fewer.
    pub(super) fn smooth(&self, halved: f64, least_bend: Option<f64>) -> Self {
        let places = self.places();
        let length = places[places.len() - 1];
        let spline = match least_bend {
            None => SmoothingSpline::new(&places, &self.points, halved),
            Some(least) => rounded_off(&places, &self.points, halved, least),
        };
        let radii = smooth_radii(&places, &self.radii);
        let mut needed = length / halved * POINTS_OF_A_WAVE;
        if let Some(least) = least_bend {
            needed = needed.max(length / least * POINTS_OF_A_BEND);
        }
        if !radii.is_empty() {
            let narrowest = radii.iter().copied().fold(f64::INFINITY, f64::min);
            needed = needed.max(length / narrowest * POINTS_OF_A_RADIUS);
        }
        if needed.max(8.0) + 1.0 >= places.len() as f64 {
            let points = spline.values().to_vec();
            return Self { points, radii };
        }
        let needed = needed.max(8.0).ceil() as usize;
        let chosen: Vec<f64> = (0..=needed)
            .map(|i| length * i as f64 / needed as f64)
            .collect();
        let points = chosen.iter().map(|x| spline.at(*x)).collect();
        let radii = match radii.is_empty() {
            true => radii,
            false => {
                let law = MonotoneCubic::new(places, radii);
                chosen.iter().map(|x| law.at(*x)).collect()
            }
        };
        Self { points, radii }
    }
}

/// The path with waves of the length `halved` halved, and longer ones around the places where it bends with less than
/// the radius `least`: as little as takes the curvature there below `1/least`.
fn rounded_off(places: &[f64], points: &[[f64; 3]], halved: f64, least: f64) -> SmoothingSpline<3> {
    let mut lengths = vec![halved; places.len()];
    let mut spline = SmoothingSpline::with_lengths(places, points, &lengths);
    for _ in 0..ROUNDS {
        let mut shares = vec![0.0f64; places.len()];
        for i in (0..places.len()).filter(|i| curvature(&spline, *i) * least > 1.0) {
            let from = places.partition_point(|x| *x < places[i] - AROUND * least);
            let to = places.partition_point(|x| *x <= places[i] + AROUND * least);
            for j in from..to {
                let away = (places[j] - places[i]) / (AROUND * least);
                shares[j] = shares[j].max((1.0 - away * away).powi(2));
            }
        }
        if shares.iter().all(|share| *share == 0.0) {
            break;
        }
        for (length, share) in lengths.iter_mut().zip(shares) {
            *length = length.max(share * least) * (1.0 + (MORE - 1.0) * share);
        }
        spline = SmoothingSpline::with_lengths(places, points, &lengths);
    }
    spline
}

/// `|g' × g''| / |g'|³` at a point.
fn curvature(spline: &SmoothingSpline<3>, i: usize) -> f64 {
    let [slope, bend] = spline.derivatives(i).map(crate::Vec3::from);
    slope.cross(&bend).norm() / slope.norm().powi(3)
}

/// Radii whose waves are halved up to a length at which they change by their own scatter, none of them by more than
/// three times that.
fn smooth_radii(places: &[f64], radii: &[f64]) -> Vec<f64> {
    let Some(scatter) = scatter(places, radii).filter(|scatter| *scatter > 0.0) else {
        return radii.to_vec();
    };
    let mut sorted = radii.to_vec();
    sorted.sort_by(f64::total_cmp);
    let values: Vec<[f64; 1]> = radii.iter().map(|r| [*r]).collect();
    let mut halved = OF_A_RADIUS * sorted[sorted.len() / 2];
    let shortest = 1e-3 * halved;
    while halved > shortest {
        let spline = SmoothingSpline::new(places, &values, halved);
        let smooth: Vec<f64> = spline.values().iter().map(|[r]| *r).collect();
        let changes = || smooth.iter().zip(radii).map(|(a, b)| (a - b).abs());
        let mean = (changes().map(|d| d * d).sum::<f64>() / radii.len() as f64).sqrt();
        let most = changes().fold(0.0, f64::max);
        if mean <= scatter && most <= MOST_CHANGE * scatter && smooth.iter().all(|r| *r > 0.0) {
            return smooth;
        }
        halved *= 0.8;
    }
    radii.to_vec()
}

/// Standard deviation of what scatters in values at ascending places: how far each is from the cubic through the two
/// before and the two after it, of which the median counts, so that a narrowing is no scatter. `None` of fewer than
/// eight.
fn scatter(places: &[f64], values: &[f64]) -> Option<f64> {
    if values.len() < 8 {
        return None;
    }
    let off = |i: usize| {
        let others = [i - 2, i - 1, i + 1, i + 2];
        let weight = |j: usize| -> f64 {
            let rest = others.iter().filter(|k| **k != j);
            rest.map(|k| (places[i] - places[*k]) / (places[j] - places[*k]))
                .product()
        };
        let weights = others.map(weight);
        let sum: f64 = (0..4).map(|k| weights[k] * values[others[k]]).sum();
        let norm = 1.0 + weights.iter().map(|w| w * w).sum::<f64>();
        (values[i] - sum).abs() / norm.sqrt()
    };
    let mut all: Vec<f64> = (2..values.len() - 2).map(off).collect();
    all.sort_by(f64::total_cmp);
    // The median of the size of a normally distributed number is 0.6745 standard deviations.
    let found = all[all.len() / 2] / 0.6745;
    let size = values.iter().copied().fold(0.0, f64::max);
    Some(if found > 1e-9 * size { found } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: &mut u64) -> f64 {
        *seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (*seed >> 33) as f64 / f64::from(1u32 << 31) - 0.5
    }

    /// A narrowing of a radius' length stays with and without scatter, and what scatters becomes less.
    #[test]
    fn radii_change_by_their_own_scatter_at_most() {
        let places: Vec<f64> = (0..=400).map(|i| 0.15 * f64::from(i)).collect();
        let exact = |x: f64| {
            let away = (x - 30.0).abs() / 1.5;
            let depth = if away < 1.0 {
                1.025 * (1.0 + (std::f64::consts::PI * away).cos())
            } else {
                0.0
            };
            3.0 - 0.01 * x - depth
        };
        let radii: Vec<f64> = places.iter().map(|x| exact(*x)).collect();
        let smooth = smooth_radii(&places, &radii);
        let off = |smooth: &[f64]| {
            let all = smooth.iter().zip(&radii).map(|(a, b)| (a - b).abs());
            all.fold(0.0, f64::max)
        };
        assert!(off(&smooth) < 1e-6, "{}", off(&smooth));
        let mut seed = 7;
        let scattering: Vec<f64> = radii.iter().map(|r| r + 0.12 * noise(&mut seed)).collect();
        let found = scatter(&places, &scattering).unwrap();
        // Of uniform noise of this width: 0.12/√12.
        assert!((found / (0.12 / 12f64.sqrt()) - 1.0).abs() < 0.2, "{found}");
        let smooth = smooth_radii(&places, &scattering);
        assert!(off(&smooth) < 0.12, "{}", off(&smooth));
        let rms = |values: &[f64]| {
            let all = values.iter().zip(&radii).map(|(a, b)| (a - b).powi(2));
            (all.sum::<f64>() / values.len() as f64).sqrt()
        };
        let [before, after] = [rms(&scattering), rms(&smooth)];
        assert!(after < 0.7 * before, "{after} {before}");
        // Too few to tell.
        assert_eq!(smooth_radii(&places[..5], &radii[..5]), radii[..5]);
    }

    #[test]
    fn a_sharp_bend_is_rounded_off_and_the_rest_stays() {
        // Two straight lines with a corner of 60°.
        let line = CentreLine {
            points: (0..=100)
                .map(|i| {
                    let x = 0.2 * f64::from(i) - 10.0;
                    [x, if x > 0.0 { 3f64.sqrt() * x } else { 0.0 }, 0.0]
                })
                .collect(),
            radii: Vec::new(),
        };
        let places = line.places();
        let sharpest = |spline: &SmoothingSpline<3>| {
            let all = (0..places.len()).map(|i| curvature(spline, i));
            all.fold(0.0, f64::max)
        };
        for least in [1.0, 2.0] {
            let spline = rounded_off(&places, &line.points, 0.1, least);
            assert!(sharpest(&spline) * least <= 1.0);
            assert!(sharpest(&spline) * least > 0.8, "{}", sharpest(&spline));
            let moved = |i: usize| -> f64 {
                let ends = [spline.values()[i], line.points[i]].map(crate::Vec3::from);
                (ends[0] - ends[1]).norm()
            };
            let most = (0..places.len()).map(moved).fold(0.0, f64::max);
            // An arc of the radius R leaves the corner by R (1/cos 30° - 1).
            let arc = least * (2.0 / 3f64.sqrt() - 1.0);
            assert!((0.8 * arc..2.5 * arc).contains(&most), "{most} {arc}");
            assert!(moved(5) < 1e-3 && moved(95) < 1e-3);
        }
    }
}
