//! A viscous stress in addition to the elastic one: Kelvin and Voigt's model on the second Piola-Kirchhoff stress.

use super::{Tensor4, add_crossed, add_parallel};
use crate::Mat3;

/// `S_v = η Ė` with the rate of the Green-Lagrange strain `Ė = sym(Fᵀ Ḟ)`: objective, and its power `η Ė : Ė` per
/// reference volume is never negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KelvinVoigt {
    /// Viscosity `η`, Pa s.
    pub viscosity: f64,
}

impl KelvinVoigt {
    /// `S_v`, Pa.
    fn second_stress(&self, F: &Mat3, rate: &Mat3) -> Mat3 {
        let product = F.transpose() * rate;
        (product + product.transpose()) * (0.5 * self.viscosity)
    }

    /// First Piola-Kirchhoff stress `P_v = F S_v`, Pa; `rate` is `Ḟ`, 1/s.
    pub fn stress(&self, F: &Mat3, rate: &Mat3) -> Mat3 {
        F * self.second_stress(F, rate)
    }

    /// `∂P_v/∂F` where `Ḟ` follows `F` with the `slope` (1/s) of the time integration, `G = Ḟ + slope F`:
    /// `A_ijkl = δ_ik S_lj + η/2 (F_il G_kj + (F Gᵀ)_ik δ_jl)`. It is symmetric but for the change within a time step.
    fn tangent(&self, F: &Mat3, rate: &Mat3, slope: f64) -> Tensor4 {
        let G = rate + F * slope;
        let half = 0.5 * self.viscosity;
        let mut A = Tensor4::zeros();
        add_parallel(&mut A, &Mat3::identity(), &self.second_stress(F, rate));
        add_parallel(&mut A, &(F * G.transpose() * half), &Mat3::identity());
        add_crossed(&mut A, half, F, &G);
        A
    }

    /// The symmetric part of the tangent, Pa.
    pub fn symmetric_tangent(&self, F: &Mat3, rate: &Mat3, slope: f64) -> Tensor4 {
        let A = self.tangent(F, rate, slope);
        (A + A.transpose()) * 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::super::verification::{Numbers, derivative, moved};
    use super::*;

    #[test]
    fn tangent_objectivity_and_power() {
        let material = KelvinVoigt { viscosity: 3.0 };
        let mut numbers = Numbers(3);
        for _ in 0..10 {
            let F = Mat3::identity() + Mat3::from_fn(|_, _| 0.25 * numbers.next());
            let rate = Mat3::from_fn(|_, _| numbers.next());
            let (slope, P) = (5.0, material.stress(&F, &rate));
            let A = material.tangent(&F, &rate, slope);
            for k in 0..3 {
                for l in 0..3 {
                    for (i, j) in (0..9).map(|n| (n / 3, n % 3)) {
                        let stress = |h| {
                            let rate = moved(&rate, k, l, slope * h);
                            material.stress(&moved(&F, k, l, h), &rate)[(i, j)]
                        };
                        let error = derivative(stress) - A[(3 * i + j, 3 * k + l)];
                        assert!(error.abs() < 1e-9 * A.norm(), "A {i}{j}{k}{l}: {error:e}");
                    }
                }
            }
            // Turned, and turning: no stress but the turned one.
            let (Q, spin) = (numbers.rotation(), numbers.vector().cross_matrix());
            let turned = material.stress(&(Q * F), &(Q * rate + spin * Q * F));
            assert!((turned - Q * P).norm() < 1e-13 * P.norm());
            let strain_rate = (F.transpose() * rate + rate.transpose() * F) * 0.5;
            let power = P.dot(&rate) - 3.0 * strain_rate.norm_squared();
            assert!(power.abs() < 1e-13 * P.norm());
        }
    }
}
