//! What an acceleration keeps from one time step to the next.

use super::SecantPair;
use serde::{Deserialize, Serialize};

/// All that an acceleration has learnt, in a form that can be stored. (What a [`Surrogate`](super::Surrogate) knows
/// follows from the displacement that was accepted last.)
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct AccelerationMemory {
    /// The relaxation factor with which the next step begins, of those models that adapt it.
    pub factor: Option<f64>,
    /// The columns of each fit of a quasi-Newton model, newest first.
    pub fits: Vec<Vec<SecantPair>>,
    /// What its surrogate was worth.
    pub surrogate: SurrogateRecord,
}

/// What a surrogate was worth so far.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SurrogateRecord {
    /// What it left of the first change of each of the last steps, newest first: 0 if it was exact, 1 if it was no
    /// better than none.
    pub left: Vec<f64>,
    /// Whether it was dropped.
    pub dropped: bool,
}

impl AccelerationMemory {
    /// Whether it was learnt on an interface with `unknowns` components, and holds nothing but finite numbers and
    /// residuals of length 1.
    pub fn fits_to(&self, unknowns: usize) -> bool {
        let fits_to = |column: &SecantPair| {
            let vectors = [&column.residual, &column.trial];
            column.size.is_finite()
                && (column.residual.norm() - 1.0).abs() < 1e-9
                && vectors
                    .iter()
                    .all(|v| v.len() == unknowns && v.iter().all(|x| x.is_finite()))
        };
        self.factor.is_none_or(f64::is_finite) && self.fits.iter().flatten().all(fits_to)
    }
}
