//! A step that fails is tried again, more carefully each time; a solver that has died is started again.

use super::observer::{FailedAttempt, Observer};
use super::{Simulation, SimulationError};
use crate::coupling::acceptance::Refusal;
use crate::coupling::{CouplingError, FailedStep};
use crate::fluid::{Fluid, FluidError};
use crate::pfem::Solid;
use std::time::Duration;

/// Attempts at a step, each more careful than the one before; those that follow halve it.
const ATTEMPTS: usize = 3;
/// A residual that is still too large after so many sweeps does not fall: more of them would not help.
const ENOUGH_SWEEPS: u32 = 10;
/// Sweeps that the fluid may spend in the second attempt and in later ones, times those of the first, where it is to
/// blame.
const MORE_SWEEPS: [u32; 2] = [4, 10];
/// Ways back to a checkpoint without a step beyond all earlier ones.
const RETURNS: usize = 4;

/// A step of the case, from 1, and how much of it was done before, see [`StepSubdivision::done`](super::subdivision::StepSubdivision::done).
type StepPlace = (usize, usize);

/// What is known of a step that makes trouble.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trouble {
    at: StepPlace,
    /// The attempt that comes next, from 1.
    attempt: usize,
    /// Parts into which the next attempt cuts a step of the case.
    parts: usize,
    /// Whether the fluid left its equations unsolved.
    of_the_fluid: bool,
}

impl Trouble {
    /// Makes the next attempt one with shorter steps than `parts` of a step of the case.
    fn cut(&mut self, parts: usize) {
        self.attempt = self.attempt.max(ATTEMPTS + 1);
        self.parts = 2 * parts;
    }

    /// Sweeps of the fluid in the next attempt, times the usual number.
    fn sweeps(self) -> u32 {
        match self.care() {
            care if care > 1 && self.of_the_fluid => MORE_SWEEPS[(care - 2).min(1)],
            _ => 1,
        }
    }

    /// How careful the next attempt is: a shorter step need not be solved with the utmost care at once.
    fn care(self) -> usize {
        if self.attempt > ATTEMPTS {
            2
        } else {
            self.attempt
        }
    }
}

/// The steps that make trouble, the farthest first. On the way back to one of them others may fail: what is known of it
/// must not be lost, or the run would go round and round.
#[derive(Debug, Clone, Default)]
pub struct Troubles {
    all: Vec<Trouble>,
    /// Ways back to a checkpoint without a step beyond the farthest.
    returns: usize,
}

impl Troubles {
    fn at(&self, place: StepPlace) -> Option<Trouble> {
        self.all.iter().copied().find(|trouble| trouble.at == place)
    }

    /// Forgets what lies before a place that was reached.
    fn leave(&mut self, place: StepPlace) {
        self.all.retain(|trouble| trouble.at >= place);
        if self.all.is_empty() {
            self.returns = 0;
        }
    }

    /// What is to be done after the step, cut into `parts`, has failed `at` a place; `gone` if its beginning is lost,
    /// `dead` if that is so because the fluid died.
    fn after(&mut self, at: StepPlace, parts: usize, gone: bool, dead: bool) -> &mut Trouble {
        self.leave(at);
        self.returns += usize::from(gone);
        let is_known = self.at(at).is_some();
        // A death on the way back to where it was tells nothing of the step.
        let place = match self.all.first() {
            Some(farthest) if dead && !is_known => farthest.at,
            _ => at,
        };
        let found = self.all.iter().position(|trouble| trouble.at == place);
        let found = found.unwrap_or_else(|| {
            self.all.push(Trouble {
                at,
                // A death may be an accident: first everything is done again as it was.
                attempt: usize::from(!dead),
                parts,
                of_the_fluid: false,
            });
            self.all.len() - 1
        });
        let trouble = &mut self.all[found];
        if place == at {
            trouble.attempt += 1;
            trouble.parts = parts;
            if trouble.attempt > ATTEMPTS {
                trouble.cut(parts);
            }
        }
        trouble
    }

    fn is_hopeless(&self, trouble: Trouble, max_halvings: usize) -> bool {
        trouble.parts > 1 << max_halvings || self.returns > RETURNS
    }
}

impl<F: Fluid, S: Solid, O: Observer<S>> Simulation<F, S, O> {
    fn place(&self) -> StepPlace {
        let reading = self.clock.reading();
        (reading.steps + 1, reading.subdivision.done())
    }

    /// Prepares the next attempt at the step that comes and says which it is, from 1.
    pub(super) fn attempt(&mut self) -> usize {
        let place = self.place();
        self.troubles.leave(place);
        let here = self.troubles.at(place);
        if let Some(trouble) = here {
            self.clock.refine(trouble.parts);
        }
        self.coupling.set_time_step(self.clock.part());
        let sweeps = here.map_or(1, Trouble::sweeps);
        self.coupling.settings.fluid_effort.max_sweeps =
            self.effort.max_sweeps.saturating_mul(sweeps);
        if let Some(trouble) = here.filter(|trouble| trouble.attempt > 1) {
            self.coupling.back_off(trouble.care());
        }
        here.map_or(1, |trouble| trouble.attempt)
    }

