//! A new tangent, factorized on another thread while the fluid works.
//!
//! When it takes the place of the old one is decided by counts alone, never by clocks, so that a run can be repeated to
//! the last digit. Whether it will be ready by then is estimated: a wall that is large compared with its fluid would
//! wait for it.

use super::super::SolidError;
use super::super::discretization::Discretization;
use super::equation_of_motion::{EquationOfMotion, Linearization};
use super::quasi_newton::KeptTangent;
use super::stats::{Stats, timed};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

/// Solutions after which a tangent is renewed, for each step that the renewal has time for. Sooner, the quasi-Newton
/// pairs of the last one would still be worth more; later, iterations would cost more than the factorization (both
/// measured).
pub const WORN: usize = 3;

/// By how much the loaded surface may have changed since a tangent was assembled, in a body whose pressure is
/// predicted, for each step that a renewal has time for (measured: `docs/speed.md`, the wall).
pub const AGED: f64 = 2e-3;

/// A tangent that is kept, and what it was assembled from.
pub struct Kept {
    pub from: Linearization,
    pub tangent: KeptTangent,
}

/// A tangent that is being factorized on another thread.
pub struct Renewal {
    pub from: Linearization,
    /// Accepted steps until it takes the place of the one in use.
    pub steps: usize,
    work: JoinHandle<Result<KeptTangent, SolidError>>,
    /// Dropped with the renewal: the thread then ends, which would have the memory of a factor.
    _cancel: Cancel,
}

/// Tells a thread, when it is dropped, that nobody waits for it any more.
struct Cancel(Arc<AtomicBool>);

impl Drop for Cancel {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

impl Renewal {
    /// Begins one that will be asked for after so many `steps`; after none in the next solution.
    pub fn start(
        equation: &Arc<EquationOfMotion>,
        from: Linearization,
        steps: usize,
    ) -> Option<Self> {
        let (equation, at) = (equation.clone(), from.clone());
        // One core is left to the fluid, unless the wall will wait.
        let spared = usize::from(steps > 0);
        let threads = rayon::current_num_threads().saturating_sub(spared).max(1);
        let cancelled = Arc::new(AtomicBool::new(false));
        let cancel = Cancel(cancelled.clone());
        let work = move || {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let pool = pool.map_err(|e| SolidError::Model(format!("no threads: {e}")))?;
            pool.install(|| equation.factorized_tangent(&at, &cancelled))
        };
        let work = thread::Builder::new().spawn(work).ok()?;
        Some(Self {
            from,
            steps,
            work,
            _cancel: cancel,
        })
    }

    /// Waits for the factorization, if need be. None if it failed.
    pub fn ready(self, stats: &mut Stats) -> Option<Kept> {
        let tangent = timed(&mut stats.factorization_s, || self.work.join());
        Some(Kept {
            from: self.from,
            tangent: tangent.ok()?.ok()?,
        })
    }
}

/// Steps that a renewal takes next to a fluid that needs `fluid` seconds for one; at least one.
///
/// Seconds are those of one machine (`docs/speed.md`, the wall); where it is slower or faster, the fluid is as well.
pub fn lead(body: &Discretization, fluid: f64) -> usize {
    /// Newton iterations of a time step.
    const ITERATIONS: f64 = 7.0;
    /// A tangent that is older still would be worth too little.
    const LONGEST: f64 = 4.0;
    let points: usize = body.elements.points.iter().map(Vec::len).sum();
    let (points, modes) = (points as f64, body.numbering.modes.len() as f64);
    let (entries, operations) = (body.symbolic.entries() as f64, body.symbolic.operations());
    let iteration = 4e-9 * points * modes + 3e-10 * entries;
    let tangent = 9e-9 * points * modes.powf(1.5) + 3e-11 * operations;
    let steps = tangent / (fluid + ITERATIONS * iteration);
    // A fifth of a step is not worth waiting for longer.
    (steps - 0.2).round().clamp(1.0, LONGEST) as usize
}
