//! What can be wrong with a case.

use std::fmt;
use std::path::PathBuf;

/// Where a value was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A line of a file, counted from 1.
    File(PathBuf, usize),
    /// An option `--set` of the command line.
    Set,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File(path, line) => write!(f, "{}:{line}", path.display()),
            Place::Set => f.write_str("--set"),
        }
    }
}

/// One mistake.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CaseError {
    /// A file cannot be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why not, and what to do.
        reason: String,
    },
    /// A text is no TOML.
    #[error("{place}: not valid TOML: {message}")]
    Syntax {
        /// Where.
        place: Place,
        /// What the parser says.
        message: String,
    },
    /// A key that no case has.
    #[error("{place}: unknown key `{key}`{}", suggestion.as_ref().map(|s| format!("; did you mean `{s}`?")).unwrap_or_default())]
    UnknownKey {
        /// Where.
        place: Place,
        /// The key.
        key: String,
        /// What may have been meant.
        suggestion: Option<String>,
    },
    /// A value of the wrong type or out of range.
    #[error("{place}: `{key}` = {found}: expected {allowed} ({about}){}", suggestion.as_ref().map(|s| format!("; did you mean \"{s}\"?")).unwrap_or_default())]
    Value {
        /// Where.
        place: Place,
        /// The key.
        key: String,
        /// The value as written.
        found: String,
        /// Which values are allowed.
        allowed: String,
        /// What the key is.
        about: String,
        /// What may have been meant.
        suggestion: Option<String>,
    },
    /// A key without a value.
    #[error("{}: `{key}` is missing: expected {allowed} ({about})", file.display())]
    Missing {
        /// The file of the case.
        file: PathBuf,
        /// The key.
        key: String,
        /// Which values are allowed.
        allowed: String,
        /// What the key is.
        about: String,
    },
    /// Very many keys without a value: the case stands on nothing.
    #[error(
        "{}: {count} keys are missing, `{first}` the first of them; write `extends = \"path/to/openfoam-case/defaults.toml\"` at the top and name only what differs",
        file.display()
    )]
    NoDefaults {
        /// The file of the case.
        file: PathBuf,
        /// How many.
        count: usize,
        /// The first of them.
        first: String,
    },
    /// Values that are allowed one by one but make no sense together.
    #[error("{place}: `{key}` = {found}: {message}")]
    Nonsense {
        /// Where.
        place: Place,
        /// The key to blame.
        key: String,
        /// Its value.
        found: String,
        /// What is wrong and what would be right.
        message: String,
    },
}

/// All mistakes of a case, in the order in which they were found; never empty.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub struct CaseErrors(pub Vec<CaseError>);

impl fmt::Display for CaseErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.as_slice() {
            [only] => only.fmt(f),
            all => {
                write!(f, "{} mistakes in the case:", all.len())?;
                all.iter().try_for_each(|error| write!(f, "\n  {error}"))
            }
        }
    }
}
