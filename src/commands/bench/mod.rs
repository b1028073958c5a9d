//! `fsi-driver bench`: where the seconds of a coupled time step go.
//!
//! A fixed number of steps is taken from a warm state, a pressurised and pulsating one, because the unloaded start is
//! not what a run consists of. The warm state is the checkpoint of an ordinary run, made once and kept; the steps are
//! taken in a copy of it.

mod budget;
mod growth;
mod warm;

use super::Failure;
use super::case_arguments::CaseArguments;
use super::run::{CoupledRun, Interrupt};
use crate::case::ResolvedCase;
use crate::fluid::FluidError;
use crate::fluid::openfoam::install;
use crate::output::terminal;
use budget::{Budget, Report};
use std::path::{Path, PathBuf};

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
    let case = arguments.warm_case(&arguments.chosen)?;
    install::check(case.fluid.ranks).map_err(|e| Failure::Input(e.to_string()))?;
    let old = arguments.compare.as_deref().map(Report::read).transpose()?;
    if let Some(old) = &old {
        old.check(&arguments.chosen.preset.to_string(), &case)?;
    }
    let then = (!arguments.quiet).then_some("the time step is finished");
    let interrupt = Interrupt::listen(then)?;
    if let Some(folder) = &arguments.growth {
        return growth::measure(arguments, &case, folder, &interrupt);
    }
    let warm = (arguments.warm.clone()).unwrap_or_else(|| {
        arguments
            .case
            .join(format!("warm-{}", arguments.chosen.preset))
    });
    let report = arguments.measure(&arguments.chosen, &warm, &interrupt)?;
    terminal::print(report.table(old.as_ref()))?;
    (arguments.json.iter()).try_for_each(|path| report.write(path))
}

impl Arguments {
    /// The case until the warm state.
    fn warm_case(&self, chosen: &CaseArguments) -> Result<ResolvedCase, Failure> {
        let chosen = chosen.clone().with("time.end_s", self.from);
        chosen.load(&self.case)
    }

    /// The figures of the case as it was `chosen`, from the warm state in the folder `warm`.
    fn measure(
        &self,
        chosen: &CaseArguments,
        warm: &Path,
        interrupt: &Interrupt,
    ) -> Result<Report, Failure> {
        let case = self.warm_case(chosen)?;
        let warm = warm::state(&self.case, &case, warm, interrupt, self.quiet)?;
        let begin = warm.checkpoint.time();
        let end = begin + f64::from(self.steps) * case.time.step;
        let measured = chosen.clone().with("time.end_s", end).load(&self.case)?;
        let mut run = CoupledRun::assemble(
            &self.case,
            &measured,
            warm.folder,
            Some(&warm.checkpoint),
            interrupt.clone(),
            self.quiet,
        )?;
        let per_step = take_steps(&mut run)?;
        Ok(Report {
            version: env!("CARGO_PKG_VERSION").into(),
            case: self.case.display().to_string(),
            preset: chosen.preset.to_string(),
            fluid_cells: run.fluid_cells,
            structure_dofs: run.degrees_of_freedom(),
            ranks: case.fluid.ranks,
            threads: rayon::current_num_threads(),
            from_s: begin,
            steps: self.steps as usize,
            per_step,
        })
    }
}

fn take_steps(run: &mut CoupledRun) -> Result<Budget, Failure> {
    let failed = |e: FluidError| Failure::Run(format!("cannot read what was measured: {e}"));
    let meter = budget::Meter::start(run).map_err(failed)?;
    run.advance()?;
    let budget = meter.stop(run);
    budget.map_err(failed)
}
