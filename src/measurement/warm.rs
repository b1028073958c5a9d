//! The state from which the measured steps start.

use crate::case::identity::changed_keys;
use crate::case::{ResolvedCase, Solver};
use crate::files::below;
use crate::output::run_files::RunFiles;
use crate::output::terminal;
use crate::run::{self, Earlier, Failure, Interrupt, RunCheckpoint, RunFolder, RunRequest};
use crate::simulation::assembly::surroundings;
use std::fs;
use std::io;
use std::path::Path;
use tempfile::TempDir;

/// What may differ between the warm state and the measured steps: they are compared for the sake of it.
const MAY_DIFFER: &[&str] = &[
    "time.end_s",
    "output",
    "coupling",
    "fluid.answer_limit_s",
    "fluid.max_correctors",
    "fluid.pressure_residual",
    "fluid.templates",
    "fluid.transport",
    "structure.newton_tolerance",
    "structure.newton_max_iterations",
];

/// A copy of a run at a checkpoint.
pub struct Warm {
    /// The checkpoint.
    pub checkpoint: RunCheckpoint,
    /// The folder of the copy.
    pub folder: RunFolder,
    /// Where the copy is; removed in the end.
    pub _root: TempDir,
}

/// Finds the checkpoint at the end of the run of `case` in `folder`, which is started or continued if it has not come
/// so far, and copies it.
pub fn state(
    path: &Path,
    case: &ResolvedCase,
    folder: &Path,
    interrupt: &Interrupt,
    quiet: bool,
) -> Result<Warm, Failure> {
    let earlier = match folder.exists() {
        true => Earlier::Resume,
        false => Earlier::Keep,
    };
    let found = match earlier {
        Earlier::Resume => newest(folder)?,
        _ => None,
    };
    let step = case.steps();
    let checkpoint = match found {
        Some(checkpoint) if checkpoint.step() == step => {
            let changed = changed_keys(&checkpoint.case.values, &case.to_toml_string(), MAY_DIFFER);
            if !changed.is_empty() {
                return Err(Failure::Input(format!(
                    "the run in {} is another case; give the same --preset and --set, or another --warm. Changed:\n  {}",
                    folder.display(),
                    changed.join("\n  ")
                )));
            }
            checkpoint
        }
        Some(checkpoint) if checkpoint.step() > step => {
            return Err(Failure::Input(format!(
                "the run in {} is already at t = {} s; give --from {1}, or another --warm",
                folder.display(),
                checkpoint.time()
            )));
        }
        _ => {
            let request = RunRequest {
                path,
                case,
                out: folder,
                earlier,
                quiet,
            };
            warm_up(&request, interrupt)?
        }
    };
    copy(folder, case.fluid.solver, checkpoint)
}

fn newest(folder: &Path) -> Result<Option<RunCheckpoint>, Failure> {
    let folder = RunFolder::open(folder, Earlier::Resume)?;
    Ok(run::newest(&folder)?.map(|found| found.checkpoint))
}

/// An ordinary run up to the warm state.
fn warm_up(request: &RunRequest, interrupt: &Interrupt) -> Result<RunCheckpoint, Failure> {
    let (root, step) = (request.out, request.case.steps());
    if !request.quiet {
        terminal::note(format_args!(
            "warming up in {} to t = {} s; done once",
            root.display(),
            request.case.time.end
        ));
    }
    request.execute(interrupt.clone())?;
    let found = newest(root)?.filter(|checkpoint| checkpoint.step() == step);
    found.ok_or_else(|| Failure::Run(format!("the run in {} left no checkpoint", root.display())))
}

/// Copies the files that a checkpoint stands on.
fn copy(from: &Path, solver: Solver, checkpoint: RunCheckpoint) -> Result<Warm, Failure> {
    let failed = |e: io::Error| {
        Failure::Run(format!(
            "cannot copy the warm state from {}: {e}",
            from.display()
        ))
    };
    let root = tempfile::Builder::new()
        .prefix("fsi-bench-")
        .tempdir()
        .map_err(failed)?;
    for file in &checkpoint.files {
        let to = root.path().join(&file.path);
        to.parent()
            .map_or(Ok(()), fs::create_dir_all)
            .map_err(failed)?;
        fs::copy(from.join(&file.path), to).map_err(failed)?;
    }
    for unchanging in surroundings::unchanging(solver, &RunFiles::new(from).fluid()) {
        let to = root.path().join(below(from, &unchanging));
        copy_folder(&unchanging, &to).map_err(failed)?;
    }
    let folder = RunFolder::adopt(root.path())?;
    Ok(Warm {
        folder,
        checkpoint,
        _root: root,
    })
}

fn copy_folder(from: &Path, to: &Path) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let target = to.join(entry.file_name());
        if entry.file_type()?.is_dir() {
            copy_folder(&entry.path(), &target)?;
        } else {
            fs::copy(entry.path(), target)?;
        }
    }
    Ok(())
}
