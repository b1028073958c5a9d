//! What a user should know of a case that can be run.

use super::{Case, FlowCurve, Problem, Window};

/// A gap of a flow curve is unusual if it is so many times as long as the next longest.
const LONG_GAP: f64 = 3.0;

impl Case {
    /// What makes the results of this case doubtful, a sentence each: a window of the hemodynamics that contains the
    /// smooth start or is no whole number of periods, a flow curve that covers a part of the period only, more MPI
    /// ranks than `cores` this machine has.
    pub fn warnings(&self, cores: usize) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Problem::Vessel(vessel) = &self.problem {
            warnings = Window::of(self).warnings(&self.ramp, self.time.period);
            if let Ok(curve) = FlowCurve::new(&vessel.inflow, self.time.period)
                && let Some([from, to]) = curve.gap(LONG_GAP)
            {
                warnings.push(format!(
                    "inflow.file says nothing of the flow from {from} to {to} s, where the curve is interpolated: is \
                     time.period_s = {} its period?",
                    self.time.period
                ));
            }
        }
        let ranks = self.fluid.ranks;
        if ranks > cores {
            warnings.push(format!(
                "fluid.ranks = {ranks} (--ranks), but this machine has {cores} core(s): the ranks wait for each other, \
                 and steps take many times as long as with {cores}"
            ));
        }
        warnings
    }
}
