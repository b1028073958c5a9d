//! Convergence acceleration, **A** in equation (13): from `d` and `d_tilde = S∘F(d)` to the next trial.
//!
//! Whatever the model, the next trial is `d + C r` with the residual `r = d_tilde - d` and some idea `C` of
//! `-(dr/dd)⁻¹`. The models differ in where they take `C` from:
//!
//! | model | `C r` | source |
//! | --- | --- | --- |
//! | [`Constant`] | `omega P r` | — |
//! | [`Aitken`] | `omega_k P r`, the factor from the last two residuals | Irons and Tuck 1969; Küttler and Wall 2008 |
//! | [`IqnLs`] | one least-squares fit with the columns of this step and the last `q` steps, `P` for the rest | Degroote, Bathe and Vierendeels 2009; filter: Haelterman et al. 2016 |
//! | [`MultiVector`] | a fit with the columns of this step; its rest to the fit of the step before, and so on; `P` for the last rest | Bogaers et al. 2014 (MVQN), Lindner et al. 2015 (IQN-IMVJ); without matrices: Spenke, Hosters and Behr 2020 |
//! | [`Hybrid`] | a fit with the columns of this step; its rest to *one* joint fit of the last `q` steps; `P` for the last rest | between the two above |
//!
//! `P` is the [`Surrogate`]: a cheap model of the two solvers, or the identity. All three quasi-Newton models agree as
//! long as nothing is remembered (`q = 0`). Beside a surrogate, columns are doubted the more the older they are (see
//! [`LeastSquares::predict`]), so that many steps can be remembered.
//!
//! The paper's "modified" variant comes from Radtke et al. 2016 (Comput. Mech. 58), who found a hybrid of two
//! well-known variants best. Its formulas were not at hand: [`Hybrid`] follows the description, not the text.
//!
//! Every model is a file of the same shape: a struct with its memory, a trait ([`Acceleration`] for the relaxations,
//! [`JacobianModel`] for what a [`QuasiNewton`] iteration remembers), tests on the linear problem of
//! [`reference`](super::reference).

mod aitken;
mod constant;
mod hybrid;
mod iqn_ls;
mod least_squares;
mod memory;
mod multi_vector;
mod quasi_newton;
pub mod surrogate;

pub use aitken::Aitken;
pub use constant::Constant;
pub use hybrid::Hybrid;
pub use iqn_ls::IqnLs;
pub use least_squares::{Columns, Filter, LeastSquares, Prediction, SecantPair};
pub use memory::AccelerationMemory;
pub use multi_vector::MultiVector;
pub use quasi_newton::{JacobianModel, QuasiNewton};
pub use surrogate::{Identity, Surrogate};

use fsi_numerics::words;
use nalgebra::DVector;

/// Finds the next trial of a fixed-point iteration.
pub trait Acceleration: Send {
    /// The next trial after `d`, whose image under structure and fluid is `d_tilde`.
    fn next(&mut self, d: &DVector<f64>, d_tilde: &DVector<f64>) -> DVector<f64>;

    /// The next calls are of a step of `length` (s) that ends at the time `end` (s).
    fn begin_step(&mut self, end: f64, length: f64);

    /// The step has converged at the `d` of the last call; what was learnt in it becomes memory.
    fn finish_step(&mut self);

    /// Forgets everything but its settings: for a step that failed and is tried again from its start.
    fn reset(&mut self);

    /// Replaces the relaxation factor of [`AccelerationSettings`].
    fn set_relaxation(&mut self, factor: f64);

    /// Holds nothing of the step that failed against what made its trials.
    fn acquit(&mut self) {}

    /// What was learnt in the accepted steps. Call it between two steps.
    fn memory(&self) -> AccelerationMemory;

    /// Continues as the one whose memory this is, where `d` is the displacement that was accepted last.
    fn recall(&mut self, memory: AccelerationMemory, d: &DVector<f64>);

    /// What the last trial was built from.
    fn columns(&self) -> Columns {
        Columns::default()
    }

    /// What a user should know and has not been told.
    fn notice(&mut self) -> Option<String> {
        None
    }
}

/// AccelerationSettings of all models; each takes what it needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AccelerationSettings {
    /// Relaxation factor: of every iteration ([`Constant`]), of the first iteration of a step ([`Aitken`]), of the very
    /// first iteration (the others).
    pub relaxation: f64,
    /// Number of earlier steps whose columns are remembered.
    pub reuse: usize,
    /// Which columns are dropped.
    pub filter: Filter,
    /// Most columns in memory; the oldest go first.
    pub max_columns: usize,
}

