//! Templates whose fields choose between conditions by themselves, as those of the project once did: they read these
//! parameters and know an inlet under a flow or a pressure, and an outlet under a pressure.

use super::openings::VesselOpenings;
use crate::case::{Condition, InletProfile, Start, VesselSide};
use std::fmt::Write as _;

impl VesselOpenings {
    /// The parameters of the openings, for a ramp of this duration (s).
    pub(super) fn earlier_parameters(&self, ramp: f64) -> String {
        let mut text = String::from("// For templates that do not include system/fsiOpenings\n");
        let mut add = |name: &str, value: &str| {
            let _ = writeln!(text, "{name:<23} {value};");
        };
        let ramp_start = match self.start {
            Start::Ramp => 0.0,
            Start::Equilibrium => -2.0 * ramp,
        };
        add("pressureRampStart", &format!("{ramp_start:e}"));
        for patch in &self.openings {
            let model = patch.opening.condition.pressure();
            let pressure = model.map_or(0.0, |model| model.at_start());
            match patch.opening.end {
                VesselSide::Start => {
                    let condition = match &patch.opening.condition {
                        Condition::Flow(_, InletProfile::Plug) => "plug",
                        Condition::Pressure(_) => "pressure",
                        _ => "profile",
                    };
                    add("inletCondition", condition);
                    add("inletMotion", patch.motion);
                    add("inletPressure", &format!("{pressure:e}"));
                    add("inletRampedFrom", &format!("{:e}", self.initial_pressure()));
                }
                VesselSide::End => {
                    let distal = model.and_then(|model| model.distal);
                    let (resistance, compliance) = distal.unwrap_or((0.0, 0.0));
                    let proximal = model.map_or(0.0, |model| model.proximal);
                    let condition = if distal.is_some() {
                        "windkessel"
                    } else {
                        "pressure"
                    };
                    add("outletCondition", condition);
                    add("outletMotion", patch.motion);
                    add("windkesselResistance", &format!("{resistance:e}"));
                    add("windkesselCompliance", &format!("{compliance:e}"));
                    add("windkesselPressure", &format!("{pressure:e}"));
                    add("proximalResistance", &format!("{proximal:e}"));
                }
            }
        }
        text
    }
}
