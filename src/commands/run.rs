//! `fsi-driver --case DIR`: a coupled run.

use super::Failure;
use super::run_folder::RunFolder;
use crate::case::{self, Case, Preset};
use crate::coupling::acceleration::{Acceleration, Aitken, Constant, IqnLs};
use crate::coupling::convergence::Criterion;
use crate::coupling::predictor::Predictor;
use crate::coupling::transfer::Transfer;
use crate::coupling::{Coupling, CouplingError, Settings, flatten};
use crate::fluid::openfoam::OpenFoam;
use crate::fluid::{Fluid, FluidEffort, FluidError};
use crate::output::progress::Progress;
use crate::output::write_atomically;
use crate::pfem::Structure;
use crate::record::Record;
use crate::{Vec3, geometry};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Options of a coupled run.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the case, with its case.toml.
    #[arg(long, value_name = "DIR")]
    case: PathBuf,
    /// Resolution and length of the run.
    #[arg(long, value_enum, default_value_t = Preset::Paper)]
    preset: Preset,
    /// Folder of the results [default: <case>/run-<preset>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// End of the simulated time in seconds [default: time.end_s of the case].
    #[arg(long, value_name = "S")]
    end_time: Option<f64>,
    /// Number of MPI ranks of the fluid [default: fluid.ranks of the case].
    #[arg(long, value_name = "N")]
    ranks: Option<usize>,
    /// Values that replace those of the case, such as coupling.e_rel=1e-6 or fluid.transport=files.
    #[arg(long = "set", value_name = "KEY=VALUE", num_args = 1..)]
    overrides: Vec<String>,
    /// Replace the results of an earlier run in the same folder.
    #[arg(long)]
    force: bool,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
}

/// Runs a coupled case from its first to its last time step.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let case = load(arguments)?;
    let installation = Installation::find().map_err(|e| Failure::Input(e.to_string()))?;
    let interrupt = interrupt_flag().map_err(|e| Failure::Run(format!("cannot listen to signals: {e}")))?;
    let out = arguments.out.clone().unwrap_or_else(|| arguments.case.join(format!("run-{}", arguments.preset)));
    let folder = RunFolder::create(&out, arguments.force)?;
    write_atomically(&folder.resolved_case(), case.to_toml_string().as_bytes()).map_err(written)?;

    let clock = Instant::now();
    let mut run = assemble(&case, &folder, installation, interrupt.clone(), arguments)?;
    let steps = (case.time.end / case.time.step).round() as usize;
    if !arguments.quiet {
        eprintln!(
            "{}: {} fluid cells, {} structural degrees of freedom, {steps} steps; ready in {:.1} s",
            arguments.case.display(),
            run.cells,
            run.coupling.solid.dofs(),
            clock.elapsed().as_secs_f64(),
        );
    }
    let outcome = advance(&mut run, &case, steps, &interrupt, arguments.quiet);
    conclude(run, outcome, &folder, arguments.quiet)
}

/// Everything that a running case consists of.
struct Run {
    coupling: Coupling<OpenFoam, Structure>,
    record: Record,
    cells: usize,
    fluid_peak_memory: f64,
}

fn load(arguments: &Arguments) -> Result<Case, Failure> {
    let mut overrides = Vec::new();
    if let Some(end) = arguments.end_time {
        overrides.push(("time.end_s".to_owned(), format!("{end:?}")));
    }
    if let Some(ranks) = arguments.ranks {
        overrides.push(("fluid.ranks".to_owned(), ranks.to_string()));
    }
    for pair in &arguments.overrides {
        let (key, value) = pair.split_once('=').ok_or_else(|| {
            Failure::Input(format!("--set {pair}: expected KEY=VALUE, such as coupling.e_rel=1e-6"))
        })?;
        overrides.push((key.trim().to_owned(), value.trim().to_owned()));
    }
    Case::load(&arguments.case, arguments.preset, &overrides).map_err(|e| Failure::Input(e.to_string()))
}

/// Set by Ctrl-C, SIGTERM and SIGHUP; a second one ends the process at once (OpenFOAM then ends by itself).
fn interrupt_flag() -> std::io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register_conditional_shutdown(signal, 130, flag.clone())?;
        signal_hook::flag::register(signal, flag.clone())?;
    }
    Ok(flag)
}
