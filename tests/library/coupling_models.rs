//! Every acceleration model, reuse and predictor against problems whose coupled solution is known.

use fsi_driver::coupling::acceleration::{
    AccelerationModel, AccelerationSettings, Filter, Identity,
};
use fsi_driver::coupling::convergence::Criterion;
use fsi_driver::coupling::fixed_point::FixedPoint;
use fsi_driver::coupling::predictor::{Extrapolation, Predictor};
use fsi_driver::coupling::reference::combinations::{Combination, problems};
use fsi_driver::coupling::reference::march;
use rayon::prelude::*;

/// Compares every combination of settings to the exact solution of problem `index`.
fn all_reach_the_exact_solution(index: usize, tolerance: f64, allowed: f64) {
    let exact = problems()[index].exact();
    Combination::all().into_par_iter().for_each(|trial| {
        let history = trial.run(problems()[index].as_mut(), tolerance);
        let last = history.residuals.last();
        assert!(history.converged, "{trial:?}: {last:?}");
        let difference = history.difference(&exact);
        assert!(difference < allowed, "{trial:?}: {difference:e}");
    });
}

#[test]
fn the_linear_problem_is_solved_to_1e_8() {
    all_reach_the_exact_solution(0, 1e-10, 1e-8);
}

#[test]
fn the_artery_is_solved_as_by_the_monolithic_method_to_1e_8() {
    all_reach_the_exact_solution(1, 1e-10, 1e-8);
}

#[test]
fn the_pressure_pulse_is_the_monolithic_one_to_1e_8() {
    all_reach_the_exact_solution(2, 1e-10, 1e-8);
}

/// At the tolerance of a computation the histories agree within ten times that.
#[test]
fn histories_agree_within_ten_tolerances() {
    for index in 0..3 {
        all_reach_the_exact_solution(index, 1e-6, 1e-5);
    }
}

#[test]
fn plain_iteration_diverges_on_all_of_them() {
    for mut problem in problems() {
        let settings = AccelerationSettings {
            relaxation: 1.0,
            reuse: 0,
            filter: Filter::exact(0.0),
            max_columns: 0,
        };
        let fixed_point = FixedPoint::new(
            AccelerationModel::Constant.build(&settings, Box::new(Identity)),
            settings.relaxation,
            Predictor::new(Extrapolation::Constant, problem.at_rest()),
            Criterion::of_residual(1e-6, 20),
        );
        let history = march(problem.as_mut(), fixed_point);
        let last = history.residuals.last().unwrap();
        assert!(!history.converged, "{}: {last:?}", problem.name());
    }
}

#[test]
fn memory_and_the_surrogate_save_iterations() {
    for index in 0..3 {
        let mean = |kind, reuse, surrogate| {
            let extrapolation = Extrapolation::Quadratic;
            let trial = Combination {
                kind,
                reuse,
                surrogate,
                extrapolation,
            };
            trial.run(problems()[index].as_mut(), 1e-6).mean()
        };
        let without = mean(AccelerationModel::IqnLs, 0, false);
        assert!(mean(AccelerationModel::IqnLs, 0, true) < without, "{index}");
        for kind in [
            AccelerationModel::IqnLs,
            AccelerationModel::MultiVector,
            AccelerationModel::Hybrid,
        ] {
            assert!(mean(kind, 10, false) < without, "{kind:?} {index}");
        }
    }
}
