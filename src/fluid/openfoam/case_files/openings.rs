//! What is prescribed at the openings of a vessel, as boundary fields and files of an OpenFOAM case.

use super::super::names::{FIELDS, included};
use crate::Vec3;
use crate::case::{
    Blood, BloodVessel, Case, Condition, FlowCurve, InletEnd, InletProfile, Opening, PressureCurve,
    PressureModel, Start, TableError, VesselEnd, VesselSide, Windkessel,
};
use crate::fluid::inlet_velocity::InletVelocity;
use crate::geometry::{PolyMesh, Vessel};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write as _;

/// How the points of a patch move at which a wall ends whose rim moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PatchMotion {
    /// Within the plane of the patch.
    InPlane,
    /// As the mesh next to them.
    Free,
}

impl PatchMotion {
    /// The type of its condition in `pointDisplacement`.
    pub(in super::super) fn condition(self) -> &'static str {
        match self {
            Self::InPlane => "slip",
            Self::Free => "zeroGradient",
        }
    }
}

/// The openings of a vessel.
#[derive(Debug, Clone)]
pub struct VesselOpenings {
    pub(super) openings: Vec<OpeningPatch>,
    pub(super) start: Start,
    /// Pressure in equilibrium at t = 0, Pa.
    equilibrium: f64,
    period: f64,
}

/// An opening as a patch.
#[derive(Debug, Clone)]
pub(super) struct OpeningPatch {
    pub(super) opening: Opening,
    /// Of a prescribed flow, if it is no plug.
    profile: Option<Profile>,
    /// How its points move.
    pub(super) motion: &'static str,
}

/// Shapes of the velocity at the centres of the faces of an opening.
#[derive(Debug, Clone)]
struct Profile {
    velocity: InletVelocity,
    /// Area of the opening, m².
    area: f64,
    /// Centres of the faces (m), and how far they are from the middle, relative to the radius.
    points: Vec<([f64; 3], f64)>,
}

impl VesselOpenings {
    /// A flow with the same velocity all over the inlet, and a windkessel.
    pub fn flow_and_windkessel(inflow: FlowCurve, windkessel: &Windkessel, start: Start) -> Self {
        let period = inflow.period();
        let model = PressureModel {
            proximal: windkessel.proximal.unwrap_or(0.0),
            distal: Some((windkessel.resistance, windkessel.compliance)),
            downstream: PressureCurve::Constant(0.0),
            initial: windkessel.initial_pressure,
        };
        let flow = Condition::Flow(inflow, InletProfile::Plug);
        let patch = |name: &str, end, condition| OpeningPatch {
            opening: Opening {
                name: name.into(),
                end,
                condition,
            },
            profile: None,
            motion: "fixedValue",
        };
        Self {
            openings: vec![
                patch("inlet", VesselSide::Start, flow),
                patch("outlet", VesselSide::End, Condition::Pressure(model)),
            ],
            start,
            equilibrium: windkessel.initial_pressure,
            period,
        }
    }

    /// Those of a vessel whose blood has this mesh.
    ///
    /// # Errors
    /// If a curve cannot be read.
    pub fn new(case: &Case, vessel: &BloodVessel, mesh: &PolyMesh) -> Result<Self, TableError> {
        let openings = vessel.openings(case.time.period)?.into_iter();
        let geometry = Vessel::new(vessel);
        let patch = |opening: Opening| OpeningPatch {
            profile: Profile::new(&case.blood, &opening, mesh, |x| {
                geometry.opening_share(opening.end, x)
            }),
            // An end of the wall that slides stays in its plane, and so do the points of the opening.
            motion: match opening.end {
                VesselSide::Start => match vessel.inlet_end() {
                    InletEnd::Clamped => "fixedValue",
                    InletEnd::Sliding | InletEnd::Radial => "slip",
                },
                VesselSide::End => match vessel.outlet_end().0 {
                    VesselEnd::Clamped => "fixedValue",
                    VesselEnd::Sliding | VesselEnd::Radial => "slip",
                    VesselEnd::Springs => "zeroGradient",
                },
            },
            opening,
        };
        Ok(Self {
            openings: openings.map(patch).collect(),
            start: vessel.start(),
            equilibrium: vessel.equilibrium_pressure(),
            period: case.time.period,
        })
    }

