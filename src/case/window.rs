//! The part of a run that is evaluated.

use super::{Case, Ramp, RunEnds};
use fsi_numerics::twelve_digits;
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

    /// Why averages over the window may not be those of a beat, in one line; `None` if nothing is to be said against
    /// it. A run that is driven steadily has no beats.
    pub fn warning(self, ramp: &Ramp, period: f64, is_steady: bool) -> Option<String> {
        let Self { start_s, end_s } = self;
        let mut reasons = Vec::new();
        let rounding = 1e-9 * period;
        // A run that ends within its first period has no better window; only a start that fills most of it is worth a
        // word.
        let is_short = end_s <= period - rounding;
        let start_counts = !is_short || ramp.duration > 0.5 * (end_s - start_s);
        if start_s < ramp.duration - rounding && start_counts {
            reasons.push(format!(
                "contains the smooth start until {} s",
                ramp.duration
            ));
        }
        let periods = (end_s - start_s) / period;
        let is_whole =
            periods.round() >= 1.0 && (periods - periods.round()).abs() <= 1e-6 * periods;
        if !is_steady && !is_whole && !is_short {
            reasons.push(format!("covers {} periods", significant(periods)));
        }
        (!reasons.is_empty()).then(|| {
            format!(
                "the window {start_s} to {end_s} s (output.window_start_s) {}: its averages are not those of a beat",
                reasons.join(" and ")
            )
        })
    }
}

/// The windows of a run: one, or, where it runs until it is periodic, the beats after which it may end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Windows {
    of_case: Window,
    /// s
    step: f64,
    ends: RunEnds,
}

impl Windows {
    /// Those of a case.
    pub fn of(case: &Case) -> Self {
        Self {
            of_case: Window::of(case),
            step: case.time.step,
            ends: RunEnds::of(case),
        }
    }

    /// The window of a run that has reached a time (s).
    pub fn at(self, time: f64) -> Window {
        // Of a time within a step it is the one that ends it.
        let step = (time / self.step - 1e-3).max(0.0).ceil() as usize;
        let Some(beat) = self.ends.beat_of(step) else {
            return self.of_case;
        };
        let [start_s, end_s] = beat.map(|step| twelve_digits(step as f64 * self.step));
        Window { start_s, end_s }
    }
}

/// A number with three significant digits, without trailing zeros.
fn significant(x: f64) -> String {
    let digits = (2.0 - x.abs().log10().floor()).clamp(0.0, 12.0) as usize;
    let text = format!("{x:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A window has the steps after its start up to its end despite rounding.
    #[test]
    fn a_window_has_its_steps_despite_rounding() {
        let window = Window {
            start_s: 0.2,
            end_s: 0.3,
        };
        let inside: Vec<usize> = (0..1000)
            .filter(|n| window.contains(*n as f64 * 0.002, 0.002))
            .collect();
        assert_eq!((inside[0], inside[inside.len() - 1]), (101, 150));
        assert_eq!(inside.len(), 50);
    }

    /// A window that contains the ramp, and one that is not a whole number of periods.
    #[test]
    fn unsuitable_windows_are_warned_of() {
        let warning = |start_s, end_s, is_steady| {
            let ramp = Ramp { duration: 0.5 };
            Window { start_s, end_s }.warning(&ramp, 0.8, is_steady)
        };
        // Whole periods after the ramp, with the rounding of decimal numbers.
        for (start, end) in [(0.5, 1.3), (1.6, 2.4), (0.7, 0.7 + 3.0 * 0.8)] {
            assert_eq!(warning(start, end, false), None);
        }
        #[rustfmt::skip]
        let windows = [
            (0.48, 1.28, "window 0.48 to 1.28 s (output.window_start_s) contains the smooth start until 0.5 s:"),
            (0.8, 1.0, "(output.window_start_s) covers 0.25 periods: its averages"),
            (0.8, 2.0, "covers 1.5 periods:"),
            (0.0, 1.0, "contains the smooth start until 0.5 s and covers 1.25 periods:"),
        ];
        for (start, end, said) in windows {
            let warning = warning(start, end, false).unwrap();
            assert!(warning.contains(said), "{warning}");
        }
        assert_eq!(warning(0.8, 1.0, true), None);
        assert_eq!(significant(1.0 / 3.0), "0.333");
        assert_eq!(significant(1234.5), "1234");
    }
}
