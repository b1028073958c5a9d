//! `fsi-driver --case DIR`: a coupled run.

mod advance;
mod assemble;
mod conclude;
mod domain;
pub mod interrupt;
pub mod preflight;
mod rescue;
pub mod save;
mod stand;
mod surrogate;

use super::Failure;
use super::case_arguments::{CaseArguments, warn};
use super::run_folder::{Earlier, RunFolder};
use crate::case::{Case, ResolvedCase};
use crate::checkpoint::Checkpoint;
use crate::fluid::openfoam::install;
use crate::output::{terminal, write_atomically};
pub use assemble::Run;
pub use interrupt::Interrupt;
pub use stand::Stand;
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
    let order = Order {
        path: &arguments.case,
        case: &case,
        out: &out,
        earlier,
        quiet: arguments.quiet,
    };
    let interrupt = || {
        Interrupt::listen((!arguments.quiet).then_some(interrupt::A_RUN_IS_SAVED))
            .map_err(|e| Failure::Run(format!("cannot listen to signals: {e}")))
    };
    order.execute(interrupt)
}

/// What is to be run, and where.
pub struct Order<'a> {
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

impl Order<'_> {
    /// Runs the case; `interrupt` is asked for once the folder of the results is claimed.
    pub fn execute(
        &self,
        interrupt: impl FnOnce() -> Result<Interrupt, Failure>,
    ) -> Result<(), Failure> {
        let case = self.case;
        install::check(case.fluid.ranks).map_err(|e| Failure::Input(e.to_string()))?;
        if self.earlier != Earlier::Resume {
            preflight::try_fluid(case).map_err(|e| Failure::Input(e.to_string()))?;
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
        let mut run = Run::assemble(self.path, case, folder, checkpoint.as_ref(), interrupt()?)?;
        if self.earlier == Earlier::ResumeWithoutTables {
            run.save()?; // a checkpoint that stands on the new tables
        }
        if !self.quiet {
            warn(case);
            terminal::note(format_args!(
                "{}: {} fluid cells, {} structural degrees of freedom, {} steps; ready in {:.1} s",
                self.path.display(),
                run.cells,
                run.coupling.solid.body().degrees_of_freedom(),
                run.case.steps(),
                clock.elapsed().as_secs_f64(),
            ));
        }
        let outcome = run.advance(self.quiet);
        run.conclude(outcome, self.quiet)
    }
}

/// The checkpoint from which the run in `folder` continues; none if it ended before it wrote the first.
fn checkpoint(folder: &RunFolder, case: &Case) -> Result<Option<Checkpoint>, Failure> {
    let Some(found) = save::find(folder)? else {
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
fn checkpoint_without_tables(folder: &RunFolder, case: &Case) -> Result<Checkpoint, Failure> {
    let found = folder
        .checkpoints()
        .newest_without(&save::table_names(folder));
    let found = found.map_err(|e| Failure::Input(e.to_string()))?;
    can_follow(&found.checkpoint, case)?;
    let (checkpoint, lost) = save::without_tables(folder, found.checkpoint)?;
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
fn can_follow(checkpoint: &Checkpoint, case: &Case) -> Result<(), Failure> {
    save::compare(checkpoint, case)?;
    let reached = checkpoint.record.totals.time_s;
    if reached > case.time.end + 0.5 * case.time.step {
        return Err(Failure::Input(format!(
            "time.end_s (--end-time): {} s, but the run to be resumed has reached t = {reached} s; expected at least that. \
             For results until an earlier time: fsi-driver hemodynamics RUN --from S --to S",
            case.time.end
        )));
    }
    Ok(())
}

fn run_failure(error: impl std::fmt::Display) -> Failure {
    Failure::Run(error.to_string())
}

fn written(error: std::io::Error) -> Failure {
    Failure::Run(format!("cannot write the results: {error}"))
}
