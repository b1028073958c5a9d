//! Where a simulation is in time.

use super::subdivision::StepSubdivision;
use crate::case::RunEnds;
use fsi_numerics::twelve_digits;
use serde::{Deserialize, Serialize};

/// Counts the time steps of a simulation, whose length the case fixes, and the parts into which trouble has cut them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    time_step: f64,
    ends: RunEnds,
    reading: ClockReading,
}

/// What a clock shows; all that a checkpoint needs of it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClockReading {
    /// Steps that are done.
    pub steps: usize,
    /// How long the next one is, and how much of it is done.
    pub subdivision: StepSubdivision,
}

impl Clock {
    /// At the start of steps of `time_step` (s), after some of which the simulation may be over.
    pub fn new(time_step: f64, ends: RunEnds) -> Self {
        Self {
            time_step,
            ends,
            reading: ClockReading::default(),
        }
    }

    /// Steps that are done.
    pub fn steps(&self) -> usize {
        self.reading.steps
    }

    /// Number of the last step.
    pub fn last(&self) -> usize {
        self.ends.last()
    }

    /// Length of a step, s.
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Length of the part of a step that comes next, s.
    pub fn part(&self) -> f64 {
        self.time_step / self.reading.subdivision.parts() as f64
    }

    /// Time at the end of that part, s.
    pub fn next_time(&self) -> f64 {
        let steps = self.reading.steps as f64 + self.reading.subdivision.reaches();
        twelve_digits(steps * self.time_step)
    }

    /// Whether that part ends a step.
    pub fn completes(&self) -> bool {
        self.reading.subdivision.completes()
    }

    /// Whether the last step is done.
    pub fn is_over(&self) -> bool {
        self.reading.steps >= self.ends.last()
    }

    /// Whether this step may be the last one.
    pub fn may_end_after(&self, step: usize) -> bool {
        self.ends.contains(step)
    }

    /// What it shows.
    pub fn reading(&self) -> ClockReading {
        self.reading
    }

    /// Sets it.
    pub fn set(&mut self, reading: ClockReading) {
        self.reading = reading;
    }

    /// Cuts steps into this many parts, a power of two, if they are not that short already.
    pub fn refine(&mut self, parts: usize) {
        self.reading.subdivision.refine(parts);
    }

    /// The next part is done.
    pub fn advance(&mut self) {
        self.reading.steps += usize::from(self.completes());
        self.reading.subdivision.advance();
    }
}

/// Whether the end of the `step`-th step is a multiple of `interval` (s), or the first one after such a time.
pub fn is_due(step: usize, time_step: f64, interval: f64) -> bool {
    let passed = |step: usize| (step as f64 * time_step / interval * (1.0 + 1e-9)).floor();
    passed(step) > passed(step - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn output_is_due_once_per_interval_despite_rounding() {
        let due = |interval: f64| (1..=1500).filter(|&n| is_due(n, 0.002, interval)).count();
        assert_eq!(
            (due(0.002), due(0.02), due(0.1), due(0.003)),
            (1500, 150, 30, 1000)
        );
    }

    #[test]
    fn parts_of_a_step_count_when_it_is_whole() {
        let mut clock = Clock::new(0.5, RunEnds::last_only(2));
        clock.advance();
        clock.refine(2);
        assert_eq!(
            (clock.steps(), clock.part(), clock.next_time()),
            (1, 0.25, 0.75)
        );
        assert!(!clock.completes() && !clock.is_over());
        clock.advance();
        assert_eq!((clock.steps(), clock.next_time()), (1, 1.0));
        let reading = clock.reading();
        clock.advance();
        assert!(clock.is_over());
        clock.set(reading);
        assert!(clock.completes() && !clock.is_over());
    }
}
