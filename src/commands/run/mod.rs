//! `fsi-driver --case DIR`: a coupled run.

mod conclude;
mod coupled_run;
pub mod interrupt;
mod new_tables;
mod status;

use super::Failure;
use super::case_arguments::{CaseArguments, warn};
use super::run_folder::{Earlier, RunFolder};
use crate::case::{Case, CaseIdentity, ResolvedCase, Solver};
use crate::fluid::openfoam::install;
use crate::output::{terminal, write_atomically};
use crate::simulation::assembly::preflight;
use crate::simulation::checkpoint::StoreError;
pub use coupled_run::{CoupledRun, Found, RunCheckpoint};
pub use interrupt::Interrupt;
pub use status::RunStatus;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Options of a coupled run.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the case, with its case.toml.
    #[arg(long, value_name = "DIR")]
    case: PathBuf,
    /// Folder of the results [default: <case>/run-<preset>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the results of an earlier run in the same folder.
    #[arg(long)]
    force: bool,
    /// Continue an earlier run in the same folder from its newest checkpoint, with the same case.
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// With --resume: go on although tables of the run are missing or damaged; they begin anew.
    #[arg(long, requires = "resume")]
    new_tables: bool,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
}

/// Runs a coupled case from its first time step, or from a checkpoint, to its last.
pub fn run(arguments: &Arguments, chosen: &CaseArguments) -> Result<(), Failure> {
    let case = chosen.load(&arguments.case)?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| arguments.case.join(format!("run-{}", chosen.preset)));
    let earlier = match arguments {
        Arguments {
            new_tables: true, ..
        } => Earlier::ResumeWithoutTables,
        Arguments { resume: true, .. } => Earlier::Resume,
        Arguments { force: true, .. } => Earlier::Replace,
        _ => Earlier::Keep,
    };
    let request = RunRequest {
        path: &arguments.case,
        case: &case,
        out: &out,
        earlier,
        quiet: arguments.quiet,
    };
    let interrupt = Interrupt::listen((!arguments.quiet).then_some(interrupt::A_RUN_IS_SAVED))?;
    request.execute(interrupt)
}

/// What is to be run, and where.
pub struct RunRequest<'a> {
    /// Folder of the case.
    pub path: &'a Path,
    /// The case.
    pub case: &'a ResolvedCase,
    /// Folder of the results.
    pub out: &'a Path,
    /// What to do with an earlier run there.
    pub earlier: Earlier,
    /// Whether to show no progress.
    pub quiet: bool,
}

impl RunRequest<'_> {
    /// Runs the case until its end or an `interrupt`.
    pub fn execute(&self, interrupt: Interrupt) -> Result<(), Failure> {
        let case = self.case;
        if case.fluid.solver == Solver::OpenFoam {
            install::check(case.fluid.ranks).map_err(|e| Failure::Input(e.to_string()))?;
        }
        if self.earlier != Earlier::Resume {
            preflight::try_fluid(case, interrupt.of_the_start())?;
        }
        let folder = RunFolder::open(self.out, self.earlier)?;
        let checkpoint = match self.earlier {
            Earlier::Resume => checkpoint(&folder, case)?,
            Earlier::ResumeWithoutTables => Some(checkpoint_without_tables(&folder, case)?),
            Earlier::Keep | Earlier::Replace => None,
        };
        write_atomically(&folder.resolved_case(), case.to_toml_string().as_bytes())
            .map_err(written)?;

        let clock = Instant::now();
        let mut run = CoupledRun::assemble(
            self.path,
            case,
            folder,
            checkpoint.as_ref(),
            interrupt,
            self.quiet,
        )?;
        if self.earlier == Earlier::ResumeWithoutTables {
            run.save()?; // a checkpoint that stands on the new tables
        }
        if !self.quiet {
            warn(case);
            terminal::note(format_args!(
                "{}: {} fluid {}, {} structural degrees of freedom, {} steps; ready in {:.1} s",
                self.path.display(),
                run.fluid_cells,
                match case.fluid.solver {
                    Solver::OpenFoam => "cells",
                    Solver::Native => "elements",
                },
                run.degrees_of_freedom(),
                case.steps(),
                clock.elapsed().as_secs_f64(),
            ));
        }
        let outcome = run.advance();
        run.conclude(outcome, self.quiet)
    }
}

