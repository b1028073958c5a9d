//! How far the run in a folder has come with a case.

use super::Failure;
use super::coupled_run::Found;
use super::resumption::{beyond, compare};
use crate::case::Case;
use crate::output::record::RunSummary;
use crate::output::run_files::RunFiles;
use crate::simulation::checkpoint::{Store, StoreError};
use std::path::Path;

/// How far a run has come.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RunStatus {
    /// There is none.
    Absent,
    /// It can be resumed.
    Unfinished,
    /// Its last step is done, and it has said so.
    Complete,
    /// It is that of another case; the text says what differs.
    Changed(String),
    /// It is farther than the end of the case; the text says so.
    Beyond(String),
}

impl RunStatus {
    /// Looks at the folder `root`.
    pub fn of(root: &Path, case: &Case) -> Self {
        let files = RunFiles::new(root);
        if !files.resolved_case().is_file() {
            return Self::Absent;
        }
        // What is wrong with damaged checkpoints is said by the attempt to resume.
        let newest: Result<Found, StoreError> = Store::new(root).newest();
        let Ok(found) = newest else {
            return Self::Unfinished;
        };
        if let Err(Failure::Input(text)) = compare(&found.checkpoint, case) {
            return Self::Changed(text);
        }
        if let Some(text) = beyond(&found.checkpoint, case) {
            return Self::Beyond(text);
        }
        let summary = std::fs::read(files.summary()).ok();
        let summary = summary.and_then(|text| serde_json::from_slice::<RunSummary>(&text).ok());
        let is_periodic = |summary: &RunSummary| {
            let limit = case.until_periodic();
            let found = summary.periodic.as_ref().zip(limit);
            found.is_some_and(|(found, limit)| found.largest <= limit)
        };
        let is_over = found.checkpoint.time() > case.time.end - 0.5 * case.time.step;
        let has_ended = |summary: RunSummary| {
            summary.status == "complete" && (is_over || is_periodic(&summary))
        };
        let complete = summary.is_some_and(has_ended) && files.hemodynamics().is_file();
        if complete {
            Self::Complete
        } else {
            Self::Unfinished
        }
    }
}
