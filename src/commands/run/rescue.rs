//! A step that fails is tried again, more carefully each time; a solver that has died is started again.

use super::assemble::Run;
use super::{run_failure, written};
use crate::commands::Failure;
use crate::coupling::{CouplingError, FailedStep};
use crate::fluid::FluidError;
use std::time::Duration;

/// Attempts at a step, each more careful than the one before.
const ATTEMPTS: usize = 3;
/// Deaths of the fluid without a step beyond all earlier ones.
const DEATHS: usize = 4;

/// What is known of the step that makes trouble.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trouble {
    /// The farthest step that failed.
    step: usize,
    /// The attempt that comes next, from 1.
    attempt: usize,
    /// Deaths of the fluid since.
    deaths: usize,
}

impl Trouble {
    /// What is known after `step` has failed; `dead` if the fluid died.
    fn after(earlier: Option<Self>, step: usize, dead: bool) -> Self {
        let Some(earlier) = earlier.filter(|trouble| trouble.step >= step) else {
            return Self {
                step,
                // A death may be an accident: first everything is done again as it was.
                attempt: if dead { 1 } else { 2 },
                deaths: usize::from(dead),
            };
        };
        Self {
            attempt: earlier.attempt + usize::from(step == earlier.step),
            deaths: earlier.deaths + usize::from(dead),
            ..earlier
        }
    }

    fn is_hopeless(self) -> bool {
        self.attempt > ATTEMPTS || self.deaths > DEATHS
    }
}

impl Run {
    /// Prepares the next attempt at step `number` and says which it is, from 1.
    pub fn attempt(&mut self, number: usize) -> usize {
        self.trouble = self.trouble.filter(|trouble| trouble.step >= number);
        match self.trouble {
            Some(trouble) if trouble.step == number => {
                if trouble.attempt > 1 {
                    self.coupling.back_off(trouble.attempt);
                }
                trouble.attempt
            }
            _ => 1,
        }
    }

    /// Makes the run ready to go on after a failed step, and says how.
    ///
    /// # Errors
    /// If there is no hope, or somebody asked the run to end.
    pub fn rescue(&mut self, failed: FailedStep) -> Result<String, Failure> {
        let number = self.record.totals.steps + 1;
        let time = number as f64 * self.case.time.step;
        let attempt = self
            .trouble
            .map_or(1, |t| if t.step == number { t.attempt } else { 1 });
        self.record
            .failed_attempt(time, attempt, &failed.iterations)
            .map_err(written)?;
        let dead = match &failed.error {
            CouplingError::Fluid(FluidError::Interrupted) => {
                return Err(Failure::Interrupted(String::new()));
            }
            CouplingError::Fluid(FluidError::Solver(_)) => true,
            _ => false,
        };
        let what = format!("step {number} (t = {time:.6} s): {}", failed.error);
        let trouble = Trouble::after(self.trouble, number, dead);
        self.trouble = Some(trouble);
        if trouble.is_hopeless() {
            return Err(Failure::Run(format!(
                "{what}\nAll {attempt} attempts at this step failed, each from the last displacement, without what the coupling had learnt, and with less relaxation than the one before."
            )));
        }
        if !dead {
            return Ok(format!("{what}; it is tried again more carefully"));
        }
        let found = self.folder.checkpoints().newest().map_err(run_failure)?;
        for death in trouble.deaths.. {
            // Whatever killed it (memory, perhaps) may need a moment to pass.
            std::thread::sleep(Duration::from_millis(200) * death as u32);
            self.record.totals.fluid_restarts += 1;
            match self.go_back(&found.checkpoint) {
                Ok(()) => break,
                Err(failure) if death >= DEATHS => return Err(failure),
                Err(_) => {}
            }
        }
        Ok(format!(
            "{what}it is started again and the run goes on from {}",
            found.path.display()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::Trouble;

    #[test]
    fn a_death_is_first_taken_for_an_accident_and_then_for_the_fault_of_the_step() {
        let mut trouble = None;
        let mut attempts = Vec::new();
        while trouble.is_none_or(|t: Trouble| !t.is_hopeless()) {
            trouble = Some(Trouble::after(trouble, 7, true));
            attempts.extend(trouble.map(|t| t.attempt));
        }
        assert_eq!(attempts, [1, 2, 3, 4]);
    }

    #[test]
    fn deaths_on_the_way_back_to_the_step_do_not_count_as_attempts_but_not_forever() {
        let mut trouble = Some(Trouble::after(None, 7, true));
        let mut deaths = 1;
        while trouble.is_some_and(|t| !t.is_hopeless()) {
            trouble = Some(Trouble::after(trouble, 5, true));
            deaths += 1;
        }
        assert_eq!((deaths, trouble.unwrap().attempt), (5, 1));
        assert_eq!(Trouble::after(trouble, 8, false).attempt, 2);
    }
}
