//! The checkpoint from which a run goes on.

use super::coupled_run::{Found, RunCheckpoint};
use super::{Failure, RunFolder, new_tables};
use crate::case::{Case, CaseIdentity};
use crate::output::record::RunSummary;
use crate::output::run_files::RunFiles;
use crate::output::terminal;
use crate::simulation::assembly::surroundings;
use crate::simulation::checkpoint::StoreError;
use std::fs;

/// The checkpoint from which the run in `folder` continues; none if it ended before it wrote the first.
pub(super) fn checkpoint(
    folder: &RunFolder,
    case: &Case,
) -> Result<Option<RunCheckpoint>, Failure> {
    let Some(found) = newest(folder)? else {
        let root = folder.root().display();
        terminal::note(format_args!(
            "the run in {root} had not begun; it starts now"
        ));
        return Ok(None);
    };
    can_follow(&found.checkpoint, case)?;
    if let Some((before, now)) = another_openfoam(folder, case) {
        terminal::note(format_args!(
            "warning: the run was computed by OpenFOAM {before} so far, and continues with {now}: it is not the same to the last digit"
        ));
    }
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

/// The OpenFOAM by which the run in `folder` was computed, as its summary says, and that which is used now, if they
/// differ.
fn another_openfoam(folder: &RunFolder, case: &Case) -> Option<(String, String)> {
    let summary = fs::read(folder.summary()).ok()?;
    let before = serde_json::from_slice::<RunSummary>(&summary)
        .ok()?
        .openfoam?;
    let now = surroundings::openfoam(case.fluid.solver)?;
    (before != now).then_some((before, now))
}

/// The checkpoint from which the run in `folder` continues with new tables.
pub(super) fn checkpoint_without_tables(
    folder: &RunFolder,
    case: &Case,
) -> Result<RunCheckpoint, Failure> {
    let found: Result<Found, _> = (folder.checkpoints()).newest_without(&new_tables::names(folder));
    let found = found.map_err(|e| Failure::Input(e.to_string()))?;
    can_follow(&found.checkpoint, case)?;
    let (checkpoint, lost) = new_tables::set_aside(folder, found.checkpoint)?;
    for lost in lost {
        terminal::note(format_args!("starts again: {lost}"));
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
    match beyond(checkpoint, case) {
        Some(reason) => Err(Failure::Input(reason)),
        None => Ok(()),
    }
}

/// What is wrong if a run is farther than the end of the case.
pub fn beyond(checkpoint: &RunCheckpoint, case: &Case) -> Option<String> {
    let (reached, end) = (checkpoint.time(), case.time.end);
    (reached > end + 0.5 * case.time.step).then(|| {
        format!(
            "time.end_s (--end-time): {end} s, but the run to be resumed has reached t = {reached} s; expected at least that. \
             For results until an earlier time: fsi-driver hemodynamics RUN --from S --to S"
        )
    })
}

/// The newest whole checkpoint in a folder; none if the run had not begun.
pub fn newest(folder: &RunFolder) -> Result<Option<Found>, Failure> {
    match folder.checkpoints().newest() {
        Ok(found) => Ok(Some(found)),
        Err(StoreError::None(_)) if !has_begun(folder) => Ok(None),
        Err(error @ StoreError::Io(_)) => Err(Failure::Input(format!(
            "cannot read the checkpoints: {error}"
        ))),
        Err(error) => {
            let waived = new_tables::names(folder);
            let state: Result<Found, _> = folder.checkpoints().newest_without(&waived);
            Err(Failure::Input(match state {
                Ok(_) => format!(
                    "{error}\nRestore such a file from a copy, or go on without its rows until now: --resume --new-tables sets it aside and starts a new one."
                ),
                Err(_) => {
                    format!("{error}\nThe run cannot be resumed; start it again with --force.")
                }
            }))
        }
    }
}

/// How the run goes on after what ended it; empty if it cannot.
pub(super) fn way_back(files: &RunFiles) -> String {
    let newest: Result<Found, _> = files.checkpoints().newest();
    match newest {
        Ok(found) => format!(
            "; --resume continues from {} (step {})",
            found.path.display(),
            found.checkpoint.step()
        ),
        Err(StoreError::None(_)) if !has_begun(files) => "; --resume begins it again".into(),
        Err(_) => String::new(),
    }
}

/// Whether a step was taken.
fn has_begun(files: &RunFiles) -> bool {
    fs::metadata(files.history()).is_ok_and(|file| file.len() > 0)
}

/// Refuses to resume another case than that of the checkpoint.
pub(super) fn compare(checkpoint: &RunCheckpoint, case: &Case) -> Result<(), Failure> {
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
