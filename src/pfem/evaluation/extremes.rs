//! Extreme values over the points of a body.

/// Extreme values over the quadrature points of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes {
    /// Largest von Mises stress, Pa.
    pub von_mises: f64,
    /// Largest principal Cauchy stress, Pa.
    pub max_principal: f64,
    /// Element where the von Mises stress is largest.
    pub element: usize,
    /// Local coordinates of that.
    pub local: [f64; 3],
    /// Smallest `det F`.
    pub min_jacobian: f64,
    /// Largest `det F`.
    pub max_jacobian: f64,
}

impl Default for Extremes {
    fn default() -> Self {
        Self {
            von_mises: -1.0,
            max_principal: f64::NEG_INFINITY,
            element: 0,
            local: [0.0; 3],
            min_jacobian: f64::INFINITY,
            max_jacobian: f64::NEG_INFINITY,
        }
    }
}

impl Extremes {
    /// Of both.
    pub fn with(self, other: &Self) -> Self {
        let larger = if other.von_mises > self.von_mises {
            *other
        } else {
            self
        };
        Self {
            max_principal: self.max_principal.max(other.max_principal),
            min_jacobian: self.min_jacobian.min(other.min_jacobian),
            max_jacobian: self.max_jacobian.max(other.max_jacobian),
            ..larger
        }
    }
}
