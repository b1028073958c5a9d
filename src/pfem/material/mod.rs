//! Hyperelastic materials: each file gives energy, stress and tangent of one strain energy density.
//!
//! Stress is the first Piola-Kirchhoff stress `P = ∂W/∂F` and the tangent is `A = ∂P/∂F`, both with respect to the
//! deformation gradient `F`; components `(i, j)` of second-order tensors are collected at `3 i + j`.

mod holzapfel_gasser_ogden;
mod kelvin_voigt;
pub mod lanes;
mod linear_elastic;
mod neo_hooke;
mod saint_venant_kirchhoff;

pub use holzapfel_gasser_ogden::HolzapfelGasserOgden;
pub use kelvin_voigt::KelvinVoigt;
pub use linear_elastic::LinearElastic;
pub use neo_hooke::NeoHooke;
pub use saint_venant_kirchhoff::SaintVenantKirchhoff;

use crate::{Mat3, Vec3};
use lanes::{LANES, Lanes, Tensor, Vector};
use std::sync::Arc;

/// Fourth-order tensor `A_ijkl` at row `3 i + j` and column `3 k + l`.
pub type Tensor4 = nalgebra::SMatrix<f64, 9, 9>;

/// Orthonormal directions of the reference wall at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallAxes {
    /// Along the vessel.
    pub axial: Vec3,
    /// Around the vessel.
    pub circumferential: Vec3,
    /// Through the wall.
    pub normal: Vec3,
}

impl WallAxes {
    /// From the columns `g_0` (axial) and `g_1` (circumferential) of the Jacobian of an element's mapping:
    /// axial `g_0/|g_0|`, normal along `g_0 × g_1`, circumferential `normal × axial`.
    pub fn from_tangents(g0: &Vec3, g1: &Vec3) -> Self {
        let axial = g0.normalize();
        let normal = g0.cross(g1).normalize();
        Self {
            axial,
            circumferential: normal.cross(&axial),
            normal,
        }
    }
}

/// The part `U` of an energy density that depends on the volume ratio alone, with its first two derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Volumetric {
    /// `U`, J/m³ of the reference volume.
    pub energy: f64,
    /// `U'`, Pa: the mean stress that it causes.
    pub slope: f64,
    /// `U''`, Pa.
    pub curvature: f64,
}

/// A strain energy density `W(F) = W_rest(F) + U(J)` with its first two derivatives. What stands for `U` and its
/// derivatives is handed in, so that a formulation may evaluate them at another volume ratio than `det F`; see
/// [`volume`](super::element::volume).
pub trait HyperelasticMaterial: Send + Sync {
    /// `W`, J/m³ of the reference volume.
    fn energy_with(&self, F: &Mat3, frame: &WallAxes, U: &Volumetric) -> f64;

    /// `P = ∂W/∂F`, Pa.
    fn stress_with(&self, F: &Mat3, frame: &WallAxes, U: &Volumetric) -> Mat3;

    /// `A = ∂P/∂F`, Pa; symmetric.
    fn tangent_with(&self, F: &Mat3, frame: &WallAxes, U: &Volumetric) -> Tensor4;

    /// `U(J)` for `J - 1`, which has more digits of a small change of volume than `J`.
    fn volumetric(&self, change: f64) -> Volumetric;

    /// Whether `U'` is proportional to `J - 1`, so that it lies in the same space.
    fn is_volumetric_slope_linear(&self) -> bool {
        false
    }

    /// Replaces each `J - 1` by `U'`, Pa.
    fn volumetric_slopes(&self, changes: &mut [f64]) {
        for change in changes {
            *change = self.volumetric(*change).slope;
        }
    }

    /// [`Self::stress_with`] at several points side by side: `P` for `F`, the axial and the circumferential
    /// direction, and `U'`.
    fn stresses(
        &self,
        F: &Tensor<Lanes>,
        [axial, circumferential]: [&Vector<Lanes>; 2],
        slope: Lanes,
    ) -> Tensor<Lanes> {
        let [F, axial, circumferential, slope] = [
            F.as_flattened(),
            axial.as_slice(),
            circumferential.as_slice(),
            &[slope],
        ]
        .map(|all| all.iter().map(|lanes| lanes.to_array()).collect::<Vec<_>>());
        let mut P = [[[0.0; LANES]; 3]; 3];
        for lane in 0..LANES {
            let vector = |v: &[[f64; LANES]]| Vec3::from_fn(|i, _| v[i][lane]);
            let (axial, circumferential) = (vector(&axial), vector(&circumferential));
            let frame = WallAxes {
                axial,
                circumferential,
                normal: axial.cross(&circumferential),
            };
            let U = Volumetric {
                slope: slope[0][lane],
                ..Volumetric::default()
            };
            let F = Mat3::from_fn(|i, j| F[3 * i + j][lane]);
            let own = self.stress_with(&F, &frame, &U);
            for (i, row) in P.iter_mut().enumerate() {
                for (j, entry) in row.iter_mut().enumerate() {
                    entry[lane] = own[(i, j)];
                }
            }
        }
        P.map(|row| row.map(Lanes::new))
    }

