//! What values over time amount to: mean, range, frequency.

use crate::case::measured::Statistic;

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
        Statistic::Frequency => {
            let middle = (largest().1 + least().1) / 2.0;
            let passages = passages(samples, middle);
            let [first, .., last] = passages[..] else {
                return None;
            };
            (passages.len() - 1) as f64 / (last - first)
        }
    })
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

/// When a level is passed upwards.
fn passages(samples: &[(f64, f64)], level: f64) -> Vec<f64> {
    let pairs = samples.iter().zip(&samples[1..]);
    let rising = pairs.filter(|((_, a), (_, b))| *a < level && level <= *b);
    rising
        .map(|((from, a), (to, b))| from + (to - from) * (level - a) / (b - a))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

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

    #[test]
    fn what_does_not_oscillate_has_no_frequency() {
        let rising: Vec<(f64, f64)> = (0..9).map(|i| (f64::from(i), f64::from(i))).collect();
        assert_eq!(statistic(Statistic::Frequency, &rising), None);
        assert_eq!(statistic(Statistic::Largest, &rising), Some(8.0));
        assert_eq!(statistic(Statistic::Mean, &rising), Some(4.0));
        assert_eq!(statistic(Statistic::Mean, &rising[..1]), None);
        assert_eq!(
            statistic(Statistic::Middle, &[(0.0, 1.0), (1.0, 1.0)]),
            Some(1.0)
        );
    }
}