/// The checkpoint from which the run in `folder` continues; none if it ended before it wrote the first.
fn checkpoint(folder: &RunFolder, case: &Case) -> Result<Option<RunCheckpoint>, Failure> {
    let Some(found) = find(folder)? else {
        let root = folder.root().display();
        terminal::note(format_args!(
            "the run in {root} had not begun; it starts now"
        ));
        return Ok(None);
    };
    can_follow(&found.checkpoint, case)?;
    for damaged in &found.damaged {
        terminal::note(format_args!("passed over: {damaged}"));
    }
    terminal::note(format_args!(
        "continues from {}: {} steps, t = {} s",
        found.path.display(),
        found.checkpoint.step(),
        found.checkpoint.time()
    ));
    Ok(Some(found.checkpoint))
}

/// The checkpoint from which the run in `folder` continues with new tables.
fn checkpoint_without_tables(folder: &RunFolder, case: &Case) -> Result<RunCheckpoint, Failure> {
    let found: Result<Found, _> = (folder.checkpoints()).newest_without(&new_tables::names(folder));
    let found = found.map_err(|e| Failure::Input(e.to_string()))?;
    can_follow(&found.checkpoint, case)?;
    let (checkpoint, lost) = new_tables::set_aside(folder, found.checkpoint)?;
    for lost in lost {
        terminal::note(format_args!("begins anew: {lost}"));
    }
    terminal::note(format_args!(
        "continues from {}: {} steps, t = {} s",
        found.path.display(),
        checkpoint.step(),
        checkpoint.time()
    ));
    Ok(checkpoint)
}

/// Refuses another case than that of the checkpoint, and one that ends before it: its results would be cut off.
fn can_follow(checkpoint: &RunCheckpoint, case: &Case) -> Result<(), Failure> {
    compare(checkpoint, case)?;
    let reached = checkpoint.time();
    if reached > case.time.end + 0.5 * case.time.step {
        return Err(Failure::Input(format!(
            "time.end_s (--end-time): {} s, but the run to be resumed has reached t = {reached} s; expected at least that. \
             For results until an earlier time: fsi-driver hemodynamics RUN --from S --to S",
            case.time.end
        )));
    }
    Ok(())
}

/// The newest whole checkpoint in a folder; none if the run had not begun.
pub fn find(folder: &RunFolder) -> Result<Option<Found>, Failure> {
    match folder.checkpoints().newest() {
        Ok(found) => Ok(Some(found)),
        Err(StoreError::None(_)) if fs::metadata(folder.history()).map_or(0, |f| f.len()) == 0 => {
            Ok(None)
        }
        Err(error) => {
            let waived = new_tables::names(folder);
            let state: Result<Found, _> = folder.checkpoints().newest_without(&waived);
            Err(Failure::Input(match state {
                Ok(_) => format!(
                    "{error}\nRestore such a file from a copy, or go on without its rows until now: --resume --new-tables sets it aside and begins it anew."
                ),
                Err(_) => {
                    format!("{error}\nThe run cannot be resumed; start it again with --force.")
                }
            }))
        }
    }
}

/// Refuses to resume another case than that of the checkpoint.
pub fn compare(checkpoint: &RunCheckpoint, case: &Case) -> Result<(), Failure> {
    let now = CaseIdentity::of(case);
    let now = now.map_err(|e| Failure::Input(format!("cannot read the case: {e}")))?;
    let changed = checkpoint.case.changes(&now);
    if changed.is_empty() {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "the case is not the one that is to be resumed; give the same --preset and --set, or start again with --force. Changed:\n  {}",
        changed.join("\n  ")
    )))
}

fn run_failure(error: impl std::fmt::Display) -> Failure {
    Failure::Run(error.to_string())
}

fn written(error: std::io::Error) -> Failure {
    Failure::Run(format!("cannot write the results: {error}"))
}
