//! `fsi-driver study`: many models, each a run of its own, several at once.

mod board;
mod models;
mod worker;

use super::Failure;
use super::case_arguments::CaseArguments;
use super::run::Interrupt;
use crate::case::Solver;
use crate::fluid::openfoam::install;
use crate::output::terminal;
use board::Board;
use models::Model;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Duration;
use worker::{Outcome, Worker};

/// Time between two looks at the models.
const LOOK: Duration = Duration::from_millis(500);

/// Options of the study.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder with the folders of the models.
    #[arg(long, value_name = "DIR", default_value = "openfoam-case")]
    cases: PathBuf,
    /// Names of the models, with * for anything, ? for any letter and [ab] for one of them; several with commas.
    #[arg(long, value_name = "PATTERN", default_value = "[SHA]-*")]
    models: String,
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
    let mut models = models::find(&arguments.cases, &arguments.models, &arguments.case, &out)?;
    let ranks = models.iter().map(|m| m.case.fluid.ranks).max().unwrap_or(1);
    let with_openfoam = |m: &Model| m.case.fluid.solver == Solver::OpenFoam;
    if models.iter().any(with_openfoam) {
        install::check(ranks).map_err(|e| Failure::Input(e.to_string()))?;
    }
    install::check_path(&out).map_err(|e| Failure::Input(e.to_string()))?;
    if !arguments.resume {
        models::refuse_earlier(&models)?;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = arguments.jobs.map_or(cores.div_ceil(ranks), usize::from);
    let jobs = jobs.min(models.len());
    std::fs::create_dir_all(&out)
        .map_err(|e| Failure::Input(format!("cannot create {}: {e}", out.display())))?;
    let then = "the models finish their time step and write a checkpoint";
    let interrupt = Interrupt::listen((!arguments.quiet).then_some(then))?;
    let notes = models::prepare(&mut models)?;
    let board = Board::new(&models, jobs, arguments.quiet);
    notes.iter().for_each(|note| board.note(note));
    let threads = (cores / jobs).max(1);
    let outcomes = work(&models, &interrupt, board, jobs, |model| {
        Worker::start(model, &arguments.case, threads)
    });
    conclude(&models, &outcomes, &out)
}

/// Keeps `jobs` models at work until all are done, or until somebody asks to end; returns what became of each.
fn work(
    models: &[Model],
    interrupt: &Interrupt,
    mut board: Board,
    jobs: usize,
    start: impl Fn(&Model) -> Result<Worker, String>,
) -> Vec<Outcome> {
    let mut outcomes: Vec<Outcome> = models.iter().map(Model::outcome).collect();
    let mut waiting: VecDeque<usize> = (0..models.len())
        .filter(|&i| outcomes[i] == Outcome::Waiting)
        .collect();
    let mut working: Vec<(usize, Worker)> = Vec::new();
    loop {
        if interrupt.asked() {
            waiting.clear();
            working
                .iter_mut()
                .for_each(|(_, worker)| worker.interrupt());
        }
        while working.len() < jobs
            && let Some(i) = waiting.pop_front()
        {
            match start(&models[i]) {
                Ok(worker) => {
                    outcomes[i] = Outcome::Working;
                    working.push((i, worker));
                }
                Err(reason) => outcomes[i] = Outcome::Failed(reason),
            }
        }
        working.retain_mut(|(i, worker)| match worker.outcome() {
            Outcome::Working => true,
            ended => {
                outcomes[*i] = ended;
                false
            }
        });
        board.show(&outcomes);
        if working.is_empty() && waiting.is_empty() {
            board.finish();
            return outcomes;
        }
        std::thread::sleep(LOOK);
    }
}

/// Says what became of the models.
fn conclude(models: &[Model], outcomes: &[Outcome], out: &std::path::Path) -> Result<(), Failure> {
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
