//! Times that fit the time step.

use super::Case;
use super::stack::Stack;

/// Whether `b` is a multiple of `a` up to rounding.
pub(super) fn divides(a: f64, b: f64) -> bool {
    let times = b / a;
    times.round() >= 1.0 && (times - times.round()).abs() <= 1e-6 * times.round()
}

impl Case {
    /// Makes the time step a whole part of a period that was written above it, and end, window and intervals of output
    /// whole numbers of steps, at least one. What the user has written and now reads otherwise is reported, one
    /// sentence each.
    pub(super) fn fit_times(&mut self, stack: &Stack) -> Vec<String> {
        let mut told = Vec::new();
        let mut tell = |key: &str, before: f64, now: f64, why: String| {
            if stack.entry(key).is_some_and(|e| !e.place.is_built_in()) {
                told.push(format!("{key} = {before:?} is taken as {now}: {why}"));
            }
        };
        let (step, period) = (self.time.step, self.time.period);
        let last = stack.last_written(&["time.step_s", "time.period_s"]);
        let is_fitted = last.is_some_and(|entry| entry.key == "time.period_s");
        if is_fitted && period > step && !divides(step, period) {
            self.time.step = period / (period / step).ceil();
            let why = format!("a whole part of time.period_s = {period}");
            tell("time.step_s", step, self.time.step, why);
        }
        let step = self.time.step;
        if !divides(step, period) {
            return told; // which is refused
        }
        let is_long = self.time.end >= 0.5 * step; // a run of no step is refused
        let output = &mut self.output;
        let all = [
            ("time.end_s", is_long.then_some(&mut self.time.end)),
            (
                "output.structure_interval_s",
                Some(&mut output.structure_interval),
            ),
            ("output.fluid_interval_s", Some(&mut output.fluid_interval)),
            ("output.window_start_s", output.window_start.as_mut()),
            ("output.window_end_s", output.window_end.as_mut()),
        ];
        for (key, value) in all {
            let Some(value) = value.filter(|value| **value > 0.0 && !divides(step, **value)) else {
                continue;
            };
            let steps = (*value / step).round().max(1.0);
            let now = steps * step;
            tell(
                key,
                *value,
                now,
                format!("{steps} steps of time.step_s = {step}"),
            );
            *value = now;
        }
        told
    }
}
