//! A run in its folder: who may work there, the checkpoint it goes on from, how it ends; and many of them at once.

pub mod batch;
mod conclude;
mod coupled_run;
mod failure;
mod folder;
mod interrupt;
mod judgement;
mod lock;
mod new_tables;
mod resumption;
mod selection;
mod status;

use crate::analysis::case_figures::step_is_large;
use crate::case::ResolvedCase;
use crate::output::run_files::RunFiles;
use crate::output::{terminal, write_atomically};
use crate::simulation::assembly::{preflight, surroundings};
pub use coupled_run::{CoupledRun, RunCheckpoint};
pub use failure::Failure;
pub use folder::at_work;
pub use folder::{Earlier, RunFolder};
pub use interrupt::{CHECKPOINT_IS_WRITTEN, Interrupt, START_IS_ABANDONED};
pub use resumption::newest;
pub use selection::{CaseSelection, warn};
use std::path::Path;
use std::time::Instant;

/// What is to be run, and where.
pub struct RunRequest<'a> {
    /// Folder of the case.
    pub path: &'a Path,
    /// The case.
    pub case: &'a ResolvedCase,
    /// Folder of the results.
    pub out: &'a Path,
    /// What to do with an earlier run there.
    pub earlier: Earlier,
    /// Whether to show no progress.
    pub quiet: bool,
}

impl RunRequest<'_> {
    /// Runs the case until its end or an `interrupt`.
    pub fn execute(&self, interrupt: Interrupt) -> Result<(), Failure> {
        interrupt.then(START_IS_ABANDONED);
        let case = self.case;
        surroundings::check_installed(case)
            .and_then(|()| surroundings::check_folder(case, self.out))
            .map_err(|e| Failure::Input(e.to_string()))?;
        if self.earlier != Earlier::Resume {
            preflight::try_fluid(case, interrupt.of_the_start())?;
        }
        let folder = RunFolder::open(self.out, self.earlier)?;
        let outcome = self.execute_in(folder, interrupt);
        outcome.map_err(|failure| match failure {
            Failure::Run(reason) => {
                let hint = step_is_large(case).map_or(String::new(), |hint| format!("\n{hint}"));
                Failure::Run(reason + &hint + &resumption::way_back(&RunFiles::new(self.out)))
            }
            failure => failure,
        })
    }

    fn execute_in(&self, folder: RunFolder, interrupt: Interrupt) -> Result<(), Failure> {
        let case = self.case;
        let checkpoint = match self.earlier {
            Earlier::Resume => resumption::checkpoint(&folder, case)?,
            Earlier::ResumeWithoutTables => {
                Some(resumption::checkpoint_without_tables(&folder, case)?)
            }
            Earlier::Keep | Earlier::Replace => None,
        };
        write_atomically(&folder.resolved_case(), case.to_toml_string().as_bytes())
            .map_err(written)?;

        let clock = Instant::now();
        let mut run = CoupledRun::assemble(
            self.path,
            case,
            folder,
            checkpoint.as_ref(),
            interrupt.clone(),
            self.quiet,
        )?;
        if self.earlier == Earlier::ResumeWithoutTables {
            run.save()?; // a checkpoint that stands on the new tables
        }
        if !self.quiet {
            warn(case);
            terminal::note(format_args!(
                "{}: {} fluid {}, {} structural degrees of freedom, {}; ready in {:.1} s",
                self.path.display(),
                run.fluid_cells,
                case.fluid.solver.pieces(),
                run.degrees_of_freedom(),
                case.steps_told(),
                clock.elapsed().as_secs_f64(),
            ));
        }
        interrupt.then(CHECKPOINT_IS_WRITTEN);
        let outcome = run.advance();
        run.conclude(outcome, self.quiet)
    }
}

fn run_failure(error: impl std::fmt::Display) -> Failure {
    Failure::Run(error.to_string())
}

fn written(error: std::io::Error) -> Failure {
    Failure::Run(format!("cannot write the results: {error}"))
}
