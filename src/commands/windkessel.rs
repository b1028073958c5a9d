//! `fsi-driver windkessel`: resistance and compliance that make given pressures of a flow.

use super::wall::with_wall;
use super::{CaseArguments, Failure};
use crate::analysis::three_elements::ThreeElements;
use crate::analysis::wall::{self, Storage};
use crate::analysis::windkessel::{Pressures, TwoElements};
use crate::case::{
    BloodVessel, Case, Condition, FlowCurve, FlowUnit, Inflow, TreeKeys, VesselSide,
};
use crate::geometry::Vessel;
use crate::geometry::tree::Tree;
use crate::output::progress::tell_preparation;
use crate::output::terminal;
use crate::proposal::{end_radii, tree_shares};
use crate::tabular::units::MMHG;
use std::f64::consts::PI;
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
    /// Shares of the flow that leave by the ends of a tree, in their order, such as 0.65,0.35 or 65,35 [default: by
    /// --murray].
    #[arg(
        long,
        value_name = "SHARE,...",
        requires = "case",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    split: Vec<f64>,
    /// Flow goes with this power of the radius at the end of a branch [default: 3].
    #[arg(
        long,
        value_name = "EXPONENT",
        requires = "case",
        allow_hyphen_values = true
    )]
    murray: Option<f64>,
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

/// A windkessel, and what it makes of the flow.
struct Proposal {
    resistance: f64,
    compliance: f64,
    proximal: Option<f64>,
    expected: Pressures,
    /// Compliance of the whole, that of the vessel included, m³/Pa.
    all: f64,
    /// Time constant, s.
    tau: f64,
}

/// Prints the keys to put into `case.toml`, and the pressures to expect.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    tell_preparation();
    let range = arguments.pressures()?;
    let case = (arguments.case.as_deref())
        .map(|folder| arguments.chosen.load(folder))
        .transpose()?;
    if let Some((case, tree)) = case.as_ref().and_then(|case| Some((case, case.tree()?))) {
        return arguments.of_tree(case, tree, range);
    }
    if !arguments.split.is_empty() || arguments.murray.is_some() {
        return Err(wrong(
            "--split and --murray are for vessels that branch, and this one has one outlet: leave them out",
        ));
    }
    let vessel = (case.as_ref())
        .map(|case| {
            case.vessel().ok_or_else(|| {
                wrong("--case: the case has no vessel of the driver's making; leave it out")
            })
        })
        .transpose()?;
    let curve = arguments.curve(case.as_deref(), vessel)?;
    let elastic = (case.as_deref().zip(vessel)).filter(|(_, vessel)| !vessel.is_rigid());
    arguments.check_third_element(elastic.is_some())?;
    // What cannot be had without the wall needs no statics.
    TwoElements::between(range[0], range[1], &curve, 0.0).map_err(wrong)?;
    let storage = elastic
        .map(|(case, _)| arguments.storage(case, range))
        .transpose()?;
    let impedance = elastic.zip(storage.as_ref()).map(|((case, vessel), wall)| {
        // Bramwell and Hill's speed of waves (1922), times density by area
        let density = case.blood.density;
        let speed = (wall.volume / (density * wall.compliance)).sqrt();
        density * speed * Vessel::new(vessel).end() / wall.volume
    });
    let own = storage.map_or(0.0, |storage| storage.compliance);
    let proposal = arguments.proposal(range, &curve, own, impedance)?;
    Ok(terminal::print(format_args!(
        "{}[windkessel]\n{}\n{}",
        understood(&curve),
        proposal.keys(1.0, None),
        proposal.expectation(own)
    ))?)
}

fn wrong(why: impl ToString) -> Failure {
    Failure::Input(why.to_string())
}

impl Arguments {
    /// Lowest and highest pressure, Pa.
    fn pressures(&self) -> Result<[f64; 2], Failure> {
        let (low, high) = (self.diastolic, self.systolic);
        for (name, value) in [("--systolic", high), ("--diastolic", low)] {
            if !ALLOWED.contains(&value) {
                let expected = "expected a pressure from 1 to 500 mmHg";
                return Err(wrong(format!("{name} {value}: {expected}")));
            }
        }
        if low >= high {
            let order = format!("--diastolic {low} must be below --systolic {high}");
            return Err(wrong(order));
        }
        Ok([low, high].map(|p| p * MMHG))
    }

