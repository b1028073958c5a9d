//! How far a run is from repeating itself, and how much of a curve alternates from step to step.

use serde::{Deserialize, Serialize};

/// Largest difference between one period and the one before, in a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PeriodDifference {
    /// End of the later period, s.
    pub period_end_s: f64,
    /// Largest `|f(t) - f(t - T)|`, in the unit of the quantity.
    #[serde(with = "crate::numbers")]
    pub largest: f64,
    /// The same over the largest `|f|` of the later period.
    #[serde(with = "crate::numbers")]
    pub relative: f64,
}

/// Differences between successive whole periods of `values`, one for each step of a run from t = 0, `per_period` to a
/// period that lasts `period` (s).
pub fn differences(values: &[f64], per_period: usize, period: f64) -> Vec<PeriodDifference> {
    let periods: Vec<&[f64]> = values.chunks_exact(per_period.max(1)).collect();
    let difference = |(i, pair): (usize, &[&[f64]])| {
        let largest = largest(
            pair[1]
                .iter()
                .zip(pair[0])
                .map(|(now, before)| now - before),
        );
        let size = self::largest(pair[1].iter().copied());
        PeriodDifference {
            period_end_s: period * (i + 2) as f64,
            largest,
            relative: if size > 0.0 { largest / size } else { 0.0 },
        }
    };
    periods.windows(2).enumerate().map(difference).collect()
}

/// What changes its sign from step to step in the values of successive steps, root mean square in their unit: `a` of
/// `f(t) + a (-1)^n`, from third differences, in which a smooth `f` nearly vanishes; none of fewer than four values.
pub fn alternating(values: &[f64]) -> Option<f64> {
    let third = values
        .windows(4)
        .map(|v| (v[3] - 3.0 * v[2] + 3.0 * v[1] - v[0]) / 8.0);
    let count = third.len();
    (count > 0).then(|| (third.map(|x| x * x).sum::<f64>() / count as f64).sqrt())
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |m, x| m.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::TAU;

    #[test]
    fn alternation_is_distinguished_from_smooth_change() {
        let sign = |n: i32| if n % 2 == 0 { 1.0 } else { -1.0 };
        let curve = |a: f64| -> Vec<f64> {
            let value = |n: i32| 3.0 + (TAU * f64::from(n) / 500.0).sin() + a * sign(n);
            (0..500).map(value).collect()
        };
        assert!(alternating(&curve(0.0)).unwrap() < 1e-6);
        assert_relative_eq!(
            alternating(&curve(0.02)).unwrap(),
            0.02,
            max_relative = 1e-6
        );
        assert_eq!(alternating(&[1.0, 2.0, 3.0]), None);
    }

    #[test]
    fn a_transient_that_decays_to_a_tenth_in_a_period_is_measured() {
        let values: Vec<f64> = (1..=350)
            .map(|n| f64::from(n) / 100.0)
            .map(|t| (TAU * t).cos() + 0.1_f64.powf(t))
            .collect();
        let found = differences(&values, 100, 1.0);
        // The half period at the end does not count.
        assert_eq!(found.len(), 2);
        assert_eq!(found[1].period_end_s, 3.0);
        assert_relative_eq!(
            found[0].largest / found[1].largest,
            10.0,
            max_relative = 1e-9
        );
    }
}
