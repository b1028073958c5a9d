//! A fixed point of two functions, stepped in time: `cargo run --release -p fsi-coupling --example two_functions`.
//!
//! A piston of the mass `m` on a spring closes a pipe with a column of water of the mass `a`. With implicit Euler each
//! half is a function, given the state at the beginning of the step:
//! ```text
//! F: the position d of the piston ↦ the force of the water, f = -a (d - d_predicted)/dt²
//! S: the force f ↦ the position of the piston, m (d - d_predicted)/dt² + k d = f + load(t)
//! ```
//! The slope of `S∘F` is about `-a/m`: with more water than piston, plain iteration diverges. This is the added mass
//! that makes blood in an artery hard to couple. The program compares the ways to find the fixed point, and the answer
//! with that of both equations solved together.

use fsi_coupling::acceleration::{
    AccelerationModel, AccelerationSettings, Columns, Filter, Identity,
};
use fsi_coupling::convergence::{ConvergenceQuantity, Criterion, ResidualMeasure};
use fsi_coupling::fixed_point::{CoupledProblem, FixedPoint};
use fsi_coupling::predictor::{Extrapolation, Predictor};
use nalgebra::{DVector, dvector};
use std::convert::Infallible;

const PISTON: f64 = 1.0; // kg
const WATER: f64 = 5.0; // kg
const SPRING: f64 = 400.0; // N/m
const STEP: f64 = 0.01; // s
const STEPS: usize = 100;

/// 1. The coupled problem: the state at the beginning of the step, and the number of calls of the two functions.
#[derive(Default)]
struct Piston {
    step: usize,
    position: f64,
    velocity: f64,
    calls: usize,
}

impl Piston {
    fn load(&self) -> f64 {
        let time = (self.step + 1) as f64 * STEP;
        10.0 * (7.0 * time).sin()
    }

    fn water(&self, d: f64) -> f64 {
        -WATER * (d - self.coasting()) / STEP.powi(2)
    }

    fn piston(&self, force: f64) -> f64 {
        let inertia = PISTON / STEP.powi(2);
        (inertia * self.coasting() + force + self.load()) / (inertia + SPRING)
    }

    /// Where the piston would be without any force, m.
    fn coasting(&self) -> f64 {
        self.position + STEP * self.velocity
    }

    /// Both equations at once.
    fn exact(&self) -> f64 {
        let inertia = (PISTON + WATER) / STEP.powi(2);
        (inertia * self.coasting() + self.load()) / (inertia + SPRING)
    }

    fn accept(&mut self, d: f64) {
        self.velocity = (d - self.position) / STEP;
        self.position = d;
        self.step += 1;
    }
}

/// 2. What the iteration asks of it: the image `S∘F(d)`.
impl CoupledProblem for Piston {
    type Error = Infallible;

    fn image(&mut self, d: &DVector<f64>, _: f64) -> Result<DVector<f64>, Infallible> {
        self.calls += 1;
        Ok(dvector![self.piston(self.water(d[0]))])
    }

    fn judged(&mut self, _: ResidualMeasure, _: Columns) -> Result<(), Infallible> {
        Ok(())
    }
}

fn main() {
    println!("model          calls per step   largest error");
    for model in AccelerationModel::ALL {
        // 3. The iteration: acceleration, prediction, criterion.
        let relaxation = PISTON / (PISTON + WATER); // what constant relaxation needs
        let settings = AccelerationSettings {
            relaxation,
            reuse: 3,
            filter: Filter::exact(1e-6),
            max_columns: 10,
        };
        let criterion = Criterion {
            quantity: ConvergenceQuantity::Residual,
            relative: 1e-10,
            absolute: 1e-14,
            displaced: 0.0,
            max_iterations: 200,
            share: 1.0,
        };
        let mut fixed_point = FixedPoint::new(
            model.build(&settings, Box::new(Identity)),
            relaxation,
            Predictor::new(Extrapolation::Quadratic, dvector![0.0]),
            criterion,
        );
        // 4. Time steps: solve, then accept on both sides.
        let mut piston = Piston::default();
        let mut error: f64 = 0.0;
        for _ in 0..STEPS {
            let Ok(solution) = fixed_point.solve(&mut piston);
            let solution = solution.expect("it converges");
            error = error.max((solution[0] - piston.exact()).abs());
            piston.accept(solution[0]);
            fixed_point.accept(solution);
        }
        let calls = piston.calls as f64 / STEPS as f64;
        println!("{:<15}{calls:>14.1}{error:>14.1e} m", model.name());
        assert!(error < 1e-9, "{}: {error:e}", model.name());
    }
}
