//! `fsi-driver check DIR`: everything that can be said of a case before it runs.

use super::Failure;
use super::case_arguments::{CaseArguments, machine_memory, warn};
use crate::fluid::openfoam::install;
use crate::output::terminal;
use crate::simulation::assembly::preflight;
use std::path::PathBuf;

/// Options of the check.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the case, with its case.toml.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    #[command(flatten)]
    case: CaseArguments,
}

/// Loads and checks a case and prints its size.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let case = arguments.case.load(&arguments.folder)?;
    let openfoam = match install::check(case.fluid.ranks) {
        Ok(_) => {
            preflight::try_fluid(&case).map_err(|e| Failure::Input(e.to_string()))?;
            "takes the templates".to_owned()
        }
        Err(missing) => format!("could not be asked: {missing}"),
    };
    let there = machine_memory().map_or(String::new(), |bytes| {
        format!(" of this machine's {:.1} GB", bytes / 1e9)
    });
    terminal::print(format_args!(
        "{} with --preset {} can be run:\n\
         blood   {} cells, {} MPI rank(s)\n\
         wall    {} degrees of freedom, p = {}\n\
         time    {} steps of {} s\n\
         OpenFOAM {openfoam}\n\
         memory  about {:.2} GB{there}\n",
        arguments.folder.display(),
        arguments.case.preset,
        case.fluid_cells(),
        case.fluid.ranks,
        case.structure_degrees_of_freedom(),
        case.structure.p,
        case.steps(),
        case.time.step,
        case.memory() / 1e9,
    ))?;
    warn(&case);
    Ok(())
}
