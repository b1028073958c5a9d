//! The openings of a vessel as a list, `[[opening]]`: where the blood enters and leaves, and what is prescribed there.
//! The tables `[inflow]` and `[inlet]`, `[windkessel]` and `[outlet]` say it of an end that the list leaves out.
//!
//! A condition is a variant of [`ConditionKeys`] with its keys, and an arm of [`ConditionKeys::read`], which makes of
//! it what fluids know: a flow, a share of a flow, or a pressure `a + b Q`.

use super::schema::{Key, KeyTable, Schema, ValueKind, above, from, join};
use super::table::choice;
use super::{
    BloodVessel, FlowCurve, FlowUnit, Inflow, InletCondition, InletProfile, OutletCondition,
    PressureCurve, PressureUnit, Start, TableError,
};
use crate::words;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

words! {
    /// An end of a vessel.
    #[derive(PartialOrd, Ord)]
    pub enum VesselSide {
        /// Where the centre-line begins.
        Start = "start",
        /// Where it ends.
        End = "end",
    }
}

/// An opening: what it is called and where it is, next to the keys of its condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OpeningKeys {
    /// `end`: at which end of the vessel it is.
    pub end: VesselSide,
    /// `name`: what tables, pages and OpenFOAM's mesh call it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The others.
    #[serde(flatten)]
    pub condition: ConditionKeys,
}

impl KeyTable for OpeningKeys {
    fn describe(path: &str, schema: &mut Schema) {
        let key = |name, kind, about, absent| Key {
            path: join(path, name),
            kind,
            absent,
            about,
            choices: Vec::new(),
            problems: &[],
            only: Vec::new(),
        };
        let end = ValueKind::Word(VesselSide::WORDS);
        schema.add(key("end", end, "at which end of the vessel it is", None));
        schema.add(key(
            "name",
            ValueKind::Text(30),
            "what tables, pages and OpenFOAM's mesh call the opening",
            Some("inlet at the start, outlet at the end"),
        ));
        ConditionKeys::describe(path, schema);
    }
}

choice! {
    /// What is prescribed at an opening.
    pub enum ConditionKeys by "condition", "what is prescribed at the opening" {
        /// A flow along the vessel: into it at its start, out of it at its end. A formula as that of `[inflow]`, or a
        /// file.
        Flow = "flow" {
            base: Option<f64> = "base_m3_s", from(-1.0, 1.0), "flow outside systole, or at all times", absent "opening.flow_file";
            amplitude: Option<f64> = "amplitude_m3_s", from(-1.0, 1.0), "height of the pulse above the base", absent "0";
            systole: Option<f64> = "systole_s", above(0.0, 100.0), "duration of the pulse", absent "time.period_s";
            exponent: Option<f64> = "exponent", from(0.1, 10.0), "exponent that makes the rise faster than the fall", absent "1";
            file: Option<PathBuf> = "flow_file", ValueKind::Path, "CSV file of the flow over one period, or a .flow of SimVascular",
                absent "opening.base_m3_s";
            unit: Option<FlowUnit> = "flow_unit", ValueKind::Word(FlowUnit::WORDS), "unit of the flows in that file",
                absent "that in its header, such as flow_m3_s; of a .flow cm3/s";
            file_period: Option<f64> = "file_period_s", above(0.0, 1e3),
                "period of the curve in that file, which is stretched to time.period_s", absent "time.period_s";
            mean: Option<f64> = "mean_m3_s", from(-1.0, 1.0), "mean flow over a period, to which the curve is scaled",
                absent "the curve as it is";
            profile: Option<InletProfile> = "profile", ValueKind::Word(InletProfile::WORDS),
                "how a prescribed flow is spread over the opening", absent "plug";
        }
        /// A share of what enters through the openings at starts: out of the vessel.
        FlowSplit = "flow_split" {
            fraction: f64 = "fraction", from(0.0, 1.0), "share of the inflow that leaves here, with the same velocity all over";
        }
        /// A pressure.
        Pressure = "pressure" {
            pressure: Option<f64> = "pressure_Pa", from(-1e6, 1e6), "constant prescribed pressure; downstream of a resistance the venous one",
                absent "0 downstream of a resistance; else opening.pressure_file";
            file: Option<PathBuf> = "pressure_file", ValueKind::Path, "CSV file of the prescribed pressure over one period",
                absent "opening.pressure_Pa";
            unit: Option<PressureUnit> = "pressure_unit", ValueKind::Word(PressureUnit::WORDS), "unit of the pressures in that file",
                absent "that in its header, such as pressure_Pa";
            file_period: Option<f64> = "file_period_s", above(0.0, 1e3),
                "period of the curve in that file, which is stretched to time.period_s", absent "time.period_s";
        }
        /// A pressure that is proportional to the flow, `p = pressure_Pa + R Q`.
        Resistance = "resistance" {
            resistance: f64 = "resistance_Pa_s_m3", above(0.0, 1e15), "resistance R, of the windkessel or alone";
            pressure: Option<f64> = "pressure_Pa", from(-1e6, 1e6), "constant prescribed pressure; downstream of a resistance the venous one",
                absent "0 downstream of a resistance; else opening.pressure_file";
        }
        /// A windkessel of two elements or three, `C dp/dt + p/R = Q`.
        Windkessel = "windkessel" {
            resistance: f64 = "resistance_Pa_s_m3", above(0.0, 1e15), "resistance R, of the windkessel or alone";
            compliance: f64 = "compliance_m3_Pa", above(0.0, 1.0), "compliance C of the windkessel";
            initial_pressure: f64 = "initial_pressure_Pa", from(-1e6, 1e6), "pressure of the windkessel at t = 0";
            proximal: Option<f64> = "proximal_resistance_Pa_s_m3", from(0.0, 1e15),
                "proximal resistance, the third element of the windkessel", absent "0";
        }
    }
}

