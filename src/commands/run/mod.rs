//! `fsi-driver --case DIR`: a coupled run.

mod advance;
mod assemble;
mod conclude;
mod interrupt;
mod rescue;
pub(in crate::commands) mod save;

use super::Failure;
use super::case_arguments::CaseArguments;
use super::run_folder::{Earlier, RunFolder};
use crate::case::Case;
use crate::checkpoint::Checkpoint;
use crate::fluid::openfoam::install;
use crate::output::write_atomically;
pub(in crate::commands) use assemble::Run;
pub(in crate::commands) use interrupt::Interrupt;
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
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
}

/// Runs a coupled case from its first time step, or from a checkpoint, to its last.
pub fn run(arguments: &Arguments, chosen: &CaseArguments) -> Result<(), Failure> {
    let case = chosen.load(&arguments.case)?;
    install::check(case.fluid.ranks).map_err(|e| Failure::Input(e.to_string()))?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| arguments.case.join(format!("run-{}", chosen.preset)));
    let earlier = match (arguments.resume, arguments.force) {
        (true, _) => Earlier::Resume,
        (_, true) => Earlier::Replace,
        _ => Earlier::Keep,
    };
    let clock = Instant::now();
    let interrupt = Interrupt::listen(arguments.quiet)
        .map_err(|e| Failure::Run(format!("cannot listen to signals: {e}")))?;
    let mut run = prepare(
        &arguments.case,
        &case,
        &case.to_toml_string(),
        &out,
        earlier,
        interrupt,
    )?;
    if !arguments.quiet {
        eprintln!(
            "{}: {} fluid cells, {} structural degrees of freedom, {} steps; ready in {:.1} s",
            arguments.case.display(),
            run.cells,
            run.coupling.solid.body().degrees_of_freedom(),
            run.case.steps(),
            clock.elapsed().as_secs_f64(),
        );
    }
    let outcome = run.advance(arguments.quiet);
    run.conclude(outcome, arguments.quiet)
}

/// Opens the folder `out`, leaves the `description` of the case there, and builds the run in it, at its beginning or at
/// the newest checkpoint.
pub(in crate::commands) fn prepare(
    path: &Path,
    case: &Case,
    description: &str,
    out: &Path,
    earlier: Earlier,
    interrupt: Interrupt,
) -> Result<Run, Failure> {
    let folder = RunFolder::open(out, earlier)?;
    let checkpoint = match earlier {
        Earlier::Resume => checkpoint(&folder, case)?,
        _ => None,
    };
    write_atomically(&folder.resolved_case(), description.as_bytes()).map_err(written)?;
    Run::assemble(path, case, folder, checkpoint.as_ref(), interrupt)
}

/// The checkpoint from which the run in `folder` continues; none if it ended before it wrote the first.
fn checkpoint(folder: &RunFolder, case: &Case) -> Result<Option<Checkpoint>, Failure> {
    let Some(found) = save::find(folder)? else {
        eprintln!(
            "the run in {} had not begun; it starts now",
            folder.root().display()
        );
        return Ok(None);
    };
    save::compare(&found.checkpoint, case)?;
    for damaged in &found.damaged {
        eprintln!("passed over: {damaged}");
    }
    eprintln!(
        "continues from {}: {} steps, t = {} s",
        found.path.display(),
        found.checkpoint.step(),
        found.checkpoint.time
    );
    Ok(Some(found.checkpoint))
}

fn run_failure(error: impl std::fmt::Display) -> Failure {
    Failure::Run(error.to_string())
}

fn written(error: std::io::Error) -> Failure {
    Failure::Run(format!("cannot write the results: {error}"))
}
