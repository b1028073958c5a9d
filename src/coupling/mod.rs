//! The coupling loop of equation (13): transfer, solve, accelerate until converged.
//!
//! The interface displacement **d** lives at the fluid's wall points. One coupling iteration applies, from right
//! to left, `A ∘ I_M^N ∘ S ∘ I_FC^QP ∘ F` to it: the fluid, the interpolation of its load to the structure's
//! quadrature points, the structure, its displacement at the fluid's points, and the acceleration.

pub mod acceptance;
pub mod common_refinement;
pub(crate) mod diagnosis;
pub(crate) mod interpolation;
pub mod reference;
pub mod surrogate;
pub mod transfer;

pub use fsi_coupling::{acceleration, convergence, fixed_point, predictor};

use crate::Vec3;
use crate::fluid::{Fluid, FluidCost, FluidEffort, FluidError, FluidStep, FluidTrial, Wanted};
use crate::geometry::CentreShift;
use crate::pfem::{Solid, SolidError, SurfaceLoad};
use acceleration::Columns;
use acceptance::{Balance, Limits, Refusal, require_finite};
use convergence::ResidualMeasure;
use fixed_point::{CoupledProblem, FixedPoint};
use nalgebra::DVector;
use std::thread;
use std::time::Instant;
use transfer::{Transfer, force_mismatch};

/// What one coupling iteration cost and how far from the fixed point it was.
#[derive(Debug, Clone, PartialEq)]
pub struct Iteration {
    /// Number of the iteration within its step, from 1.
    pub number: usize,
    /// Distance to convergence.
    pub measure: ResidualMeasure,
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
    /// Pressure of the fluid at each face of its wall, Pa.
    pub wall_pressure: Vec<f64>,
    /// Seconds that the fluid needed to finish the accepted step.
    pub accept_seconds: f64,
    /// Share of the flow through the domain that the step lost.
    pub mass_lost: f64,
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
    /// The iteration did not converge.
    #[error("the coupling did not converge: {0}")]
    NotConverged(String),
    /// What it converged to is not an answer.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The same, seen only in what the fluid reports of a step that it has kept.
    #[error("{0}")]
    RefusedTooLate(Refusal),
}

/// A time step that failed; both solvers still have the state at its beginning, except for the fluid after
/// [`CouplingError::RefusedTooLate`], which has to be recalled.
#[derive(Debug, thiserror::Error)]
#[error("{}", diagnosis::failure(self))]
pub struct FailedStep {
    /// The coupling iterations that were done.
    pub iterations: Vec<Iteration>,
    /// Of the last trial or of the last accepted displacement, whichever is farther aside; `None` if the wall is no
    /// tube.
    pub centre_shift: Option<Box<CentreShift>>,
    /// Why it failed.
    pub error: CouplingError,
}

impl FailedStep {
    /// Whether it was given up because the run is to end.
    pub fn is_interrupt(&self) -> bool {
        matches!(self.error, CouplingError::Fluid(FluidError::Interrupted))
    }
}

/// Numerical settings of the loop that are not part of its building blocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings {
    /// Length of a time step, s.
    pub time_step: f64,
    /// Work that the fluid may spend on an iteration.
    pub fluid_effort: FluidEffort,
    /// Relative residual at which the structure's Newton iteration ends.
    pub newton_tolerance: f64,
    /// What an accepted step must not exceed.
    pub limits: Limits,
}

/// The structure's Newton iteration may end at this share of the last coupling residual: its error must be far below
/// what the acceleration learns from.
const EASE: f64 = 1e-3;
/// From this many times the limit of the criterion on it must not end early: this iteration may be the last one.
const NEAR: f64 = 30.0;

/// A fluid and a structure joined at the wet surface.
pub struct Coupling<F, S: Solid> {
    /// The flow solver, **F**.
    pub fluid: F,
    /// The structural solver, **S**.
    pub solid: S,
    /// Interpolation between the two surfaces, **I**.
    pub transfer: Transfer<S::Location>,
    /// Prediction, acceleration **A**, and criterion (14).
    pub fixed_point: FixedPoint,
    /// The rest.
    pub settings: StepSettings,
    /// The fluid's mass so far.
    pub balance: Balance,
}

/// A time step that has converged, and is not accepted yet.
#[derive(Debug)]
#[must_use = "it is lost unless it is accepted"]
pub struct Solved<T> {
    /// Every coupling iteration.
    pub iterations: Vec<Iteration>,
    /// The structure's trial.
    pub trial: T,
    /// Displacement of the fluid's wall points, m.
    pub displacement: Vec<Vec3>,
    /// Load of the fluid on the wall at each face, Pa.
    pub tractions: Vec<Vec3>,
}

impl<F: Fluid, S: Solid> Coupling<F, S> {
    /// Solves one time step and accepts it.
    pub fn step(&mut self) -> Result<Step, FailedStep> {
        let solved = self.solve()?;
        self.accept(solved, Wanted::default())
    }

