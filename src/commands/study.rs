//! `fsi-driver study`: many models, each a run of its own, several at once.

use super::{CaseArguments, Failure};
use crate::case::{Unread, ValuePlace};
use crate::output::report;
use crate::output::results::Results;
use crate::output::{terminal, write_atomically};
use crate::run::Interrupt;
use crate::run::batch::{self, BatchRun, Board, Outcome, Variation, Worker};
use crate::simulation::assembly::surroundings;
use std::path::{Path, PathBuf};

/// Parameters and measures of the runs of a study, in its folder.
const MEASURES: &str = "measures.csv";

/// Options of the study.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder with the folders of the models, or that of one case.
    #[arg(long, value_name = "DIR", default_value = "openfoam-case")]
    cases: PathBuf,
    /// Names of the models, with * for anything, ? for any letter and [ab] for one of them; several with commas. One
    /// case needs none.
    #[arg(long, value_name = "PATTERN", default_value = "[SHA]-*")]
    models: String,
    /// Runs each model with each of these values, such as 'vessel.material[media].k1_Pa=500,1000' or '…=*0.8,*1.2' of
    /// what the case has; 'KEY+KEY=…' changes keys together, to one value or to 'VALUE:VALUE'. Given several times,
    /// with all combinations.
    #[arg(long = "sweep", value_name = "KEY=VALUE,VALUE…")]
    sweeps: Vec<String>,
    /// Runs each model as it is, and with each value of each --sweep alone, not in all combinations.
    #[arg(long, requires = "sweeps")]
    one_at_a_time: bool,
    /// Runs each model with each row of a table, whose first line has keys as --sweep does, and perhaps `name`.
    #[arg(long, value_name = "FILE.csv", conflicts_with = "sweeps")]
    samples: Option<PathBuf>,
    /// Models at once [default: as many as fit into the cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Folder of the results, a folder for each model [default: <cases>/study-<preset>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue an earlier study in the same folder: finished models are kept, others continue from their newest
    /// checkpoint, those whose case has changed start again next to their earlier results.
    #[arg(long)]
    resume: bool,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    case: CaseArguments,
}

/// Runs all models that are not done yet.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let out = arguments.out.clone().unwrap_or_else(|| {
        arguments
            .cases
            .join(format!("study-{}", arguments.case.preset))
    });
    let selection = arguments.case.selection()?;
    let variation = Variation {
        sweeps: &arguments.sweeps,
        one_at_a_time: arguments.one_at_a_time,
        samples: arguments.samples.as_deref(),
    };
    let variants = variation.variants(&selection)?;
    let mut models = batch::find(&arguments.cases, &arguments.models, &variants, &out)?;
    refuse_unread(&models)?;
    let ranks = models.iter().map(|m| m.case.fluid.ranks).max().unwrap_or(1);
    for model in &models {
        surroundings::check_installed(&model.case)
            .and_then(|()| surroundings::check_folder(&model.case, &model.out))
            .map_err(|e| Failure::Input(e.to_string()))?;
    }
    if arguments.resume {
        batch::refuse_farther(&models)?;
    } else {
        batch::refuse_earlier(&models)?;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = arguments.jobs.map_or(cores.div_ceil(ranks), usize::from);
    let jobs = jobs.min(models.len());
    std::fs::create_dir_all(&out)
        .map_err(|e| Failure::Input(format!("cannot create {}: {e}", out.display())))?;
    let then = "the models that have begun finish their time step and write a checkpoint";
    let interrupt = Interrupt::listen((!arguments.quiet).then_some(then))?;
    let notes = batch::prepare(&mut models)?;
    let board = Board::new(&models, jobs, arguments.quiet);
    notes.iter().for_each(|note| board.note(note));
    let threads = (cores / jobs).max(1);
    let outcomes = batch::work(&models, &interrupt, board, jobs, |model| {
        Worker::start(model, &model.selection, threads)
    });
    conclude(&models, &outcomes, &out)
}

/// Refuses a sweep over a key that does nothing in one of the models: its runs would all be the same.
fn refuse_unread(models: &[BatchRun]) -> Result<(), Failure> {
    for model in models {
        let is_swept =
            |unread: &&Unread| (unread.keys.iter()).any(|(_, place)| *place == ValuePlace::Sweep);
        if let Some(unread) = model.case.unread.iter().find(is_swept) {
            return Err(Failure::Input(format!(
                "{}: {unread}; its runs would all be the same",
                model.name
            )));
        }
    }
    Ok(())
}

/// Writes parameters and measures of the runs that are done.
fn write_measures(runs: &[Results], out: &Path) -> Result<(), Failure> {
    if runs.is_empty() {
        return Ok(());
    }
    let table = report::measures(&runs.iter().collect::<Vec<_>>());
    write_atomically(&out.join(MEASURES), table.to_csv().as_bytes())
        .map_err(|e| Failure::Run(format!("cannot write {e}")))
}

/// Names of runs whose histories are the same though their cases are not, each with the first of its kind.
fn alike(runs: &[Results]) -> Vec<(String, String)> {
    let figures = |run: &Results| -> Vec<[u64; 4]> {
        let rows = run.history.iter();
        rows.map(|row| {
            [
                row.Q_out_m3_s,
                row.p_in_Pa,
                row.p_out_Pa,
                row.max_displacement_m,
            ]
            .map(f64::to_bits)
        })
        .collect()
    };
    let all: Vec<_> = runs.iter().map(figures).collect();
    let first = |i: usize| (0..i).find(|j| all[*j] == all[i] && runs[*j].case != runs[i].case);
    let pairs = (0..runs.len()).filter_map(|i| Some((first(i)?, i)));
    pairs
        .map(|(first, i)| (runs[first].name(), runs[i].name()))
        .collect()
}

/// Says what became of the models.
fn conclude(models: &[BatchRun], outcomes: &[Outcome], out: &Path) -> Result<(), Failure> {
    let failed: Vec<String> = models
        .iter()
        .zip(outcomes)
        .filter_map(|(model, outcome)| match outcome {
            Outcome::Failed(reason) => Some(format!("{}: {reason}", model.name)),
            _ => None,
        })
        .collect();
    let done = outcomes.iter().filter(|o| **o == Outcome::Done).count();
    let runs: Vec<Results> = (models.iter().zip(outcomes))
        .filter(|(_, outcome)| **outcome == Outcome::Done)
        .filter_map(|(model, _)| Results::load(&model.out).ok())
        .collect();
    write_measures(&runs, out)?;
    for (name, other) in alike(&runs) {
        terminal::note(format_args!(
            "warning: {other} has the history of {name} to the last digit: what differs in their cases does nothing"
        ));
    }
    let (all, shown) = (models.len(), out.display());
    let again = "--resume continues them";
    if done == all {
        return Ok(terminal::print(format_args!(
            "all {all} models are done: {shown}; fsi-driver report {shown} shows them\n"
        ))?);
    }
    if failed.is_empty() {
        return Err(Failure::Interrupted(format!(
            "{done} of {all} models are done in {shown}; {again}"
        )));
    }
    Err(Failure::Run(format!(
        "{} of {all} models failed in {shown}, {done} are done; {again}\n{}",
        failed.len(),
        failed.join("\n")
    )))
}
