//! Neo-Hooke, equation (4).

use super::{Frame, HyperelasticMaterial, Tensor4, add_crossed, add_dyadic, inverse_transpose};
use crate::Mat3;

/// Isotropic, compressible: `W = mu/2 (I_C - 3) - mu ln J + kappa/2 (ln J)²`.
#[derive(Debug, Clone, PartialEq)]
pub struct NeoHooke {
    /// Shear modulus, Pa.
    pub mu: f64,
    /// Bulk parameter (Lamé's first), Pa.
    pub kappa: f64,
}

impl HyperelasticMaterial for NeoHooke {
    fn energy(&self, F: &Mat3, _: &Frame) -> f64 {
        let ln_J = F.determinant().ln();
        0.5 * self.mu * (F.norm_squared() - 3.0) - self.mu * ln_J + 0.5 * self.kappa * ln_J * ln_J
    }

    /// `P = mu F + (kappa ln J - mu) F⁻ᵀ`.
    fn stress(&self, F: &Mat3, _: &Frame) -> Mat3 {
        let (G, J) = inverse_transpose(F);
        F * self.mu + G * (self.kappa * J.ln() - self.mu)
    }

    /// With `G = F⁻ᵀ`: `A_ijkl = mu δ_ik δ_jl + (U'' J² + U' J) G_ij G_kl - U' J G_il G_kj`.
    fn tangent_with(&self, F: &Mat3, _: &Frame, slope: f64) -> Tensor4 {
        let (G, J) = inverse_transpose(F);
        let [_, curvature] = self.volumetric(J);
        let mut A = Tensor4::identity() * self.mu;
        add_dyadic(&mut A, (curvature * J + slope) * J, &G, &G);
        add_crossed(&mut A, -slope * J, &G);
        A
    }

    /// `U = kappa/2 (ln J)² - mu ln J`.
    fn volumetric(&self, J: f64) -> [f64; 2] {
        let stress = self.kappa * J.ln() - self.mu;
        [stress / J, (self.kappa - stress) / (J * J)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pfem::material::verification::check;

    #[test]
    fn derivatives_symmetry_and_objectivity() {
        check(&NeoHooke {
            mu: 3.33e5,
            kappa: 1.67e9,
        });
        check(&NeoHooke {
            mu: 2.0,
            kappa: 3.0,
        });
    }
}
