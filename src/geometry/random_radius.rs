//! A lumen's radius that is random: one realization of a Gaussian field, in which the wall's surfaces have a share.

use crate::case::{RandomLumen, RandomWall};
use crate::uncertainty::Realization;

/// A realization of the random radius.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomRadius {
    field: Realization,
    /// The share that each surface has in it, from the lumen outward.
    shares: Vec<f64>,
}

impl RandomRadius {
    /// What the keys of a checked case say; the surfaces of a wall that thickens move by the shares `thickening`. None
    /// if all amplitudes are zero.
    pub fn new(keys: &RandomLumen, thickening: Vec<f64>) -> Option<Self> {
        if keys.amplitudes.iter().all(|amplitude| *amplitude == 0.0) {
            return None;
        }
        Some(Self {
            field: keys.field()?.realization(&keys.amplitudes),
            shares: match keys.wall.unwrap_or_default() {
                RandomWall::Thickens => thickening,
                RandomWall::Moves => vec![1.0; thickening.len()],
            },
        })
    }

    /// How much further inside surface `index` lies at `s` (m) and `phi`, m.
    pub fn inward(&self, index: usize, s: f64, phi: f64) -> f64 {
        -self.shares[index] * self.field.value(s, phi)
    }
}