    /// Makes the simulation ready to go on after a failed step, and says how. A fluid that found no solution is asked
    /// again with more care; one that has died is started again from the newest checkpoint.
    ///
    /// # Errors
    /// If there is no hope, or the user asked the run to end.
    pub(super) fn rescue(&mut self, failed: FailedStep) -> Result<String, SimulationError> {
        let place = self.place();
        let (number, time) = (place.0, self.clock.next_time());
        let attempt = self.troubles.at(place).map_or(1, |trouble| trouble.attempt);
        self.totals.failed_attempts += 1;
        self.observer.failed(&FailedAttempt {
            time,
            attempt,
            iterations: &failed.iterations,
        })?;
        let what = format!("step {number} (t = {time:.6} s): {failed}");
        let RescueVerdict {
            dead,
            gone,
            of_the_fluid,
            needs_shorter_steps,
            in_vain,
        } = match RescueVerdict::of(&failed.error) {
            Ok(verdict) => verdict,
            Err(FluidError::Interrupted) => return Err(SimulationError::Interrupted),
            Err(_) => return Err(SimulationError::Step(what)),
        };
        if in_vain {
            return self.keep_last_good(number - 1, what);
        }
        let parts = self.clock.reading().subdivision.parts();
        let trouble = self.troubles.after(place, parts, gone, dead);
        trouble.of_the_fluid |= of_the_fluid;
        // Even a solver that dies of an overflow may have been killed from outside the first time.
        if needs_shorter_steps && !(dead && attempt == 1 && trouble.attempt == 1) {
            trouble.cut(parts);
        }
        let trouble = *trouble;
        let max_halvings = self.settings.max_halvings;
        if self.troubles.is_hopeless(trouble, max_halvings) {
            let sweeps = match of_the_fluid {
                true => ", with up to ten times as many sweeps of the fluid",
                false => "",
            };
            let reason = format!(
                "{what}\nAll {attempt} attempts at this step failed: from the last displacement, without what the coupling had learnt, with less relaxation{sweeps}, with shorter steps (time.max_halvings = {max_halvings})"
            );
            return self.keep_last_good(number - 1, reason);
        }
        let how = match trouble.parts > parts {
            true => format!("in {} parts for a while", trouble.parts),
            false => "more carefully".into(),
        };
        if !gone {
            return Ok(format!("{what}; it is tried again {how}"));
        }
        let Ok(found) = self.newest() else {
            return Err(SimulationError::Step(what));
        };
        for death in self.troubles.returns.. {
            // Whatever killed it (memory, perhaps) may need a moment to pass.
            std::thread::sleep(Duration::from_millis(200) * death as u32);
            self.totals.fluid_restarts += usize::from(dead);
            match self.go_back(&found.checkpoint) {
                Ok(()) => break,
                Err(error) if death >= RETURNS => return Err(error),
                Err(_) => {}
            }
        }
        let from = found.path.display();
        Ok(match dead {
            true => format!("{what}it is started again and the run continues from {from}"),
            false => format!("{what}; the run goes back to {from} and tries the step again {how}"),
        })
    }

    /// The run cannot go on after the `last` step. If that is in no checkpoint the steps since the newest one are taken
    /// once more, so that it will be.
    fn keep_last_good(&mut self, last: usize, reason: String) -> Result<String, SimulationError> {
        if let Some((_, first)) = self.last_good.take() {
            return Err(SimulationError::Step(format!("{first}\nThen {reason}")));
        }
        let newest = self.newest().ok();
        let Some(found) = newest.filter(|found| found.checkpoint.step() < last) else {
            return Err(SimulationError::Step(reason));
        };
        if self.go_back(&found.checkpoint).is_err() {
            return Err(SimulationError::Step(reason));
        }
        self.troubles = Troubles::default();
        let told = format!(
            "{reason}\nThe steps from {} on are repeated to keep the last good one",
            found.path.display()
        );
        self.last_good = Some((last, reason));
        Ok(told)
    }
}

/// What a failure says of the fluid, and of another attempt.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct RescueVerdict {
    /// The fluid has died.
    dead: bool,
    /// It has not the state at the beginning of the step any more.
    gone: bool,
    /// It left its equations unsolved.
    of_the_fluid: bool,
    /// More sweeps would not help.
    needs_shorter_steps: bool,
    /// Another attempt would end in the same way.
    in_vain: bool,
}

