//! Acceleration where the two solvers answer only to a tolerance: their error must not be taken for the Jacobian.

use fsi_driver::coupling::acceleration::{
    AccelerationModel, AccelerationSettings, Filter, Identity, Surrogate,
};
use fsi_driver::coupling::convergence::Criterion;
use fsi_driver::coupling::fixed_point::FixedPoint;
use fsi_driver::coupling::predictor::{Extrapolation, Predictor};
use fsi_driver::coupling::reference::combinations::problems;
use fsi_driver::coupling::reference::{History, Reference, march};
use nalgebra::DVector;

/// A problem whose image carries an error that changes from call to call.
struct Noisy {
    problem: Box<dyn Reference>,
    /// Size of the error relative to the displacement.
    level: f64,
    calls: f64,
}

impl Reference for Noisy {
    fn name(&self) -> &str {
        self.problem.name()
    }
    fn steps(&self) -> usize {
        self.problem.steps()
    }
    fn at_rest(&self) -> DVector<f64> {
        self.problem.at_rest()
    }
    fn relaxation(&self) -> f64 {
        self.problem.relaxation()
    }
    fn image(&mut self, d: &DVector<f64>) -> DVector<f64> {
        self.calls += 1.0;
        let image = self.problem.image(d);
        let scatter = |i: usize| (1e4 * (self.calls + 0.37 * i as f64).sin()).fract();
        let error = DVector::from_fn(image.len(), |i, _| scatter(i));
        let size = self.level * image.norm() / error.norm();
        image + size * error
    }
    fn accept(&mut self, d: &DVector<f64>) {
        self.problem.accept(d);
    }
    fn surrogate(&self) -> Box<dyn Surrogate> {
        self.problem.surrogate()
    }
    fn exact(&self) -> Vec<DVector<f64>> {
        self.problem.exact()
    }
}

/// Tolerance of the coupling, and the error of the solvers.
const TOLERANCE: f64 = 1e-4;
const ERROR: f64 = 2e-5;

fn run(index: usize, kind: AccelerationModel, resolution: f64, surrogate: bool) -> History {
    let problem = problems().swap_remove(index);
    let mut noisy = Noisy {
        problem,
        level: ERROR,
        calls: 0.0,
    };
    let start: Box<dyn Surrogate> = if surrogate {
        noisy.surrogate()
    } else {
        Box::new(Identity)
    };
    let settings = AccelerationSettings {
        relaxation: if surrogate { 0.9 } else { noisy.relaxation() },
        reuse: 10,
        filter: Filter::new(1e-2, resolution, surrogate),
        max_columns: 100,
    };
    let fixed_point = FixedPoint::new(
        kind.build(&settings, start),
        settings.relaxation,
        Predictor::new(Extrapolation::Quadratic, noisy.at_rest()),
        Criterion::of_residual(TOLERANCE, 100),
    );
    march(&mut noisy, fixed_point)
}

#[test]
fn errors_of_a_fifth_of_the_tolerance_are_borne() {
    for index in 0..3 {
        let exact = problems()[index].exact();
        for kind in [
            AccelerationModel::IqnLs,
            AccelerationModel::MultiVector,
            AccelerationModel::Hybrid,
        ] {
            for surrogate in [false, true] {
                let history = run(index, kind, TOLERANCE, surrogate);
                let (most, difference) = (history.most(), history.difference(&exact));
                assert!(history.converged, "{kind:?} {index} {surrogate}");
                assert!(most <= 10, "{kind:?} {index} {surrogate}: {most}");
                assert!(
                    difference < 10.0 * TOLERANCE,
                    "{kind:?} {index}: {difference:e}"
                );
            }
        }
    }
}

#[test]
fn without_a_resolution_least_squares_fit_the_noise() {
    for index in [0, 2] {
        assert!(!run(index, AccelerationModel::IqnLs, 0.0, false).converged);
    }
}
