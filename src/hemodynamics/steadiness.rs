//! Whether a run whose inputs are constant has become steady.

use serde::{Deserialize, Serialize};

/// Share of the time since the ramp that is looked at.
const LAST: f64 = 0.2;
/// By so much of its size a measure of a steady flow changes at most meanwhile.
const STEADY: f64 = 5e-3;

/// A measure of a run, a value for each time.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyMeasure {
    /// What it is.
    pub name: String,
    /// Times (s), ascending, with values.
    pub values: Vec<[f64; 2]>,
    /// What counts as much of it, if it is small itself.
    pub size: f64,
}

/// `summary.json`: whether a run with constant inputs has become steady.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Steadiness {
    /// Whether no measure changed by more than 0.5 %.
    pub steady: bool,
    /// Over how long that was looked at, up to the end.
    pub over_s: f64,
    /// The measure that changed most.
    pub measure: String,
    /// Difference of its largest and smallest value meanwhile, relative to its size.
    #[serde(with = "crate::numbers")]
    pub change: f64,
    /// That per second.
    #[serde(with = "crate::numbers")]
    pub change_1_s: f64,
}

impl Steadiness {
    /// Of the measures of a run, which began to be constant at the time `begin` (s); none where there are too few
    /// steps.
    pub fn of(measures: &[SteadyMeasure], begin: f64) -> Option<Self> {
        let end = measures.iter().find_map(|m| m.values.last())?[0];
        let over = LAST * (end - begin);
        let change = |measure: &SteadyMeasure| {
            let late = measure.values.iter().filter(|[t, _]| *t >= end - over);
            let late: Vec<f64> = late.map(|[_, value]| *value).collect();
            if late.len() < 3 {
                return None;
            }
            let low = late.iter().copied().fold(f64::INFINITY, f64::min);
            let high = late.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let size = late[late.len() - 1].abs().max(measure.size);
            let change = if size > 0.0 { (high - low) / size } else { 0.0 };
            Some(change)
        };
        let changes = measures
            .iter()
            .filter_map(|measure| Some((measure, change(measure)?)));
        let (most, change) = changes.max_by(|a, b| a.1.total_cmp(&b.1))?;
        (over > 0.0).then(|| Self {
            steady: change <= STEADY,
            over_s: over,
            measure: most.name.clone(),
            change,
            change_1_s: change / over,
        })
    }

    /// What a run that has not become steady should be told.
    pub fn warning(&self) -> Option<String> {
        (!self.steady).then(|| {
            format!(
                "what drives the blood is constant, but the flow has not become steady: over the last {:.3} s the {} changed by {:.1} %, \
                 {:.0} % per second: raise time.end_s (--end-time), and go on with --resume",
                self.over_s,
                self.measure,
                100.0 * self.change,
                100.0 * self.change_1_s
            )
        })
    }
}

impl std::fmt::Display for Steadiness {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            over_s,
            measure,
            change,
            ..
        } = self;
        match self.warning() {
            Some(warning) => write!(f, "warning: {warning}"),
            None => write!(
                f,
                "the flow has become steady: over the last {over_s:.3} s nothing changed by more than {:.2} % ({measure})",
                100.0 * change
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn measure(name: &str, f: impl Fn(f64) -> f64) -> SteadyMeasure {
        SteadyMeasure {
            name: name.into(),
            values: (1..=100)
                .map(|n| f64::from(n) / 100.0)
                .map(|t| [t, f(t)])
                .collect(),
            size: 0.0,
        }
    }

    #[test]
    fn what_changes_most_decides_whether_a_run_is_steady() {
        let still = measure("pressure", |_| 7.0);
        let decays = |rate: f64| measure("wall shear", move |t| 1.0 + (-rate * t).exp());
        let found = Steadiness::of(&[still.clone(), decays(3.0)], 0.0).unwrap();
        assert!(!found.steady);
        assert_eq!(found.measure, "wall shear");
        let change = ((-2.4f64).exp() - (-3.0f64).exp()) / (1.0 + (-3.0f64).exp());
        assert_relative_eq!(found.change, change, max_relative = 1e-9);
        assert_relative_eq!(found.change_1_s, change / 0.2, max_relative = 1e-9);
        assert!(
            found
                .warning()
                .unwrap()
                .contains("the wall shear changed by 3.9 %")
        );
        let found = Steadiness::of(&[still, decays(8.0)], 0.0).unwrap();
        assert!(found.steady && found.change > 1e-3, "{found:?}");
        assert_eq!(found.warning(), None);
    }

    #[test]
    fn what_swings_is_not_steady_even_if_it_comes_back() {
        let swings = measure("outflow", |t| 1.0 + 0.01 * (62.8 * t).sin());
        assert!(!Steadiness::of(&[swings], 0.0).unwrap().steady);
    }

    #[test]
    fn a_small_measure_counts_by_its_size() {
        let mut small = measure("velocity", |t| 1e-3 * t);
        assert!(!Steadiness::of(&[small.clone()], 0.0).unwrap().steady);
        small.size = 1.0;
        assert!(Steadiness::of(&[small], 0.0).unwrap().steady);
    }
}