    /// Directions of two families of fibres in the reference configuration, if it has any.
    fn fibre_directions(&self, _frame: &WallAxes) -> Option<[Vec3; 2]> {
        None
    }

    /// `W` of the deformation gradient alone, J/m³.
    fn energy(&self, F: &Mat3, frame: &WallAxes) -> f64 {
        self.energy_with(F, frame, &self.volumetric(volume_change(F)))
    }

    /// `P = ∂W/∂F` of the deformation gradient alone, Pa.
    fn stress(&self, F: &Mat3, frame: &WallAxes) -> Mat3 {
        self.stress_with(F, frame, &self.volumetric(volume_change(F)))
    }

    /// `A = ∂P/∂F` of the deformation gradient alone, Pa.
    fn tangent(&self, F: &Mat3, frame: &WallAxes) -> Tensor4 {
        self.tangent_with(F, frame, &self.volumetric(volume_change(F)))
    }
}

/// What a part of a body is made of.
#[derive(Clone)]
pub struct Law {
    /// Stress by deformation.
    pub elastic: Arc<dyn HyperelasticMaterial>,
    /// Stress by rate of deformation, if there is any.
    pub viscous: Option<KelvinVoigt>,
}

impl<M: HyperelasticMaterial + Clone + 'static> From<&M> for Law {
    fn from(material: &M) -> Self {
        Self {
            elastic: Arc::new(material.clone()),
            viscous: None,
        }
    }
}

impl From<&Self> for Law {
    fn from(law: &Self) -> Self {
        law.clone()
    }
}

/// Lamé's parameters (Pa) from Young's modulus (Pa) and Poisson's ratio: the first one and the shear modulus.
fn lame_parameters(youngs_modulus: f64, poisson_ratio: f64) -> [f64; 2] {
    let (E, nu) = (youngs_modulus, poisson_ratio);
    [
        E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        E / (2.0 * (1.0 + nu)),
    ]
}

/// `A_ijkl += a X_ij Y_kl`.
fn add_dyadic(A: &mut Tensor4, a: f64, X: &Mat3, Y: &Mat3) {
    for k in 0..3 {
        for l in 0..3 {
            let y = a * Y[(k, l)];
            for i in 0..3 {
                for j in 0..3 {
                    A[(3 * i + j, 3 * k + l)] += X[(i, j)] * y;
                }
            }
        }
    }
}

/// `A_ijkl += a X_il Y_kj`.
fn add_crossed(A: &mut Tensor4, a: f64, X: &Mat3, Y: &Mat3) {
    for k in 0..3 {
        for l in 0..3 {
            for i in 0..3 {
                let x = a * X[(i, l)];
                for j in 0..3 {
                    A[(3 * i + j, 3 * k + l)] += x * Y[(k, j)];
                }
            }
        }
    }
}

/// `A_ijkl += X_ik Y_jl`.
fn add_parallel(A: &mut Tensor4, X: &Mat3, Y: &Mat3) {
    for k in 0..3 {
        for l in 0..3 {
            for i in 0..3 {
                for j in 0..3 {
                    A[(3 * i + j, 3 * k + l)] += X[(i, k)] * Y[(j, l)];
                }
            }
        }
    }
}

/// `det F - 1`.
pub fn volume_change(F: &Mat3) -> f64 {
    lanes::volume_change(&lanes::rows(&(F - Mat3::identity())))
}

/// `F⁻ᵀ` and `J = det F`.
pub fn inverse_transpose(F: &Mat3) -> (Mat3, f64) {
    let J = F.determinant();
    // Cofactor matrix over the determinant: F⁻ᵀ = cof(F)/J.
    let row = |i: usize| Vec3::new(F[(i, 0)], F[(i, 1)], F[(i, 2)]);
    let (a, b, c) = (row(0), row(1), row(2));
    let cofactor = Mat3::from_rows(&[
        b.cross(&c).transpose(),
        c.cross(&a).transpose(),
        a.cross(&b).transpose(),
    ]);
    (cofactor / J, J)
}

