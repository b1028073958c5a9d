//! `fsi-driver calibrate STUDY`: the likeliest inputs with which measures are what they should be, confirmed by a run.

use super::Failure;
use super::report::study;
use crate::case::Preset;
use crate::output::report::{PageTable, Uncertainty, significant};
use crate::output::results::Results;
use crate::output::terminal;
use crate::run::batch::{self, BatchRun, Board, Outcome, Worker};
use crate::run::{CaseSelection, Interrupt};
use crate::uncertainty::{Target, calibrated};
use std::path::{Path, PathBuf};

/// Standard deviations of a target in how far it may be missed: the targets count for more than the distributions.
const DEVIATIONS: f64 = 3.0;

/// Options of the calibration.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of a study of [[uncertain]] inputs: they are what may be changed.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// What a measure should be, such as 'inlet pressure, highest=125', in the unit that moments.csv has. Give it once
    /// for each target.
    #[arg(long = "target", value_name = "MEASURE=VALUE", required = true)]
    targets: Vec<String>,
    /// How far a target may be missed, as a share of it.
    #[arg(long, value_name = "SHARE", default_value_t = 0.02)]
    within: f64,
    /// Runs that confirm, at most: each corrects the inputs by what the one before has missed.
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=9))]
    runs: u8,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
}

/// A measure and its target.
struct Wanted {
    measure: String,
    value: f64,
    /// What the run says more than the polynomial at the same inputs.
    offset: f64,
}

/// Finds the inputs, and runs the case with them.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if !(arguments.within > 0.0 && arguments.within < 1.0) {
        return Err(Failure::Input(format!(
            "--within {}: expected a share above 0 and below 1, such as 0.01",
            arguments.within
        )));
    }
    let folder = &arguments.study;
    let study = study(folder, Results::load)?;
    let runs: Vec<&Results> = study.runs.iter().collect();
    let found = Uncertainty::of(&runs, folder).map_err(|e| Failure::Input(e.to_string()))?;
    let found = found.ok_or_else(|| {
        Failure::Input(format!(
            "{} holds no samples of [[uncertain]] inputs: begin such a study with `fsi-driver study --samples`",
            folder.display()
        ))
    })?;
    let mut wanted = wanted(&arguments.targets, &found)?;
    let interrupt = Interrupt::listen((!arguments.quiet).then_some("the run writes a checkpoint"))?;
    let mut still_missed = Vec::new();
    for _ in 0..arguments.runs {
        let targets: Vec<Target> = (wanted.iter())
            .map(|wanted| Target {
                chaos: found.chaos(&wanted.measure).expect("it was found before"),
                value: wanted.value - wanted.offset,
                tolerance: (arguments.within * wanted.value).abs() / DEVIATIONS,
            })
            .collect();
        let point = calibrated(found.inputs(), &targets);
        let expected: Vec<f64> = (targets.iter().zip(&wanted))
            .map(|(target, w)| target.chaos.value(&found.inputs().germs_at(&point)) + w.offset)
            .collect();
        terminal::print(format_args!("{}", inputs_in_words(&found, &point)))?;
        let run = confirm(&found, &point, folder, &interrupt, arguments.quiet)?;
        let reached = (wanted.iter())
            .map(|wanted| found.value(&run, &wanted.measure).unwrap_or(f64::NAN))
            .collect::<Vec<f64>>();
        terminal::print(format_args!(
            "{}",
            targets_in_words(&wanted, &expected, &reached)
        ))?;
        let is_missed = |(wanted, reached): &(&Wanted, &f64)| {
            let miss = (*reached - wanted.value).abs();
            miss.is_nan() || miss > (arguments.within * wanted.value).abs()
        };
        let missed = wanted.iter().zip(&reached).filter(is_missed);
        still_missed = missed.map(|(wanted, _)| wanted.measure.clone()).collect();
        if still_missed.is_empty() {
            return Ok(terminal::print(format_args!(
                "all targets are met within {} %: {} is the case\n",
                significant(100.0 * arguments.within, 2),
                run.files.resolved_case().display()
            ))?);
        }
        for ((wanted, reached), expected) in wanted.iter_mut().zip(&reached).zip(&expected) {
            wanted.offset += reached - expected;
        }
    }
    Err(not_met(&still_missed, &found, arguments))
}