/// An opening with what is prescribed there, its files read.
#[derive(Debug, Clone, PartialEq)]
pub struct Opening {
    /// Its name.
    pub name: String,
    /// At which end of the vessel it is.
    pub end: VesselSide,
    /// What is prescribed.
    pub condition: Condition,
}

/// What is prescribed at an opening.
#[derive(Debug, Clone, PartialEq)]
pub enum Condition {
    /// A flow into the vessel, and how it is spread.
    Flow(FlowCurve, InletProfile),
    /// This share of the inflow leaves, with the same velocity all over, where the inflow is not prescribed itself.
    FlowSplit(f64),
    /// A pressure.
    Pressure(PressureModel),
}

/// A pressure `p_c + R_p Q` with the flow `Q` out of the vessel: `C dp_c/dt + p_c/R = Q`, or `p_c` is prescribed.
#[derive(Debug, Clone, PartialEq)]
pub struct PressureModel {
    /// `R_p`, Pa s/m³.
    pub proximal: f64,
    /// R (Pa s/m³) and C (m³/Pa) of a windkessel.
    pub distal: Option<(f64, f64)>,
    /// Where there is no windkessel: the pressure downstream of `R_p`.
    pub downstream: PressureCurve,
    /// Where there is one: its pressure at t = 0, before any ramp, Pa.
    pub initial: f64,
}

impl PressureModel {
    fn prescribed(downstream: PressureCurve, proximal: f64) -> Self {
        Self {
            proximal,
            distal: None,
            downstream,
            initial: 0.0,
        }
    }

    /// Pressure (Pa) downstream of `R_p` at t = 0, before any ramp.
    pub fn at_start(&self) -> f64 {
        match self.distal {
            Some(_) => self.initial,
            None => self.downstream.pressure(0.0),
        }
    }
}

impl Condition {
    /// The pressure, if it is one.
    pub fn pressure(&self) -> Option<&PressureModel> {
        match self {
            Self::Pressure(model) => Some(model),
            Self::Flow(..) | Self::FlowSplit(_) => None,
        }
    }

    /// Whether nothing changes in it by itself, asked in steps of this length (s).
    pub fn is_constant(&self, step: f64) -> bool {
        match self {
            Self::Flow(curve, _) => {
                let first = curve.flow(0.0);
                curve.samples(step).all(|[_, flow]| flow == first)
            }
            Self::FlowSplit(_) => true,
            Self::Pressure(model) => matches!(model.downstream, PressureCurve::Constant(_)),
        }
    }

    /// The flow into the vessel, if one is prescribed over time.
    pub fn flow(&self) -> Option<&FlowCurve> {
        match self {
            Self::Flow(curve, _) => Some(curve),
            Self::Pressure(_) | Self::FlowSplit(_) => None,
        }
    }
}

/// A share of what is prescribed is prescribed.
pub(super) fn prescribe_shares(openings: &mut [Opening]) {
    let inflow = (openings.iter()).find(|opening| opening.end == VesselSide::Start);
    let inflow = inflow.and_then(|inlet| inlet.condition.flow()).cloned();
    let Some(inflow) = inflow else { return };
    for opening in openings {
        if let Condition::FlowSplit(fraction) = opening.condition {
            let profile = InletProfile::default();
            opening.condition = Condition::Flow(inflow.times(-fraction), profile);
        }
    }
}