    /// Solves one time step; both solvers still have the state at its beginning.
    pub fn solve(&mut self) -> Result<Solved<S::Trial>, FailedStep> {
        self.solve_with_background_work(|_| ())
    }

    /// The same, and on another thread what is still to be done with the structure at the beginning of the step, while
    /// the fluid works at its first trial and the structure waits.
    pub fn solve_with_background_work(
        &mut self,
        beside: impl FnOnce(&S) + Send,
    ) -> Result<Solved<S::Trial>, FailedStep> {
        let dt = self.settings.time_step;
        let foreseen = self.transfer.foreseen(&self.solid, dt);
        let needs_load = foreseen.is_none() && self.settings.limits.is_elastic;
        let start = match foreseen {
            Some(known) => flatten(&known),
            None => self.fixed_point.predictor().first_guess(),
        };
        let mut step = CoupledStep {
            fluid: &mut self.fluid,
            solid: &mut self.solid,
            transfer: &self.transfer,
            settings: self.settings,
            effort: self.settings.fluid_effort,
            near: NEAR * self.fixed_point.criterion().relative,
            iterations: Vec::new(),
            trial: unflatten(self.fixed_point.predictor().last()),
            last: None,
            beside: Some(beside),
        };
        let done = self.fixed_point.solve_from(start, &mut step);
        self.settings.fluid_effort.from_old_state = step.effort.from_old_state;
        let CoupledStep {
            iterations,
            last,
            trial,
            ..
        } = step;
        let error = match (done, last) {
            (Ok(Some(_)), Some(last)) => {
                let end = iterations.last().expect("an answer has been judged");
                let limits = self.settings.limits;
                match limits.of_trial(end, &last, &self.transfer, &self.solid, needs_load) {
                    Ok(()) => {
                        return Ok(Solved {
                            iterations,
                            trial: last.trial,
                            displacement: trial,
                            tractions: last.flow.tractions,
                        });
                    }
                    Err(refusal) => refusal.into(),
                }
            }
            (Err(error), _) => error,
            _ => {
                let limit = self.settings.fluid_effort.max_sweeps;
                CouplingError::NotConverged(diagnosis::diagnosis(&iterations, limit))
            }
        };
        if let CouplingError::Refused(Refusal::Diverging { .. }) = error {
            self.fixed_point.acquit();
        }
        Err(self.failed(iterations, &trial, error))
    }

    /// Makes a solved step the new state of both sides; what is `wanted` comes from the fluid.
    pub fn accept(&mut self, solved: Solved<S::Trial>, wanted: Wanted) -> Result<Step, FailedStep> {
        let Solved {
            mut iterations,
            trial,
            displacement,
            tractions,
        } = solved;
        let clock = Instant::now();
        let fluid = match self.fluid.accept(wanted) {
            Ok(fluid) => fluid,
            Err(error) => return Err(self.failed(iterations, &displacement, error.into())),
        };
        let accept_seconds = clock.elapsed().as_secs_f64();
        let limits = self.settings.limits;
        let judged = limits.of_step(
            &fluid,
            self.settings.time_step,
            &self.balance,
            &self.transfer,
        );
        let mass_lost = match judged {
            Ok((balance, lost)) => {
                self.balance = balance;
                lost
            }
            Err(refusal) => {
                let error = CouplingError::RefusedTooLate(refusal);
                return Err(self.failed(iterations, &displacement, error));
            }
        };
        let clock = Instant::now();
        self.solid.accept(trial);
        if let Some(last) = iterations.last_mut() {
            last.structure_seconds += clock.elapsed().as_secs_f64();
        }
        self.fixed_point.accept(flatten(&displacement));
        let areas = self.transfer.face_areas(&displacement);
        let loads = tractions.iter().zip(&fluid.wall_shear).zip(&areas);
        Ok(Step {
            iterations,
            // The load is p n and the wall shear stress.
            wall_pressure: loads
                .map(|((load, shear), area)| (load - shear).dot(&area.normalize()))
                .collect(),
            fluid,
            displacement,
            accept_seconds,
            mass_lost,
        })
    }

    /// A step that failed at the displacement `trial` (m).
    fn failed(
        &self,
        iterations: Vec<Iteration>,
        trial: &[Vec3],
        error: CouplingError,
    ) -> FailedStep {
        let accepted = unflatten(self.fixed_point.predictor().last());
        let shifts = [trial, &accepted].map(|d| self.transfer.centre_shift(d));
        let shifts = shifts.into_iter().flatten();
        FailedStep {
            iterations,
            centre_shift: shifts
                .max_by(|a, b| a.shift.total_cmp(&b.shift))
                .map(Box::new),
            error,
        }
    }

    /// Makes the next step a more careful attempt, the `attempt`-th (from 2), at the one that failed: from the old
    /// state of the fluid, and as [`FixedPoint::back_off`] says.
    pub fn back_off(&mut self, attempt: usize) {
        self.settings.fluid_effort.from_old_state = true;
        self.fixed_point.back_off(attempt);
    }

