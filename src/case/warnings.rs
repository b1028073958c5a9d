//! What a user should know of a case that can be run.

use super::{
    BloodVessel, Case, FlowCurve, GivenShape, OutletCondition, PressureUnit, Problem, Window,
};

/// A gap of a flow curve is unusual if it is so many times as long as the next longest.
const LONG_GAP: f64 = 3.0;

impl Case {
    /// What makes the results of this case doubtful, a sentence each: a window of the hemodynamics that contains the
    /// smooth start or is no whole number of periods, a flow curve that covers a part of the period only, more MPI
    /// ranks than `cores` this machine has.
    pub fn warnings(&self, cores: usize) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Problem::Vessel(vessel) = &self.problem {
            warnings.extend(image_pressure(vessel));
            warnings.extend(Window::of(self).warnings(&self.ramp, self.time.period));
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

/// That the pressure in a given shape that is loaded is not said.
fn image_pressure(vessel: &BloodVessel) -> Option<String> {
    let said = vessel.initial.as_ref()?.pressure;
    if vessel.given_shape() != GivenShape::Loaded || said.is_some() {
        return None;
    }
    let key = match vessel.outlet_condition() {
        OutletCondition::Windkessel => "windkessel.initial_pressure_Pa",
        OutletCondition::Resistance | OutletCondition::Pressure => "outlet.pressure_Pa",
    };
    let pressure = vessel.image_pressure();
    Some(format!(
        "the case does not say under which pressure its loaded shape was seen: {key} is taken, {:.0} mmHg, and whoever changes it \
         changes the unloaded wall. Add pressure_Pa = {pressure:?} to [initial]",
        pressure / PressureUnit::MillimetreMercury.si()
    ))
}
