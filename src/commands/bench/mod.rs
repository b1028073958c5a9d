//! `fsi-driver bench`: where the seconds of a coupled time step go.
//!
//! A fixed number of steps is taken from a warm state, a pressurised and pulsating one, because the unloaded start is
//! not what a run consists of. The warm state is the checkpoint of an ordinary run, made once and kept; the steps are
//! taken in a copy of it.

mod budget;
mod profile;
mod warm;

use super::Failure;
use super::case_arguments::CaseArguments;
use super::run::{Interrupt, Run};
use crate::fluid::openfoam::install;
use crate::output::write_atomically;
use budget::{Budget, Report};
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
    /// Figures of another version, to be shown beside the new ones.
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
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
    let until = |end: f64| {
        let chosen = arguments.chosen.clone().with("time.end_s", end);
        chosen.load(&arguments.case)
    };
    let case = until(arguments.from)?;
    install::check(case.fluid.ranks).map_err(|e| Failure::Input(e.to_string()))?;
    let old = arguments.compare.as_deref().map(Report::read).transpose()?;
    if let Some(old) = &old {
        old.check(&arguments.chosen.preset.to_string(), &case)?;
    }
    let then = (!arguments.quiet).then_some("the time step is finished");
    let interrupt = Interrupt::listen(then)
        .map_err(|e| Failure::Run(format!("cannot listen to signals: {e}")))?;
    let folder = (arguments.warm.clone()).unwrap_or_else(|| {
        arguments
            .case
            .join(format!("warm-{}", arguments.chosen.preset))
    });
    let warm = warm::state(&arguments.case, &case, &folder, &interrupt, arguments.quiet)?;
    let begin = warm.checkpoint.time;
    let measured = until(begin + f64::from(arguments.steps) * case.time.step)?;
    let mut run = Run::assemble(
        &arguments.case,
        &measured,
        warm.folder,
        Some(&warm.checkpoint),
        interrupt,
    )?;
    let budget = take_steps(&mut run, arguments)?;
    let report = Report {
        version: env!("CARGO_PKG_VERSION").into(),
        case: arguments.case.display().to_string(),
        preset: arguments.chosen.preset.to_string(),
        fluid_cells: run.cells,
        structure_dofs: run.coupling.solid.body().degrees_of_freedom(),
        ranks: case.fluid.ranks,
        threads: rayon::current_num_threads(),
        from_s: begin,
        steps: arguments.steps as usize,
        per_step: budget,
    };
    print!("{}", report.table(old.as_ref()));
    if let Some(path) = &arguments.json {
        let text = serde_json::to_string_pretty(&report).expect("plain data can be written");
        write_atomically(path, text.as_bytes())
            .map_err(|e| Failure::Run(format!("cannot write {}: {e}", path.display())))?;
    }
    Ok(())
}

fn take_steps(run: &mut Run, arguments: &Arguments) -> Result<Budget, Failure> {
    let meter = budget::Meter::start(run);
    run.advance(arguments.quiet)?;
    let budget = meter.stop(run);
    budget.map_err(|e| Failure::Run(format!("cannot read what was measured: {e}")))
}
