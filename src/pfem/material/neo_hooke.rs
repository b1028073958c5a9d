//! Neo-Hooke, equation (4).

use super::lanes::{self, LANES, Lanes, Real, Tensor, Vector};
use super::{
    HyperelasticMaterial, Tensor4, Volumetric, WallAxes, add_crossed, add_dyadic, inverse_transpose,
};
use crate::Mat3;
use multiversion::multiversion;

/// Isotropic, compressible: `W = mu/2 (I_C - 3) - mu ln J + kappa/2 (ln J)²`.
#[derive(Debug, Clone, PartialEq)]
pub struct NeoHooke {
    /// Shear modulus, Pa.
    pub mu: f64,
    /// Bulk parameter (Lamé's first), Pa.
    pub kappa: f64,
}

impl NeoHooke {
    /// `P = mu F + (U' J - mu) F⁻ᵀ`.
    #[inline(always)]
    fn stress_of<T: Real>(&self, F: &Tensor<T>, slope: T) -> Tensor<T> {
        let C = lanes::cofactors(F);
        let J = lanes::dot(&F[0], &C[0]);
        let spherical = slope - T::of(self.mu) * J.inverse();
        let mu = T::of(self.mu);
        let mut P = *F;
        for i in 0..3 {
            for j in 0..3 {
                P[i][j] = mu * F[i][j] + spherical * C[i][j];
            }
        }
        P
    }
}

/// The term `-mu ln J` depends on the volume ratio alone, too, but belongs to the rest: without it the rest is not
/// positive definite in the reference configuration, and modes whose volume change a projection does not see would be
/// unstable.
impl HyperelasticMaterial for NeoHooke {
    fn energy_with(&self, F: &Mat3, _: &WallAxes, U: &Volumetric) -> f64 {
        0.5 * self.mu * (F.norm_squared() - 3.0) - self.mu * F.determinant().ln() + U.energy
    }

    fn stress_with(&self, F: &Mat3, _: &WallAxes, U: &Volumetric) -> Mat3 {
        lanes::matrix(&self.stress_of(&lanes::rows(F), U.slope))
    }

    fn stresses(&self, F: &Tensor<Lanes>, _: [&Vector<Lanes>; 2], slope: Lanes) -> Tensor<Lanes> {
        #[multiversion(targets = "simd")]
        fn stresses(material: &NeoHooke, F: &Tensor<Lanes>, slope: Lanes) -> Tensor<Lanes> {
            material.stress_of(F, slope)
        }
        stresses(self, F, slope)
    }

    /// With `G = F⁻ᵀ`: `A_ijkl = mu δ_ik δ_jl + (U'' J² + U' J) G_ij G_kl + (mu - U' J) G_il G_kj`.
    fn tangent_with(&self, F: &Mat3, _: &WallAxes, U: &Volumetric) -> Tensor4 {
        let (G, J) = inverse_transpose(F);
        let mut A = Tensor4::identity() * self.mu;
        add_dyadic(&mut A, (U.curvature * J + U.slope) * J, &G, &G);
        add_crossed(&mut A, self.mu - U.slope * J, &G, &G);
        A
    }

    /// `U = kappa/2 (ln J)²`.
    fn volumetric(&self, change: f64) -> Volumetric {
        let (ln_J, J) = (change.ln_1p(), 1.0 + change);
        Volumetric {
            energy: 0.5 * self.kappa * ln_J * ln_J,
            slope: self.kappa * ln_J / J,
            curvature: self.kappa * (1.0 - ln_J) / (J * J),
        }
    }

    fn volumetric_slopes(&self, changes: &mut [f64]) {
        #[multiversion(targets = "simd")]
        fn slopes(changes: &mut [[f64; LANES]], kappa: f64) {
            for group in changes {
                let change = Lanes::new(*group);
                let slope = Lanes::of(kappa) * lanes::ln_1p(change);
                *group = (slope / (Lanes::of(1.0) + change)).to_array();
            }
        }
        let (groups, rest) = changes.as_chunks_mut::<LANES>();
        slopes(groups, self.kappa);
        for change in rest {
            *change = self.volumetric(*change).slope;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::verification::check;

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

    #[test]
    fn slopes_side_by_side_are_those_one_by_one() {
        let material = NeoHooke {
            mu: 1.0,
            kappa: 7.0,
        };
        let changes = [1e-14, -1e-7, 3e-3, 0.14, -0.14, 0.16, -0.9, 4.0, 0.0, -0.02];
        let mut slopes = changes;
        material.volumetric_slopes(&mut slopes);
        for (change, slope) in changes.into_iter().zip(slopes) {
            let expected = material.volumetric(change).slope;
            assert!(
                (slope - expected).abs() <= 1e-15 * expected.abs(),
                "{change}: {slope} {expected}"
            );
        }
    }
}
