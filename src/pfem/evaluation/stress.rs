//! Stresses and strains at a point of a deformed wall, in the wall's own directions.

use super::super::material::{HyperelasticMaterial, Volumetric, WallAxes};
use crate::{Mat3, Vec3};

/// Stress and strain at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StressState {
    /// Cauchy stress `σ = P Fᵀ / J`, Pa.
    pub cauchy: Mat3,
    /// Green-Lagrange strain `E = (Fᵀ F - 1)/2`.
    pub strain: Mat3,
    /// Unit vector along the deformed vessel: `F` times the axial direction.
    pub axial: Vec3,
    /// Unit vector around the deformed vessel, perpendicular to the axial one in the deformed wall.
    pub circumferential: Vec3,
    /// Stretch of both families of fibres; NaN in a material without.
    pub fibre_stretches: [f64; 2],
}

impl StressState {
    /// At a point with the deformation gradient `F`.
    pub fn new(
        material: &dyn HyperelasticMaterial,
        F: &Mat3,
        frame: &WallAxes,
        U: &Volumetric,
    ) -> Self {
        let J = F.determinant();
        let cauchy = match J > 0.0 {
            true => material.stress_with(F, frame, U) * F.transpose() / J,
            false => Mat3::from_element(f64::NAN),
        };
        let axial = (F * frame.axial).normalize();
        let around = F * frame.circumferential;
        let stretch = |a: Vec3| (F * a).norm();
        Self {
            cauchy: 0.5 * (cauchy + cauchy.transpose()),
            strain: 0.5 * (F.transpose() * F - Mat3::identity()),
            axial,
            circumferential: (around - axial * axial.dot(&around)).normalize(),
            fibre_stretches: (material.fibre_directions(frame))
                .map_or([f64::NAN; 2], |a| a.map(stretch)),
        }
    }

    /// The same with another stress.
    pub fn with_cauchy(self, cauchy: Mat3) -> Self {
        Self { cauchy, ..self }
    }

    /// Von Mises stress, Pa.
    pub fn von_mises(&self) -> f64 {
        let deviator = self.cauchy - Mat3::identity() * (self.cauchy.trace() / 3.0);
        (1.5 * deviator.norm_squared()).sqrt()
    }

    /// Stress around the vessel, Pa.
    pub fn hoop_stress(&self) -> f64 {
        self.circumferential
            .dot(&(self.cauchy * self.circumferential))
    }

    /// Stress along the vessel, Pa.
    pub fn axial_stress(&self) -> f64 {
        self.axial.dot(&(self.cauchy * self.axial))
    }

    /// Principal stresses, Pa, the largest first.
    pub fn principal_stresses(&self) -> [f64; 3] {
        eigenvalues(&self.cauchy)
    }

    /// Principal strains, the largest first.
    pub fn principal_strains(&self) -> [f64; 3] {
        eigenvalues(&self.strain)
    }
}

/// Eigenvalues of a symmetric matrix, the largest first (Smith: *Eigenvalues of a symmetric 3×3 matrix*, 1961).
pub fn eigenvalues(A: &Mat3) -> [f64; 3] {
    let (mean, deviator, radius) = split(A);
    if radius <= f64::EPSILON * mean.abs() {
        return [mean; 3];
    }
    let cosine = 0.5 * (deviator / radius).determinant();
    let angle = cosine.clamp(-1.0, 1.0).acos() / 3.0;
    let third = std::f64::consts::TAU / 3.0;
    let at = |angle: f64| mean + 2.0 * radius * angle.cos();
    [at(angle), at(angle - third), at(angle + third)]
}

/// What the largest eigenvalue of a symmetric matrix does not exceed: that of `[2, -1, -1]` with the same deviator's
/// norm.
pub fn largest_eigenvalue_bound(A: &Mat3) -> f64 {
    let (mean, _, radius) = split(A);
    mean + 2.0 * radius
}

/// Mean of the eigenvalues, deviator, and half of what the largest eigenvalue may be above the mean.
fn split(A: &Mat3) -> (f64, Mat3, f64) {
    let mean = A.trace() / 3.0;
    let deviator = A - Mat3::identity() * mean;
    (mean, deviator, (deviator.norm_squared() / 6.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::HolzapfelGasserOgden;

    #[test]
    fn eigenvalues_are_those_of_the_diagonal_form() {
        let rotation = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        for values in [
            [3.0, -1.0, -4.0],
            [2.0, 2.0, -1.0],
            [5.0, 1.0, 1.0],
            [7.0; 3],
        ] {
            let A = rotation * Mat3::from_diagonal(&values.into()) * rotation.transpose();
            let found = eigenvalues(&A);
            for (a, b) in found.iter().zip(values) {
                assert!((a - b).abs() < 1e-7, "{found:?} {values:?}");
            }
            let bound = largest_eigenvalue_bound(&A);
            assert!(
                bound > values[0] - 1e-9 && bound < values[0] + 3.0,
                "{bound} {values:?}"
            );
        }
    }

    #[test]
    fn a_turned_tube_wall_has_the_stresses_of_the_straight_one() {
        let material = HolzapfelGasserOgden {
            mu: 2.0,
            kappa: 30.0,
            k1: 1.0,
            k2: 0.5,
            fibre: [0.8, 0.6],
            dispersion: 0.0,
            tension_only: false,
        };
        let frame = WallAxes::from_tangents(&Vec3::x(), &Vec3::y());
        // Stretches along, around and through the wall.
        let F = Mat3::from_diagonal(&Vec3::new(1.1, 1.3, 0.7));
        let turn = nalgebra::Rotation3::from_euler_angles(0.4, 0.9, -0.2).into_inner();
        let state = |F: &Mat3| {
            let U = material.volumetric(F.determinant() - 1.0);
            StressState::new(&material, F, &frame, &U)
        };
        let (straight, turned) = (state(&F), state(&(turn * F)));
        assert!((straight.axial_stress() - straight.cauchy[(0, 0)]).abs() < 1e-14);
        assert!((straight.hoop_stress() - straight.cauchy[(1, 1)]).abs() < 1e-14);
        assert!((turned.axial_stress() - straight.axial_stress()).abs() < 1e-12);
        assert!((turned.hoop_stress() - straight.hoop_stress()).abs() < 1e-12);
        assert!((turned.von_mises() - straight.von_mises()).abs() < 1e-12);
        let [largest, ..] = turned.principal_stresses();
        assert!((largest - straight.hoop_stress()).abs() < 1e-12);
        let strains = turned.principal_strains();
        for (strain, stretch) in strains.iter().zip([1.3f64, 1.1, 0.7]) {
            assert!((strain - 0.5 * (stretch * stretch - 1.0)).abs() < 1e-12);
        }
        let fibre = (0.64 * 1.3f64.powi(2) + 0.36 * 1.1f64.powi(2)).sqrt();
        assert!(
            turned
                .fibre_stretches
                .iter()
                .all(|stretch| (stretch - fibre).abs() < 1e-12)
        );
    }
}
