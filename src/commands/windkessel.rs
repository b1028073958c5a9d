//! `fsi-driver windkessel`: resistance and compliance that make given pressures of a flow.

use super::wall::with_wall;
use super::{CaseArguments, Failure};
use crate::analysis::three_elements::ThreeElements;
use crate::analysis::wall;
use crate::analysis::windkessel::TwoElements;
use crate::case::{FlowCurve, FlowUnit, Inflow, VesselSide};
use crate::geometry::Vessel;
use crate::output::progress::tell_statics;
use crate::output::report::quantities::MMHG;
use crate::output::terminal;
use std::path::PathBuf;

/// Pressures that may be asked for, mmHg.
const ALLOWED: std::ops::RangeInclusive<f64> = 1.0..=500.0;

/// Options of the proposal.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// File of the flow over one period, as inflow.file [default: the inflow of the case].
    #[arg(long, value_name = "FILE", required_unless_present = "case")]
    flow: Option<PathBuf>,
    /// Unit of the flows in that file [default: that in its header; of a .flow of SimVascular cm3/s].
    #[arg(long, value_name = "UNIT", requires = "flow", value_parser = unit)]
    unit: Option<FlowUnit>,
    /// Duration of a period of that file, s [default: time.period_s of the case, or 1].
    #[arg(long, value_name = "S", requires = "flow")]
    period: Option<f64>,
    /// Highest pressure, mmHg.
    #[arg(long, value_name = "MMHG", default_value_t = 120.0)]
    systolic: f64,
    /// Lowest pressure, mmHg.
    #[arg(long, value_name = "MMHG", default_value_t = 80.0)]
    diastolic: f64,
    /// Elements of the windkessel: 3 adds a proximal resistance, so that waves are not reflected.
    #[arg(long, value_name = "2|3", default_value_t = 2, value_parser = clap::value_parser!(u8).range(2..=3))]
    elements: u8,
    /// Proximal resistance of a windkessel of three elements, Pa s/m³ [default: the characteristic impedance of the
    /// case's vessel].
    #[arg(long, value_name = "PA_S_M3")]
    proximal: Option<f64>,
    /// Folder of a case, whose wall takes a share of the compliance: its statics, up to a minute.
    #[arg(long, value_name = "DIR")]
    case: Option<PathBuf>,
    #[command(flatten)]
    chosen: CaseArguments,
}

pub(super) fn unit(word: &str) -> Result<FlowUnit, String> {
    FlowUnit::spelled(word).ok_or_else(|| {
        let words: Vec<&str> = FlowUnit::ALL.iter().map(|unit| unit.name()).collect();
        format!("expected one of {}", words.join(", "))
    })
}

