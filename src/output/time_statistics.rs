//! What values over time amount to: mean, range, frequency, and what of them is periodic.

use crate::case::measured::Statistic;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Harmonics of the Fourier series that is fitted to what is periodic.
const HARMONICS: usize = 16;

/// A statistic of samples (time in s, value) in the order of their times; none if there are fewer than two, or if they
/// do not oscillate and a frequency is asked for.
pub fn statistic(kind: Statistic, samples: &[(f64, f64)]) -> Option<f64> {
    let [(begin, _), .., (end, _)] = samples else {
        return None;
    };
    let (largest, least) = (|| peak(samples, 1.0), || peak(samples, -1.0));
    Some(match kind {
        Statistic::Mean => {
            let pairs = samples.iter().zip(&samples[1..]);
            let trapezoids = pairs.map(|((from, a), (to, b))| (to - from) * (a + b) / 2.0);
            trapezoids.sum::<f64>() / (end - begin)
        }
        Statistic::Middle => (largest().1 + least().1) / 2.0,
        Statistic::Amplitude => (largest().1 - least().1) / 2.0,
        Statistic::Largest => largest().1,
        Statistic::Least => least().1,
        Statistic::TimeOfLargest => largest().0,
        Statistic::Frequency => frequency(samples)?,
        Statistic::PeriodicAmplitude => {
            let series = periodic_part(samples)?;
            (peak(&series, 1.0).1 - peak(&series, -1.0).1) / 2.0
        }
        Statistic::Noise => {
            let series = periodic_part(samples)?;
            let pairs = samples.iter().zip(&series);
            let squares = pairs.map(|((_, value), (_, periodic))| (value - periodic).powi(2));
            (squares.sum::<f64>() / samples.len() as f64).sqrt()
        }
    })
}

/// How often per second (1/s) samples (time in s, value) pass their middle upwards; none if they do so less than twice.
fn frequency(samples: &[(f64, f64)]) -> Option<f64> {
    let (largest, least) = (peak(samples, 1.0).1, peak(samples, -1.0).1);
    let passages = passages(samples, (largest + least) / 2.0, (largest - least) / 4.0);
    let [first, .., last] = passages[..] else {
        return None;
    };
    Some((passages.len() - 1) as f64 / (last - first))
}

/// A Fourier series of half of their frequency, since every second swing may differ, fitted to samples by least
/// squares: its values at their times. None if they do not oscillate or are too few.
fn periodic_part(samples: &[(f64, f64)]) -> Option<Vec<(f64, f64)>> {
    let terms = 2 * HARMONICS + 1;
    let base = TAU * frequency(samples)? / 2.0;
    if samples.len() < 2 * terms {
        return None;
    }
    let term = |row: usize, term: usize| {
        let angle = term.div_ceil(2) as f64 * base * samples[row].0;
        if term.is_multiple_of(2) {
            angle.cos()
        } else {
            angle.sin()
        }
    };
    let matrix = DMatrix::from_fn(samples.len(), terms, term);
    let values = DVector::from_iterator(samples.len(), samples.iter().map(|(_, value)| *value));
    let coefficients = matrix.clone().svd(true, true).solve(&values, 1e-9).ok()?;
    let periodic = matrix * coefficients;
    let times = samples.iter().map(|(time, _)| *time);
    Some(times.zip(periodic.iter().copied()).collect())
}

/// Time and value of the largest (`sign` 1) or least (-1) value: of the parabola through that sample and its neighbours
/// where the samples before and after it are as far away.
fn peak(samples: &[(f64, f64)], sign: f64) -> (f64, f64) {
    let by_value = |a: &usize, b: &usize| (sign * samples[*a].1).total_cmp(&(sign * samples[*b].1));
    let at = (0..samples.len()).max_by(by_value).unwrap_or(0);
    let (time, value) = samples[at];
    let (Some(before), Some(after)) = (at.checked_sub(1), samples.get(at + 1)) else {
        return (time, value);
    };
    let before = samples[before];
    let step = (after.0 - before.0) / 2.0;
    let bend = before.1 - 2.0 * value + after.1;
    if bend == 0.0 || (after.0 - time - step).abs() > 1e-3 * step {
        return (time, value);
    }
    let slope = (after.1 - before.1) / 2.0;
    (
        time - slope / bend * step,
        value - slope * slope / (2.0 * bend),
    )
}

