//! `fsi-driver --case DIR`: a coupled run.

use super::{CaseArguments, Failure};
use crate::case::Preset;
use crate::output::progress::tell_preparation;
use crate::run::{Earlier, Interrupt, RunFolder, RunRequest, START_IS_ABANDONED};
use std::path::{Path, PathBuf};

/// A coupled run with the case as its first word.
#[derive(Debug, clap::Args)]
pub struct InFolder {
    /// Folder of the case, with its case.toml, or that file.
    #[arg(value_name = "DIR")]
    case: PathBuf,
    #[command(flatten)]
    how: How,
    #[command(flatten)]
    chosen: CaseArguments,
}

/// Options of a coupled run.
#[derive(Debug, clap::Args)]
pub struct How {
    /// Folder of the results [default: <case>/run-<preset>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the results of an earlier run in the same folder.
    #[arg(long)]
    force: bool,
    /// Continue an earlier run in the same folder from its newest checkpoint, with the same case.
    #[arg(long, conflicts_with = "force")]
    resume: bool,
    /// With --resume: continue although tables of the run are missing or damaged; they start again.
    #[arg(long, requires = "resume")]
    new_tables: bool,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
}

/// Runs a coupled case from its first time step, or from a checkpoint, to its last.
pub fn in_folder(arguments: &InFolder) -> Result<(), Failure> {
    run(&arguments.case, &arguments.how, &arguments.chosen)
}

/// The same of the case at `path`.
pub fn run(path: &Path, how: &How, chosen: &CaseArguments) -> Result<(), Failure> {
    let default_folder = || results_of(path, chosen.preset);
    let out = how.out.clone().unwrap_or_else(default_folder);
    let earlier = match how {
        How {
            new_tables: true, ..
        } => Earlier::ResumeWithoutTables,
        How { resume: true, .. } => Earlier::Resume,
        How { force: true, .. } => Earlier::Replace,
        _ => Earlier::Keep,
    };
    RunFolder::look(&out, earlier)?;
    if !how.quiet {
        tell_preparation();
    }
    let case = chosen.load(path)?;
    let request = RunRequest {
        path,
        case: &case,
        out: &out,
        earlier,
        quiet: how.quiet,
    };
    let interrupt = Interrupt::listen((!how.quiet).then_some(START_IS_ABANDONED))?;
    request.execute(interrupt)
}

/// Where results go by default: into the folder of the case; those of a file with a name of its own into a
/// folder that tells it.
fn results_of(path: &Path, preset: Preset) -> PathBuf {
    if !path.is_file() {
        return path.join(format!("run-{preset}"));
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = match &*stem {
        "case" => format!("run-{preset}"),
        stem => format!("run-{stem}-{preset}"),
    };
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_lie_next_to_the_case() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["case.toml", "closed.toml"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        for (path, results) in [
            ("", "run-demo"),
            ("case.toml", "run-demo"),
            ("closed.toml", "run-closed-demo"),
        ] {
            let found = results_of(&folder.path().join(path), Preset::Demo);
            assert_eq!(found, folder.path().join(results));
        }
    }
}