impl ConditionKeys {
    /// Whether the velocity is prescribed; else it is a pressure.
    pub fn is_flow(&self) -> bool {
        match self {
            Self::Flow { .. } | Self::FlowSplit { .. } => true,
            Self::Pressure { .. } | Self::Resistance { .. } | Self::Windkessel { .. } => false,
        }
    }

    /// The file that it names, and the key that does.
    pub fn file(&self) -> Option<(&'static str, &PathBuf)> {
        match self {
            Self::Flow { file, .. } => file.as_ref().map(|file| ("flow_file", file)),
            Self::Pressure { file, .. } => file.as_ref().map(|file| ("pressure_file", file)),
            Self::FlowSplit { .. } | Self::Resistance { .. } | Self::Windkessel { .. } => None,
        }
    }

    /// A prescribed flow as the keys of `[inflow]`, if it is one, in beats of `period` (s).
    pub fn inflow(&self, period: f64) -> Option<Inflow> {
        match self {
            Self::Flow {
                base,
                amplitude,
                systole,
                exponent,
                file,
                unit,
                file_period,
                mean,
                ..
            } => Some(Inflow {
                base: base.unwrap_or(0.0),
                amplitude: amplitude.unwrap_or(0.0),
                systole: systole.unwrap_or(period),
                exponent: exponent.unwrap_or(1.0),
                file: file.clone(),
                unit: *unit,
                file_period: *file_period,
                mean: *mean,
            }),
            _ => None,
        }
    }

    /// Pressure (Pa) without flow at t = 0, and the key that says it.
    pub(super) fn start_pressure(&self) -> Option<(f64, &'static str)> {
        match self {
            Self::Flow { .. } | Self::FlowSplit { .. } => None,
            // A curve in a file does not begin in equilibrium: that is refused.
            Self::Pressure { pressure, .. } | Self::Resistance { pressure, .. } => {
                Some((pressure.unwrap_or(0.0), "pressure_Pa"))
            }
            Self::Windkessel {
                initial_pressure, ..
            } => Some((*initial_pressure, "initial_pressure_Pa")),
        }
    }

    /// What is wrong with it at an end of the vessel in beats of `period` (s): the keys, and why.
    pub fn mistakes(&self, end: VesselSide, period: f64) -> Vec<(Vec<&'static str>, String)> {
        let file = self.file().map(|(name, _)| name);
        let mut found = Vec::new();
        let mut report = |keys: &[&'static str], is_wrong: bool, reason: &str| {
            if is_wrong {
                found.push((keys.to_vec(), reason.to_owned()));
            }
        };
        let needs_file = "this is of a file with a curve, and there is none: leave it out";
        match self {
            Self::Flow {
                base,
                amplitude,
                systole,
                unit,
                file_period,
                mean,
                ..
            } => {
                let lonely = file.is_none();
                report(&["flow_unit"], unit.is_some() && lonely, needs_file);
                report(
                    &["file_period_s"],
                    file_period.is_some() && lonely,
                    needs_file,
                );
                let reason = "needs the flow: add base_m3_s, or flow_file with a curve";
                report(&["condition"], base.is_none() && lonely, reason);
                let is_formula = base.is_some() || amplitude.is_some();
                let reason = "there is a formula as well: leave out one of the two";
                report(&["flow_file", "base_m3_s"], is_formula && !lonely, reason);
                let reason = format!("the pulse must fit into time.period_s = {period:?}");
                let is_long = systole.is_some_and(|systole| systole > period);
                report(&["systole_s"], is_long, &reason);
                let curve = self
                    .inflow(period)
                    .and_then(|inflow| FlowCurve::new(&inflow, period).ok());
                let is_lost = mean.is_some() && curve.is_some_and(|curve| !curve.has_mean());
                report(&["mean_m3_s"], is_lost, FlowCurve::NO_MEAN);
            }
            Self::FlowSplit { .. } => {
                let reason =
                    "a share of the inflow leaves at an end: it cannot be prescribed at a start";
                report(&["condition"], end == VesselSide::Start, reason);
            }
            Self::Pressure {
                pressure,
                unit,
                file_period,
                ..
            } => {
                let lonely = file.is_none();
                report(&["pressure_unit"], unit.is_some() && lonely, needs_file);
                report(
                    &["file_period_s"],
                    file_period.is_some() && lonely,
                    needs_file,
                );
                let reason =
                    "needs the pressure: either pressure_Pa, or pressure_file with a curve";
                report(&["condition"], pressure.is_some() == file.is_some(), reason);
            }
            Self::Resistance { .. } | Self::Windkessel { .. } => {}
        }
        if let Err(error) = self.read(end, period) {
            let reason = error.to_string().replace("inflow.unit", "flow_unit");
            report(&[file.unwrap_or("condition")], true, &reason);
        }
        found
    }

