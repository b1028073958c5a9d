//! `fsi-driver study`: many models, each a run of its own, several at once.

use super::{CaseArguments, Failure};
use crate::case::{Override, Place};
use crate::output::terminal;
use crate::run::batch::{self, BatchRun, Board, Outcome, Worker};
use crate::run::{CaseSelection, Interrupt};
use crate::simulation::assembly::surroundings;
use std::path::PathBuf;

/// Options of the study.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder with the folders of the models, or that of one case.
    #[arg(long, value_name = "DIR", default_value = "openfoam-case")]
    cases: PathBuf,
    /// Names of the models, with * for anything, ? for any letter and [ab] for one of them; several with commas. One case
    /// needs none.
    #[arg(long, value_name = "PATTERN", default_value = "[SHA]-*")]
    models: String,
    /// Runs each model with each of these values, such as 'vessel.material[0].k1_Pa=500,1000,2000'; given several times, with
    /// all combinations.
    #[arg(long = "sweep", value_name = "KEY=VALUE,VALUE…")]
    sweeps: Vec<String>,
    /// Models at once [default: as many as fit into the cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Folder of the results, a folder for each model [default: <cases>/study-<preset>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Go on with an earlier study in the same folder: finished models are kept, others continue from their newest
    /// checkpoint, those whose case has changed begin anew beside their earlier results.
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
    let variants = variants(selection, &arguments.sweeps)?;
    let mut models = batch::find(&arguments.cases, &arguments.models, &variants, &out)?;
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

/// Selections of a case with what each adds to the name of its model.
fn variants(
    selection: CaseSelection,
    sweeps: &[String],
) -> Result<Vec<(String, CaseSelection)>, Failure> {
    let mut all = vec![(String::new(), selection)];
    for sweep in sweeps {
        let wrong = |why: &str| Failure::Input(format!("--sweep {sweep}: {why}"));
        let (key, values) = (sweep.split_once('='))
            .ok_or_else(|| wrong("expected KEY=VALUE,VALUE…, such as wall.media.k1_Pa=500,1000"))?;
        let values: Vec<&str> = values.split(',').map(str::trim).collect();
        if values.iter().any(|value| value.is_empty()) {
            return Err(wrong("a value is missing between the commas"));
        }
        if let Some(twice) = (1..values.len()).find(|i| values[..*i].contains(&values[*i])) {
            return Err(wrong(&format!(
                "the value {} stands there twice",
                values[twice]
            )));
        }
        let key = key.trim();
        let name = key.rsplit('.').next().unwrap_or(key);
        let with = |(before, selection): &(String, CaseSelection), value: &str| {
            let mut selection = selection.clone();
            selection.given.push(Override {
                place: Place::Set,
                key: key.to_owned(),
                value: value.to_owned(),
            });
            (format!("{before}-{name}={value}"), selection)
        };
        all = (all.iter())
            .flat_map(|model| {
                values
                    .iter()
                    .map(|value| with(model, value))
                    .collect::<Vec<_>>()
            })
            .collect();
    }
    Ok(all)
}

/// Says what became of the models.
fn conclude(
    models: &[BatchRun],
    outcomes: &[Outcome],
    out: &std::path::Path,
) -> Result<(), Failure> {
    let failed: Vec<String> = models
        .iter()
        .zip(outcomes)
        .filter_map(|(model, outcome)| match outcome {
            Outcome::Failed(reason) => Some(format!("{}: {reason}", model.name)),
            _ => None,
        })
        .collect();
    let done = outcomes.iter().filter(|o| **o == Outcome::Done).count();
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
