//! `fsi-driver compare A B`: how far two runs are from each other.

use super::{Failure, report, results_folder};
use crate::output::comparison::{Comparison, RunDifference};
use crate::output::terminal;
use std::path::PathBuf;

/// The table that marks a folder of comparisons.
const MARK: &str = "compare.csv";

/// Options of the comparison.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of a run.
    #[arg(value_name = "A")]
    first: PathBuf,
    /// Folder of another run; if it is of another model, what differs is listed, and limits are not applied.
    #[arg(value_name = "B")]
    second: PathBuf,
    #[command(flatten)]
    limits: CompareLimits,
    /// Folder for the table, the figures of the histories, and maps of both runs and of their difference.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace an earlier comparison in that folder.
    #[arg(long, requires = "out")]
    force: bool,
}

/// How far two runs may be from each other.
#[derive(Debug, clap::Args)]
pub struct CompareLimits {
    /// Largest allowed root mean square of the difference of a history, relative to that of the history.
    #[arg(long, value_name = "SHARE", default_value_t = 0.02)]
    history: f64,
    /// The same of the fields TAWSS and radius on the wall.
    #[arg(long, value_name = "SHARE", default_value_t = 0.05)]
    wall: f64,
    /// Largest allowed root mean square of the difference of the oscillating shear index, absolute.
    #[arg(long, value_name = "INDEX", default_value_t = 0.01)]
    osi: f64,
}

impl CompareLimits {
    /// Those of histories, of fields, and of the oscillating shear index.
    ///
    /// # Errors
    /// If one is not a number from 0.
    pub fn checked(&self) -> Result<[f64; 3], Failure> {
        let limits = [self.history, self.wall, self.osi];
        match limits.iter().find(|limit| **limit < 0.0 || limit.is_nan()) {
            Some(limit) => Err(Failure::Input(format!(
                "a limit of {limit}: expected a number from 0"
            ))),
            None => Ok(limits),
        }
    }
}

/// Compares two runs; exit code 1 if they differ by more than is allowed.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let limits = arguments.limits.checked()?;
    let load = report::load;
    let (first, second) = (load(&arguments.first)?, load(&arguments.second)?);
    let comparison =
        Comparison::new(&first, &second, limits).map_err(|e| Failure::Input(e.to_string()))?;
    terminal::print(&comparison)?;
    if let Some(out) = &arguments.out {
        results_folder::claim(out, MARK, arguments.force)?;
        comparison
            .write(out, MARK)
            .map_err(|e| Failure::Run(format!("cannot write the comparison: {e}")))?;
        let out = out.display();
        terminal::print(format_args!("table, figures and maps are in {out}\n"))?;
    }
    let beyond: Vec<String> = comparison
        .differences
        .iter()
        .filter(|difference| difference.is_beyond())
        .map(RunDifference::name)
        .collect();
    if beyond.is_empty() {
        return Ok(());
    }
    Err(Failure::Run(format!(
        "the runs differ by more than is allowed in: {}",
        beyond.join(", ")
    )))
}
