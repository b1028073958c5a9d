//! Writes a file of a case.

use std::path::{Path, PathBuf};
use std::{fs, io};

/// Why the case could not be written.
#[derive(Debug, thiserror::Error)]
pub enum CaseFilesError {
    /// The system refused.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// What was being done.
        action: &'static str,
        /// With what.
        path: PathBuf,
        /// Why it failed.
        source: io::Error,
    },
}

pub(super) fn io_error(
    action: &'static str,
    path: &Path,
) -> impl FnOnce(io::Error) -> CaseFilesError {
    let path = path.to_owned();
    move |source| CaseFilesError::Io {
        action,
        path,
        source,
    }
}

pub(super) fn write_file(path: &Path, text: &str) -> Result<(), CaseFilesError> {
    fs::write(path, text).map_err(io_error("write", path))
}
