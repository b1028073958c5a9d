//! Saint Venant-Kirchhoff, for benchmarks.

use super::{
    HyperelasticMaterial, Tensor4, Volumetric, WallAxes, add_crossed, add_dyadic, add_parallel,
    lame_parameters,
};
use crate::Mat3;

/// Linear relation between Green-Lagrange strain `E` and second Piola-Kirchhoff stress:
/// `W = lambda/2 (tr E)² + mu E:E`.
#[derive(Debug, Clone, PartialEq)]
pub struct SaintVenantKirchhoff {
    /// First Lamé parameter, Pa.
    pub lambda: f64,
    /// Shear modulus, Pa.
    pub mu: f64,
}

impl SaintVenantKirchhoff {
    /// From Young's modulus (Pa) and Poisson's ratio.
    pub fn new(youngs_modulus: f64, poisson_ratio: f64) -> Self {
        let [lambda, mu] = lame_parameters(youngs_modulus, poisson_ratio);
        Self { lambda, mu }
    }

    /// `S = lambda tr(E) 1 + 2 mu E`.
    fn second_piola_kirchhoff(&self, F: &Mat3) -> Mat3 {
        let E = (F.transpose() * F - Mat3::identity()) * 0.5;
        Mat3::identity() * (self.lambda * E.trace()) + E * (2.0 * self.mu)
    }
}

impl HyperelasticMaterial for SaintVenantKirchhoff {
    fn energy_with(&self, F: &Mat3, _: &WallAxes, _: &Volumetric) -> f64 {
        let E = (F.transpose() * F - Mat3::identity()) * 0.5;
        0.5 * self.lambda * E.trace().powi(2) + self.mu * E.norm_squared()
    }

    /// `P = F S`.
    fn stress_with(&self, F: &Mat3, _: &WallAxes, _: &Volumetric) -> Mat3 {
        F * self.second_piola_kirchhoff(F)
    }

    /// `A_ijkl = δ_ik S_jl + lambda F_ij F_kl + mu (F_il F_kj + (F Fᵀ)_ik δ_jl)`.
    fn tangent_with(&self, F: &Mat3, _: &WallAxes, _: &Volumetric) -> Tensor4 {
        let mut A = Tensor4::zeros();
        add_parallel(&mut A, &Mat3::identity(), &self.second_piola_kirchhoff(F));
        add_dyadic(&mut A, self.lambda, F, F);
        add_crossed(&mut A, self.mu, F, F);
        add_parallel(&mut A, &(F * F.transpose() * self.mu), &Mat3::identity());
        A
    }

    /// `U = 0`: the energy has no part that depends on `J` alone.
    fn volumetric(&self, _: f64) -> Volumetric {
        Volumetric::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::verification::check;

    #[test]
    fn derivatives_symmetry_and_objectivity() {
        check(&SaintVenantKirchhoff::new(1.4e6, 0.4));
        check(&SaintVenantKirchhoff::new(3e5, 0.0));
    }
}
