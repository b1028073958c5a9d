//! The end of a run, good or bad.

use super::coupled_run::CoupledRun;
use super::judgement::Judgement;
use super::resumption::way_back;
use super::{Failure, RunFolder, written};
use crate::case::Solver;
use crate::output::progress::human;
use crate::output::record::{Ending, RunSummary};
use crate::output::{results, terminal};
use crate::simulation::assembly::surroundings;
use std::path::PathBuf;

impl CoupledRun {
    /// Ends the fluid, writes the summary, and names the files.
    pub fn conclude(self, outcome: Result<(), Failure>, quiet: bool) -> Result<(), Failure> {
        let (status, reason) = match &outcome {
            Ok(()) => ("complete", None),
            Err(failure @ Failure::Interrupted(_)) => ("interrupted", Some(failure.to_string())),
            Err(failure) => ("failed", Some(failure.to_string())),
        };
        let record = &self.simulation.observer.0;
        // The summary is written also of a run whose tables cannot be read.
        let (judgement, unread) = match Judgement::of(&self.case, &self.folder, record) {
            Ok(judgement) => (judgement, Ok(())),
            Err(error) => (Judgement::default(), Err(error)),
        };
        let ending = Ending {
            resolution: judgement.resolution.clone(),
            steadiness: judgement.steadiness.clone(),
            periodic: judgement.periodic.clone(),
            openings: judgement.openings.clone(),
            status,
            reason,
            case: self.case_folder.clone(),
            openfoam: surroundings::openfoam(self.case.fluid.solver),
            fluid_cells: self.fluid_cells,
            structure_dofs: self.degrees_of_freedom(),
            unloading: self.unloading,
            fluid_peak_memory: self.simulation.fluid_usage().peak_memory,
        };
        let Self {
            simulation,
            folder,
            case,
            ..
        } = self;
        let totals = simulation.totals();
        drop(simulation.coupling); // ends the fluid
        let (record, _) = simulation.observer;
        let summary = RunSummary::new(ending, totals);
        let written_down = (summary.write(&folder.summary()))
            .and_then(|()| judgement.write(&folder))
            .and(unread);
        let summarized = written_down.and_then(|()| {
            let (wall, statistics) = (record.wall().monitor().wall(), record.wall().statistics());
            results::evaluate(&folder, &folder, &case, wall, statistics)
        });
        match outcome {
            Ok(()) => {
                let hemodynamics = summarized.map_err(written)?;
                if !quiet {
                    let closing_text = closing_text(&summary, &folder, case.fluid.solver);
                    let judged = judgement.lines();
                    terminal::print(format_args!("{closing_text}\n{hemodynamics}{judged}"))?;
                }
                Ok(())
            }
            // What ended the run says more than that the summary could not be written either.
            Err(Failure::Interrupted(_)) => Err(Failure::Interrupted(format!(
                "{} steps (t = {:.4} s) are in {}{}",
                summary.totals.steps,
                summary.totals.time_s,
                folder.root().display(),
                way_back(&folder)
            ))),
            Err(failure) => Err(failure),
        }
    }
}

fn closing_text(summary: &RunSummary, folder: &RunFolder, solver: Solver) -> String {
    let shown = |path: PathBuf| path.display().to_string();
    let fields = surroundings::fields_to_open(solver, &folder.fluid());
    let fields = fields.unwrap_or_else(|| folder.fluid_fields());
    format!(
        "{} steps to t = {:.4} s in {}: {:.2} coupling iterations per step (at most {}), outlet pressure {:.0} Pa\n\
         \n\
         {:<44} one row per time step: flow, pressure, volume, displacement, stress\n\
         {:<44} one row per coupling iteration\n\
         {:<44} the run in figures\n\
         {:<44} one row per time step and region: wall shear, volume, stress\n\
         {:<44} wall shear measures in figures\n\
         {:<44} wall shear measures on the wall: open it in ParaView\n\
         {:<44} the wall over time: open it in ParaView\n\
         {:<44} the blood over time: open it in ParaView\n\
         {:<44} opens wall and blood in ParaView\n\
         {:<44} every value that was used\n",
        summary.totals.steps,
        summary.totals.time_s,
        human(summary.totals.wall_s),
        summary.mean_coupling_iterations,
        summary.totals.max_coupling_iterations,
        summary.totals.p_out_Pa,
        shown(folder.history()),
        shown(folder.iterations()),
        shown(folder.summary()),
        shown(folder.regions()),
        shown(folder.hemodynamics()),
        shown(folder.wall_shear()),
        shown(folder.structure()),
        shown(fields),
        shown(folder.view()),
        shown(folder.resolved_case()),
    )
}
