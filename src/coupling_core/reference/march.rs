//! A reference problem taken through its time steps as the driver does: predict, iterate, accept.

use super::Reference;
use crate::acceleration::Columns;
use crate::convergence::ResidualMeasure;
use crate::fixed_point::{CoupledProblem, FixedPoint};
use crate::predictor::Extrapolation;
use nalgebra::DVector;
use std::convert::Infallible;

/// What happened in the steps that were computed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// Relative residuals `|d_tilde - d|/|d|` of the coupling iterations of each step.
    pub residuals: Vec<Vec<f64>>,
    /// Accepted displacement of each step.
    pub displacements: Vec<DVector<f64>>,
    /// Extrapolation that each step began with.
    pub predictions: Vec<Extrapolation>,
    /// Whether every step converged; if not, the last one is incomplete and was not accepted.
    pub converged: bool,
}

impl History {
    /// Coupling iterations of each step.
    pub fn iterations(&self) -> impl Iterator<Item = usize> {
        self.residuals.iter().map(Vec::len)
    }

    /// Mean number of coupling iterations of a step.
    pub fn mean(&self) -> f64 {
        self.iterations().sum::<usize>() as f64 / self.residuals.len() as f64
    }

    /// Largest number of coupling iterations of a step.
    pub fn most(&self) -> usize {
        self.iterations().max().unwrap_or(0)
    }

    /// Largest difference to `other` of a step, relative to the largest displacement.
    pub fn difference(&self, other: &[DVector<f64>]) -> f64 {
        let size = other.iter().map(DVector::norm).fold(0.0, f64::max);
        let pairs = self.displacements.iter().zip(other);
        pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / size
    }
}

/// A step of a reference problem, and the residuals of its iterations.
struct Step<'a> {
    problem: &'a mut dyn Reference,
    residuals: Vec<f64>,
}

impl CoupledProblem for Step<'_> {
    type Error = Infallible;

    fn image(&mut self, d: &DVector<f64>, _: f64) -> Result<DVector<f64>, Infallible> {
        Ok(self.problem.image(d))
    }

    fn judged(&mut self, measure: ResidualMeasure, _: Columns) -> Result<(), Infallible> {
        self.residuals.push(measure.residual);
        Ok(())
    }
}

/// Computes all steps of `problem` by the iteration of a coupled run; ends early if one does not converge.
pub fn march(problem: &mut dyn Reference, mut fixed_point: FixedPoint) -> History {
    let mut history = History::default();
    for _ in 0..problem.steps() {
        history.predictions.push(fixed_point.predictor().current());
        let mut step = Step {
            problem: &mut *problem,
            residuals: Vec::new(),
        };
        let Ok(converged) = fixed_point.solve(&mut step);
        history.residuals.push(step.residuals);
        let Some(d) = converged else {
            return history;
        };
        problem.accept(&d);
        fixed_point.accept(d.clone());
        history.displacements.push(d);
    }
    history.converged = true;
    history
}
