//! What ends a command early, and its exit code.

use crate::files::Fault;
use crate::output::terminal::PrintError;
use crate::simulation::assembly::preflight::TrialError;
use std::process::ExitCode;

/// What ends a command early; printed once, by `main`.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The input or the installation is at fault; nothing was written. Exit code 2.
    #[error("error: {0}")]
    Input(String),
    /// A solver failed, or a file could not be written, after the run had begun. Exit code 1.
    #[error("error: {0}")]
    Run(String),
    /// The user, or the system, asked to stop. Exit code 130.
    #[error("interrupted: {0}")]
    Interrupted(String),
}

impl From<PrintError> for Failure {
    fn from(error: PrintError) -> Self {
        Self::Run(error.to_string())
    }
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Self {
        Self::Input(fault.to_string())
    }
}

impl From<TrialError> for Failure {
    fn from(error: TrialError) -> Self {
        match error {
            TrialError::Refused(mistakes) => Self::Input(mistakes.to_string()),
            TrialError::Interrupted => Self::Interrupted("nothing was written".into()),
        }
    }
}

impl Failure {
    /// The exit code of the process.
    pub fn exit_code(&self) -> ExitCode {
        match self {
            Self::Input(_) => ExitCode::from(2),
            Self::Run(_) => ExitCode::from(1),
            Self::Interrupted(_) => ExitCode::from(130),
        }
    }
}
