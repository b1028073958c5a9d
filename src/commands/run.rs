//! `fsi-driver --case DIR`: a coupled run.

use super::{CaseArguments, Failure};
use crate::run::{Earlier, Interrupt, RunRequest, THE_START_ENDS};
use std::path::PathBuf;

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
    let interrupt = Interrupt::listen((!arguments.quiet).then_some(THE_START_ENDS))?;
    request.execute(interrupt)
}
