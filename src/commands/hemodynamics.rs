//! `fsi-driver hemodynamics RUN`: wall shear measures again, from what a run has stored, over any window.

use super::Failure;
use crate::case::Window;
use crate::output::results;
use crate::output::run_files::RunFiles;
use crate::output::terminal;
use std::path::PathBuf;

/// Options of the evaluation.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the run.
    #[arg(value_name = "RUN")]
    folder: PathBuf,
    /// Start of the window in seconds, not included [default: as the run was evaluated].
    #[arg(long, value_name = "S", requires = "to")]
    from: Option<f64>,
    /// End of the window in seconds, included.
    #[arg(long, value_name = "S", requires = "from")]
    to: Option<f64>,
    /// Replace the run's own evaluation, which reports and comparisons read, instead of writing a new folder.
    #[arg(long, requires = "from")]
    replace: bool,
    /// Also average over the beats of the window at N phases of the period: phases.csv and phases.pvd.
    #[arg(long, value_name = "N")]
    phases: Option<usize>,
}

/// Evaluates a run again and prints the result.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let window = match (arguments.from, arguments.to) {
        (Some(from), Some(to)) if !(from >= 0.0 && from < to) => {
            return Err(Failure::Input(format!(
                "--from {from} --to {to}: expected times with 0 <= FROM < TO"
            )));
        }
        (Some(start_s), Some(end_s)) => Some(Window { start_s, end_s }),
        _ => None,
    };
    let files = RunFiles::new(&arguments.folder);
    let own_folder = window.filter(|_| !arguments.replace);
    let into = own_folder.map_or(files.clone(), |window| {
        results::window_files(&files, window)
    });
    let summary = results::reevaluate(&files, &into, window, arguments.phases)
        .map_err(|e| Failure::Input(e.to_string()))?;
    terminal::print(summary)?;
    if own_folder.is_some() {
        terminal::print(format_args!(
            "in {}; the run's own evaluation is as it was (--replace puts this one in its place)\n",
            into.root().display()
        ))?;
    }
    Ok(())
}
