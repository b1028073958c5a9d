//! The part of a run that is evaluated.

use crate::case::Case;
use serde::{Deserialize, Serialize};

/// The times `start < t <= end`, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// Not included.
    pub start_s: f64,
    /// Included.
    pub end_s: f64,
}

impl Window {
    /// The window that a case asks for: the last period if it names none, which is shorter than a period in a run that
    /// is.
    pub fn of(case: &Case) -> Self {
        let end = case.output.window_end.unwrap_or(case.time.end);
        let last_period = (end - case.time.period).max(0.0);
        // Differences of decimal numbers are not decimal: 3.3 - 1.0.
        let rounded = (last_period / case.time.step).round() * case.time.step;
        Self {
            start_s: case.output.window_start.unwrap_or(rounded),
            end_s: end,
        }
    }

    /// Whether the step that ends at `time` (s) and is `step` (s) long belongs to it.
    pub fn contains(self, time: f64, step: f64) -> bool {
        time > self.start_s + 0.5 * step && time < self.end_s + 0.5 * step
    }

    /// Number of steps of the length `step` (s).
    pub fn steps(self, step: f64) -> usize {
        ((self.end_s - self.start_s) / step).round().max(0.0) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_has_the_steps_after_its_start_up_to_its_end_despite_rounding() {
        let window = Window {
            start_s: 0.2,
            end_s: 0.3,
        };
        let inside: Vec<usize> = (0..1000)
            .filter(|n| window.contains(*n as f64 * 0.002, 0.002))
            .collect();
        assert_eq!((inside[0], inside[inside.len() - 1]), (101, 150));
        assert_eq!(inside.len(), window.steps(0.002));
    }
}