words! {
    /// How the next trial displacement is found.
    pub enum AccelerationModel {
        /// Constant relaxation.
        Constant = "constant",
        /// Aitken's dynamic relaxation.
        Aitken = "aitken",
        /// Interface quasi-Newton: one least-squares fit of the columns of this and earlier steps.
        IqnLs = "iqn_ls",
        /// Interface quasi-Newton: the Jacobian of the earlier steps, updated by the columns of this one.
        MultiVector = "multi_vector",
        /// Interface quasi-Newton: the columns of this step first; earlier ones for what those do not span.
        Hybrid = "hybrid",
    }
}

impl AccelerationModel {
    /// Whether the model learns from earlier steps.
    pub fn remembers(self) -> bool {
        !matches!(self, Self::Constant | Self::Aitken)
    }

    /// The model with its settings; `surrogate` is the initial inverse Jacobian ([`Identity`] if there is none).
    pub fn build(
        self,
        settings: &AccelerationSettings,
        surrogate: Box<dyn Surrogate>,
    ) -> Box<dyn Acceleration> {
        let AccelerationSettings {
            relaxation,
            reuse,
            filter,
            max_columns,
        } = *settings;
        match self {
            Self::Constant => Box::new(Constant::new(relaxation).with_surrogate(surrogate)),
            Self::Aitken => Box::new(Aitken::new(relaxation).with_surrogate(surrogate)),
            Self::IqnLs => {
                let model = IqnLs::new(reuse, filter, max_columns);
                Box::new(QuasiNewton::new(model, relaxation).with_surrogate(surrogate))
            }
            Self::MultiVector => {
                let model = MultiVector::new(reuse, filter, max_columns);
                Box::new(QuasiNewton::new(model, relaxation).with_surrogate(surrogate))
            }
            Self::Hybrid => {
                let model = Hybrid::new(reuse, filter, max_columns);
                Box::new(QuasiNewton::new(model, relaxation).with_surrogate(surrogate))
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::super::reference::{Linear, Reference};
    use super::*;

    /// Iterates on the first step of `problem` until the residual has fallen by 1e-10; returns the number of
    /// iterations and the solution, and finishes the step.
    pub fn iterate(
        problem: &mut Linear,
        model: &mut dyn Acceleration,
        most: usize,
    ) -> Option<(usize, DVector<f64>)> {
        let mut d = problem.at_rest();
        let mut first = None;
        for k in 1..=most {
            let d_tilde = problem.image(&d);
            let next = model.next(&d, &d_tilde);
            let residual = (&d_tilde - &d).norm();
            if residual < 1e-10 * *first.get_or_insert(residual) {
                model.finish_step();
                problem.accept(&d);
                return Some((k, d));
            }
            d = next;
        }
        None
    }

    /// The distance of `d` to the solution of step `step` of `problem`.
    pub fn error(problem: &Linear, step: usize, d: &DVector<f64>) -> f64 {
        let exact = &problem.exact()[step];
        (d - exact).norm() / exact.norm()
    }

    #[test]
    fn every_model_forgets_on_reset() {
        let settings = AccelerationSettings {
            relaxation: 0.1,
            reuse: 5,
            filter: Filter::exact(1e-6),
            max_columns: 100,
        };
        for kind in AccelerationModel::ALL {
            let trial = |model: &mut dyn Acceleration| {
                iterate(&mut Linear::new(20, 8.0), model, 1000).unwrap()
            };
            let mut model = kind.build(&settings, Box::new(Identity));
            let first = trial(model.as_mut());
            model.reset();
            assert_eq!(trial(model.as_mut()), first, "{}", kind.name());
        }
    }

    #[test]
    fn every_model_continues_to_the_bit_from_its_memory() {
        let settings = AccelerationSettings {
            relaxation: 0.1,
            reuse: 3,
            filter: Filter::exact(1e-3),
            max_columns: 12,
        };
        for kind in AccelerationModel::ALL {
            let mut problem = Linear::new(20, 8.0);
            let mut straight = kind.build(&settings, Box::new(Identity));
            let mut d = problem.at_rest();
            for _ in 0..4 {
                d = iterate(&mut problem, straight.as_mut(), 1000).unwrap().1;
            }
            let mut resumed = kind.build(&settings, Box::new(Identity));
            let bytes = postcard::to_stdvec(&straight.memory()).unwrap();
            resumed.recall(postcard::from_bytes(&bytes).unwrap(), &d);
            for _ in 0..2 {
                let mut same = problem.clone();
                let expected = iterate(&mut problem, straight.as_mut(), 1000);
                assert_eq!(
                    iterate(&mut same, resumed.as_mut(), 1000),
                    expected,
                    "{}",
                    kind.name()
                );
                assert_eq!(resumed.memory(), straight.memory(), "{}", kind.name());
            }
        }
    }
}
