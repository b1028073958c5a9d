//! How far a run is from repeating itself, and how much of a curve alternates from step to step.

use fsi_numerics::twelve_digits;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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

/// A quantity, or several of a kind, over a run.
#[derive(Debug, Clone, PartialEq)]
pub struct BeatMeasure {
    /// What it is.
    pub name: String,
    /// One value for each step of the run from t = 0, of each quantity.
    pub curves: Vec<Vec<f64>>,
}

/// How far a beat ends as it began, in a run that is over when it does. What it ends with the next one begins with, so
/// that this differs from it by no more.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// Largest difference that counts as agreement (`time.until_periodic`).
    pub limit: f64,
    /// End of the beat, s.
    #[serde(default)] // earlier runs have the number of the beat instead
    pub time_s: f64,
    /// Largest relative difference of a measure.
    #[serde(with = "crate::numbers")]
    pub largest: f64,
    /// The measure that has it.
    pub measure: String,
    /// That of each: by how much the mean over the last tenth of the beat differs from that a beat earlier, over the
    /// root mean square there; root mean squares of all its quantities. (The coupling's tolerance lets single steps
    /// scatter about a mean that no longer changes.)
    pub differences: BTreeMap<String, f64>,
}

impl Agreement {
    /// At the last step of a run with so many steps, which take `step` (s), to a beat; none before there is as much a
    /// beat earlier.
    pub fn of(measures: &[BeatMeasure], beat: usize, step: f64, limit: f64) -> Option<Self> {
        let compared = beat.div_ceil(10);
        let relative = |measure: &BeatMeasure| {
            let (mut difference, mut size) = (0.0, 0.0);
            for curve in &measure.curves {
                let start = curve.len().checked_sub(compared)?;
                let before = &curve[start.checked_sub(beat)?..];
                let known = curve[start..].iter().zip(before);
                let known = known.filter(|(now, before)| (*now - *before).is_finite());
                let (mut of_curve, mut count) = (0.0, 0.0);
                for (now, before) in known {
                    of_curve += now - before;
                    count += 1.0;
                    size += now.powi(2);
                }
                if count > 0.0 {
                    difference += of_curve.powi(2) / count;
                }
            }
            Some(if size > 0.0 {
                f64::sqrt(difference / size)
            } else {
                0.0
            })
        };
        let found = measures
            .iter()
            .map(|measure| Some((measure.name.clone(), relative(measure)?)));
        let differences: BTreeMap<String, f64> = found.collect::<Option<_>>()?;
        let (measure, largest) = differences.iter().max_by(|a, b| a.1.total_cmp(b.1))?;
        Some(Self {
            limit,
            time_s: twelve_digits(measures.first()?.curves.first()?.len() as f64 * step),
            largest: *largest,
            measure: measure.clone(),
            differences,
        })
    }

    /// Whether the beat ends as it began.
    pub fn is_reached(&self) -> bool {
        self.largest <= self.limit
    }

    /// What a run should be told whose beat does not.
    pub fn warning(&self) -> Option<String> {
        (!self.is_reached()).then(|| {
            format!(
                "the run has ended before it was periodic: between t = {} s and a beat earlier there is a difference \
                 of {:.1e} in {}, more than time.until_periodic = {:?}: raise time.end_s (--end-time), and go on with --resume",
                self.time_s, self.largest, self.measure, self.limit
            )
        })
    }
}

impl std::fmt::Display for Agreement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.warning() {
            Some(warning) => write!(f, "warning: {warning}"),
            None => write!(
                f,
                "periodic: at t = {} s and a beat earlier, nothing differs by more than {:.1e}, that of {} \
                 (time.until_periodic = {:?})",
                self.time_s, self.largest, self.measure, self.limit
            ),
        }
    }
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

    /// Two flows of one kind count together; a beat may end anywhere after the first and a tenth.
    #[test]
    fn a_beat_ends_as_it_began_when_the_worst_of_all_measures_does() {
        let curve = |size: f64, transient: f64, steps: i32| -> Vec<f64> {
            let times = (1..=steps).map(|n| f64::from(n) / 1000.0);
            let value = |t: f64| size * (TAU * t).cos() + transient * 0.1_f64.powf(t);
            times.map(value).collect()
        };
        let agreement = |steps| {
            let flows = vec![curve(1.0, 0.0, steps), curve(1e-3, 1e-3, steps)];
            // What scatters from step to step, otherwise in each beat.
            let sign = |n: i32| {
                if (n + (n - 1) / 1000) % 2 == 0 {
                    1.0
                } else {
                    -1.0
                }
            };
            let scatter = (1..=steps).map(|n| 1.0 + 0.1 * sign(n)).collect();
            let measures = [
                ("flow", flows),
                ("pressure", vec![curve(2.0, 0.2, steps)]),
                ("scatter", vec![scatter]),
            ];
            let measures = measures.map(|(name, curves)| BeatMeasure {
                name: name.into(),
                curves,
            });
            Agreement::of(&measures, 1000, 1e-3, 0.01)
        };
        assert_eq!(agreement(1099), None);
        let second = agreement(2000).unwrap();
        assert_eq!((second.time_s, second.measure.as_str()), (2.0, "pressure"));
        // The mean of 0.2 (0.1^(t - 1) - 0.1^t) from t = 1.9 to 2 over the root mean square of 2 cos(2πt).
        let decay = 10.0 * (0.1_f64.powf(0.9) - 0.1_f64.powf(1.0)) / 10_f64.ln();
        let cosine = f64::sqrt(0.5 + 10.0 * (2.0 * 0.1 * TAU).sin() / (4.0 * TAU));
        let of_second = 0.1 * 0.9 * decay / cosine;
        assert_relative_eq!(second.largest, of_second, max_relative = 0.01);
        assert_relative_eq!(
            second.differences["flow"],
            0.01 * of_second,
            max_relative = 0.01
        );
        assert!(second.differences["scatter"] < 1e-9, "{second:?}");
        assert!(!second.is_reached());
        let said = second.to_string();
        let start = "warning: the run has ended before it was periodic: between t = 2 s and a beat earlier there is a difference of 1.1e-2 in pressure, more than";
        assert!(said.starts_with(start), "{said}");
        let third = agreement(3000).unwrap();
        assert_relative_eq!(third.largest, 0.1 * of_second, max_relative = 0.01);
        let said = third.to_string();
        assert!(third.is_reached(), "{said}");
        assert_eq!(
            said,
            "periodic: at t = 3 s and a beat earlier, nothing differs by more than 1.1e-3, that of pressure (time.until_periodic = 0.01)"
        );
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
