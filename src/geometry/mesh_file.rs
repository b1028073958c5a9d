//! What is wrong with a file that holds a mesh.

use std::path::{Path, PathBuf};

/// What is wrong with a file that holds a mesh, and where.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", .path.display())]
pub struct MeshFileError {
    /// The file.
    pub path: PathBuf,
    /// What was expected, and what was found.
    pub reason: String,
}

impl MeshFileError {
    /// Something about the file `path`.
    pub fn new(path: &Path, reason: impl std::fmt::Display) -> Self {
        Self {
            path: path.to_owned(),
            reason: reason.to_string(),
        }
    }
}