    /// What it prescribes at an end of the vessel in beats of `period` (s).
    ///
    /// # Errors
    /// If its file cannot be read.
    pub fn read(&self, end: VesselSide, period: f64) -> Result<Condition, TableError> {
        Ok(match self {
            Self::Flow { profile, .. } => {
                let keys = self.inflow(period).expect("it is a flow");
                let curve = FlowCurve::new(&keys, period)?;
                let curve = match end {
                    VesselSide::Start => curve,
                    VesselSide::End => curve.times(-1.0),
                };
                Condition::Flow(curve, profile.unwrap_or_default())
            }
            Self::FlowSplit { fraction } => Condition::FlowSplit(*fraction),
            Self::Pressure {
                pressure,
                file,
                unit,
                file_period,
            } => {
                let curve =
                    PressureCurve::new(file.as_ref(), *unit, *file_period, *pressure, period)?;
                Condition::Pressure(PressureModel::prescribed(curve, 0.0))
            }
            Self::Resistance {
                resistance,
                pressure,
            } => {
                let venous = PressureCurve::Constant(pressure.unwrap_or(0.0));
                Condition::Pressure(PressureModel::prescribed(venous, *resistance))
            }
            Self::Windkessel {
                resistance,
                compliance,
                initial_pressure,
                proximal,
            } => Condition::Pressure(PressureModel {
                proximal: proximal.unwrap_or(0.0),
                distal: Some((*resistance, *compliance)),
                downstream: PressureCurve::Constant(0.0),
                initial: *initial_pressure,
            }),
        })
    }
}

/// For a table of the case.
impl std::fmt::Display for ConditionKeys {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Flow { .. } => f.write_str("a prescribed flow"),
            Self::FlowSplit { fraction } => write!(f, "{} of the inflow", fraction),
            Self::Pressure { .. } => f.write_str("a prescribed pressure"),
            Self::Resistance { resistance, .. } => {
                write!(f, "resistance, {resistance:.3e} Pa s/m³")
            }
            Self::Windkessel {
                resistance,
                compliance,
                proximal,
                ..
            } => {
                f.write_str("windkessel, ")?;
                if let Some(proximal) = proximal {
                    write!(f, "proximal R {proximal:.3e} Pa s/m³, ")?;
                }
                write!(f, "R {resistance:.3e} Pa s/m³, C {compliance:.3e} m³/Pa")
            }
        }
    }
}

impl OpeningKeys {
    /// What the opening is called.
    pub fn name(&self) -> &str {
        match (&self.name, self.end) {
            (Some(name), _) => name,
            (None, VesselSide::Start) => "inlet",
            (None, VesselSide::End) => "outlet",
        }
    }
}

impl BloodVessel {
    /// The openings, those at starts first: of the list, or for an end that it leaves out of the tables.
    pub fn opening_keys(&self) -> Vec<OpeningKeys> {
        let listed = self.opening.iter().flatten();
        let mut openings: Vec<OpeningKeys> = listed.cloned().collect();
        for end in VesselSide::ALL {
            if self.listed(end).is_none() {
                openings.push(OpeningKeys {
                    end,
                    name: None,
                    condition: match end {
                        VesselSide::Start => self.inlet_keys(),
                        VesselSide::End => self.outlet_keys(),
                    },
                });
            }
        }
        openings.sort_by_key(|opening| opening.end);
        openings
    }

    /// Where the opening at an end stands in the list, if it does.
    pub fn listed(&self, end: VesselSide) -> Option<usize> {
        let mut list = self.opening.iter().flatten();
        list.position(|opening| opening.end == end)
    }