impl RescueVerdict {
    /// # Errors
    /// What ends the run at once: another attempt would not find more room on the disk.
    fn of(error: &CouplingError) -> Result<Self, &FluidError> {
        let verdict = Self::default();
        Ok(match error {
            CouplingError::Fluid(FluidError::Died(_)) => Self {
                dead: true,
                gone: true,
                ..verdict
            },
            CouplingError::Fluid(error @ (FluidError::Interrupted | FluidError::Storage(_))) => {
                return Err(error);
            }
            CouplingError::Refused(Refusal::ForceLost { .. }) => Self {
                in_vain: true,
                ..verdict
            },
            CouplingError::Fluid(FluidError::Diverged(_)) => Self {
                dead: true,
                gone: true,
                of_the_fluid: true,
                needs_shorter_steps: true,
                ..verdict
            },
            CouplingError::Refused(Refusal::Diverging { .. }) => Self {
                of_the_fluid: true,
                needs_shorter_steps: true,
                ..verdict
            },
            CouplingError::Refused(Refusal::Unsolved { sweeps, .. }) => Self {
                of_the_fluid: true,
                needs_shorter_steps: *sweeps >= ENOUGH_SWEEPS,
                ..verdict
            },
            CouplingError::Fluid(FluidError::NotSolved(_)) | CouplingError::Refused(_) => Self {
                of_the_fluid: true,
                ..verdict
            },
            CouplingError::RefusedTooLate(_) => Self {
                of_the_fluid: true,
                gone: true,
                ..verdict
            },
            CouplingError::Solid(_) | CouplingError::NotConverged(_) => verdict,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Troubles;

    /// Attempts and parts after each failure at one place, until there is no hope.
    fn attempts(dead: bool, max_halvings: usize) -> Vec<(usize, usize)> {
        let (mut troubles, mut parts, mut all) = (Troubles::default(), 1, Vec::new());
        loop {
            let next = *troubles.after((7, 0), parts, dead, dead);
            if troubles.is_hopeless(next, max_halvings) {
                return all;
            }
            all.push((next.attempt, next.parts));
            parts = parts.max(next.parts);
        }
    }

    #[test]
    fn a_step_is_tried_with_care_and_then_in_parts() {
        assert_eq!(attempts(false, 0), [(2, 1), (3, 1)]);
        assert_eq!(attempts(false, 2), [(2, 1), (3, 1), (4, 2), (5, 4)]);
    }

    /// A death is first taken for an accident and then for the fault of the step.
    #[test]
    fn a_second_death_blames_the_step() {
        assert_eq!(attempts(true, 1), [(1, 1), (2, 1), (3, 1), (4, 2)]);
    }

    /// Deaths on the way back to the step do not count as attempts but not forever.
    #[test]
    fn deaths_during_recovery_are_no_attempts() {
        let mut troubles = Troubles::default();
        let mut trouble = *troubles.after((7, 0), 1, true, true);
        let mut deaths = 1;
        while !troubles.is_hopeless(trouble, 0) {
            trouble = *troubles.after((5, 0), 1, true, true);
            deaths += 1;
        }
        assert_eq!((deaths, trouble.at, trouble.attempt), (5, (7, 0), 1));
        assert_eq!(troubles.after((8, 0), 1, false, false).attempt, 2);
        assert_eq!(troubles.returns, 0);
    }

    #[test]
    fn where_sweeps_do_not_help_steps_are_cut_at_once() {
        let mut troubles = Troubles::default();
        let trouble = troubles.after((7, 0), 1, false, false);
        trouble.cut(1);
        assert_eq!((trouble.attempt, trouble.parts, trouble.care()), (4, 2, 2));
        let trouble = troubles.after((7, 0), 2, false, false);
        assert_eq!((trouble.attempt, trouble.parts), (5, 4));
        trouble.cut(2);
        assert_eq!((trouble.attempt, trouble.parts), (5, 4));
        let trouble = *trouble;
        assert!(troubles.is_hopeless(trouble, 1) && !troubles.is_hopeless(trouble, 2));
    }

    #[test]
    fn a_fluid_that_is_to_blame_may_spend_more_sweeps() {
        let mut troubles = Troubles::default();
        let trouble = troubles.after((7, 0), 1, false, false);
        assert_eq!(trouble.sweeps(), 1);
        trouble.of_the_fluid = true;
        assert_eq!(trouble.sweeps(), 4);
        assert_eq!(troubles.after((7, 0), 1, false, false).sweeps(), 10);
        let trouble = troubles.after((7, 0), 1, false, false);
        assert_eq!((trouble.sweeps(), trouble.parts), (4, 2));
    }

    #[test]
    fn a_failure_on_the_way_back_is_met_with_care_as_well() {
        let mut troubles = Troubles::default();
        troubles.after((7, 4), 2, true, true);
        let trouble = *troubles.after((5, 0), 1, false, false);
        assert_eq!(
            (trouble.at, trouble.attempt, troubles.returns),
            ((5, 0), 2, 1)
        );
    }

    /// A step that fails too late sends the run back over one that fails each time: the farther one is tried with more
    /// and more care until it is given up.
    #[test]
    fn a_step_that_fails_on_each_way_back_hides_no_other() {
        let mut troubles = Troubles::default();
        let mut farther = Vec::new();
        loop {
            let nearer = *troubles.after((8, 0), 1, false, false);
            assert_eq!(nearer.attempt, 2);
            troubles.leave((9, 0));
            let far = troubles.after((27, 0), 1, true, false);
            far.of_the_fluid = true;
            farther.push((far.attempt, far.parts));
            let far = *far;
            if troubles.is_hopeless(far, 0) {
                break;
            }
        }
        assert_eq!(farther, [(2, 1), (3, 1), (4, 2)]);
    }
}
