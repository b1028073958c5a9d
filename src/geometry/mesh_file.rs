//! What is wrong with a file that holds a mesh.

use crate::Vec3;
use std::path::{Path, PathBuf};

/// Coordinates (of a file, in its unit) beyond this cannot be meant; their cubes are finite.
const FARTHEST: f64 = 1e12;

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

/// Whether a point of a file can be meant.
pub(super) fn is_a_place(x: &Vec3) -> bool {
    x.iter().all(|c| c.abs() <= FARTHEST)
}
