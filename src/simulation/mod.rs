//! A coupled run: time steps one after the other, rescued where one fails, kept in checkpoints, watched by observers.
//!
//! [`Simulation`] knows no file but its checkpoints and no user; what a run leaves is written by its [`Observer`]s.
//! [`assembly`] builds everything that a simulation consists of from a case.

pub mod assembly;
pub mod checkpoint;
pub(crate) mod clock;
pub mod observer;
mod rescue;
pub(crate) mod subdivision;
pub(crate) mod totals;

use crate::case::CaseIdentity;
use crate::coupling::fixed_point::FixedPointMemory;
use crate::coupling::{Coupling, FailedStep, diagnosis};
use crate::files::{FileFingerprint, below};
use crate::fluid::{Fluid, FluidEffort, FluidError, FluidStep, FluidUsage, Wanted};
use crate::pfem::{Solid, SolidError};
use checkpoint::{Checkpoint, Store, StoreError};
pub(crate) use clock::is_due;
use clock::{Clock, ClockReading};
use observer::{AcceptedStep, AcceptedWall, Note, Observer};
use rescue::Troubles;
use std::io;
use std::time::Instant;
use totals::Totals;

/// From so long a step on (s) what a checkpoint needs is kept while the next one is solved.
const SLOW: f64 = 1.0;

/// Choices of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationSettings {
    /// A step that fails is cut in halves at most so often.
    pub max_halvings: usize,
    /// Intervals in which the fluid leaves its fields on disk, s.
    pub fluid_interval: f64,
}

/// Where checkpoints go, and whose they are.
#[derive(Debug)]
pub struct Checkpoints {
    /// Their folder.
    pub store: Store,
    /// Minutes of wall-clock time from one to the next; 0 writes one after each step.
    pub interval_minutes: f64,
    /// The case, by which a run that resumes there is recognized.
    pub case: CaseIdentity,
}

