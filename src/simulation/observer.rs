//! Those who watch a simulation: told of accepted steps, they write tables and fields, or show progress.

use super::clock::is_due;
use crate::coupling::{Iteration, Step};
use crate::pfem::solid::StressPeak;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::io;
use std::path::PathBuf;

/// A time step, or a part of one, that both solvers have accepted.
pub struct AcceptedStep {
    /// What it came to.
    pub step: Step,
    /// Number of the time step, from 1.
    pub number: usize,
    /// Whether it may be the last one.
    pub may_be_last: bool,
    /// Whether the step is whole now.
    pub completes: bool,
    /// Length of a whole step, s.
    pub time_step: f64,
    /// Length of this one or this part of one, s.
    pub length: f64,
    /// Attempt that succeeded, from 1.
    pub attempt: usize,
    /// Seconds from the beginning of the attempt until it was accepted.
    pub seconds: f64,
}

impl AcceptedStep {
    /// Time at its end, s.
    pub fn time(&self) -> f64 {
        self.step.fluid.time
    }

    /// Whether something that is wanted in intervals (s) is due at its end; it always is at the end of what may be the
    /// last step.
    pub fn is_due(&self, interval: f64) -> bool {
        let due = is_due(self.number, self.time_step, interval);
        self.completes && (self.may_be_last || due)
    }
}

/// An attempt at a step that failed.
pub struct FailedAttempt<'a> {
    /// Time at the end of the step, s.
    pub time: f64,
    /// Its number, from 1.
    pub attempt: usize,
    /// The coupling iterations that were done.
    pub iterations: &'a [Iteration],
}

/// Something that the user should know.
#[derive(Debug, Clone, PartialEq)]
pub enum Note {
    /// The step that ended at `time` (s) took many iterations.
    Slow {
        /// Its end, s.
        time: f64,
        /// How many, and what to try.
        text: String,
    },
    /// The structure or the coupling has something to tell after the step that ended at `time` (s).
    Notice {
        /// Its end, s.
        time: f64,
        /// What.
        text: String,
    },
    /// A step failed, and this is done about it.
    Rescue(String),
}

/// The structure at the end of an accepted step.
pub struct AcceptedWall<'a, S> {
    /// The structure.
    pub solid: &'a S,
    /// Largest von Mises stress of each of its elements.
    pub stresses: &'a [StressPeak],
}

/// Watches a simulation, from another thread where the fluid works at the next step already. Pairs of observers are
/// one, and `()` is one that does nothing.
pub trait Observer<S>: Send {
    /// What it needs to continue after the last accepted step.
    type Memory: Clone + Serialize + DeserializeOwned;

    /// A step was accepted.
    fn accepted(&mut self, step: &AcceptedStep, wall: &AcceptedWall<S>) -> io::Result<()>;

    /// An attempt failed.
    fn failed(&mut self, _attempt: &FailedAttempt) -> io::Result<()> {
        Ok(())
    }

    /// Hears what the user should know.
    fn note(&mut self, _note: &Note) {}

    /// Whether the simulation is to end after the last accepted step; asked where the clock allows it, and again after
    /// a resumption there.
    fn has_seen_enough(&self) -> io::Result<bool> {
        Ok(false)
    }

    /// What it needs to continue later; everything so far is on the disk when this returns.
    fn memory(&self) -> io::Result<Self::Memory>;

    /// The files on which that memory stands, with the number of bytes that count.
    fn files(&self, _memory: &Self::Memory) -> Vec<(PathBuf, u64)> {
        Vec::new()
    }

    /// Goes back to the state of `memory`; the steps after it did not happen.
    fn rewind(&mut self, memory: Self::Memory) -> io::Result<()>;
}

impl<S> Observer<S> for () {
    type Memory = ();

    fn accepted(&mut self, _: &AcceptedStep, _: &AcceptedWall<S>) -> io::Result<()> {
        Ok(())
    }

    fn memory(&self) -> io::Result<()> {
        Ok(())
    }

    fn rewind(&mut self, (): ()) -> io::Result<()> {
        Ok(())
    }
}

impl<S, A: Observer<S>, B: Observer<S>> Observer<S> for (A, B) {
    type Memory = (A::Memory, B::Memory);

    fn accepted(&mut self, step: &AcceptedStep, wall: &AcceptedWall<S>) -> io::Result<()> {
        self.0.accepted(step, wall)?;
        self.1.accepted(step, wall)
    }

    fn failed(&mut self, attempt: &FailedAttempt) -> io::Result<()> {
        self.0.failed(attempt)?;
        self.1.failed(attempt)
    }

    fn note(&mut self, note: &Note) {
        self.0.note(note);
        self.1.note(note);
    }

    fn has_seen_enough(&self) -> io::Result<bool> {
        Ok(self.0.has_seen_enough()? || self.1.has_seen_enough()?)
    }

    fn memory(&self) -> io::Result<Self::Memory> {
        Ok((self.0.memory()?, self.1.memory()?))
    }

    fn files(&self, memory: &Self::Memory) -> Vec<(PathBuf, u64)> {
        let mut files = self.0.files(&memory.0);
        files.extend(self.1.files(&memory.1));
        files
    }

    fn rewind(&mut self, memory: Self::Memory) -> io::Result<()> {
        self.0.rewind(memory.0)?;
        self.1.rewind(memory.1)
    }
}
