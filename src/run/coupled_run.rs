//! A run in its folder: the simulation of a case, its record and its progress.

use super::{Failure, Interrupt, RunFolder, run_failure, written};
use crate::case::{Case, RunEnds};
use crate::fluid::{Fluid, FluidError};
use crate::output::progress::Progress;
use crate::output::record::{self, Record, RecordSettings};
use crate::output::terminal;
use crate::pfem::{Structure, solution::structure};
use crate::simulation::assembly::{AssemblyError, CoupledModel, Unloading, Workplace};
use crate::simulation::{Checkpoints, Simulation, SimulationError, checkpoint};
use std::path::{Path, PathBuf};

/// The state of a run.
pub type RunCheckpoint =
    checkpoint::Checkpoint<structure::StructureMemory, (record::RecordMemory, ())>;
/// A checkpoint of a run that was found.
pub type Found = checkpoint::Found<structure::StructureMemory, (record::RecordMemory, ())>;

/// A running case.
pub struct CoupledRun {
    pub(super) case_folder: PathBuf,
    pub(super) case: Case,
    pub(super) folder: RunFolder,
    interrupt: Interrupt,
    /// The simulation.
    pub simulation: Simulation<Box<dyn Fluid>, Structure, (Record, Progress)>,
    /// Cells of the fluid.
    pub fluid_cells: usize,
    /// Where the unloaded shape of the wall comes from, if it is not the given one.
    pub(super) unloading: Option<Unloading>,
}

impl CoupledRun {
    /// Builds meshes and solvers and starts the fluid, in the state of `checkpoint` or at rest.
    pub fn assemble(
        path: &Path,
        case: &Case,
        folder: RunFolder,
        checkpoint: Option<&RunCheckpoint>,
        interrupt: Interrupt,
        quiet: bool,
    ) -> Result<Self, Failure> {
        let workplace = Workplace {
            interrupt: interrupt.of_the_start(),
            tell: Some(|what| terminal::note(what)),
            ..folder.workplace()
        };
        let memory = checkpoint.map(|checkpoint| &checkpoint.fluid);
        let model = CoupledModel::new(case, workplace, memory).map_err(|error| match error {
            AssemblyError::Fluid(FluidError::Interrupted) => {
                Failure::Interrupted("no step was taken".into())
            }
            error => run_failure(error),
        })?;
        let (settings, solid) = (
            RecordSettings::of(case, &folder, &model),
            &model.coupling.solid,
        );
        let record = match checkpoint {
            Some(checkpoint) => Record::resume(settings, solid, checkpoint.observer.0.clone()),
            None => Record::create(settings, solid),
        };
        let progress = Progress::new(RunEnds::of(case), quiet);
        let observer = (record.map_err(run_failure)?, progress);
        let checkpoints = Checkpoints::of(case, folder.checkpoints()).map_err(written)?;
        let simulation = Simulation::of(case, model.coupling, observer);
        let mut run = Self {
            // A folder such as "." has no name by itself.
            case_folder: match path.file_name() {
                Some(_) => path.to_owned(),
                None => path.canonicalize().unwrap_or_else(|_| path.to_owned()),
            },
            case: case.clone(),
            folder,
            interrupt,
            simulation: simulation.with_checkpoints(checkpoints),
            fluid_cells: model.fluid_cells,
            unloading: model.unloading,
        };
        if let Some(checkpoint) = checkpoint {
            run.simulation.resume(checkpoint).map_err(failure)?;
        }
        Ok(run)
    }

    /// Degrees of freedom of the structure.
    pub fn degrees_of_freedom(&self) -> usize {
        self.simulation.coupling.solid.body().degrees_of_freedom()
    }

    /// Writes a checkpoint of the last accepted step.
    pub fn save(&mut self) -> Result<(), Failure> {
        self.simulation.save().map_err(failure)
    }

    /// Goes on to the last step; ends early at an interrupt, or at a failure that no rescue helps against.
    pub fn advance(&mut self) -> Result<(), Failure> {
        let interrupt = self.interrupt.clone();
        self.simulation.observer.1.begin();
        let outcome = self.simulation.run(&|| interrupt.asked());
        if outcome.is_ok() {
            self.simulation.observer.1.finish();
        }
        outcome.map_err(failure)
    }
}

fn failure(error: SimulationError) -> Failure {
    match error {
        SimulationError::Interrupted => Failure::Interrupted(String::new()),
        error => run_failure(error),
    }
}