    /// What `[inflow]` and `[inlet]` prescribe.
    fn inlet_keys(&self) -> ConditionKeys {
        let (inflow, inlet) = (self.inflow.clone(), self.inlet.clone().unwrap_or_default());
        match inlet.condition.unwrap_or_default() {
            InletCondition::Flow => ConditionKeys::Flow {
                base: Some(inflow.base),
                amplitude: Some(inflow.amplitude),
                systole: Some(inflow.systole),
                exponent: Some(inflow.exponent),
                file: inflow.file,
                unit: inflow.unit,
                file_period: inflow.file_period,
                mean: inflow.mean,
                profile: inlet.profile,
            },
            InletCondition::Pressure => ConditionKeys::Pressure {
                pressure: inlet.pressure,
                file: inlet.file,
                unit: inlet.unit,
                file_period: inlet.file_period,
            },
        }
    }

    /// What `[windkessel]` and `[outlet]` prescribe.
    fn outlet_keys(&self) -> ConditionKeys {
        let outlet = self.outlet.clone().unwrap_or_default();
        match outlet.condition.unwrap_or_default() {
            OutletCondition::Windkessel => ConditionKeys::Windkessel {
                resistance: self.windkessel.resistance,
                compliance: self.windkessel.compliance,
                initial_pressure: self.windkessel.initial_pressure,
                proximal: self.windkessel.proximal,
            },
            OutletCondition::Resistance => ConditionKeys::Resistance {
                resistance: outlet.resistance.unwrap_or(0.0),
                pressure: outlet.pressure,
            },
            OutletCondition::Pressure => ConditionKeys::Pressure {
                pressure: outlet.pressure,
                file: outlet.file,
                unit: outlet.unit,
                file_period: outlet.file_period,
            },
        }
    }

    /// The openings with what is prescribed there in beats of `period` (s), those at starts first.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn openings(&self, period: f64) -> Result<Vec<Opening>, TableError> {
        let read = |keys: OpeningKeys| {
            Ok(Opening {
                name: keys.name().into(),
                end: keys.end,
                condition: keys.condition.read(keys.end, period)?,
            })
        };
        let keys = self.opening_keys().into_iter();
        let mut openings: Vec<Opening> = keys.map(read).collect::<Result<_, _>>()?;
        prescribe_shares(&mut openings);
        Ok(openings)
    }

    /// The keys of the opening at an end.
    pub fn condition_at(&self, end: VesselSide) -> ConditionKeys {
        match (self.listed(end), &self.opening, end) {
            (Some(index), Some(list), _) => list[index].condition.clone(),
            (.., VesselSide::Start) => self.inlet_keys(),
            (.., VesselSide::End) => self.outlet_keys(),
        }
    }

    /// What is prescribed at the opening at an end, in beats of `period` (s).
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn prescribed_at(&self, end: VesselSide, period: f64) -> Result<Condition, TableError> {
        let mut openings = self.openings(period)?.into_iter();
        let there = openings.find(|opening| opening.end == end);
        Ok(there
            .expect("a vessel has an opening at each end")
            .condition)
    }

    /// The key by which a case says `name` of the opening at an end: in the list, or in the tables in its place.
    pub fn opening_key(&self, end: VesselSide, name: &str) -> String {
        if let Some(index) = self.listed(end) {
            return format!("opening[{index}].{name}");
        }
        let condition = self.condition_at(end);
        let table = match (&condition, name) {
            (ConditionKeys::Flow { .. }, "profile" | "condition") => "inlet",
            (ConditionKeys::Flow { .. }, _) => "inflow",
            (ConditionKeys::Windkessel { .. }, "condition") => "outlet",
            (ConditionKeys::Windkessel { .. }, _) => "windkessel",
            _ if end == VesselSide::Start => "inlet",
            _ => "outlet",
        };
        let name = match name {
            "flow_file" | "pressure_file" => "file",
            name => name,
        };
        format!("{table}.{name}")
    }

    /// Pressure (Pa) at t = 0 without flow, and the key that says it: at the end, or where that
    /// prescribes a flow at the start.
    pub fn start_pressure(&self) -> (f64, String) {
        let sides = [VesselSide::End, VesselSide::Start];
        let found = sides.into_iter().find_map(|end| {
            let (pressure, key) = self.condition_at(end).start_pressure()?;
            Some((pressure, self.opening_key(end, key)))
        });
        found.unwrap_or((0.0, self.opening_key(VesselSide::End, "condition")))
    }

    /// Pressure (Pa) with which the wall is in static equilibrium at t = 0.
    pub fn equilibrium_pressure(&self) -> f64 {
        match self.start() {
            Start::Ramp => 0.0,
            Start::Equilibrium => self.start_pressure().0,
        }
    }
}
