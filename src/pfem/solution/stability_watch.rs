//! Looks now and then, on a thread of its own, whether a moving wall would stand without its inertia.
//!
//! Inertia keeps the tangent of a time step positive definite where that of statics no longer is, so that a wall that
//! buckles shows in a run only as a motion that grows. Findings are reported and change nothing.

use super::equation_of_motion::{EquationOfMotion, Linearization};
use std::sync::Arc;
use std::thread::{self, JoinHandle};

/// Accepted steps between two looks, each of which costs an assembly and a factorization next to the run.
const INTERVAL: usize = 20;

/// What was seen so far.
#[derive(Default)]
pub struct StabilityWatch {
    /// Accepted steps since the last look.
    steps: usize,
    /// A look that is under way, with the mean pressure at it.
    look: Option<(f64, JoinHandle<Option<bool>>)>,
    /// Mean pressure (Pa) at which the wall was first seen without stability.
    lost: Option<f64>,
    /// Whether that has been told.
    told: bool,
}

impl StabilityWatch {
    /// A step was accepted under a mean `pressure` (Pa); `at` is what the tangent there is assembled from.
    pub fn accepted(
        &mut self,
        equation: &Arc<EquationOfMotion>,
        pressure: f64,
        at: impl FnOnce() -> Linearization,
    ) {
        self.steps += 1;
        if let Some((_, work)) = &self.look
            && work.is_finished()
            && let Some((pressure, work)) = self.look.take()
            && let Ok(Some(false)) = work.join()
        {
            self.lost = self.lost.or(Some(pressure));
        }
        if self.lost.is_none() && self.look.is_none() && self.steps >= INTERVAL {
            self.steps = 0;
            let (equation, at) = (equation.clone(), at());
            let look = move || {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(1)
                    .build()
                    .ok()?;
                pool.install(|| equation.is_statically_stable(&at).ok())
            };
            let work = thread::Builder::new().spawn(look).ok();
            self.look = work.map(|work| (pressure, work));
        }
    }

    /// Mean pressure (Pa) at which the wall was seen without stability; told once.
    pub fn tell(&mut self) -> Option<f64> {
        let notice = self.lost.filter(|_| !self.told);
        self.told |= notice.is_some();
        notice
    }
}
