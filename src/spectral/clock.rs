//! Where the solver's seconds go.

use std::time::Instant;

/// A part of the solver's work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolverPart {
    /// The nodes' places, the metric, and all of the equations that depends on them.
    Geometry,
    /// The inverse of the pressure's Schur complement, when it is made again.
    Factorization,
    /// Products with the equations' matrix.
    Products,
    /// Divergence and gradient in the preconditioner.
    Preconditioner,
    /// Use of the inverse of the pressure's Schur complement.
    Pressure,
    /// The rest of the iteration: scalar products and sums.
    Orthogonalization,
    /// Loads on the wall.
    Loads,
}

impl SolverPart {
    const ALL: [(Self, &str); 7] = [
        (Self::Geometry, "geometry"),
        (Self::Factorization, "factorization"),
        (Self::Products, "products"),
        (Self::Preconditioner, "preconditioner"),
        (Self::Pressure, "pressure"),
        (Self::Orthogonalization, "orthogonalization"),
        (Self::Loads, "loads"),
    ];
}

/// Seconds of wall-clock time by part.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Clock {
    seconds: [f64; SolverPart::ALL.len()],
}

impl Clock {
    /// Adds the time since `begin`.
    pub fn add(&mut self, part: SolverPart, begin: Instant) {
        self.seconds[part as usize] += begin.elapsed().as_secs_f64();
    }

    /// Adds the time since `begin` that no part has taken since the clock stood at `then`.
    pub fn add_rest(&mut self, part: SolverPart, begin: Instant, then: &Self) {
        let elapsed = begin.elapsed().as_secs_f64();
        self.seconds[part as usize] += elapsed - (self.total() - then.total());
    }

    /// Seconds of each part with its name.
    pub fn by_part(&self) -> Vec<(String, f64)> {
        let parts =
            SolverPart::ALL.map(|(part, name)| (name.to_owned(), self.seconds[part as usize]));
        parts.into()
    }

    fn total(&self) -> f64 {
        self.seconds.iter().sum()
    }
}
