//! The inverse of the tangent, approximated by an old factorization and what the iterations since have shown.
//!
//! Each iteration moves by a step `s` and so changes the residual by `y`. The BFGS formula corrects the inverse `H` of
//! the factorized tangent, by as little as possible, such that it stays symmetric, positive definite, and `H y = s` for
//! the pairs that are remembered (Matthies, Strang: *The solution of nonlinear finite element equations*, 1979; the
//! product by two loops over the pairs: Nocedal, *Updating quasi-Newton matrices with limited storage*, 1980).

use super::super::SolidError;
use super::super::element::predicted_pressure::{Origin, VolumeGradients, Volumes};
use super::super::linear_algebra::factor::Factorization;
use fsi_numerics::dot;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Most pairs that are remembered.
const MAX_PAIRS: usize = 20;

/// A step of an iteration, and the change of the residual that it caused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Pair {
    step: Vec<f64>,
    change: Vec<f64>,
    /// `s · y`.
    curvature: f64,
}

/// What iterations with a kept factorization have shown.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct QuasiNewtonPairs {
    /// Oldest first.
    pairs: VecDeque<Pair>,
    /// Number of solutions.
    solutions: usize,
}

/// A factorized tangent and the experience with it.
#[derive(Debug, Clone)]
pub struct KeptTangent {
    factorization: Factorization,
    /// Where it was assembled, if the pressure is predicted with it.
    volume_gradients: Option<VolumeGradients>,
    /// Since it was factorized.
    pub experience: QuasiNewtonPairs,
}

impl KeptTangent {
    /// Of a fresh factorization.
    pub fn new(factorization: Factorization, volume_gradients: Option<VolumeGradients>) -> Self {
        Self {
            factorization,
            volume_gradients,
            experience: QuasiNewtonPairs::default(),
        }
    }

    /// Whence the iterate comes that a step with this tangent led to from one with the volumes `before`; none if no
    /// pressure is predicted.
    pub fn origin<'a>(&'a self, before: Option<&'a Volumes>) -> Option<Origin<'a>> {
        let gradients = self.volume_gradients.as_ref()?;
        Some(Origin { gradients, before })
    }

    /// Whether the pressure is predicted with it. Then there is nothing to learn from iterations: what the residual
    /// changes by is not a matter of the step alone, but of the pressure's defect before it as well.
    pub fn predicts_pressure(&self) -> bool {
        self.volume_gradients.is_some()
    }

    /// Replaces a residual by the approximate solution of the linear system.
    pub fn solve(&self, residual: &mut [f64]) -> Result<(), SolidError> {
        let pairs = &self.experience.pairs;
        let mut weights = Vec::with_capacity(pairs.len());
        for pair in pairs.iter().rev() {
            let weight = dot(&pair.step, residual) / pair.curvature;
            add(residual, -weight, &pair.change);
            weights.push(weight);
        }
        self.factorization.solve(residual)?;
        for (pair, weight) in pairs.iter().zip(weights.iter().rev()) {
            let other = dot(&pair.change, residual) / pair.curvature;
            add(residual, weight - other, &pair.step);
        }
        Ok(())
    }

    /// Remembers a pair, unless it belongs to a direction of negative curvature.
    pub fn learn(&mut self, step: Vec<f64>, change: Vec<f64>) {
        let curvature = dot(&step, &change);
        if curvature > 0.0 {
            let pairs = &mut self.experience.pairs;
            if pairs.len() == MAX_PAIRS {
                pairs.pop_front();
            }
            pairs.push_back(Pair {
                step,
                change,
                curvature,
            });
        }
    }

    /// Notes that a solution was found.
    pub fn solved(&mut self) {
        self.experience.solutions += 1;
    }

    /// Number of negative eigenvalues of the factorized tangent.
    pub fn negative_eigenvalues(&self) -> usize {
        self.factorization.negative_eigenvalues()
    }

    /// Number of solutions since the factorization.
    pub fn solutions(&self) -> usize {
        self.experience.solutions
    }
}

fn add(to: &mut [f64], scale: f64, vector: &[f64]) {
    to.iter_mut().zip(vector).for_each(|(t, v)| *t += scale * v);
}
