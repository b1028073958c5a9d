//! The iteration of equation (13), whatever the two solvers are: `d_{k+1} = A(d_k, S∘F(d_k))` until criterion (14) is
//! met.

use super::acceleration::{Acceleration, AccelerationMemory, Columns};
use super::convergence::{Criterion, ResidualMeasure};
use super::predictor::Predictor;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// What the first residual of a step is taken for.
const FIRST_RESIDUAL: f64 = 1e-2;
/// Each further attempt at a step relaxes by this share of the factor of the attempt before.
const BACK_OFF: f64 = 0.2;

/// Two solvers joined at an interface, within one time step.
pub trait CoupledProblem {
    /// Why a solver failed.
    type Error;

    /// The image `S∘F(d)` of a trial displacement of the interface. `residual` is that of the trial before, relative to
    /// the displacement from the unloaded shape: the solvers need not be much more accurate.
    fn image(&mut self, d: &DVector<f64>, residual: f64) -> Result<DVector<f64>, Self::Error>;

    /// Learns how far the trial was from convergence, and which columns the next one was built from. After a measure
    /// that says converged there is no next one.
    fn judged(&mut self, measure: ResidualMeasure, columns: Columns) -> Result<(), Self::Error>;
}

/// Finds the fixed point of each time step, and learns from one step to the next.
pub struct FixedPoint {
    acceleration: Box<dyn Acceleration>,
    predictor: Predictor,
    criterion: Criterion,
    /// Relaxation factor of the acceleration.
    relaxation: f64,
}

/// What it keeps from one time step to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FixedPointMemory {
    /// Accepted displacements of the interface, newest first, m.
    pub displacements: Vec<Vec<f64>>,
    /// Errors of the predictor's candidates in the last step.
    pub predictor_errors: Vec<f64>,
    /// What the acceleration has learnt.
    pub acceleration: AccelerationMemory,
}

impl FixedPoint {
    /// With an acceleration whose usual relaxation factor is `relaxation`.
    pub fn new(
        acceleration: Box<dyn Acceleration>,
        relaxation: f64,
        predictor: Predictor,
        criterion: Criterion,
    ) -> Self {
        Self {
            acceleration,
            predictor,
            criterion,
            relaxation,
        }
    }

    /// The next [`FixedPoint::solve`] is of a step of `length` (s) that ends at the time `end` (s).
    pub fn begin_step(&mut self, end: f64, length: f64) {
        self.acceleration.begin_step(end, length);
    }

    /// Iterates from the predicted displacement to the one whose image it is; `None` if that takes too many iterations
    /// or leads nowhere.
    pub fn solve<P: CoupledProblem>(
        &mut self,
        problem: &mut P,
    ) -> Result<Option<DVector<f64>>, P::Error> {
        self.solve_from(self.predictor.first_guess(), problem)
    }

    /// The same from the displacement `start`.
    pub fn solve_from<P: CoupledProblem>(
        &mut self,
        start: DVector<f64>,
        problem: &mut P,
    ) -> Result<Option<DVector<f64>>, P::Error> {
        let mut d = start;
        let mut residual = FIRST_RESIDUAL;
        for _ in 0..self.criterion.max_iterations {
            let d_tilde = problem.image(&d, residual)?; // S∘F
            let d_next = self.acceleration.next(&d, &d_tilde); // A
            let columns = self.acceleration.columns();
            let (relaxed, last) = (columns.used == 0, self.predictor.last());
            let measure = (self.criterion).measure(&d, &d_tilde, &d_next, relaxed, last);
            problem.judged(measure, columns)?;
            if measure.converged {
                return Ok(Some(d));
            }
            if !measure.residual.is_finite() {
                break;
            }
            residual = self.criterion.share_of_all(&measure);
            d = d_next;
        }
        Ok(None)
    }

    /// The step has converged at `d`, where the last [`FixedPoint::solve`] ended: what was learnt becomes memory.
    pub fn accept(&mut self, d: DVector<f64>) {
        self.acceleration.finish_step();
        self.set_share(1.0);
        self.predictor.accept(d);
    }

    /// Makes the next [`FixedPoint::solve`] a more careful attempt, the `attempt`-th (from 2), at the step that failed:
    /// without what was learnt, with less relaxation, and from the third on from the last displacement: not before, for
    /// a wall that stops at once is a blow where there is much added mass.
    pub fn back_off(&mut self, attempt: usize) {
        if attempt > 2 {
            self.predictor.reset();
        }
        self.acceleration.reset();
        self.set_share(BACK_OFF.powi(attempt as i32 - 1));
    }

    /// The step that failed says nothing about the acceleration: one of the two solvers gave wrong answers.
    pub fn acquit(&mut self) {
        self.acceleration.acquit();
    }

    /// The next time steps are `ratio` times as long. What was learnt of the Jacobian in steps of another length is
    /// forgotten.
    pub fn change_time_step(&mut self, ratio: f64) {
        self.predictor.resample(ratio);
        self.acceleration.reset();
    }

    /// What a user should know of the acceleration and has not been told.
    pub fn notice(&mut self) -> Option<String> {
        self.acceleration.notice()
    }

    /// When it ends.
    pub fn criterion(&self) -> &Criterion {
        &self.criterion
    }

    /// Where it begins.
    pub fn predictor(&self) -> &Predictor {
        &self.predictor
    }

    /// Relaxes by this share of the usual factor from now on.
    fn set_share(&mut self, share: f64) {
        self.criterion.share = share;
        self.acceleration.set_relaxation(share * self.relaxation);
    }

    /// What is needed to continue later.
    pub fn memory(&self) -> FixedPointMemory {
        let (displacements, predictor_errors) = self.predictor.memory();
        FixedPointMemory {
            displacements,
            predictor_errors,
            acceleration: self.acceleration.memory(),
        }
    }

    /// Continues as the one whose memory this is.
    ///
    /// # Errors
    /// If it belongs to another interface.
    pub fn recall(&mut self, memory: FixedPointMemory) -> Result<(), ForeignMemory> {
        let unknowns = self.predictor.last().len();
        let fits = |d: &Vec<f64>| d.len() == unknowns && d.iter().all(|x| x.is_finite());
        if memory.displacements.is_empty()
            || !memory.displacements.iter().all(fits)
            || !memory.acceleration.fits_to(unknowns)
        {
            return Err(ForeignMemory {
                points: unknowns / 3,
            });
        }
        self.predictor
            .recall(memory.displacements, memory.predictor_errors);
        self.acceleration
            .recall(memory.acceleration, self.predictor.last());
        self.set_share(1.0);
        Ok(())
    }
}

/// A memory of another interface.
#[derive(Debug, thiserror::Error)]
#[error("what the coupling remembers does not belong to an interface of {points} points")]
pub struct ForeignMemory {
    /// Points of this one.
    pub points: usize,
}
