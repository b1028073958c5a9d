//! Takes the time steps one by one.

use super::assemble::Run;
use super::{run_failure, written};
use crate::commands::Failure;
use crate::coupling::{FailedStep, diagnosis};
use crate::fluid::Fluid;
use crate::hemodynamics::WallState;
use crate::output::probes::fluid_rows;
use crate::output::progress::Progress;
use crate::output::record::WallPeaks;
use crate::output::tables::HistoryRow;
use crate::output::vtu::{Cells, Grid, Values};
use crate::pfem::samples::{Sampler, Samples, StressPeak, stress_peaks};
use crate::pfem::structure::Trial;
use crate::pfem::{SolidError, Structure};
use std::cell::Cell;
use std::time::Instant;

/// Why no step was taken.
pub enum Stop {
    /// The step failed; both solvers, if they live, still have the state before it.
    Step(FailedStep),
    /// The run cannot go on.
    Run(Failure),
}

impl From<Failure> for Stop {
    fn from(failure: Failure) -> Self {
        Self::Run(failure)
    }
}

impl Run {
    /// Goes on to the last step; ends early at an interrupt, or at a failure that no rescue helps against.
    pub fn advance(&mut self, quiet: bool) -> Result<(), Failure> {
        let steps = self.case.steps();
        let mut progress = Progress::new(steps as u64, quiet);
        while self.record.totals.steps < steps {
            if self.interrupt.asked() && self.is_saved() {
                return Err(Failure::Interrupted(String::new()));
            }
            if let Some((last, reason)) = &self.last_good
                && *last == self.record.totals.steps
            {
                return Err(Failure::Run(reason.clone()));
            }
            match self.step() {
                Ok((row, slowness)) => {
                    progress.step(
                        self.record.totals.steps as u64,
                        row.time_s,
                        row.coupling_iterations,
                        row.residual,
                        row.wall_s,
                    );
                    if let Some(slowness) = slowness.filter(|_| !quiet) {
                        progress.note(&format!("t = {:.6} s: {slowness}", row.time_s));
                    }
                }
                Err(Stop::Step(failed)) => {
                    let what = self.rescue(failed)?;
                    progress.note(&what);
                }
                Err(Stop::Run(failure)) => return Err(failure),
            }
        }
        progress.finish();
        Ok(())
    }

    /// Takes one step, or a part of it, records it, and writes a checkpoint if one is due. Says why if it was slow.
    fn step(&mut self) -> Result<(HistoryRow, Option<String>), Stop> {
        let (clock, last) = (Instant::now(), self.case.steps());
        let number = self.record.totals.steps + 1;
        let attempt = self.attempt();
        let completes = self.cadence.completes();
        let (output, time_step) = (&self.case.output, self.case.time.step);
        let due =
            |interval: f64| completes && (number == last || is_due(number, time_step, interval));
        let ends = number == last || self.last_good.as_ref().is_some_and(|good| good.0 == number);
        let sampler = due(output.structure_interval).then_some(&self.sampler);
        // Decided when the step is about to be accepted: an interrupt may have come until then.
        let saving = Cell::new(false);
        let write = || {
            let waited = self.saved.elapsed().as_secs_f64() / 60.0;
            let now = waited >= output.checkpoint_interval || self.interrupt.asked();
            saving.set(completes && (now || ends));
            saving.get() || due(output.fluid_interval)
        };
        let mut wall = None;
        let mut probed = Vec::new();
        let outcome = self.coupling.step(write, |solid, trial| {
            wall = Some(inspect(solid, trial, sampler));
            probed = self.probes.displacement(solid, trial);
        });
        let accepted = outcome.map_err(Stop::Step)?;
        let (stresses, samples) = wall
            .expect("an accepted step has been inspected")
            .map_err(run_failure)?;
        if let Some(samples) = samples {
            self.record
                .structure
                .add(accepted.fluid.time, &grid(&self.sampler, &samples))
                .map_err(written)?;
        }
        self.record
            .probes(&(self.probes).rows(accepted.fluid.time, &probed, &accepted.fluid.wall_shear))
            .map_err(written)?;
        let sampled = self.coupling.fluid.probes().map_err(run_failure)?;
        let sampled = fluid_rows(accepted.fluid.time, &output.fluid_probes, &sampled);
        self.record.fluid_probes(&sampled).map_err(written)?;
        let state = WallState::new(
            accepted.fluid.time,
            &accepted.fluid.wall_shear,
            &accepted.displacement,
        );
        self.record.wall.step(&state, &stresses).map_err(written)?;
        let totals = &self.record.totals;
        let usual = totals.coupling_iterations as f64 / totals.steps.max(1) as f64;
        let correctors = self.case.fluid.max_correctors;
        let slowness = diagnosis::slowness(&accepted.iterations, usual, correctors)
            .filter(|_| totals.steps > 0);
        let displacements = accepted.displacement.iter().map(|d| d.norm());
        let peaks = WallPeaks {
            displacement: displacements.fold(0.0, f64::max),
            von_mises: stresses.iter().map(|s| s.von_mises).fold(0.0, f64::max),
        };
        let seconds = clock.elapsed().as_secs_f64();
        let row = self
            .record
            .step(
                &accepted,
                self.coupling.settings.time_step,
                attempt,
                peaks,
                seconds,
            )
            .map_err(written)?;
        self.cadence.advance();
        self.record.totals.steps += usize::from(completes);
        let memory = self.coupling.fluid.usage().peak_memory;
        self.fluid_peak_memory = self.fluid_peak_memory.max(memory);
        if saving.get() {
            self.save()?;
        }
        Ok((row, slowness))
    }
}

/// Largest von Mises stress of each element in an accepted trial, and the fields if they are wanted.
fn inspect(
    solid: &Structure,
    trial: &Trial,
    sampler: Option<&Sampler>,
) -> Result<(Vec<StressPeak>, Option<Samples>), SolidError> {
    let stresses = stress_peaks(solid.body(), &trial.state.d)?;
    let samples = sampler
        .map(|s| s.sample(solid.body(), &trial.state.d))
        .transpose()?;
    Ok((stresses, samples))
}

fn grid<'a>(sampler: &'a Sampler, samples: &'a Samples) -> Grid<'a> {
    Grid {
        points: &sampler.points,
        cells: Cells::Hexes(&sampler.hexes),
        point_data: vec![
            ("displacement_m", Values::Vectors(&samples.displacement)),
            ("von_mises_Pa", Values::Scalars(&samples.von_mises)),
        ],
        cell_data: vec![
            ("material", Values::Integers(&sampler.regions)),
            ("element", Values::Integers(&sampler.element_of_hex)),
        ],
    }
}

/// Whether the end of `step` is a multiple of `interval`, or the first step end after one.
pub fn is_due(step: usize, time_step: f64, interval: f64) -> bool {
    let passed = |step: usize| (step as f64 * time_step / interval * (1.0 + 1e-9)).floor();
    passed(step) > passed(step - 1)
}

#[cfg(test)]
mod tests {
    use super::is_due;

    #[test]
    fn output_is_due_once_per_interval_despite_rounding() {
        let due = |interval: f64| (1..=1500).filter(|&n| is_due(n, 0.002, interval)).count();
        assert_eq!(
            (due(0.002), due(0.02), due(0.1), due(0.003)),
            (1500, 150, 30, 1000)
        );
    }
}
