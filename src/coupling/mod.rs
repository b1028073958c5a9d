//! The coupling loop of equation (13): transfer, solve, accelerate until converged.
//!
//! The interface displacement **d** lives at the fluid's wall points. One coupling iteration applies, from right
//! to left, `A ∘ I_M^N ∘ S ∘ I_FC^QP ∘ F` to it: the fluid, the interpolation of its load to the structure's
//! quadrature points, the structure, its displacement at the fluid's points, and the acceleration.

pub mod acceleration;
pub mod cadence;
pub mod convergence;
pub mod diagnosis;
pub mod interpolation;
pub mod predictor;
pub mod reference;
pub mod transfer;

use crate::Vec3;
use crate::fluid::{Fluid, FluidCost, FluidEffort, FluidError, FluidStep};
use crate::geometry::CentreShift;
use crate::pfem::{Solid, SolidError};
use acceleration::{Acceleration, Columns};
use convergence::{Criterion, Measure};
use nalgebra::DVector;
use predictor::Predictor;
use serde::{Deserialize, Serialize};
use std::time::Instant;
use transfer::{Transfer, force_mismatch};

/// What one coupling iteration cost and how far from the fixed point it was.
#[derive(Debug, Clone, PartialEq)]
pub struct Iteration {
    /// Number of the iteration within its step, from 1.
    pub number: usize,
    /// Distance to convergence.
    pub measure: Measure,
    /// Columns that a quasi-Newton model used.
    pub columns: usize,
    /// Columns dropped since the step began, because newer ones say the same.
    pub dropped: usize,
    /// What the fluid's answer cost.
    pub fluid_cost: FluidCost,
    /// |resultant of the fluid's load - resultant on the structure| over the sum of |load| of all faces.
    pub force_mismatch: f64,
    /// Seconds spent in the fluid.
    pub fluid_seconds: f64,
    /// Seconds spent in the structure.
    pub structure_seconds: f64,
    /// Seconds spent in transfer and acceleration.
    pub coupling_seconds: f64,
}

/// An accepted time step.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Every coupling iteration.
    pub iterations: Vec<Iteration>,
    /// The fluid's report.
    pub fluid: FluidStep,
    /// Displacement of the fluid's wall points, m.
    pub displacement: Vec<Vec3>,
    /// Seconds that the fluid needed to finish the accepted step.
    pub accept_seconds: f64,
}

/// Why a time step failed.
#[derive(Debug, thiserror::Error)]
pub enum CouplingError {
    /// The flow solver failed.
    #[error(transparent)]
    Fluid(#[from] FluidError),
    /// The structural solver failed.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// The two meshes do not describe the same surface.
    #[error("{0}")]
    Transfer(String),
    /// The iteration did not converge.
    #[error("the coupling did not converge: {0}")]
    NotConverged(String),
}

/// A time step that failed; both solvers still have the state at its beginning.
#[derive(Debug, thiserror::Error)]
#[error("{error}{}{}", diagnosis::circumstances(.error, .iterations), diagnosis::buckling(.centre_shift.as_deref()))]
pub struct FailedStep {
    /// The coupling iterations that were done.
    pub iterations: Vec<Iteration>,
    /// Of the last trial or of the last accepted displacement, whichever is farther aside; `None` if the wall is no tube.
    pub centre_shift: Option<Box<CentreShift>>,
    /// Why it failed.
    pub error: CouplingError,
}

/// What the coupling keeps from one time step to the next, besides the states of the two solvers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Accepted displacements of the fluid's wall points, newest first, m.
    pub displacements: Vec<Vec<f64>>,
    /// Errors of the predictor's candidates in the last step.
    pub predictor_errors: Vec<f64>,
    /// What the acceleration has learnt.
    pub acceleration: acceleration::Memory,
}

/// Numerical settings of the loop that are not part of its building blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Length of a time step, s.
    pub time_step: f64,
    /// Work that the fluid may spend on an iteration.
    pub fluid_effort: FluidEffort,
    /// Relative residual at which the structure's Newton iteration ends.
    pub newton_tolerance: f64,
    /// Relaxation factor of the acceleration.
    pub relaxation: f64,
}