/// Prints the keys to put into `case.toml`, and the pressures to expect.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    tell_statics();
    let wrong = |why: String| Failure::Input(why);
    for (name, value) in [
        ("--systolic", arguments.systolic),
        ("--diastolic", arguments.diastolic),
    ] {
        if !ALLOWED.contains(&value) {
            return Err(wrong(format!(
                "{name} {value}: expected a pressure from 1 to 500 mmHg"
            )));
        }
    }
    if arguments.diastolic >= arguments.systolic {
        return Err(wrong(format!(
            "--diastolic {} must be below --systolic {}",
            arguments.diastolic, arguments.systolic
        )));
    }
    let [lowest, highest] = [arguments.diastolic, arguments.systolic].map(|p| p * MMHG);
    let case = (arguments.case.as_deref())
        .map(|folder| arguments.chosen.load(folder))
        .transpose()?;
    let vessel = (case.as_ref())
        .map(|case| {
            case.vessel().ok_or_else(|| {
                wrong("--case: the case has a flag in a channel and no vessel; leave it out".into())
            })
        })
        .transpose()?;
    let period = (arguments.period)
        .or(case.as_ref().map(|case| case.time.period))
        .unwrap_or(1.0);
    if !(1e-3..=1e3).contains(&period) {
        return Err(wrong(format!(
            "--period {period}: expected a duration from 0.001 to 1000 s"
        )));
    }
    let inflow = match (&arguments.flow, vessel) {
        (None, Some(vessel)) => (vessel.condition_at(VesselSide::Start).inflow(period))
            .unwrap_or_else(|| vessel.inflow.clone()),
        (file, _) => Inflow {
            base: 0.0,
            amplitude: 0.0,
            systole: period,
            exponent: 1.0,
            file: file.clone(),
            unit: arguments.unit,
            file_period: None,
        },
    };
    let curve = FlowCurve::new(&inflow, period).map_err(|e| {
        let reason = e.to_string().replace("inflow.unit", "--unit");
        wrong(match &arguments.flow {
            Some(_) => reason.replace(
                "give its own period as `file_period_s` next to the file, and it is stretched",
                "--period S says how long it is",
            ),
            None => reason,
        })
    })?;
    let is_allowed = arguments.proximal.is_none_or(|r| r > 0.0 && r < 1e15);
    if !is_allowed {
        return Err(wrong(
            "--proximal: expected a resistance above 0 Pa s/m³".into(),
        ));
    }
    if arguments.proximal.is_some() && arguments.elements == 2 {
        return Err(wrong(
            "--proximal is the third element: add --elements 3".into(),
        ));
    }
    let is_elastic = vessel.is_some_and(|vessel| !vessel.is_rigid());
    if arguments.elements == 3 && arguments.proximal.is_none() && !is_elastic {
        return Err(wrong(
            "--elements 3 needs the proximal resistance, --proximal PA_S_M3 (a tenth of the whole is usual), or --case with an elastic wall, whose characteristic impedance is taken"
                .into(),
        ));
    }
    let propose =
        |own| TwoElements::between(lowest, highest, &curve, own).map_err(|e| wrong(e.to_string()));
    // What cannot be had without the wall needs no statics.
    propose(0.0)?;
    let storage = match (&case, vessel) {
        (Some(case), Some(vessel)) if !vessel.is_rigid() => Some(
            with_wall(case, vessel, |wall| wall::compliance(wall, lowest, highest))
                .map_err(|e| Failure::Run(e.to_string()))?
                .ok_or_else(|| {
                    Failure::Run(format!(
                        "the wall of the case buckles below {} mmHg, so that it has no compliance: see `fsi-driver check --wall`",
                        arguments.systolic
                    ))
                })?,
        ),
        _ => None,
    };
    let own = storage.map_or(0.0, |storage| storage.compliance);
    let (keys, expected, tau, all) = if arguments.elements == 2 {
        let found = propose(own)?;
        let all = TwoElements {
            compliance: found.compliance + own,
            ..found
        };
        let keys = (found.resistance, found.compliance, None);
        (
            keys,
            all.pressures(&curve),
            all.resistance * all.compliance,
            all.compliance,
        )
    } else {
        let density = case.as_ref().map_or(0.0, |case| case.blood.density);
        let impedance = vessel.zip(storage).map(|(vessel, storage)| {
            // Bramwell and Hill's speed of waves (1922), times density by area
            let speed = (storage.volume / (density * storage.compliance)).sqrt();
            density * speed * Vessel::new(vessel).end() / storage.volume
        });
        let proximal = arguments.proximal.or(impedance).unwrap_or_default();
        let found = ThreeElements::between(lowest, highest, &curve, proximal, own)
            .map_err(|e| wrong(e.to_string()))?;
        let keys = (found.resistance, found.compliance, Some(proximal));
        (
            keys,
            found.pressures(&curve),
            found.resistance * found.compliance,
            found.compliance + own,
        )
    };
    let (resistance, compliance, proximal) = keys;
    let whole = resistance + proximal.unwrap_or(0.0);
    let vessel = match own {
        0.0 => "a vessel's own compliance was left out (--case takes that of a case)".to_owned(),
        own => format!(
            "the vessel itself has {own:.3e} m³/Pa, {:.0} % of all",
            100.0 * own / all
        ),
    };
    let third = proximal.map_or(String::new(), |proximal| {
        format!("proximal_resistance_Pa_s_m3 = {proximal:.4e}\n")
    });
    // Without the drop over the proximal resistance
    let initial = expected.mean * resistance / whole;
    if let Some(table) = curve.table() {
        terminal::print(format_args!("# flow: {}\n", table.understood()))?;
    }
    Ok(terminal::print(format_args!(
        "[windkessel]\n\
         resistance_Pa_s_m3 = {resistance:.4e}\n\
         compliance_m3_Pa = {compliance:.4e}\n\
         {third}\
         initial_pressure_Pa = {initial:.4e}\n\n\
         pressures from {:.1} to {:.1} mmHg, {:.1} on average, in the periodic state;\n\
         time constant R C {tau:.3} s; mean flow {:.1} ml/min; {vessel}\n",
        expected.lowest / MMHG,
        expected.highest / MMHG,
        expected.mean / MMHG,
        6e7 * expected.mean / whole,
    ))?)
}