    /// The flow over a period: of the file, or of the case.
    fn curve(
        &self,
        case: Option<&Case>,
        vessel: Option<&BloodVessel>,
    ) -> Result<FlowCurve, Failure> {
        let period = (self.period)
            .or(case.map(|case| case.time.period))
            .unwrap_or(1.0);
        if !(1e-3..=1e3).contains(&period) {
            let expected = "expected a duration from 0.001 to 1000 s";
            return Err(wrong(format!("--period {period}: {expected}")));
        }
        let inflow = match (&self.flow, vessel) {
            (None, Some(vessel)) => (vessel.condition_at(VesselSide::Start).inflow(period))
                .unwrap_or_else(|| vessel.inflow.clone()),
            (file, _) => Inflow {
                file: file.clone(),
                unit: self.unit,
                ..Inflow::pulse(0.0, 0.0, period, 1.0)
            },
        };
        // What the case calls by its keys, the command line has as options.
        FlowCurve::new(&inflow, period).map_err(|e| {
            let reason = e.to_string().replace("inflow.unit", "--unit");
            wrong(match &self.flow {
                Some(_) => reason.replace(
                    "give its own period as `file_period_s` next to the file, and it is stretched",
                    "--period S says how long it is",
                ),
                None => reason,
            })
        })
    }

    fn check_third_element(&self, is_elastic: bool) -> Result<(), Failure> {
        match (self.elements, self.proximal) {
            (_, Some(r)) if !(r > 0.0 && r < 1e15) => {
                Err(wrong("--proximal: expected a resistance above 0 Pa s/m³"))
            }
            (2, Some(_)) => Err(wrong("--proximal is the third element: add --elements 3")),
            (3, None) if !is_elastic => Err(wrong(
                "--elements 3 needs the proximal resistance, --proximal PA_S_M3 (a tenth of the whole is usual), or --case with an elastic wall, whose characteristic impedance is taken",
            )),
            _ => Ok(()),
        }
    }

    /// What the wall of a case stores between the pressures (Pa).
    fn storage(&self, case: &Case, [lowest, highest]: [f64; 2]) -> Result<Storage, Failure> {
        with_wall(case, |wall| wall::compliance(wall, lowest, highest))
            .map_err(|e| Failure::Run(e.to_string()))?
            .ok_or_else(|| {
                Failure::Run(format!(
                    "the wall of the case buckles below {} mmHg, so that it has no compliance: see `fsi-driver check --wall`",
                    self.systolic
                ))
            })
    }

    /// The windkessels of a tree: all together make the pressures of the inflow, each has its share of it.
    fn of_tree(&self, case: &Case, tree: &TreeKeys, range: [f64; 2]) -> Result<(), Failure> {
        let shares = tree_shares(tree, &self.split, self.murray).map_err(wrong)?;
        let curve = self.tree_curve(case, tree)?;
        let is_elastic = case.has_elastic_wall();
        self.check_third_element(is_elastic)?;
        TwoElements::between(range[0], range[1], &curve, 0.0).map_err(wrong)?;
        let storage = is_elastic.then(|| self.storage(case, range)).transpose()?;
        let own = storage.as_ref().map_or(0.0, |storage| storage.compliance);
        // Of the branches that end at the openings, side by side, with Bramwell and Hill's speed of waves in the whole.
        let impedance = match storage {
            Some(_) if self.elements == 3 && self.proximal.is_none() => {
                let volume = Tree::meshes(tree).map_err(wrong)?.outside.volume();
                let density = case.blood.density;
                let speed = (volume / (density * own)).sqrt();
                let areas = end_radii(tree).into_iter().map(|r| PI * r * r);
                Some(density * speed / areas.sum::<f64>())
            }
            _ => None,
        };
        let whole = self.proposal(range, &curve, own, impedance)?;
        let start = case.initial_wall().map(|initial| initial.pressure);
        let names = tree.open_names();
        terminal::print(understood(&curve))?;
        for (name, share) in names[1..].iter().zip(&shares) {
            let name = toml::Value::from(name.as_str());
            terminal::print(format_args!(
                "[[tree.opening]] # {:.1} % of the flow\nname = {name}\ncondition = \"windkessel\"\n{}\n",
                100.0 * share,
                whole.keys(*share, start)
            ))?;
        }
        Ok(terminal::print(whole.expectation(own))?)
    }

