//! Linear elasticity, for comparison with programs that take the wall to be linear.

use super::{
    HyperelasticMaterial, Tensor4, Volumetric, WallAxes, add_crossed, add_dyadic, add_parallel,
    lame_parameters,
};
use crate::Mat3;

/// Hooke's law between engineering strain `ε = (F + Fᵀ)/2 - 1` and first Piola-Kirchhoff stress:
/// `W = lambda/2 (tr ε)² + mu ε:ε`. Not objective: turning it causes stress, of second order in the angle. Nor does
/// tension make it stiffer: a thick tube (radii of 4 and 6 mm) of 3e5 Pa loses its stability under 2.0 kPa that follow
/// its surface.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearElastic {
    /// First Lamé parameter, Pa.
    pub lambda: f64,
    /// Shear modulus, Pa.
    pub mu: f64,
}

impl LinearElastic {
    /// From Young's modulus (Pa) and Poisson's ratio.
    pub fn new(youngs_modulus: f64, poisson_ratio: f64) -> Self {
        let [lambda, mu] = lame_parameters(youngs_modulus, poisson_ratio);
        Self { lambda, mu }
    }
}

fn engineering_strain(F: &Mat3) -> Mat3 {
    F.symmetric_part() - Mat3::identity()
}

impl HyperelasticMaterial for LinearElastic {
    fn energy_with(&self, F: &Mat3, _: &WallAxes, _: &Volumetric) -> f64 {
        let strain = engineering_strain(F);
        0.5 * self.lambda * strain.trace().powi(2) + self.mu * strain.norm_squared()
    }

    /// `P = lambda tr(ε) 1 + 2 mu ε`.
    fn stress_with(&self, F: &Mat3, _: &WallAxes, _: &Volumetric) -> Mat3 {
        let strain = engineering_strain(F);
        Mat3::identity() * (self.lambda * strain.trace()) + strain * (2.0 * self.mu)
    }

    /// `A_ijkl = lambda δ_ij δ_kl + mu (δ_ik δ_jl + δ_il δ_kj)`.
    fn tangent_with(&self, _: &Mat3, _: &WallAxes, _: &Volumetric) -> Tensor4 {
        let one = Mat3::identity();
        let mut A = Tensor4::zeros();
        add_dyadic(&mut A, self.lambda, &one, &one);
        add_parallel(&mut A, &(one * self.mu), &one);
        add_crossed(&mut A, self.mu, &one, &one);
        A
    }

    /// `U = 0`: the energy has no part that depends on `J` alone.
    fn volumetric(&self, _: f64) -> Volumetric {
        Volumetric::default()
    }
}

#[cfg(test)]
mod tests {
    use super::super::SaintVenantKirchhoff;
    use super::*;
    use crate::Vec3;
    use crate::material::verification::check_derivatives;

    #[test]
    fn derivatives_and_symmetry() {
        check_derivatives(&LinearElastic::new(1.4e6, 0.4));
        check_derivatives(&LinearElastic::new(3e5, 0.0));
    }

    /// It is what Saint Venant-Kirchhoff's law is for small strains.
    #[test]
    fn small_strains_cause_the_stress_of_saint_venant_and_kirchhoff() {
        let (linear, other) = (
            LinearElastic::new(3e5, 0.3),
            SaintVenantKirchhoff::new(3e5, 0.3),
        );
        let frame = WallAxes::from_tangents(&Vec3::x(), &Vec3::y());
        let direction = Mat3::new(1.0, 0.4, -0.2, 0.1, -0.7, 0.5, 0.3, 0.2, 0.6);
        let difference = |h: f64| {
            let F = Mat3::identity() + direction * h;
            (linear.stress(&F, &frame) - other.stress(&F, &frame)).norm()
        };
        let order = (difference(1e-4) / difference(1e-5)).log10();
        assert!((order - 2.0).abs() < 1e-2, "{order}");
        assert!(difference(1e-4) < 1e-2);
    }
}
