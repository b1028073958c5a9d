//! What a user should know of a case that can be run.

use super::{
    BloodVessel, Case, Condition, GivenShape, PressureUnit, Problem, Start, TissueDirection, Window,
};

/// A gap of a flow curve is unusual if it is so many times as long as the next longest.
const LONG_GAP: f64 = 3.0;

impl Case {
    /// What makes the results of this case doubtful, a sentence each: a window of the hemodynamics that contains the
    /// smooth start or is not a whole number of periods, a flow curve that covers a part of the period only, more MPI
    /// ranks than `cores` this machine has.
    pub fn warnings(&self, cores: usize) -> Vec<String> {
        let mut warnings = Vec::new();
        if let Problem::Vessel(vessel) = &self.problem {
            warnings.extend(image_pressure(vessel));
            warnings.extend(tissue_at_rest(vessel));
            let is_steady = self.is_driven_steadily();
            let window = Window::of(self);
            warnings.extend(window.warning(&self.ramp, self.time.period, is_steady));
            for opening in vessel.openings(self.time.period).unwrap_or_default() {
                if let Condition::Flow(curve, _) = &opening.condition
                    && let Some([from, to]) = curve.gap(LONG_GAP)
                {
                    warnings.push(format!(
                        "{} says nothing of the flow from {from} to {to} s, where the curve is interpolated: is \
                         time.period_s = {} its period?",
                        vessel.opening_key(opening.end, "flow_file"),
                        self.time.period
                    ));
                }
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
    let (_, key) = vessel.start_pressure();
    let pressure = vessel.image_pressure();
    Some(format!(
        "the case does not say under which pressure its loaded shape was seen: {key} is taken, {:.0} mmHg, and changing it changes the unloaded wall. Add pressure_Pa = {pressure:?} to [initial]",
        pressure / PressureUnit::MillimetreMercury.si()
    ))
}

/// That tissue counts from an unloaded wall which is not the one that was seen, or that was stretched, if the case does
/// not say so.
fn tissue_at_rest(vessel: &BloodVessel) -> Option<String> {
    let tissue = vessel.surroundings.as_ref()?;
    if tissue.at_rest.is_some() || vessel.start() != Start::Equilibrium {
        return None;
    }
    let axial = match tissue.direction.unwrap_or_default() {
        TissueDirection::Radial => tissue.axial_spring,
        TissueDirection::Axial | TissueDirection::All => tissue.spring,
    };
    let is_there = |spring: Option<f64>| spring.is_some_and(|spring| spring > 0.0);
    let why = if vessel.given_shape() == GivenShape::Loaded
        && (is_there(tissue.spring) || is_there(axial))
    {
        "carry a part of the pressure in the given shape (`fsi-driver check --wall` says how much)"
    } else if vessel.axial_stretch() != 1.0 && is_there(axial) {
        "pull the wall back to where it was before initial.axial_stretch"
    } else {
        return None;
    };
    Some(format!(
        "springs of [surroundings] are at rest in the unloaded wall, so that they {why}: if the tissue is at rest in the loaded wall, add at_rest = \
         \"loaded\" to [surroundings]; if not, at_rest = \"unloaded\" says so"
    ))
}