    /// Those of a tree whose blood has this mesh, and how the points of patches move that are not held.
    pub fn of_tree(
        case: &Case,
        openings: Vec<Opening>,
        moving: &BTreeMap<String, PatchMotion>,
        mesh: &PolyMesh,
    ) -> Self {
        let patch = |opening: Opening| {
            let faces = mesh.patch(&opening.name).map(|patch| {
                let faces = patch.start..patch.start + patch.size;
                faces
                    .map(|face| mesh.face_geometry(face))
                    .collect::<Vec<_>>()
            });
            let faces = faces.unwrap_or_default();
            let area: f64 = faces.iter().map(|(_, area)| area.norm()).sum();
            let middle: Vec3 = faces.iter().map(|(x, area)| x * area.norm()).sum::<Vec3>() / area;
            let share = |x: &Vec3| (x - middle).norm() / (area / PI).sqrt();
            OpeningPatch {
                profile: Profile::new(&case.blood, &opening, mesh, share),
                motion: moving
                    .get(&opening.name)
                    .map_or("fixedValue", |it| it.condition()),
                opening,
            }
        };
        let initial = case.initial_wall();
        Self {
            openings: openings.into_iter().map(patch).collect(),
            start: match initial {
                None => Start::Ramp,
                Some(_) => Start::Equilibrium,
            },
            equilibrium: initial.map_or(0.0, |initial| initial.pressure),
            period: case.time.period,
        }
    }

    /// Names of the patches.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.openings
            .iter()
            .map(|patch| patch.opening.name.as_str())
    }

    /// Pressure (Pa) in the whole blood at t = 0.
    pub fn initial_pressure(&self) -> f64 {
        match self.start {
            Start::Ramp => 0.0,
            Start::Equilibrium => self.equilibrium,
        }
    }

    /// Names and contents of the files that fields include, for a ramp of this duration (s) and blood of this density
    /// (kg/m³).
    pub fn conditions(&self, ramp: f64, density: f64) -> Vec<(String, String)> {
        let inlets: Vec<&str> = (self.openings.iter())
            .filter(|patch| patch.opening.end == VesselSide::Start)
            .map(|patch| patch.opening.name.as_str())
            .collect();
        let condition = |patch: &OpeningPatch, field: &str| match field {
            "p" => self.pressure(patch, ramp, density),
            "U" => patch.velocity(ramp, &inlets),
            _ => format!("type {}; value uniform (0 0 0);", patch.motion),
        };
        let file = |field: &str| {
            let mut text = String::from(
                "// What is prescribed at the openings; written by fsi-driver, do not edit\n",
            );
            for patch in &self.openings {
                let _ = writeln!(
                    text,
                    "{}\n{{\n{}\n}}",
                    patch.opening.name,
                    condition(patch, field)
                );
            }
            (included(field), text)
        };
        FIELDS.into_iter().map(file).collect()
    }

    /// The kinematic pressure at an opening.
    fn pressure(&self, patch: &OpeningPatch, ramp: f64, density: f64) -> String {
        let Condition::Pressure(model) = &patch.opening.condition else {
            return "type zeroGradient;".into();
        };
        let (resistance, compliance) = model.distal.unwrap_or((0.0, 0.0));
        let name = &patch.opening.name;
        let mut text = format!(
            "type windkesselPressure;\nresistance {resistance:e};\ncompliance {compliance:e};\nproximalResistance {:e};\n\
             density {density:e};\npressure {:e};\n",
            model.proximal,
            model.at_start(),
        );
        if model.distal.is_none() {
            let _ = writeln!(
                text,
                "distalPressure {{ {} }}",
                of_file(&format!("{name}Pressure"))
            );
        }
        // At a start the pressure rises from that of the beginning; at an end the ramp of an equilibrium has ended at
        // t = 0.
        let ramp_start = match (patch.opening.end, self.start) {
            (VesselSide::End, Start::Equilibrium) => -2.0 * ramp,
            (VesselSide::End, Start::Ramp) => 0.0,
            (VesselSide::Start, _) => {
                let _ = writeln!(text, "rampedFrom {:e};", self.initial_pressure());
                0.0
            }
        };
        text + &format!("ramp {}", half_cosine(ramp_start, ramp))
    }

    /// Names and contents of the files in `constant`, for steps of this length (s). OpenFOAM interpolates linearly
    /// between the rows of curves and repeats them.
    pub fn files(&self, step: f64) -> Vec<(String, String)> {
        let mut files = Vec::new();
        for OpeningPatch {
            opening, profile, ..
        } in &self.openings
        {
            let name = |what| format!("{}{what}", opening.name);
            match &opening.condition {
                Condition::Flow(curve, _) => {
                    files.push((name("Flow"), table(curve.samples(step))));
                    files.extend(profile.iter().map(|it| (name("Profile"), it.dictionary())));
                }
                Condition::FlowSplit(_) => {}
                Condition::Pressure(model) if model.distal.is_none() => {
                    let rows = model.downstream.samples(step, self.period).into_iter();
                    files.push((name("Pressure"), table(rows)));
                }
                Condition::Pressure(_) => {}
            }
        }
        files
    }
}

