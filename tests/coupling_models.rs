//! Every acceleration model, reuse and predictor against problems whose coupled solution is known.

use fsi_driver::coupling::acceleration::{Identity, Kind, Settings, Surrogate};
use fsi_driver::coupling::predictor::{Extrapolation, Predictor};
use fsi_driver::coupling::reference::{History, Linear, Reference, Tube, TubeSetup, march};
use nalgebra::DVector;
use rayon::prelude::*;

fn problems() -> [Box<dyn Reference>; 3] {
    [
        Box::new(Linear::new(60, 20.0)),
        Box::new(Tube::new(TubeSetup::artery())),
        Box::new(Tube::new(TubeSetup::pressure_pulse())),
    ]
}

/// Takes problem `index` of [`problems`] through all its steps.
fn run(
    index: usize,
    kind: Kind,
    reuse: usize,
    extrapolation: Extrapolation,
    with_surrogate: bool,
    tolerance: f64,
) -> History {
    let [a, b, c] = problems();
    let mut problem = [a, b, c].into_iter().nth(index).unwrap();
    let surrogate: Box<dyn Surrogate> = if with_surrogate {
        problem.surrogate()
    } else {
        Box::new(Identity)
    };
    let settings = Settings {
        relaxation: if with_surrogate {
            0.8
        } else {
            problem.relaxation()
        },
        reuse,
        filter: 1e-4,
        max_columns: 200,
    };
    let mut model = kind.build(&settings, surrogate);
    let predictor = Predictor::new(extrapolation, problem.at_rest());
    march(problem.as_mut(), model.as_mut(), predictor, tolerance, 2000)
}

/// Compares every model, reuse and predictor with and without surrogate to the exact solution of problem `index`.
fn all_reach_the_exact_solution(index: usize, tolerance: f64, allowed: f64) {
    let exact: Vec<DVector<f64>> = problems()[index].exact();
    let mut runs = Vec::new();
    for kind in Kind::ALL {
        for reuse in [0, 5, 10] {
            for extrapolation in Extrapolation::ALL {
                for surrogate in [false, true] {
                    if kind.remembers() || reuse == 0 {
                        runs.push((kind, reuse, extrapolation, surrogate));
                    }
                }
            }
        }
    }
    runs.into_par_iter()
        .for_each(|(kind, reuse, extrapolation, surrogate)| {
            let history = run(index, kind, reuse, extrapolation, surrogate, tolerance);
            let what = format!("{kind:?}, q = {reuse}, {extrapolation:?}, surrogate {surrogate}");
            assert!(history.converged, "{what}: {:?}", history.residuals.last());
            let difference = history.difference(&exact);
            assert!(difference < allowed, "{what}: {difference:e}");
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
fn the_pressure_pulse_is_solved_as_by_the_monolithic_method_to_1e_8() {
    all_reach_the_exact_solution(2, 1e-10, 1e-8);
}

#[test]
fn at_the_tolerance_of_a_computation_the_histories_agree_within_ten_times_that() {
    for index in 0..3 {
        all_reach_the_exact_solution(index, 1e-6, 1e-5);
    }
}

#[test]
fn plain_iteration_diverges_on_all_of_them() {
    for mut problem in problems() {
        let settings = Settings {
            relaxation: 1.0,
            reuse: 0,
            filter: 0.0,
            max_columns: 0,
        };
        let mut model = Kind::Constant.build(&settings, Box::new(Identity));
        let predictor = Predictor::new(Extrapolation::Constant, problem.at_rest());
        let history = march(problem.as_mut(), model.as_mut(), predictor, 1e-6, 50);
        let residuals = history.residuals.last().unwrap();
        assert!(!history.converged, "{}", problem.name());
        assert!(
            residuals.last().unwrap() > &residuals[0],
            "{}: {residuals:?}",
            problem.name()
        );
    }
}

#[test]
fn memory_and_the_surrogate_save_iterations() {
    for index in 0..3 {
        let mean = |kind, reuse, surrogate| {
            run(
                index,
                kind,
                reuse,
                Extrapolation::Quadratic,
                surrogate,
                1e-6,
            )
            .mean()
        };
        let without_memory = mean(Kind::IqnLs, 0, false);
        assert!(mean(Kind::IqnLs, 0, true) < without_memory, "{index}");
        for kind in [Kind::IqnLs, Kind::MultiVector, Kind::Hybrid] {
            assert!(mean(kind, 10, false) < without_memory, "{kind:?} {index}");
        }
    }
}