/// That these measures do not have their targets, and what helps.
fn not_met(missed: &[String], found: &Uncertainty, arguments: &Arguments) -> Failure {
    let doubts = missed.iter().filter_map(|measure| {
        let error = found.chaos(measure)?.error_deviation();
        Some(format!(
            "{measure} (its polynomial is off by {} as a rule)",
            significant(error, 2)
        ))
    });
    Failure::Run(format!(
        "missed by more than {} % after {} runs: {}; where the polynomial is off by as much, add samples (study --extend) \
         or widen --within; otherwise the inputs would have to leave what [[uncertain]] says of them, or the targets \
         exclude each other",
        significant(100.0 * arguments.within, 2),
        arguments.runs,
        doubts.collect::<Vec<_>>().join(", ")
    ))
}

/// The targets by the names of the measures, of which the unit may be left out.
fn wanted(targets: &[String], found: &Uncertainty) -> Result<Vec<Wanted>, Failure> {
    let wanted = |text: &String| {
        let wrong = |what: String| Failure::Input(format!("--target '{text}': {what}"));
        let (name, value) = text.rsplit_once('=').ok_or_else(|| {
            wrong("expected MEASURE=VALUE, such as 'inlet pressure, highest=125'".to_owned())
        })?;
        let value: f64 = (value.trim().parse().ok())
            .filter(|value: &f64| value.is_finite() && *value != 0.0)
            .ok_or_else(|| wrong("expected a number that is not 0 after =".to_owned()))?;
        let measure = found.measure_called(name.trim()).map_err(wrong)?;
        Ok(Wanted {
            measure: measure.to_owned(),
            value,
            offset: 0.0,
        })
    };
    targets.iter().map(wanted).collect()
}

/// Runs the case at a point of the unit cube, next to the samples.
fn confirm(
    found: &Uncertainty,
    point: &[f64],
    folder: &Path,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<Results, Failure> {
    let name = (1..)
        .map(|n| format!("calibrated-{n}"))
        .find(|name| !folder.join(name).exists())
        .expect("there are endless numbers");
    let (case, given) = found.case_at(point);
    let selection = CaseSelection::new(Preset::Paper, given);
    let models = [BatchRun::of(
        name.clone(),
        case,
        folder.join(&name),
        &selection,
    )?];
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let board = Board::new(&models, 1, quiet);
    let outcomes = batch::work(&models, interrupt, board, 1, |model| {
        Worker::start(model, &model.selection, cores)
    });
    match &outcomes[0] {
        Outcome::Done => Results::load(&models[0].out).map_err(|e| Failure::Run(e.to_string())),
        Outcome::Failed(reason) => Err(Failure::Run(format!("{name}: {reason}"))),
        _ => Err(Failure::Interrupted(format!(
            "{name} is not done; remove it and calibrate again"
        ))),
    }
}

fn inputs_in_words(found: &Uncertainty, point: &[f64]) -> String {
    let mut table = PageTable::new(["input", "median", "calibrated", "percentile"]);
    let values = found.inputs().values_at(point);
    for (i, name) in found.names().into_iter().enumerate() {
        let marginal = found.inputs().marginal(i);
        let percentile = 100.0 * marginal.share_below(values[i]);
        let figures = [marginal.quantile(0.5), values[i]].map(|x| significant(x, 5));
        let [median, value] = figures;
        table.push(vec![name, median, value, significant(percentile, 2)]);
    }
    table.to_markdown()
}

fn targets_in_words(wanted: &[Wanted], expected: &[f64], reached: &[f64]) -> String {
    let mut table = PageTable::new(["measure", "target", "by the polynomial", "by the run"]);
    for ((wanted, expected), reached) in wanted.iter().zip(expected).zip(reached) {
        let figures = [wanted.value, *expected, *reached].map(|x| significant(x, 5));
        let name = std::iter::once(wanted.measure.clone());
        table.push(name.chain(figures).collect());
    }
    table.to_markdown()
}