/// Why a simulation ended before its last step.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// The user asked it to end; the last step is in a checkpoint, if there are any.
    #[error("interrupted")]
    Interrupted,
    /// A step failed, and no attempt helped.
    #[error("{0}")]
    Step(String),
    /// The fluid could not go back to a checkpoint, or could not tidy up.
    #[error(transparent)]
    Fluid(#[from] FluidError),
    /// The structure could not be evaluated, or a checkpoint is not one of it.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// The checkpoint is one of another coupling.
    #[error(transparent)]
    Coupling(#[from] crate::coupling::fixed_point::ForeignMemory),
    /// A checkpoint could not be written.
    #[error("cannot write a checkpoint: {0}")]
    Save(String),
    /// Old checkpoints could not be removed.
    #[error("cannot remove old checkpoints: {0}")]
    Tidy(#[source] StoreError),
    /// No checkpoint could be read.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// An observer could not write.
    #[error("cannot write the results: {0}")]
    Results(#[from] io::Error),
}

/// A coupled problem in time, from its first step to its last.
pub struct Simulation<F, S: Solid, O> {
    /// The two solvers.
    pub coupling: Coupling<F, S>,
    /// Who watches.
    pub observer: O,
    clock: Clock,
    settings: SimulationSettings,
    /// Work that the fluid may spend on an iteration of a step's first attempt.
    effort: FluidEffort,
    checkpoints: Option<Checkpoints>,
    totals: Totals,
    /// The accepted step of which the observer has not been told yet.
    untold: Option<AcceptedStep>,
    /// The steps that make trouble.
    troubles: Troubles,
    /// The step after which the run ends with a checkpoint, and why, if the next one has been given up.
    last_good: Option<(usize, String)>,
    /// What the checkpoint needs of structure and coupling if the step that is being solved is given up; kept where
    /// steps take long.
    beginning: Option<(S::Memory, FixedPointMemory)>,
    /// Wall-clock time of the last step, s.
    pace: f64,
    /// When the last checkpoint was written.
    saved: Instant,
    /// Since when wall-clock time is not in the totals yet.
    started: Instant,
    fluid_usage: FluidUsage,
    fluid_seconds: Vec<(String, f64)>,
}

/// Why no step was taken.
enum Stop {
    /// The step failed; both solvers, if they live, still have the state before it.
    Step(Box<FailedStep>),
    /// The simulation cannot go on.
    Simulation(SimulationError),
}

impl<E: Into<SimulationError>> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::Simulation(error.into())
    }
}

impl<F: Fluid, S: Solid, O: Observer<S>> Simulation<F, S, O> {
    /// A simulation at the start of its first step.
    pub fn new(
        coupling: Coupling<F, S>,
        clock: Clock,
        settings: SimulationSettings,
        observer: O,
    ) -> Self {
        Self {
            effort: coupling.settings.fluid_effort,
            coupling,
            observer,
            clock,
            settings,
            checkpoints: None,
            totals: Totals::default(),
            untold: None,
            troubles: Troubles::default(),
            last_good: None,
            beginning: None,
            pace: 0.0,
            saved: Instant::now(),
            started: Instant::now(),
            fluid_usage: FluidUsage::default(),
            fluid_seconds: Vec::new(),
        }
    }

    /// The same with checkpoints, without which a fluid that dies ends it.
    pub fn with_checkpoints(self, checkpoints: Checkpoints) -> Self {
        Self {
            checkpoints: Some(checkpoints),
            ..self
        }
    }

    /// Goes on where `checkpoint` was written, perhaps by an earlier process; the observer was made as of then.
    ///
    /// # Errors
    /// If it is the checkpoint of another simulation, or the fluid cannot go there.
    pub fn resume(
        &mut self,
        checkpoint: &Checkpoint<S::Memory, O::Memory>,
    ) -> Result<(), SimulationError> {
        self.recall(checkpoint)?;
        self.totals.resumed += 1;
        // What an earlier process could not remove; after its last step nobody would do so.
        self.tidy()
    }

    /// Goes on to the last step. `interrupted` is asked before each step and, lest it be lost, before one is accepted.
    ///
    /// # Errors
    /// At an interrupt, or at a failure that no rescue helps against. The simulation can be continued from its newest
    /// checkpoint.
    pub fn run(&mut self, interrupted: &dyn Fn() -> bool) -> Result<(), SimulationError> {
        if self.checkpoints.is_some() && self.clock.steps() == 0 && !self.is_saved() {
            self.save()?; // so that there is always one to go back to
        }
        while !(self.clock.is_over() || self.is_enough()?) {
            if interrupted() && self.is_saved() {
                return Err(SimulationError::Interrupted);
            }
            if let Some((last, reason)) = &self.last_good
                && *last == self.clock.steps()
            {
                return Err(SimulationError::Step(reason.clone()));
            }
            match self.step(interrupted) {
                Ok(()) => {}
                Err(Stop::Step(failed)) if failed.is_interrupt() => {
                    self.keep_beginning()?;
                    return Err(SimulationError::Interrupted);
                }
                Err(Stop::Step(failed)) => {
                    let what = self.rescue(*failed)?;
                    self.observer.note(&Note::Rescue(what));
                }
                Err(Stop::Simulation(error)) => return Err(error),
            }
        }
        Ok(())
    }

    /// Whether observers end the simulation here, before its last step. Asked of what they have written alone, so that
    /// a resumed run ends where the uninterrupted one does.
    fn is_enough(&self) -> Result<bool, SimulationError> {
        let ClockReading { steps, subdivision } = self.clock.reading();
        let may_end = subdivision.done() == 0 && self.clock.may_end_after(steps);
        Ok(may_end && self.observer.has_seen_enough()?)
    }

    /// Takes one step, or a part of it, and writes a checkpoint if one is due. The observer learns of it while the
    /// fluid works at the next one, or at once where a checkpoint follows or perhaps no other step.
    fn step(&mut self, interrupted: &dyn Fn() -> bool) -> Result<(), Stop> {
        let (started, attempt) = (Instant::now(), self.attempt());
        let (number, length) = (self.clock.steps() + 1, self.clock.part());
        let completes = self.clock.completes();
        let (mut told, untold) = (Ok(()), self.untold.take());
        let is_slow = self.pace > SLOW && attempt == 1 && self.checkpoints.is_some();
        self.beginning = is_slow.then(|| self.memories());
        self.coupling.begin_step(self.clock.next_time());
        let solved = self.coupling.solve_with_background_work(|solid| {
            if let Some(step) = untold {
                told = tell(&mut self.observer, &step, solid);
            }
        });
        told?;
        let solved = solved.map_err(|e| Stop::Step(Box::new(e)))?;
        let saving = completes && self.is_checkpoint_due(number, interrupted());
        let fields = completes && self.is_fluid_due(number);
        let wanted = Wanted {
            state: saving,
            field: fields,
        };
        let step = self.coupling.accept(solved, wanted);
        let step = step.map_err(|e| Stop::Step(Box::new(e)))?;
        self.see_usage(&step.fluid);
        if let Some(text) = self.slowness(&step.iterations) {
            let time = step.fluid.time;
            self.observer.note(&Note::Slow { time, text });
        }
        let notices = [
            self.coupling.fixed_point.notice(),
            self.coupling.solid.notice(),
        ];
        for text in notices.into_iter().flatten() {
            let time = step.fluid.time;
            self.observer.note(&Note::Notice { time, text });
        }
        let accepted = AcceptedStep {
            number,
            may_be_last: self.clock.may_end_after(number),
            completes,
            time_step: self.clock.time_step(),
            length,
            attempt,
            seconds: started.elapsed().as_secs_f64(),
            step,
        };
        self.clock.advance();
        let at_once = saving || accepted.may_be_last && completes;
        if at_once {
            tell(&mut self.observer, &accepted, &self.coupling.solid)?;
        }
        let seconds = started.elapsed().as_secs_f64();
        self.pace = seconds;
        let steps = self.clock.steps();
        (self.totals).add(&accepted.step, steps, seconds, self.effort.residual);
        self.untold = (!at_once).then_some(accepted);
        if saving {
            self.save()?;
        }
        Ok(())
    }

    /// Whether a checkpoint is to be written after the step `number`, which is about to be accepted.
    fn is_checkpoint_due(&self, number: usize, interrupted: bool) -> bool {
        let Some(checkpoints) = &self.checkpoints else {
            return false;
        };
        let waited = self.saved.elapsed().as_secs_f64() / 60.0;
        let is_last_good = self.last_good.as_ref().is_some_and(|good| good.0 == number);
        let is_last = self.clock.may_end_after(number) || is_last_good;
        waited >= checkpoints.interval_minutes || interrupted || is_last
    }

    /// Whether the fluid is to leave its fields on disk after the step `number`.
    fn is_fluid_due(&self, number: usize) -> bool {
        let interval = self.settings.fluid_interval;
        self.clock.may_end_after(number) || is_due(number, self.clock.time_step(), interval)
    }

    /// Why the step that has just been accepted was slow, if it was.
    fn slowness(&self, iterations: &[crate::coupling::Iteration]) -> Option<String> {
        let Totals {
            steps,
            coupling_iterations,
            ..
        } = self.totals;
        let limit = self.coupling.settings.fluid_effort.max_sweeps;
        let all = coupling_iterations + iterations.len();
        let usual = coupling_iterations as f64 / steps as f64;
        let slow = (steps > 0).then(|| diagnosis::slowness(iterations, usual, limit));
        (slow.flatten()).or_else(|| diagnosis::tiring(steps + 1, all, iterations, limit))
    }

    /// Where it is in time.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The figures so far.
    pub fn totals(&self) -> Totals {
        Totals {
            wall_s: self.totals.wall_s + self.started.elapsed().as_secs_f64(),
            ..self.totals.clone()
        }
    }

    /// What the fluid's processes have used until the last accepted step.
    pub fn fluid_usage(&self) -> FluidUsage {
        self.fluid_usage
    }

    /// Seconds by part of the fluid's work until the last accepted step after which it knew them.
    pub fn fluid_seconds(&self) -> &[(String, f64)] {
        &self.fluid_seconds
    }

    fn see_usage(&mut self, step: &FluidStep) {
        let peak_memory = self.fluid_usage.peak_memory.max(step.usage.peak_memory);
        self.fluid_usage = FluidUsage {
            peak_memory,
            ..step.usage
        };
        if !step.seconds_by_part.is_empty() {
            self.fluid_seconds.clone_from(&step.seconds_by_part);
        }
    }

    /// Whether the last accepted step is in a checkpoint, if there are any.
    fn is_saved(&self) -> bool {
        let Some(checkpoints) = &self.checkpoints else {
            return true;
        };
        let reading = self.clock.reading();
        reading.subdivision.done() == 0 && checkpoints.store.path(reading.steps).exists()
    }

    /// Writes a checkpoint of the last accepted step, which the fluid has written, and removes what is not needed any
    /// more.
    ///
    /// # Errors
    /// If it cannot be written; the checkpoints before it stay.
    pub fn save(&mut self) -> Result<(), SimulationError> {
        self.save_with(self.memories())
    }

    /// What a checkpoint needs of structure and coupling.
    fn memories(&self) -> (S::Memory, FixedPointMemory) {
        (
            self.coupling.solid.memory(),
            self.coupling.fixed_point.memory(),
        )
    }

    /// Writes a checkpoint of the last accepted step after the next one has been given up, if what that needs was kept;
    /// the newest one serves otherwise.
    fn keep_beginning(&mut self) -> Result<(), SimulationError> {
        match self.beginning.take() {
            Some(memories) if self.clock.reading().subdivision.done() == 0 && !self.is_saved() => {
                self.save_with(memories)
            }
            _ => Ok(()),
        }
    }

    fn save_with(
        &mut self,
        (structure, coupling): (S::Memory, FixedPointMemory),
    ) -> Result<(), SimulationError> {
        let clock = Instant::now();
        let Some(checkpoints) = &self.checkpoints else {
            return Ok(());
        };
        let failed = |what: &dyn std::fmt::Display| SimulationError::Save(what.to_string());
        let root = checkpoints.store.root();
        let step = self.clock.steps();
        let kept = checkpoints.store.kept(step).map_err(|e| failed(&e))?;
        let (time_step, interval) = (self.clock.time_step(), self.settings.fluid_interval);
        let done = self.totals.time_s + 0.5 * time_step;
        let needed = |time: f64| {
            let step = (time / time_step).round() as usize;
            let needed = step == 0 || kept.contains(&step) || is_due(step, time_step, interval);
            time < done && needed
        };
        let mut fluid = (self.coupling.fluid.memory(&needed)).map_err(|e| failed(&e))?;
        let observer = self.observer.memory().map_err(|e| failed(&e))?;
        let tables = self.observer.files(&observer).into_iter();
        let tables = tables.filter(|(_, length)| *length > 0);
        let mut files: Vec<_> = tables.map(|(path, length)| (path, Some(length))).collect();
        for file in &mut fluid.files {
            files.push((file.clone(), None));
            *file = below(root, file).to_owned();
        }
        let fingerprint = |(path, length): (std::path::PathBuf, Option<u64>)| {
            FileFingerprint::of(root, below(root, &path), length)
        };
        let files: io::Result<Vec<_>> = files.into_iter().map(fingerprint).collect();
        let checkpoint = Checkpoint {
            case: checkpoints.case.clone(),
            files: files.map_err(|e| failed(&e))?,
            clock: self.clock.reading(),
            totals: self.totals(),
            fluid,
            structure,
            coupling,
            balance: self.coupling.balance.clone(),
            observer,
        };
        let written = checkpoints.store.write(&checkpoint);
        written.map_err(|e| failed(&e))?;
        self.tidy()?;
        self.saved = Instant::now();
        self.totals.checkpoint_s += clock.elapsed().as_secs_f64();
        Ok(())
    }

    /// Removes checkpoints that are not needed once the last accepted step is in one.
    fn tidy(&self) -> Result<(), SimulationError> {
        match &self.checkpoints {
            Some(checkpoints) => {
                (checkpoints.store.tidy(self.clock.steps())).map_err(SimulationError::Tidy)
            }
            None => Ok(()),
        }
    }

    /// Gives solvers, coupling, clock and totals the state of a checkpoint.
    fn recall(
        &mut self,
        checkpoint: &Checkpoint<S::Memory, O::Memory>,
    ) -> Result<(), SimulationError> {
        let mut fluid = checkpoint.fluid.clone();
        if let Some(checkpoints) = &self.checkpoints {
            for file in &mut fluid.files {
                *file = checkpoints.store.root().join(&*file);
            }
        }
        self.coupling.fluid.recall(&fluid)?;
        self.clock.set(checkpoint.clock);
        // Before the coupling remembers: another length makes it forget.
        self.coupling.set_time_step(self.clock.part());
        (self.coupling.fixed_point).recall(checkpoint.coupling.clone())?;
        self.coupling.balance = checkpoint.balance.clone();
        self.coupling.solid.recall(checkpoint.structure.clone())?;
        self.totals = checkpoint.totals.clone();
        self.untold = None;
        self.started = Instant::now();
        Ok(())
    }

    /// Goes back to a checkpoint of this process; only the failures since then are remembered.
    fn go_back(
        &mut self,
        checkpoint: &Checkpoint<S::Memory, O::Memory>,
    ) -> Result<(), SimulationError> {
        let (failed, restarts) = (self.totals.failed_attempts, self.totals.fluid_restarts);
        self.recall(checkpoint)?;
        (self.totals.failed_attempts, self.totals.fluid_restarts) = (failed, restarts);
        Ok(self.observer.rewind(checkpoint.observer.clone())?)
    }

    /// The newest checkpoint that is whole.
    fn newest(&self) -> Result<checkpoint::Found<S::Memory, O::Memory>, StoreError> {
        match &self.checkpoints {
            Some(checkpoints) => checkpoints.store.newest(),
            None => Err(StoreError::Unwanted),
        }
    }
}

/// Tells an observer of a step that the structure has accepted.
fn tell<S: Solid>(
    observer: &mut impl Observer<S>,
    step: &AcceptedStep,
    solid: &S,
) -> Result<(), SimulationError> {
    let stresses = solid.stress_peaks()?;
    let stresses = &stresses;
    Ok(observer.accepted(step, &AcceptedWall { solid, stresses })?)
}
