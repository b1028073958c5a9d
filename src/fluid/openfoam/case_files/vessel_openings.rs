//! What is prescribed at the ends of a vessel, as parameters and files of an OpenFOAM case.

use crate::case::{
    Blood, BloodVessel, Case, FlowCurve, InletEnd, InletProfile, OutletCondition, OutletElements,
    PressureCurve, Start, TableError, VesselEnd, Windkessel,
};
use crate::fluid::inlet_velocity::InletVelocity;
use crate::geometry::{PolyMesh, Vessel};
use std::f64::consts::PI;
use std::fmt::Write as _;

/// Inlet and outlet of a vessel.
#[derive(Debug, Clone)]
pub struct VesselOpenings {
    inlet: Inlet,
    outlet: OutletElements,
    /// Pressure behind the outlet, if it is prescribed.
    distal: Option<PressureCurve>,
    /// Pressure of the windkessel at t = 0, Pa.
    windkessel_pressure: f64,
    start: Start,
    /// What holds the wall at the inlet.
    inlet_end: InletEnd,
    /// What holds the wall at the outlet.
    outlet_end: VesselEnd,
    /// Pressure in equilibrium at t = 0, Pa.
    equilibrium: f64,
    period: f64,
}

#[derive(Debug, Clone)]
enum Inlet {
    /// A flow, and its profile if it is no plug.
    Flow(FlowCurve, Option<Profile>),
    Pressure(PressureCurve),
}

/// Shapes of the velocity at the centres of the inlet's faces.
#[derive(Debug, Clone)]
struct Profile {
    velocity: InletVelocity,
    /// Area of the inlet, m².
    area: f64,
    /// Centres of the faces (m), and how far they are from the middle, relative to the radius.
    points: Vec<([f64; 3], f64)>,
}

impl VesselOpenings {
    /// A flow with the same velocity all over the inlet, and a windkessel.
    pub fn flow_and_windkessel(inflow: FlowCurve, windkessel: &Windkessel, start: Start) -> Self {
        Self {
            period: inflow.period(),
            inlet: Inlet::Flow(inflow, None),
            outlet: windkessel.into(),
            distal: None,
            windkessel_pressure: windkessel.initial_pressure,
            start,
            inlet_end: InletEnd::Clamped,
            outlet_end: VesselEnd::Clamped,
            equilibrium: windkessel.initial_pressure,
        }
    }

    /// Those of a vessel whose blood has this mesh.
    ///
    /// # Errors
    /// If a curve cannot be read.
    pub fn new(case: &Case, vessel: &BloodVessel, mesh: &PolyMesh) -> Result<Self, TableError> {
        let period = case.time.period;
        let inlet = match vessel.inlet_pressure(period)? {
            Some(pressure) => Inlet::Pressure(pressure),
            None => {
                let curve = FlowCurve::new(&vessel.inflow, period)?;
                let profile = Profile::new(&case.blood, vessel, &curve, mesh);
                Inlet::Flow(curve, profile)
            }
        };
        let distal = match vessel.outlet_condition() {
            OutletCondition::Windkessel => None,
            OutletCondition::Resistance | OutletCondition::Pressure => {
                Some(vessel.outlet_pressure(period)?)
            }
        };
        Ok(Self {
            inlet,
            outlet: vessel.outlet_elements(),
            distal,
            windkessel_pressure: vessel.windkessel.initial_pressure,
            start: vessel.start(),
            inlet_end: vessel.inlet_end(),
            outlet_end: vessel.outlet_end().0,
            equilibrium: vessel.equilibrium_pressure(),
            period,
        })
    }

    /// Words by which the templates choose.
    pub fn words(&self) -> [(&'static str, &'static str); 4] {
        let inlet = match &self.inlet {
            Inlet::Flow(_, None) => "plug",
            Inlet::Flow(_, Some(_)) => "profile",
            Inlet::Pressure(_) => "pressure",
        };
        let outlet = match self.distal {
            None => "windkessel",
            Some(_) => "pressure",
        };
        // An end of the wall that slides stays in its plane, and so do the points of the opening.
        let inlet_motion = match self.inlet_end {
            InletEnd::Clamped => "fixedValue",
            InletEnd::Sliding | InletEnd::Radial => "slip",
        };
        let outlet_motion = match self.outlet_end {
            VesselEnd::Clamped => "fixedValue",
            VesselEnd::Sliding | VesselEnd::Radial => "slip",
            VesselEnd::Springs => "zeroGradient",
        };
        [
            ("inletCondition", inlet),
            ("outletCondition", outlet),
            ("inletMotion", inlet_motion),
            ("outletMotion", outlet_motion),
        ]
    }