/// The structure's Newton iteration may end at this share of the last coupling residual: its error must be far below what
/// the acceleration learns from.
const EASE: f64 = 1e-3;
/// From this many times the limit of the criterion on it must not end early: this iteration may be the last one.
const NEAR: f64 = 30.0;
/// What the first residual of a step is taken for.
const FIRST_RESIDUAL: f64 = 1e-2;

/// Each further attempt at a step relaxes by this share of the factor of the attempt before.
const BACK_OFF: f64 = 0.2;

/// A fluid and a structure joined at the wet surface.
pub struct Coupling<F, S: Solid> {
    /// The flow solver, **F**.
    pub fluid: F,
    /// The structural solver, **S**.
    pub solid: S,
    /// Interpolation between the two surfaces, **I**.
    pub transfer: Transfer<S::Location>,
    /// Convergence acceleration, **A**.
    pub acceleration: Box<dyn Acceleration>,
    /// First guess of each step.
    pub predictor: Predictor,
    /// Criterion (14).
    pub criterion: Criterion,
    /// The rest.
    pub settings: Settings,
}

impl<F: Fluid, S: Solid> Coupling<F, S> {
    /// Solves one time step and accepts it on both sides. `inspect` sees the structure and its accepted trial before
    /// it becomes the new state; `write`, asked at the end, lets the fluid leave its fields on disk.
    pub fn step(
        &mut self,
        write: impl FnOnce() -> bool,
        inspect: impl FnOnce(&S, &S::Trial),
    ) -> Result<Step, FailedStep> {
        let mut iterations = Vec::new();
        let mut d = self.predictor.first_guess();
        let done = self.iterate(&mut d, &mut iterations, write, inspect);
        done.map_err(|error| {
            let shift = |d: &DVector<f64>| self.transfer.centre_shift(&unflatten(d));
            let shifts = [&d, self.predictor.last()].into_iter().filter_map(shift);
            FailedStep {
                iterations,
                centre_shift: shifts
                    .max_by(|a, b| a.shift.total_cmp(&b.shift))
                    .map(Box::new),
                error,
            }
        })
    }

    /// Iterates from the trial `d`, which is the last one afterwards.
    fn iterate(
        &mut self,
        d: &mut DVector<f64>,
        iterations: &mut Vec<Iteration>,
        write: impl FnOnce() -> bool,
        inspect: impl FnOnce(&S, &S::Trial),
    ) -> Result<Step, CouplingError> {
        let settings = self.settings;
        let mut start = None;
        let mut residual = FIRST_RESIDUAL;
        while iterations.len() < self.criterion.max_iterations {
            let clock = Instant::now();
            let points = unflatten(d);
            let flow = self
                .fluid
                .solve(&points, settings.time_step, settings.fluid_effort)?; // F
            let fluid_seconds = clock.elapsed().as_secs_f64();
            let areas = self.transfer.face_areas(&points);
            let load = self.transfer.load(&flow.tractions, &areas); // I: face centres to quadrature points

            let clock = Instant::now();
            let dt = settings.time_step;
            let tolerance = self.newton_tolerance(residual);
            let mut trial = self.solid.solve(&load, dt, tolerance, start.as_ref())?; // S
            let mut structure_seconds = clock.elapsed().as_secs_f64();

            let clock = Instant::now();
            let d_tilde = flatten(&self.transfer.displacement(&self.solid, &trial)); // I: structure to fluid points
            let d_next = self.acceleration.next(d, &d_tilde); // A
            let Columns { used, dropped } = self.acceleration.columns();
            let measure = self.criterion.measure(d, &d_tilde, &d_next, used == 0);
            residual = measure.residual;
            let coupling_seconds = clock.elapsed().as_secs_f64();
            if measure.converged && tolerance > settings.newton_tolerance {
                let clock = Instant::now();
                trial = (self.solid).solve(&load, dt, settings.newton_tolerance, Some(&trial))?;
                structure_seconds += clock.elapsed().as_secs_f64();
            }
            iterations.push(Iteration {
                number: iterations.len() + 1,
                measure,
                columns: used,
                dropped,
                fluid_cost: flow.cost,
                force_mismatch: force_mismatch(
                    &flow.tractions,
                    &areas,
                    &load,
                    &self.solid.deformed_areas(&trial),
                ),
                fluid_seconds,
                structure_seconds,
                coupling_seconds,
            });
            if measure.converged {
                let clock = Instant::now();
                let fluid = self.fluid.accept(write())?;
                let accept_seconds = clock.elapsed().as_secs_f64();
                inspect(&self.solid, &trial);
                let clock = Instant::now();
                self.solid.accept(trial);
                if let Some(last) = iterations.last_mut() {
                    last.structure_seconds += clock.elapsed().as_secs_f64();
                }
                self.acceleration.finish_step();
                self.set_share(1.0);
                self.predictor.accept(d.clone());
                return Ok(Step {
                    iterations: std::mem::take(iterations),
                    fluid,
                    displacement: points,
                    accept_seconds,
                });
            }
            *d = d_next;
            start = Some(trial);
        }
        let limit = settings.fluid_effort.max_sweeps;
        Err(CouplingError::NotConverged(diagnosis::diagnosis(
            iterations, limit,
        )))
    }