/// What every material must fulfil, called by the test in each file.
#[cfg(test)]
mod verification {
    use super::lanes::Real;
    use super::*;
    use nalgebra::{Rotation3, Unit};

    /// Reproducible numbers in [-1, 1].
    pub struct Numbers(pub u64);

    impl Numbers {
        pub fn next(&mut self) -> f64 {
            self.0 = self
                .0
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        pub fn vector(&mut self) -> Vec3 {
            Vec3::new(self.next(), self.next(), self.next())
        }

        pub fn rotation(&mut self) -> Mat3 {
            let axis = Unit::new_normalize(self.vector());
            Rotation3::from_axis_angle(&axis, 3.0 * self.next()).into_inner()
        }
    }

    /// Derivative at zero, of fourth order in the step.
    pub fn derivative(f: impl Fn(f64) -> f64) -> f64 {
        let h = 1e-3;
        (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
    }

    pub fn moved(F: &Mat3, i: usize, j: usize, h: f64) -> Mat3 {
        let mut F = *F;
        F[(i, j)] += h;
        F
    }

    /// A random large deformation in random axes of the wall.
    fn random_deformation(numbers: &mut Numbers) -> (Mat3, WallAxes) {
        let rotation = numbers.rotation();
        let directions: [Vec3; 3] = std::array::from_fn(|i| rotation.column(i).into());
        let disturbance = Mat3::from_fn(|_, _| 0.25 * numbers.next());
        (
            rotation.transpose() * (Mat3::identity() + disturbance),
            WallAxes::from_tangents(&directions[0], &directions[1]),
        )
    }

    /// [`check_derivatives`], objectivity, and a reference configuration free of stress however it is turned.
    pub fn check(material: &dyn HyperelasticMaterial) {
        check_derivatives(material);
        let mut numbers = Numbers(7);
        for _ in 0..20 {
            let (F, frame) = random_deformation(&mut numbers);
            if F.determinant() < 0.3 {
                continue;
            }
            let (P, A) = (material.stress(&F, &frame), material.tangent(&F, &frame));
            let Q = numbers.rotation();
            let (energy, turned) = (
                material.energy(&F, &frame),
                material.energy(&(Q * F), &frame),
            );
            assert!((turned - energy).abs() < 1e-11 * energy.abs().max(P.norm()));
            assert!((material.stress(&(Q * F), &frame) - Q * P).norm() < 1e-11 * A.norm());
            assert!(material.stress(&Q, &frame).norm() < 1e-14 * A.norm());
            assert!(material.energy(&Q, &frame).abs() < 1e-14 * A.norm());
        }
    }

    /// Stress and tangent against finite differences of energy and stress, major symmetry, and stresses side by side,
    /// for random large deformations.
    pub fn check_derivatives(material: &dyn HyperelasticMaterial) {
        let mut numbers = Numbers(7);
        for _ in 0..20 {
            let (F, frame) = random_deformation(&mut numbers);
            if F.determinant() < 0.3 {
                continue;
            }
            let (P, A) = (material.stress(&F, &frame), material.tangent(&F, &frame));
            for i in 0..3 {
                for j in 0..3 {
                    let slope = derivative(|h| material.energy(&moved(&F, i, j, h), &frame));
                    assert!((slope - P[(i, j)]).abs() < 1e-6 * P.norm(), "P {i}{j}");
                    for k in 0..3 {
                        for l in 0..3 {
                            let stress = |h| material.stress(&moved(&F, k, l, h), &frame)[(i, j)];
                            let error = derivative(stress) - A[(3 * i + j, 3 * k + l)];
                            assert!(error.abs() < 1e-6 * A.norm(), "A {i}{j}{k}{l}: {error:e}");
                        }
                    }
                }
            }
            assert!((A - A.transpose()).norm() < 1e-13 * A.norm());
            let side_by_side = Lanes::of;
            let all = lanes::rows(&F).map(|row| row.map(side_by_side));
            let [axial, around] =
                [frame.axial, frame.circumferential].map(|v| [v.x, v.y, v.z].map(side_by_side));
            let slope = material.volumetric(volume_change(&F)).slope;
            let own = material.stresses(&all, [&axial, &around], side_by_side(slope));
            for lane in 0..LANES {
                let own = Mat3::from_fn(|i, j| own[i][j].to_array()[lane]);
                assert!((own - P).norm() <= 1e-13 * P.norm(), "{own} {P}");
            }
        }
    }
}
