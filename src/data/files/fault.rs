//! What is wrong with a file that people or other programs wrote.

use std::fmt::{Debug, Display};
use std::path::{Path, PathBuf};

/// What is wrong with a file, in words, and where in it. Who names the file puts its path before it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}{message}", line.map_or(String::new(), |line| format!("line {line}: ")))]
pub struct Fault {
    /// The line, counted from 1.
    pub line: Option<usize>,
    /// What was found, what is expected, and what to do.
    pub message: String,
}

impl Fault {
    /// Something about a line.
    pub fn at(line: usize, message: impl Display) -> Self {
        Self {
            line: Some(line),
            message: message.to_string(),
        }
    }

    /// Something about the whole file.
    pub fn whole(message: impl Display) -> Self {
        Self {
            line: None,
            message: message.to_string(),
        }
    }

    /// Something else than what is `expected` in the whole file.
    pub fn unexpected(expected: impl Display, found: impl Debug) -> Self {
        Self::whole(format!("expected {expected}, found {found:?}"))
    }
}

impl From<String> for Fault {
    fn from(message: String) -> Self {
        Self::whole(message)
    }
}

impl From<&str> for Fault {
    fn from(message: &str) -> Self {
        Self::whole(message)
    }
}

/// What is wrong with a file or folder, which is named.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", .path.display())]
pub struct FileError {
    /// The file or folder.
    pub path: PathBuf,
    /// What was found, what is expected, and what to do.
    pub reason: String,
}

impl FileError {
    /// Something about the file `path`.
    pub fn new(path: &Path, reason: impl Display) -> Self {
        Self {
            path: path.to_owned(),
            reason: reason.to_string(),
        }
    }
}

/// Something about the whole file, as of `format!`.
#[macro_export]
macro_rules! fault {
    ($($text:tt)*) => {
        $crate::files::Fault::whole(format_args!($($text)*))
    };
}
