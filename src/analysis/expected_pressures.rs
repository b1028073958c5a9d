//! The pressures that a case lets expect, before anything is computed.

use super::three_elements::ThreeElements;
use super::windkessel::{Pressures, STEPS, TwoElements};
use crate::case::{BloodVessel, Condition, PressureModel, TableError, VesselSide};

impl Pressures {
    /// Those to expect in a vessel, in the periodic state of beats of `period` (s) and without the vessel's own
    /// compliance: of what is prescribed at the outlet for the flow, or of the pressure at the inlet.
    ///
    /// # Errors
    /// If a curve cannot be read.
    pub fn expected(vessel: &BloodVessel, period: f64) -> Result<Self, TableError> {
        let times = (0..STEPS).map(|i| period * i as f64 / STEPS as f64);
        let [inlet, outlet] = [
            vessel.prescribed_at(VesselSide::Start, period)?,
            vessel.prescribed_at(VesselSide::End, period)?,
        ];
        let (curve, model) = match (inlet, outlet) {
            (Condition::Flow(curve, _), Condition::Pressure(model)) => (curve, model),
            (Condition::Pressure(PressureModel { downstream, .. }), _) => {
                return Ok(Self::of(
                    &times.map(|t| downstream.pressure(t)).collect::<Vec<_>>(),
                ));
            }
            _ => unreachable!("one of the openings of a checked case is under a pressure"),
        };
        let PressureModel {
            proximal,
            distal,
            downstream,
            ..
        } = model;
        let Some((resistance, compliance)) = distal else {
            let at = |t: f64| downstream.pressure(t) + proximal * curve.flow(t);
            return Ok(Self::of(&times.map(at).collect::<Vec<_>>()));
        };
        if proximal == 0.0 {
            let two = TwoElements {
                resistance,
                compliance,
            };
            return Ok(two.pressures(&curve));
        }
        let all = ThreeElements {
            proximal,
            resistance,
            compliance,
            vessel: 0.0,
        };
        Ok(all.pressures(&curve))
    }
}
