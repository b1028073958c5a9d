//! `fsi-driver windkessel`: resistance and compliance that make given pressures of a flow.

use super::wall::with_wall;
use super::{CaseArguments, Failure};
use crate::analysis::wall;
use crate::analysis::windkessel::TwoElements;
use crate::case::{FlowCurve, Inflow};
use crate::output::report::quantities::MMHG;
use crate::output::terminal;
use std::path::PathBuf;

/// Pressures that may be asked for, mmHg.
const ALLOWED: std::ops::RangeInclusive<f64> = 1.0..=500.0;

/// Options of the proposal.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// CSV file of the flow over one period, with the columns time_s,flow_m3_s [default: the inflow of the case].
    #[arg(long, value_name = "FILE", required_unless_present = "case")]
    flow: Option<PathBuf>,
    /// Duration of a period of that file, s [default: time.period_s of the case, or 1].
    #[arg(long, value_name = "S", requires = "flow")]
    period: Option<f64>,
    /// Highest pressure, mmHg.
    #[arg(long, value_name = "MMHG", default_value_t = 120.0)]
    systolic: f64,
    /// Lowest pressure, mmHg.
    #[arg(long, value_name = "MMHG", default_value_t = 80.0)]
    diastolic: f64,
    /// Folder of a case, whose wall takes a share of the compliance: its statics, up to a minute.
    #[arg(long, value_name = "DIR")]
    case: Option<PathBuf>,
    #[command(flatten)]
    chosen: CaseArguments,
}

/// Prints the keys to put into `case.toml`, and the pressures to expect.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
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
        (None, Some(vessel)) => vessel.inflow.clone(),
        (file, _) => Inflow {
            base: 0.0,
            amplitude: 0.0,
            systole: period,
            exponent: 1.0,
            file: file.clone(),
        },
    };
    let curve = FlowCurve::new(&inflow, period).map_err(|e| wrong(e.to_string()))?;
    let propose =
        |own| TwoElements::between(lowest, highest, &curve, own).map_err(|e| wrong(e.to_string()));
    // What cannot be had without the wall needs no statics.
    propose(0.0)?;
    let own = match (&case, vessel) {
        (Some(case), Some(vessel)) => with_wall(case, vessel, |wall| wall::compliance(wall, lowest, highest))
            .map_err(|e| Failure::Run(e.to_string()))?
            .ok_or_else(|| {
                Failure::Run(format!(
                    "the wall of the case buckles below {} mmHg, so that it has no compliance: see `fsi-driver check --wall`",
                    arguments.systolic
                ))
            })?,
        _ => 0.0,
    };
    let found = propose(own)?;
    let all = TwoElements {
        compliance: found.compliance + own,
        ..found
    };
    let expected = all.pressures(&curve);
    let vessel = match own {
        0.0 => "a vessel's own compliance was left out (--case takes that of a case)".to_owned(),
        own => format!(
            "the vessel itself has {own:.3e} m³/Pa, {:.0} % of all",
            100.0 * own / all.compliance
        ),
    };
    Ok(terminal::print(format_args!(
        "[windkessel]\n\
         resistance_Pa_s_m3 = {:.4e}\n\
         compliance_m3_Pa = {:.4e}\n\
         initial_pressure_Pa = {:.4e}\n\n\
         pressures from {:.1} to {:.1} mmHg, {:.1} on average, in the periodic state;\n\
         time constant R C {:.3} s; mean flow {:.1} ml/min; {vessel}\n",
        found.resistance,
        found.compliance,
        expected.mean,
        expected.lowest / MMHG,
        expected.highest / MMHG,
        expected.mean / MMHG,
        all.resistance * all.compliance,
        6e7 * expected.mean / all.resistance,
    ))?)
}
