//! What passes through each opening on average.

use super::tables::{OpeningRow, by_name, is_whole};
use crate::case::Window;
use crate::hemodynamics::summary::Course;
use serde::{Deserialize, Serialize};

/// An opening over a window, in `summary.json` and on the page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct OpeningSummary {
    /// Its name.
    pub opening: String,
    /// Flow out of the domain, mean over time; negative where the fluid enters.
    #[serde(with = "crate::numbers")]
    pub mean_outflow_m3_s: f64,
    /// That over the sum of all that are positive, if it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share_of_outflow: Option<f64>,
    /// Mean pressure over the opening.
    pub p_Pa: Course,
}

impl OpeningSummary {
    /// Of each opening over the steps of a window, which are `step` (s) long; none if it has no step. Parts of steps
    /// that were divided do not count: means are those of equal distances.
    pub fn all(rows: &[OpeningRow], window: Window, step: f64) -> Vec<Self> {
        let inside = |row: &OpeningRow| {
            let is_inside = window.contains(row.time_s, step) && is_whole(row.time_s, step);
            is_inside.then_some((-row.flow_m3_s, row.p_Pa))
        };
        let summary = |(opening, points): (String, Vec<(f64, f64)>)| {
            let (outflow, pressure): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
            Some(Self {
                opening,
                mean_outflow_m3_s: Course::of(&outflow)?.mean,
                share_of_outflow: None,
                p_Pa: Course::of(&pressure)?,
            })
        };
        let names = by_name(rows, |row| row.opening.as_str(), inside).into_iter();
        let mut openings: Vec<Self> = names.filter_map(summary).collect();
        let outflows = openings.iter().map(|opening| opening.mean_outflow_m3_s);
        let all: f64 = outflows.filter(|outflow| *outflow > 0.0).sum();
        for opening in &mut openings {
            let share = opening.mean_outflow_m3_s / all;
            opening.share_of_outflow = (share > 0.0).then_some(share);
        }
        openings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step in two parts counts once, what is outside of the window not at all, and backflow has no share.
    #[test]
    fn means_are_over_the_whole_steps_of_the_window() {
        let row = |time_s, opening: &str, flow_m3_s| OpeningRow {
            time_s,
            opening: opening.into(),
            flow_m3_s,
            p_Pa: 1e3 - 1e9 * flow_m3_s,
            p_model_Pa: None,
        };
        let times = [(0.1, 9.0), (0.2, 1.0), (0.25, 7.0), (0.3, 2.0), (0.4, 9.0)];
        let rows: Vec<OpeningRow> = (times.iter())
            .flat_map(|&(t, q)| {
                let flows = [("in", 4.0 * q), ("a", -3.0 * q), ("b", -q), ("c", 0.1 * q)];
                flows.map(|(name, flow)| row(t, name, 1e-7 * flow))
            })
            .collect();
        let window = Window {
            start_s: 0.1,
            end_s: 0.3,
        };
        let found = OpeningSummary::all(&rows, window, 0.1);
        let shares: Vec<_> = found.iter().map(|it| it.share_of_outflow).collect();
        assert_eq!(shares[0], None);
        assert_eq!(shares[3], None);
        assert!((shares[1].unwrap() - 0.75).abs() < 1e-12);
        let a = &found[1];
        assert!((a.mean_outflow_m3_s - 4.5e-7).abs() < 1e-18);
        let p = [a.p_Pa.min, a.p_Pa.mean, a.p_Pa.max];
        assert!(
            p.iter()
                .zip([1300.0, 1450.0, 1600.0])
                .all(|(p, q)| (p - q).abs() < 1e-9)
        );
        let later = Window {
            start_s: 0.5,
            end_s: 0.8,
        };
        assert!(OpeningSummary::all(&rows, later, 0.1).is_empty());
    }
}