    /// The flow into a tree over a period: of the file, or of the case.
    fn tree_curve(&self, case: &Case, tree: &TreeKeys) -> Result<FlowCurve, Failure> {
        if self.flow.is_some() {
            return self.curve(Some(case), None);
        }
        let openings = tree.openings(case.time.period).map_err(wrong)?;
        let inlet = openings
            .into_iter()
            .find(|opening| opening.end == VesselSide::Start);
        match inlet.map(|inlet| inlet.condition) {
            Some(Condition::Flow(curve, _)) => Ok(curve),
            _ => Err(wrong(format!(
                "what is prescribed at \"{}\" is no flow: say what flows in, --flow FILE",
                tree.names()[0]
            ))),
        }
    }

    /// The windkessel downstream of a vessel of the compliance `own` (m³/Pa) and this impedance (Pa s/m³).
    fn proposal(
        &self,
        [lowest, highest]: [f64; 2],
        curve: &FlowCurve,
        own: f64,
        impedance: Option<f64>,
    ) -> Result<Proposal, Failure> {
        if self.elements == 2 {
            let found = TwoElements::between(lowest, highest, curve, own).map_err(wrong)?;
            let all = TwoElements {
                compliance: found.compliance + own,
                ..found
            };
            return Ok(Proposal {
                resistance: found.resistance,
                compliance: found.compliance,
                proximal: None,
                expected: all.pressures(curve),
                all: all.compliance,
                tau: all.resistance * all.compliance,
            });
        }
        let proximal = self.proximal.or(impedance).unwrap_or_default();
        let found = ThreeElements::between(lowest, highest, curve, proximal, own).map_err(wrong)?;
        Ok(Proposal {
            resistance: found.resistance,
            compliance: found.compliance,
            proximal: Some(proximal),
            expected: found.pressures(curve),
            all: found.compliance + own,
            tau: found.resistance * found.compliance,
        })
    }
}

/// What was understood of the file of the flow.
fn understood(curve: &FlowCurve) -> String {
    let table = curve.table();
    table.map_or(String::new(), |table| {
        format!("# flow: {}\n", table.understood())
    })
}

impl Proposal {
    /// Keys of the windkessel that takes a share of the flow, and begins with a pressure (Pa), or else with its mean.
    fn keys(&self, share: f64, start: Option<f64>) -> String {
        let proximal = self.proximal.map_or(String::new(), |proximal| {
            let proximal = proximal / share;
            format!("proximal_resistance_Pa_s_m3 = {proximal:.4e}\n")
        });
        // Without the drop over the proximal resistance
        let mean = self.expected.mean * self.resistance / self.whole();
        format!(
            "resistance_Pa_s_m3 = {:.4e}\ncompliance_m3_Pa = {:.4e}\n{proximal}initial_pressure_Pa = {}\n",
            self.resistance / share,
            self.compliance * share,
            start.map_or(format!("{mean:.4e}"), |start| format!("{start:?}"))
        )
    }

    fn whole(&self) -> f64 {
        self.resistance + self.proximal.unwrap_or(0.0)
    }

    /// What it makes of the flow into a vessel of the compliance `own` (m³/Pa).
    fn expectation(&self, own: f64) -> String {
        let Self {
            expected, all, tau, ..
        } = self;
        let vessel = match own {
            0.0 => {
                "a vessel's own compliance was left out (--case takes that of a case)".to_owned()
            }
            own => format!(
                "the vessel itself has {own:.3e} m³/Pa, {:.0} % of all",
                100.0 * own / all
            ),
        };
        format!(
            "pressures from {:.1} to {:.1} mmHg, {:.1} on average, in the periodic state;\n\
             time constant R C {tau:.3} s; mean flow {:.1} ml/min; {vessel}\n",
            expected.lowest / MMHG,
            expected.highest / MMHG,
            expected.mean / MMHG,
            6e7 * expected.mean / self.whole(),
        )
    }
}
