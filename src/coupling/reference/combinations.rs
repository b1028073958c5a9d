//! Which settings a study of the acceleration compares, and one computation with each.

use super::{History, Linear, PartitionedTube, Reference, TubeSetup, march};
use crate::coupling::acceleration::{
    AccelerationModel, AccelerationSettings, Filter, Identity, Surrogate,
};
use crate::coupling::convergence::Criterion;
use crate::coupling::fixed_point::FixedPoint;
use crate::coupling::predictor::{Extrapolation, Predictor};

/// A combination of settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Combination {
    /// Acceleration model.
    pub kind: AccelerationModel,
    /// Number of steps that it remembers; 0 for models without memory.
    pub reuse: usize,
    /// Whether it is given the problem's surrogate.
    pub surrogate: bool,
    /// First guess of each step.
    pub extrapolation: Extrapolation,
}

impl Combination {
    /// Every model, with and without surrogate, with every predictor, and with memory of 0, 5 and 10 steps for those
    /// that can have it.
    pub fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for kind in AccelerationModel::ALL {
            let reuses: &[usize] = if kind.remembers() { &[0, 5, 10] } else { &[0] };
            for &reuse in reuses {
                for surrogate in [false, true] {
                    for extrapolation in Extrapolation::ALL {
                        all.push(Self {
                            kind,
                            reuse,
                            surrogate,
                            extrapolation,
                        });
                    }
                }
            }
        }
        all
    }

    /// Computes all steps of `problem` (see [`march`]).
    pub fn run(&self, problem: &mut dyn Reference, tolerance: f64) -> History {
        let (relaxation, surrogate): (f64, Box<dyn Surrogate>) = if self.surrogate {
            (0.9, problem.surrogate())
        } else {
            (problem.relaxation(), Box::new(Identity))
        };
        let settings = AccelerationSettings {
            relaxation,
            reuse: self.reuse,
            filter: Filter::new(1e-2, tolerance, self.surrogate),
            max_columns: 200,
        };
        let fixed_point = FixedPoint::new(
            self.kind.build(&settings, surrogate),
            relaxation,
            Predictor::new(self.extrapolation, problem.at_rest()),
            Criterion::of_residual(tolerance, 2000),
        );
        march(problem, fixed_point)
    }
}

/// The problems of the study, at rest.
pub fn problems() -> Vec<Box<dyn Reference>> {
    vec![
        Box::new(Linear::new(60, 20.0)),
        Box::new(PartitionedTube::new(TubeSetup::artery())),
        Box::new(PartitionedTube::new(TubeSetup::pressure_pulse())),
    ]
}