    /// Names, values and units of the parameters, for a ramp of this duration (s) and blood of this density (kg/m³).
    pub fn parameters(&self, ramp: f64, density: f64) -> Vec<(&'static str, f64, &'static str)> {
        let (resistance, compliance) = self.outlet.distal.unwrap_or((0.0, 0.0));
        let behind = match &self.distal {
            Some(curve) => curve.pressure(0.0),
            None => self.windkessel_pressure,
        };
        // A ramp that has ended at t = 0.
        let is_over = -2.0 * ramp;
        let (ramp_start, initial) = match self.start {
            Start::Ramp => (0.0, 0.0),
            Start::Equilibrium => (is_over, self.equilibrium),
        };
        let mut all = vec![
            ("windkesselResistance", resistance, "Pa s/m3"),
            ("windkesselCompliance", compliance, "m3/Pa"),
            (
                "windkesselPressure",
                behind,
                "Pa, at t = 0, before the ramp",
            ),
            ("proximalResistance", self.outlet.proximal, "Pa s/m3"),
            ("pressureRampStart", ramp_start, "s"),
            (
                "initialPressure",
                initial / density,
                "m2/s2, p/rho at t = 0",
            ),
        ];
        if let Inlet::Pressure(curve) = &self.inlet {
            all.push((
                "inletPressure",
                curve.pressure(0.0),
                "Pa, at t = 0, before the ramp",
            ));
            all.push(("inletRampedFrom", initial, "Pa"));
        }
        all
    }

    /// Names and contents of the files in `constant`, for steps of this length (s). OpenFOAM interpolates linearly
    /// between the rows of curves and repeats them.
    pub fn files(&self, step: f64) -> Vec<(&'static str, String)> {
        let mut files = Vec::new();
        match &self.inlet {
            Inlet::Flow(curve, profile) => {
                files.push(("inflow", table(curve.samples(step))));
                files.extend(profile.iter().map(|it| ("inletProfile", it.dictionary())));
            }
            Inlet::Pressure(curve) => {
                let rows = curve.samples(step, self.period).into_iter();
                files.push(("inletPressure", table(rows)));
            }
        }
        if let Some(curve) = &self.distal {
            let rows = curve.samples(step, self.period).into_iter();
            files.push(("outletPressure", table(rows)));
        }
        files
    }
}

/// A list, as OpenFOAM's `tableFile` reads it: it gives up at one that does not end.
fn table(rows: impl Iterator<Item = [f64; 2]>) -> String {
    let mut text = "(\n".to_owned();
    for [time, value] in rows {
        let _ = writeln!(text, "({time:e} {value:e})");
    }
    text + ")\n"
}

impl Profile {
    /// None if the velocity is the same all over.
    fn new(
        blood: &Blood,
        vessel: &BloodVessel,
        curve: &FlowCurve,
        mesh: &PolyMesh,
    ) -> Option<Self> {
        let profile = vessel.inlet_profile();
        if profile == InletProfile::Plug {
            return None;
        }
        let geometry = Vessel::new(vessel);
        let patch = mesh.patch("inlet")?;
        let faces = patch.start..patch.start + patch.size;
        let faces: Vec<_> = faces.map(|face| mesh.face_geometry(face)).collect();
        let area = faces.iter().map(|(_, area)| area.norm()).sum::<f64>();
        let points = faces.iter().map(|(centre, _)| {
            let share = geometry.inlet_share(centre);
            ((*centre).into(), share)
        });
        Some(Self {
            velocity: InletVelocity::new(
                profile,
                curve,
                (area / PI).sqrt(),
                blood.viscosity / blood.density,
            ),
            area,
            points: points.collect(),
        })
    }

    /// As the adapter reads it (`profiledFlowRateInletVelocity`).
    fn dictionary(&self) -> String {
        let list = |values: &mut dyn Iterator<Item = f64>| -> String {
            let numbers: Vec<String> = values.map(|x| format!("{x:e}")).collect();
            format!("({})", numbers.join(" "))
        };
        let points: Vec<String> = (self.points.iter())
            .map(|(x, _)| list(&mut x.iter().copied()))
            .collect();
        let shares = || self.points.iter().map(|(_, share)| *share);
        let at_points: Vec<Vec<f64>> = shares().map(|r| self.velocity.terms(r)).collect();
        let terms: Vec<String> = (0..self.velocity.factors(0.0).len())
            .map(|k| list(&mut at_points.iter().map(|terms| terms[k] / self.area)))
            .collect();
        format!(
            "// Velocity at the inlet: shapes at the centres of its faces; written by fsi-driver, do not edit\n\
             frequency {:e}; // 1/s, of the first harmonic, times 2 pi\n\
             points\n(\n{}\n);\n\
             // What the terms do not bring, relative to the mean velocity\n\
             rest {};\n\
             // m/s: the mean, then cosine and sine of each harmonic\n\
             terms\n(\n{}\n);\n",
            self.velocity.frequency(),
            points.join("\n"),
            list(&mut shares().map(|share| self.velocity.rest(share))),
            terms.join("\n"),
        )
    }
}
