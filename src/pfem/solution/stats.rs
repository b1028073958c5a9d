//! What a solution cost.

use serde::Serialize;
use std::ops::AddAssign;
use std::time::Instant;

/// Counters and wall-clock seconds of the structural solver.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Stats {
    /// Newton iterations: linear systems solved.
    pub iterations: usize,
    /// Evaluations of the residual.
    pub residuals: usize,
    /// Seconds spent on residuals.
    pub residual_s: f64,
    /// Assemblies of the tangent.
    pub assemblies: usize,
    /// Seconds spent on assemblies.
    pub assembly_s: f64,
    /// Numeric factorizations.
    pub factorizations: usize,
    /// Seconds spent on factorizations.
    pub factorization_s: f64,
    /// Seconds spent on forward and backward substitution.
    pub substitution_s: f64,
}

impl AddAssign for Stats {
    fn add_assign(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.residuals += other.residuals;
        self.residual_s += other.residual_s;
        self.assemblies += other.assemblies;
        self.assembly_s += other.assembly_s;
        self.factorizations += other.factorizations;
        self.factorization_s += other.factorization_s;
        self.substitution_s += other.substitution_s;
    }
}

/// Runs `f` and adds its seconds.
pub fn timed<T>(seconds: &mut f64, f: impl FnOnce() -> T) -> T {
    let begin = Instant::now();
    let result = f();
    *seconds += begin.elapsed().as_secs_f64();
    result
}
