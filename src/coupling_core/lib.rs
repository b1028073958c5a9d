//! # fsi-coupling: the fixed point of two solvers
//!
//! Two solvers that share an interface, a fluid and a structure say, are solved one after the other until neither
//! changes any more: in each time step the unknown `d` of the interface (its displacement) is a fixed point of `S∘F`.
//! This crate finds it with few calls of the solvers, and learns from one step to the next. It knows nothing of what
//! they solve.
//!
//! ## A guided tour
//!
//! 1. [`fixed_point::CoupledProblem`] is what you write: the image `S∘F(d)` of a trial.
//! 2. [`fixed_point::FixedPoint`] iterates `d ← A(d, S∘F(d))`. It is made of three parts:
//! 3. [`predictor::Predictor`] extrapolates the accepted steps to the first trial of the next one;
//! 4. [`acceleration`] is `A`: relaxation, Aitken's method, interface quasi-Newton methods with memory;
//!    [`acceleration::AccelerationModel`] chooses one by its name;
//! 5. [`convergence::Criterion`] says when to stop.
//! 6. [`fixed_point::FixedPoint::memory`] is all that the next step depends on, to be stored: after
//!    [`recall`](fixed_point::FixedPoint::recall) a run continues to the last digit.
//! 7. [`reference`](mod@reference) has a problem whose answer is known, and [`reference::march`] to take it through its time steps.
//!
//! ```
//! use fsi_coupling::acceleration::{AccelerationModel, AccelerationSettings, Columns, Filter, Identity};
//! use fsi_coupling::convergence::{ConvergenceQuantity, Criterion, ResidualMeasure};
//! use fsi_coupling::fixed_point::{CoupledProblem, FixedPoint};
//! use fsi_coupling::predictor::{Extrapolation, Predictor};
//! use nalgebra::{DVector, dvector};
//! use std::convert::Infallible;
//!
//! /// x ← 2 - 3 y, y ← cos x: plain iteration diverges.
//! struct TwoFunctions {
//!     calls: usize,
//! }
//!
//! impl CoupledProblem for TwoFunctions {
//!     type Error = Infallible;
//!
//!     fn image(&mut self, d: &DVector<f64>, _: f64) -> Result<DVector<f64>, Infallible> {
//!         self.calls += 1;
//!         Ok(dvector![2.0 - 3.0 * d[1], d[0].cos()])
//!     }
//!
//!     fn judged(&mut self, _: ResidualMeasure, _: Columns) -> Result<(), Infallible> {
//!         Ok(())
//!     }
//! }
//!
//! let settings = AccelerationSettings {
//!     relaxation: 0.1,
//!     reuse: 0,
//!     filter: Filter::exact(1e-10),
//!     max_columns: 10,
//! };
//! let acceleration = AccelerationModel::IqnLs.build(&settings, Box::new(Identity));
//! let predictor = Predictor::new(Extrapolation::Constant, dvector![1.0, 1.0]);
//! let criterion = Criterion {
//!     quantity: ConvergenceQuantity::Residual,
//!     relative: 1e-12,
//!     absolute: 1e-12,
//!     displaced: 0.0,
//!     max_iterations: 50,
//!     share: 1.0,
//! };
//! let mut fixed_point = FixedPoint::new(acceleration, 0.1, predictor, criterion);
//! let mut problem = TwoFunctions { calls: 0 };
//! let solution = fixed_point.solve(&mut problem).unwrap().expect("it converges");
//! assert!((solution[0] - (2.0 - 3.0 * solution[0].cos())).abs() < 1e-9);
//! assert!(problem.calls < 15);
//! ```

pub mod acceleration;
pub mod convergence;
pub mod fixed_point;
pub mod predictor;
pub mod reference;
