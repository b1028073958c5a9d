//! A simulation in figures.

use crate::coupling::{Iteration, Step};
use serde::{Deserialize, Serialize};

/// Seconds of wall-clock time by where they went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Seconds {
    /// In the fluid.
    pub fluid_s: f64,
    /// In the structure.
    pub structure_s: f64,
    /// In transfer and acceleration.
    pub coupling_s: f64,
    /// In output and everything else.
    pub rest_s: f64,
}

/// The figures of a run so far; a resumed run continues them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct Totals {
    /// Accepted time steps.
    pub steps: usize,
    /// Time at the end of the last accepted step.
    pub time_s: f64,
    /// Coupling iterations of all accepted attempts.
    pub coupling_iterations: usize,
    /// Outer correctors of the fluid in these iterations.
    pub fluid_correctors: usize,
    /// Largest number of coupling iterations of a step.
    pub max_coupling_iterations: usize,
    /// Attempts at a step that failed.
    pub failed_attempts: usize,
    /// How often the fluid died and was started again.
    pub fluid_restarts: usize,
    /// How often the run was resumed.
    pub resumed: usize,
    /// Outlet pressure at the end of the last step.
    #[serde(with = "crate::numbers")]
    pub p_out_Pa: f64,
    /// Wall-clock time of the accepted steps alone.
    pub steps_s: f64,
    /// Wall-clock time of the steps and its parts, without steps that were lost.
    pub wall_s: f64,
    /// The parts.
    pub seconds: Seconds,
    /// Seconds of `rest_s` that writing checkpoints took.
    pub checkpoint_s: f64,
    /// Largest mismatch of the resultant force between the two surfaces, relative to the sum of |load|.
    #[serde(with = "crate::numbers")]
    pub max_force_mismatch: f64,
    /// Accepted steps, or parts of them, in which the fluid's last sweep began above `fluid.pressure_residual`.
    #[serde(default)]
    pub unfinished_steps: usize,
    /// Largest residual with which the last sweep of a step began.
    #[serde(default, with = "crate::numbers")]
    pub max_fluid_residual: f64,
    /// Largest share of the flow through the domain that a step lost.
    #[serde(default, with = "crate::numbers")]
    pub max_mass_lost: f64,
}

impl Totals {
    /// Counts an accepted step, or a part of one, that took `wall_seconds` in all; `steps` are done now, and the fluid
    /// was asked for this residual.
    pub(super) fn add(&mut self, step: &Step, steps: usize, wall_seconds: f64, residual: f64) {
        let seconds = Seconds::of(step, wall_seconds);
        let iterations = &step.iterations;
        self.steps = steps;
        self.time_s = step.fluid.time;
        self.coupling_iterations += iterations.len();
        let sweeps = iterations.iter().map(|i| i.fluid_cost.sweeps as usize);
        self.fluid_correctors += sweeps.sum::<usize>();
        self.max_coupling_iterations = self.max_coupling_iterations.max(iterations.len());
        self.p_out_Pa = step.fluid.outlet_pressure();
        self.steps_s += wall_seconds;
        self.seconds.fluid_s += seconds.fluid_s;
        self.seconds.structure_s += seconds.structure_s;
        self.seconds.coupling_s += seconds.coupling_s;
        let mismatch = iterations.last().map_or(0.0, |last| last.force_mismatch);
        self.max_force_mismatch = self.max_force_mismatch.max(mismatch);
        let left = iterations
            .last()
            .map_or(0.0, |last| last.fluid_cost.residual);
        self.unfinished_steps += usize::from(left > residual);
        self.max_fluid_residual = self.max_fluid_residual.max(left);
        self.max_mass_lost = self.max_mass_lost.max(step.mass_lost);
    }
}

impl Seconds {
    /// Of a step that took `wall_seconds` in all.
    pub fn of(step: &Step, wall_seconds: f64) -> Self {
        let sum = |part: fn(&Iteration) -> f64| step.iterations.iter().map(part).sum::<f64>();
        let fluid_s = sum(|i| i.fluid_seconds) + step.accept_seconds;
        let structure_s = sum(|i| i.structure_seconds);
        let coupling_s = sum(|i| i.coupling_seconds);
        Self {
            fluid_s,
            structure_s,
            coupling_s,
            rest_s: wall_seconds - fluid_s - structure_s - coupling_s,
        }
    }
}