impl OpeningPatch {
    /// The velocity at the opening, with a ramp of this duration (s); `inlets` are the patches where blood enters.
    fn velocity(&self, ramp: f64, inlets: &[&str]) -> String {
        let name = &self.opening.name;
        let ramp = half_cosine(0.0, ramp);
        match (&self.opening.condition, self.opening.end) {
            (Condition::Flow(..), _) => {
                let kind = match self.profile {
                    None => "type flowRateInletVelocity;\n".into(),
                    Some(_) => format!(
                        "type profiledFlowRateInletVelocity;\nprofile \"<constant>/{name}Profile\";\nramp {ramp}\n"
                    ),
                };
                let curve = of_file(&format!("{name}Flow"));
                format!(
                    "{kind}volumetricFlowRate\n{{\n    type scale;\n    scale {ramp}\n    value {{ {curve} }}\n}}\nvalue uniform (0 0 0);"
                )
            }
            (Condition::FlowSplit(fraction), _) => format!(
                "type flowSplitVelocity;\nfraction {fraction:e};\ninlets ({});\nvalue uniform (0 0 0);",
                inlets.join(" ")
            ),
            // Fluid enters along the normal.
            (Condition::Pressure(_), VesselSide::Start) => {
                "type pressureInletOutletVelocity;\nvalue uniform (0 0 0);".into()
            }
            // Fluid that should enter here during reversal enters at rest.
            (Condition::Pressure(_), VesselSide::End) => {
                "type inletOutlet;\ninletValue uniform (0 0 0);\nvalue uniform (0 0 0);".into()
            }
        }
    }
}

/// A curve in a file, as a function of time: not `csvFile`, which takes the place where reading fails for the end.
fn of_file(name: &str) -> String {
    format!("type tableFile; file \"<constant>/{name}\"; outOfBounds repeat;")
}

fn half_cosine(start: f64, duration: f64) -> String {
    format!("{{ type halfCosineRamp; start {start:e}; duration {duration:e}; }}")
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
    /// None if the velocity is the same all over. `share` says how far a point (m) is from the middle, relative to the
    /// radius.
    fn new(
        blood: &Blood,
        opening: &Opening,
        mesh: &PolyMesh,
        share: impl Fn(&Vec3) -> f64,
    ) -> Option<Self> {
        let Condition::Flow(curve, profile) = &opening.condition else {
            return None;
        };
        if *profile == InletProfile::Plug {
            return None;
        }
        let patch = mesh.patch(&opening.name)?;
        let faces = patch.start..patch.start + patch.size;
        let faces: Vec<_> = faces.map(|face| mesh.face_geometry(face)).collect();
        let area = faces.iter().map(|(_, area)| area.norm()).sum::<f64>();
        let points = faces
            .iter()
            .map(|(centre, _)| ((*centre).into(), share(centre)));
        Some(Self {
            velocity: InletVelocity::new(
                *profile,
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
            "// Velocity at the opening: shapes at the centres of its faces; written by fsi-driver, do not edit\n\
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
