//! A reference problem taken through its time steps as the driver does: predict, iterate, accept.

use super::Reference;
use crate::coupling::acceleration::Acceleration;
use crate::coupling::predictor::{Extrapolation, Predictor};
use nalgebra::DVector;

/// What happened in the steps that were computed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// Relative residuals `|d_tilde - d|/|d_tilde|` of the coupling iterations of each step.
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

/// Computes all steps of `problem`. A step has converged when the residual, relative to the displacement, is below
/// `tolerance`; the computation ends early if one does not within `most` iterations.
pub fn march(
    problem: &mut dyn Reference,
    model: &mut dyn Acceleration,
    mut predictor: Predictor,
    tolerance: f64,
    most: usize,
) -> History {
    let mut history = History::default();
    for _ in 0..problem.steps() {
        history.predictions.push(predictor.current());
        history.residuals.push(Vec::new());
        let residuals = history.residuals.last_mut().expect("just added");
        let mut d = predictor.first_guess();
        loop {
            let d_tilde = problem.image(&d);
            let next = model.next(&d, &d_tilde);
            let residual = (&d_tilde - &d).norm() / d_tilde.norm();
            residuals.push(residual);
            if residual < tolerance {
                break;
            }
            if residuals.len() == most || !residual.is_finite() {
                return history;
            }
            d = next;
        }
        problem.accept(&d);
        model.finish_step();
        predictor.accept(d.clone());
        history.displacements.push(d);
    }
    history.converged = true;
    history
}
