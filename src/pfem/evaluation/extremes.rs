//! Extreme values over the points of a body.

/// Extreme values over the quadrature points of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes {
    /// Largest von Mises stress, Pa.
    pub von_mises: f64,
    /// Largest principal Cauchy stress, Pa.
    pub max_principal: f64,
    /// Largest stress around the deformed vessel, Pa.
    pub max_hoop: f64,
    /// Largest stress along it, Pa.
    pub max_axial: f64,
    /// Largest stretch of fibres; none is infinitely small.
    pub max_fibre_stretch: f64,
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
            max_hoop: f64::NEG_INFINITY,
            max_axial: f64::NEG_INFINITY,
            max_fibre_stretch: f64::NEG_INFINITY,
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
            max_hoop: self.max_hoop.max(other.max_hoop),
            max_axial: self.max_axial.max(other.max_axial),
            max_fibre_stretch: self.max_fibre_stretch.max(other.max_fibre_stretch),
            min_jacobian: self.min_jacobian.min(other.min_jacobian),
            max_jacobian: self.max_jacobian.max(other.max_jacobian),
            ..larger
        }
    }
}