    /// The next step ends at this time (s).
    pub fn begin_step(&mut self, end: f64) {
        self.fixed_point.begin_step(end, self.settings.time_step);
    }

    /// Makes the next time steps `time_step` (s) long.
    pub fn set_time_step(&mut self, time_step: f64) {
        if time_step != self.settings.time_step {
            (self.fixed_point).change_time_step(time_step / self.settings.time_step);
            self.settings.time_step = time_step;
        }
    }
}

/// The two solvers within one time step, with the books of its iterations.
struct CoupledStep<'a, F, S: Solid, B> {
    fluid: &'a mut F,
    solid: &'a mut S,
    transfer: &'a Transfer<S::Location>,
    settings: StepSettings,
    /// What the fluid may spend on the next trial.
    effort: FluidEffort,
    /// Coupling residual from which on Newton's iteration must not end early.
    near: f64,
    iterations: Vec<Iteration>,
    /// The last trial displacement, m.
    trial: Vec<Vec3>,
    last: Option<Answer<S::Trial>>,
    /// What is to be done with the structure before it is asked.
    beside: Option<B>,
}

/// What the solvers answered to the last trial.
struct Answer<T> {
    flow: FluidTrial,
    /// Area vectors of the fluid's faces, m².
    areas: Vec<Vec3>,
    load: SurfaceLoad,
    trial: T,
    newton_tolerance: f64,
    fluid_seconds: f64,
    structure_seconds: f64,
    /// Since the structure has answered.
    clock: Instant,
}

impl<F: Fluid, S: Solid, B: FnOnce(&S) + Send> CoupledProblem for CoupledStep<'_, F, S, B> {
    type Error = CouplingError;

    fn image(&mut self, d: &DVector<f64>, residual: f64) -> Result<DVector<f64>, CouplingError> {
        let dt = self.settings.time_step;
        self.trial = unflatten(d);
        let solid = &*self.solid;
        let (flow, fluid_seconds) = thread::scope(|threads| {
            if let Some(beside) = self.beside.take() {
                threads.spawn(move || beside(solid));
            }
            let clock = Instant::now();
            let flow = (self.fluid).solve(&self.trial, dt, self.effort); // F
            (flow, clock.elapsed().as_secs_f64())
        });
        self.effort.from_old_state = false;
        let flow = flow?;
        require_finite(&flow, self.transfer)?;
        let areas = self.transfer.face_areas(&self.trial);
        let load = self.transfer.load(&flow.tractions, &areas); // I: face centres to quadrature points

        let clock = Instant::now();
        let newton_tolerance = self.newton_tolerance(residual);
        let start = self.last.take().map(|last| last.trial);
        let trial = (self.solid).solve(&load, dt, newton_tolerance, start.as_ref())?; // S
        let structure_seconds = clock.elapsed().as_secs_f64();
        let clock = Instant::now();
        let image = flatten(&self.transfer.displacement(self.solid, &trial)); // I: structure to fluid points
        self.last = Some(Answer {
            flow,
            areas,
            load,
            trial,
            newton_tolerance,
            fluid_seconds,
            structure_seconds,
            clock,
        });
        Ok(image)
    }

    fn judged(&mut self, measure: ResidualMeasure, columns: Columns) -> Result<(), CouplingError> {
        let Some(last) = &mut self.last else {
            return Ok(());
        };
        let coupling_seconds = last.clock.elapsed().as_secs_f64();
        let tight = self.settings.newton_tolerance;
        if measure.converged && last.newton_tolerance > tight {
            let (clock, dt) = (Instant::now(), self.settings.time_step);
            last.trial = (self.solid).solve(&last.load, dt, tight, Some(&last.trial))?;
            last.structure_seconds += clock.elapsed().as_secs_f64();
        }
        let wet_areas = self.solid.deformed_areas(&last.trial);
        self.iterations.push(Iteration {
            number: self.iterations.len() + 1,
            measure,
            columns: columns.used,
            dropped: columns.dropped,
            fluid_cost: last.flow.cost,
            force_mismatch: force_mismatch(
                &last.flow.tractions,
                &last.areas,
                &last.load,
                &wet_areas,
            ),
            fluid_seconds: last.fluid_seconds,
            structure_seconds: last.structure_seconds,
            coupling_seconds,
        });
        let max_sweeps = self.effort.max_sweeps;
        Ok(self
            .settings
            .limits
            .of_iterations(&self.iterations, max_sweeps)?)
    }
}

impl<F, S: Solid, B> CoupledStep<'_, F, S, B> {
    /// The relative residual at which the structure's Newton iteration may end after a coupling `residual`.
    fn newton_tolerance(&self, residual: f64) -> f64 {
        let tight = self.settings.newton_tolerance;
        if residual < self.near {
            tight
        } else {
            tight.max(EASE * residual)
        }
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