    /// The relative residual at which the structure's Newton iteration may end after a coupling `residual`.
    fn newton_tolerance(&self, residual: f64) -> f64 {
        let tight = self.settings.newton_tolerance;
        if residual < NEAR * self.criterion.relative {
            tight
        } else {
            tight.max(EASE * residual)
        }
    }

    /// Makes the next [`Coupling::step`] a more careful attempt, the `attempt`-th (from 2), at the step that failed:
    /// from the old state of the fluid, without what was learnt, with less relaxation, and from the third on from the
    /// last displacement: not before, for a wall that stops at once is a blow where there is much added mass.
    pub fn back_off(&mut self, attempt: usize) {
        self.fluid.forget_trial();
        if attempt > 2 {
            self.predictor.reset();
        }
        self.acceleration.reset();
        self.set_share(BACK_OFF.powi(attempt as i32 - 1));
    }

    /// Makes the next time steps `time_step` (s) long. What was learnt of the Jacobian in steps of another length is
    /// forgotten.
    pub fn set_time_step(&mut self, time_step: f64) {
        if time_step != self.settings.time_step {
            self.predictor.resample(time_step / self.settings.time_step);
            self.settings.time_step = time_step;
            self.acceleration.reset();
        }
    }

    /// Relaxes by this share of the usual factor from now on.
    fn set_share(&mut self, share: f64) {
        self.criterion.share = share;
        self.acceleration
            .set_relaxation(share * self.settings.relaxation);
    }

    /// What is needed, besides the states of the two solvers, to continue later.
    pub fn memory(&self) -> Memory {
        let (displacements, predictor_errors) = self.predictor.memory();
        Memory {
            displacements,
            predictor_errors,
            acceleration: self.acceleration.memory(),
        }
    }

    /// Continues as the coupling whose memory this is.
    ///
    /// # Errors
    /// If it belongs to another interface.
    pub fn recall(&mut self, memory: Memory) -> Result<(), CouplingError> {
        let unknowns = self.predictor.last().len();
        let fits = |d: &Vec<f64>| d.len() == unknowns && d.iter().all(|x| x.is_finite());
        if memory.displacements.is_empty()
            || !memory.displacements.iter().all(fits)
            || !memory.acceleration.fits_to(unknowns)
        {
            return Err(CouplingError::Transfer(format!(
                "what the coupling remembers does not belong to an interface of {} points",
                unknowns / 3
            )));
        }
        self.predictor
            .recall(memory.displacements, memory.predictor_errors);
        self.acceleration
            .recall(memory.acceleration, self.predictor.last());
        self.set_share(1.0);
        Ok(())
    }
}

/// Vectors of space, one after the other: x0 y0 z0 x1 y1 z1 …
pub fn flatten(vectors: &[Vec3]) -> DVector<f64> {
    DVector::from_iterator(
        3 * vectors.len(),
        vectors.iter().flat_map(|v| [v.x, v.y, v.z]),
    )
}

/// The inverse of [`flatten`].
pub fn unflatten(values: &DVector<f64>) -> Vec<Vec3> {
    values
        .as_slice()
        .chunks_exact(3)
        .map(Vec3::from_column_slice)
        .collect()
}
