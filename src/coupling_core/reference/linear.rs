//! A linear interface problem with a dial for the added mass.

use super::Reference;
use crate::acceleration::Surrogate;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// `d_tilde = b(t) - A d`, where `A` has the spectrum of an added-mass operator: its eigenvectors are waves, that of
/// the greatest length has the eigenvalue `added_mass`, the k-th `added_mass/k²`. Plain fixed-point iteration diverges
/// if `added_mass` is above 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    added_mass: f64,
    /// Eigenvectors as columns.
    modes: DMatrix<f64>,
    a: DMatrix<f64>,
    step: usize,
}

impl Linear {
    /// The problem with `n` unknowns.
    pub fn new(n: usize, added_mass: f64) -> Self {
        let m = n as f64 + 1.0;
        let modes = DMatrix::from_fn(n, n, |i, k| {
            (2.0 / m).sqrt() * (PI * (k as f64 + 1.0) * (i as f64 + 1.0) / m).sin()
        });
        let eigenvalues = DVector::from_fn(n, |k, _| added_mass / (k as f64 + 1.0).powi(2));
        let a = &modes * DMatrix::from_diagonal(&eigenvalues) * modes.transpose();
        Self {
            added_mass,
            modes,
            a,
            step: 0,
        }
    }

    /// The load of step `step`: all modes, oscillating at different rates.
    fn load(&self, step: usize) -> DVector<f64> {
        let t = step as f64 + 1.0;
        let amplitude = |k: usize| {
            let k = k as f64 + 1.0;
            (0.1 * t * k.sqrt() + k).sin() / k
        };
        let n = self.modes.ncols();
        &self.modes * DVector::from_fn(n, |k, _| self.added_mass * amplitude(k))
    }
}

impl Reference for Linear {
    fn name(&self) -> &str {
        "linear"
    }

    fn steps(&self) -> usize {
        60
    }

    fn at_rest(&self) -> DVector<f64> {
        DVector::zeros(self.modes.nrows())
    }

    fn relaxation(&self) -> f64 {
        1.0 / (1.0 + self.added_mass)
    }

    fn image(&mut self, d: &DVector<f64>) -> DVector<f64> {
        self.load(self.step) - &self.a * d
    }

    fn accept(&mut self, _d: &DVector<f64>) {
        self.step += 1;
    }

    fn surrogate(&self) -> Box<dyn Surrogate> {
        let count = self.modes.ncols().min(5);
        Box::new(LongWaves {
            added_mass: 1.2 * self.added_mass,
            modes: self.modes.columns(0, count).into_owned(),
        })
    }

    fn exact(&self) -> Vec<DVector<f64>> {
        let n = self.modes.nrows();
        let lu = (DMatrix::identity(n, n) + &self.a).lu();
        (0..self.steps())
            .map(|step| {
                lu.solve(&self.load(step))
                    .expect("1 + A is positive definite")
            })
            .collect()
    }
}

/// Knows the longest waves, and their added mass only roughly.
struct LongWaves {
    added_mass: f64,
    modes: DMatrix<f64>,
}

impl Surrogate for LongWaves {
    fn predict(&self, residual: &DVector<f64>) -> DVector<f64> {
        let mut change = self.modes.transpose() * residual;
        for (k, share) in change.iter_mut().enumerate() {
            let eigenvalue = self.added_mass / (k as f64 + 1.0).powi(2);
            *share *= 1.0 / (1.0 + eigenvalue) - 1.0;
        }
        residual + &self.modes * change
    }
}
