//! What can be wrong with a case.

use super::defaults;
use std::fmt;
use std::path::{Path, PathBuf};

/// Where a value was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ValuePlace {
    /// A line of a file, counted from 1.
    File(PathBuf, usize),
    /// An option `--set` of the command line.
    Set,
    /// What a study varies: `--sweep`, or a row of `--samples`.
    Sweep,
    /// Another option of the command line, such as `--end-time`, that stands for a key.
    Option(&'static str),
    /// Nowhere: a default counts.
    Absent,
    /// The command itself, whatever the user said: a benchmark ends when it ends.
    Command,
}

impl ValuePlace {
    /// Whether it is in what is built into the program.
    pub(super) fn is_built_in(&self) -> bool {
        matches!(self, Self::File(path, _) if path == Path::new(defaults::SHOWN_AS))
    }

    /// The same in messages: nobody has the lines of what is built into the program.
    pub(super) fn told(&self) -> &dyn fmt::Display {
        match self.is_built_in() {
            true => &Self::Absent,
            false => self,
        }
    }
}

impl fmt::Display for ValuePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ValuePlace::File(path, line) => write!(f, "{}:{line}", path.display()),
            ValuePlace::Set => f.write_str("--set"),
            ValuePlace::Sweep => f.write_str("--sweep"),
            ValuePlace::Option(name) => f.write_str(name),
            ValuePlace::Absent => f.write_str("by default"),
            ValuePlace::Command => f.write_str("chosen by the command"),
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
        place: ValuePlace,
        /// What the parser says.
        message: String,
    },
    /// A key that no case has.
    #[error("{place}: unknown key `{key}`{}", meant(suggestions))]
    UnknownKey {
        /// Where.
        place: ValuePlace,
        /// The key.
        key: String,
        /// Keys that may have been meant.
        suggestions: Vec<String>,
    },
    /// A key that the command line gives two values.
    #[error(
        "{}: `{key}` is given twice, as {} by {} and as {} by {}: leave one of them out",
        second.0, first.1, first.0, second.1, second.0
    )]
    Repeated {
        /// The key.
        key: String,
        /// Option and value.
        first: (ValuePlace, String),
        /// Option and value of the other.
        second: (ValuePlace, String),
    },
    /// A value of the wrong type or out of range.
    #[error("{}: `{key}` = {found}: expected {allowed} ({about}){}", place.told(), suggestion.as_ref().map(|s| format!("; did you mean \"{s}\"?")).unwrap_or_default())]
    Value {
        /// Where.
        place: ValuePlace,
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
        "{}: {count} keys are missing, `{first}` the first of them; write `extends = \"defaults\"` at the top and name only what differs",
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
    #[error("{}: `{key}` = {found}: {message}", place.told())]
    Nonsense {
        /// Where.
        place: ValuePlace,
        /// The key to blame.
        key: String,
        /// Its value.
        found: String,
        /// What is wrong and what would be right.
        message: String,
    },
    /// What no single key is to blame for.
    #[error("{0}")]
    Whole(String),
}

/// "; did you mean `a`, `b` or `c`?"
fn meant(keys: &[String]) -> String {
    let quoted: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
    match quoted.split_last() {
        None => String::new(),
        Some((only, [])) => format!("; did you mean {only}?"),
        Some((last, others)) => format!("; did you mean {} or {last}?", others.join(", ")),
    }
}

/// So many mistakes are shown at once.
const SHOWN: usize = 25;

/// All mistakes of a case, in the order in which they were found; never empty.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub struct CaseErrors(pub Vec<CaseError>);

impl fmt::Display for CaseErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.as_slice() {
            [only] => only.fmt(f),
            all => {
                write!(f, "{} mistakes in the case:", all.len())?;
                let mut shown = all.iter().take(SHOWN);
                shown.try_for_each(|error| write!(f, "\n  {error}"))?;
                match all.len().saturating_sub(SHOWN) {
                    0 => Ok(()),
                    more => write!(f, "\n  and {more} more"),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::defaults::SHOWN_AS;
    use super::*;

    /// Nobody has the lines of what is built in.
    #[test]
    fn a_value_of_the_built_in_defaults_has_no_line() {
        let mistake = |path: &str| {
            let mistake = CaseError::Nonsense {
                place: ValuePlace::File(path.into(), 273),
                key: "time.step_s".into(),
                found: "0.002".into(),
                message: "why".into(),
            };
            mistake.to_string()
        };
        assert_eq!(mistake(SHOWN_AS), "by default: `time.step_s` = 0.002: why");
        assert_eq!(
            mistake("case.toml"),
            "case.toml:273: `time.step_s` = 0.002: why"
        );
    }
}
