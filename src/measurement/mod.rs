//! What coupled steps cost: the seconds of a step by part, how they grow with the meshes, and what the acceleration
//! models make of them.

mod budget;
pub mod growth;
pub mod models;
mod warm;

use crate::case::ResolvedCase;
use crate::run::{CaseSelection, CoupledRun, Failure, Interrupt};
use budget::Budget;
pub use budget::BudgetReport;
use std::path::Path;

/// What is done when the user asks a measurement to end.
pub const STEPS_END: &str = "the time step is finished";

/// Steps of a case that are measured.
pub struct Measurement<'a> {
    /// Folder of the case.
    pub case: &'a Path,
    /// Preset and values that replace those of the case.
    pub selection: &'a CaseSelection,
    /// Time of the warm state, s.
    pub from: f64,
    /// Number of steps.
    pub steps: u32,
    /// Whether to show no progress.
    pub quiet: bool,
}

impl Measurement<'_> {
    /// The case until the warm state.
    ///
    /// # Errors
    /// All mistakes in the case.
    pub fn warm_case(&self) -> Result<ResolvedCase, Failure> {
        self.case_until(self.from)
    }

    /// The case until a time (s), whether it is periodic before or not.
    fn case_until(&self, end: f64) -> Result<ResolvedCase, Failure> {
        let selection = self.selection.clone().with("time.end_s", end);
        let mut case = selection.load(self.case)?;
        case.case.time.until_periodic = None;
        Ok(case)
    }

    /// The figures, from the warm state in the folder `warm`, which is made or completed if need be.
    ///
    /// # Errors
    /// If the run there is another one, or a step fails.
    pub fn take(&self, warm: &Path, interrupt: &Interrupt) -> Result<BudgetReport, Failure> {
        let case = self.warm_case()?;
        let warm = warm::state(self.case, &case, warm, interrupt, self.quiet)?;
        interrupt.then(STEPS_END);
        let begin = warm.checkpoint.time();
        let end = begin + f64::from(self.steps) * case.time.step;
        let measured = self.case_until(end)?;
        let mut run = CoupledRun::assemble(
            self.case,
            &measured,
            warm.folder,
            Some(&warm.checkpoint),
            interrupt.clone(),
            self.quiet,
        )?;
        let per_step = take_steps(&mut run)?;
        Ok(BudgetReport {
            version: env!("CARGO_PKG_VERSION").into(),
            case: self.case.display().to_string(),
            preset: self.selection.preset.to_string(),
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
    let meter = budget::Meter::start(run);
    run.advance()?;
    Ok(meter.stop(run))
}