/// When a level is passed upwards, not counting returns from less than `depth` below it: noise.
fn passages(samples: &[(f64, f64)], level: f64, depth: f64) -> Vec<f64> {
    let mut counts = samples[0].1 < level;
    let mut times = Vec::new();
    for (&(from, a), &(to, b)) in samples.iter().zip(&samples[1..]) {
        counts |= a < level - depth;
        if counts && a < level && level <= b {
            times.push(from + (to - from) * (level - a) / (b - a));
            counts = false;
        }
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sampled 37 times a period.
    #[test]
    fn an_oscillation_has_its_middle_amplitude_and_frequency() {
        let (mean, amplitude, frequency) = (1.5, 35.0, 5.46);
        let step = 1.0 / (37.0 * frequency);
        let sample = |i: usize| {
            let t = 4.0 + i as f64 * step;
            (t, mean + amplitude * (TAU * frequency * (t - 4.0)).sin())
        };
        let samples: Vec<(f64, f64)> = (0..=37 * 5).map(sample).collect();
        let of = |kind| statistic(kind, &samples).unwrap();
        assert!((of(Statistic::Mean) - mean).abs() < 1e-12);
        assert!((of(Statistic::Middle) - mean).abs() < 1e-3);
        assert!((of(Statistic::Amplitude) - amplitude).abs() < 1e-3);
        assert!((of(Statistic::Largest) - mean - amplitude).abs() < 2e-3);
        assert!((of(Statistic::Least) - mean + amplitude).abs() < 2e-3);
        assert!((of(Statistic::Frequency) / frequency - 1.0).abs() < 1e-4);
        let quarter = (of(Statistic::TimeOfLargest) - 4.0) * frequency % 1.0;
        assert!((quarter - 0.25).abs() < 1e-3, "{quarter}");
    }

    /// Every second swing is smaller, and each value jumps by 3 % of the amplitude, up and down in turn.
    #[test]
    fn noise_is_told_from_what_is_periodic() {
        let (frequency, jump) = (10.0, 0.03);
        let clean = |t: f64| (TAU * frequency * t).sin() + 0.2 * (TAU * frequency / 2.0 * t).sin();
        let with = |jump: f64| -> Vec<(f64, f64)> {
            let times = (0..=1000).map(|i| (i, 4.0 + 1e-3 * f64::from(i)));
            times
                .map(|(i, t)| (t, clean(t) + if i % 2 == 0 { jump } else { -jump }))
                .collect()
        };
        let (noisy, clean) = (with(jump), with(0.0));
        let of = |kind| statistic(kind, &noisy).unwrap();
        let amplitude = statistic(Statistic::Amplitude, &clean).unwrap();
        assert!((of(Statistic::Frequency) / frequency - 1.0).abs() < 1e-2);
        assert!((of(Statistic::Amplitude) - amplitude - jump).abs() < 3e-3);
        assert!((of(Statistic::PeriodicAmplitude) - amplitude).abs() < 3e-3);
        assert!((of(Statistic::Noise) - jump).abs() < 1e-3);
        assert!(statistic(Statistic::Noise, &clean).unwrap() < 1e-2 * jump);
    }

    #[test]
    fn what_does_not_oscillate_has_no_frequency() {
        let rising: Vec<(f64, f64)> = (0..9).map(|i| (f64::from(i), f64::from(i))).collect();
        assert_eq!(statistic(Statistic::Frequency, &rising), None);
        assert_eq!(statistic(Statistic::Noise, &rising), None);
        assert_eq!(statistic(Statistic::Largest, &rising), Some(8.0));
        assert_eq!(statistic(Statistic::Mean, &rising), Some(4.0));
        assert_eq!(statistic(Statistic::Mean, &rising[..1]), None);
        assert_eq!(
            statistic(Statistic::Middle, &[(0.0, 1.0), (1.0, 1.0)]),
            Some(1.0)
        );
    }
}
