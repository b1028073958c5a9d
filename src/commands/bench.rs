//! `fsi-driver bench`: where the seconds of a coupled time step go.
//!
//! A fixed number of steps is taken from a warm state, a pressurised and pulsating one, because the unloaded start is
//! not what a run consists of. The warm state is the checkpoint of an ordinary run, made once and kept; the steps are
//! taken in a copy of it.

use super::{CaseArguments, Failure};
use crate::measurement::{BudgetReport, Measurement, growth};
use crate::output::terminal;
use crate::run::Interrupt;
use crate::simulation::assembly::surroundings;
use std::path::PathBuf;

/// Options of the benchmark.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the case, with its case.toml.
    #[arg(long, value_name = "DIR")]
    case: PathBuf,
    #[command(flatten)]
    chosen: CaseArguments,
    /// Time steps to take.
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..))]
    steps: u32,
    /// Folder of the run that provides the warm state; made or completed if need be [default: <case>/warm-<preset>].
    #[arg(long, value_name = "DIR")]
    warm: Option<PathBuf>,
    /// Time of the warm state in seconds; by default one beat after the start.
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    from: f64,
    /// File for the figures, to compare another version with.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Figures of another version, to be shown next to the new ones.
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Measure finer and finer meshes of the case instead, and write a table and a plot of how the cost grows into this
    /// folder; sizes that are there already are not measured again. Each one is warmed up: give a small --from.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["warm", "json", "compare"])]
    growth: Option<PathBuf>,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
}

/// Measures, prints, compares.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.from.is_nan() || arguments.from <= 0.0 {
        return Err(Failure::Input(format!(
            "--from {}: expected a time above 0 s, at which the run is warm",
            arguments.from
        )));
    }
    let selection = arguments.chosen.selection()?;
    let measurement = Measurement {
        case: &arguments.case,
        selection: &selection,
        from: arguments.from,
        steps: arguments.steps,
        quiet: arguments.quiet,
    };
    let case = measurement.warm_case()?;
    surroundings::check_installed(&case).map_err(|e| Failure::Input(e.to_string()))?;
    let old = arguments
        .compare
        .as_deref()
        .map(BudgetReport::read)
        .transpose()?;
    if let Some(old) = &old {
        old.check(&arguments.chosen.preset.to_string(), &case)?;
    }
    let then = (!arguments.quiet).then_some(crate::measurement::STEPS_END);
    let interrupt = Interrupt::listen(then)?;
    if let Some(folder) = &arguments.growth {
        return growth::measure(&measurement, &case, folder, &interrupt);
    }
    let warm = (arguments.warm.clone()).unwrap_or_else(|| {
        arguments
            .case
            .join(format!("warm-{}", arguments.chosen.preset))
    });
    let report = measurement.take(&warm, &interrupt)?;
    terminal::print(report.table(old.as_ref()))?;
    (arguments.json.iter()).try_for_each(|path| report.write(path))
}
