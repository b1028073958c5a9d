//! Holzapfel-Gasser-Ogden, equation (5).

use super::lanes::{self, Lanes, Real, Tensor, Vector};
use super::{
    HyperelasticMaterial, Tensor4, Volumetric, WallAxes, add_crossed, add_dyadic, add_parallel,
    inverse_transpose,
};
use crate::{Mat3, Vec3};
use multiversion::multiversion;

/// Ground substance and two families of fibres:
/// `W = k1/(2 k2) Σ_f (exp(k2 (IV_f - 1)²) - 1) + mu/2 (J^{-2/3} I_C - 3) + kappa/2 (J - 1)²`
/// with `IV_f = a_f · C a_f`. Where directions are dispersed by `κ` about the mean (Gasser, Ogden, Holzapfel:
/// *Hyperelastic modelling of arterial layers with distributed collagen fibre orientations*, J. R. Soc. Interface 3,
/// 2006, equation (4.7)), `κ (I_C - 3) + (1 - 3 κ) (IV_f - 1)` takes the place of `IV_f - 1`. As in the
/// paper, the fibres see the full `C`, not its isochoric part, and resist compression as well unless `tension_only` is
/// set.
#[derive(Debug, Clone, PartialEq)]
pub struct HolzapfelGasserOgden {
    /// Shear modulus of the ground substance, Pa.
    pub mu: f64,
    /// Bulk modulus, Pa.
    pub kappa: f64,
    /// Stiffness of the fibres, Pa.
    pub k1: f64,
    /// Exponent of the fibres.
    pub k2: f64,
    /// Cosine and sine of the angle of the fibres from the circumferential direction towards plus and minus the axial
    /// direction.
    pub fibre: [f64; 2],
    /// Dispersion `κ` of the fibres, from 0 (all in one direction) to 1/3 (isotropic).
    pub dispersion: f64,
    /// Fibres shorter than in the reference configuration (in the mean, where they are dispersed) carry no load.
    pub tension_only: bool,
}

impl HolzapfelGasserOgden {
    /// Directions `a_1`, `a_2` of the fibres in the reference configuration.
    fn fibres(&self, frame: &WallAxes) -> [Vec3; 2] {
        let [cos, sin] = self.fibre;
        [
            frame.circumferential * cos + frame.axial * sin,
            frame.circumferential * cos - frame.axial * sin,
        ]
    }

    /// Mean strain `E = κ (I_C - 3) + (1 - 3 κ) (IV - 1)` of the fibres about the direction `a`, and half of its
    /// derivative by `F`: `κ F + (1 - 3 κ) (F a) ⊗ a`.
    fn strain(&self, F: &Mat3, a: &Vec3) -> (f64, Mat3) {
        let (Fa, aligned) = (F * a, 1.0 - 3.0 * self.dispersion);
        let E = self.dispersion * (F.norm_squared() - 3.0) + aligned * (Fa.norm_squared() - 1.0);
        (E, F * self.dispersion + Fa * a.transpose() * aligned)
    }

    /// `psi(E) = k1/(2 k2) (exp(k2 E²) - 1)`, and its first two derivatives by `E`.
    fn fibre_energy(&self, E: f64) -> [f64; 3] {
        if self.tension_only && E <= 0.0 {
            return [0.0; 3];
        }
        if self.k2 == 0.0 {
            return [0.5 * self.k1 * E * E, self.k1 * E, self.k1];
        }
        let exponent = self.k2 * E * E;
        let first = self.k1 * exponent.exp();
        [
            self.k1 / (2.0 * self.k2) * exponent.exp_m1(),
            first * E,
            first * (1.0 + 2.0 * exponent),
        ]
    }

    /// `psi'(E)` alone.
    #[inline(always)]
    fn fibre_tension<T: Real>(&self, E: T) -> T {
        let E = if self.tension_only {
            E.positive_part()
        } else {
            E
        };
        T::of(self.k1) * (T::of(self.k2) * E * E).exponential() * E
    }

    /// `P = mu J^{-2/3} (F - I_C/3 F⁻ᵀ) + U' J F⁻ᵀ + Σ_f 2 psi' M_f`, `M_f = κ F + (1 - 3 κ) (F a_f) ⊗ a_f`.
    #[inline(always)]
    fn stress_of<T: Real>(
        &self,
        F: &Tensor<T>,
        [axial, circumferential]: [&Vector<T>; 2],
        slope: T,
    ) -> Tensor<T> {
        let (C, I_C) = (lanes::cofactors(F), lanes::norm_squared(F));
        let J = lanes::dot(&F[0], &C[0]);
        let mu = T::of(self.mu) * J.power_minus_two_thirds();
        let third = (T::of(3.0) * J).inverse();
        let spherical = slope - mu * I_C * third;
        let mut P = *F;
        for i in 0..3 {
            for j in 0..3 {
                P[i][j] = mu * F[i][j] + spherical * C[i][j];
            }
        }
        let aligned = T::of(1.0 - 3.0 * self.dispersion);
        let dispersed = T::of(self.dispersion) * (I_C - T::of(3.0));
        let [cos, sin] = self.fibre;
        for sin in [sin, -sin] {
            let (cos, sin) = (T::of(cos), T::of(sin));
            let mut a = *axial;
            for i in 0..3 {
                a[i] = cos * circumferential[i] + sin * axial[i];
            }
            let Fa = lanes::apply(F, &a);
            let E = dispersed + aligned * (lanes::dot(&Fa, &Fa) - T::of(1.0));
            let tension = T::of(2.0) * self.fibre_tension(E);
            let (along, everywhere) = (tension * aligned, tension * T::of(self.dispersion));
            for i in 0..3 {
                let force = along * Fa[i];
                for j in 0..3 {
                    P[i][j] = P[i][j] + force * a[j] + everywhere * F[i][j];
                }
            }
        }
        P
    }
}

impl HyperelasticMaterial for HolzapfelGasserOgden {
    fn energy_with(&self, F: &Mat3, frame: &WallAxes, U: &Volumetric) -> f64 {
        let J = F.determinant();
        let fibres: f64 = self
            .fibres(frame)
            .iter()
            .map(|a| self.fibre_energy(self.strain(F, a).0)[0])
            .sum();
        fibres + 0.5 * self.mu * (F.norm_squared() * J.cbrt().powi(-2) - 3.0) + U.energy
    }

    fn stress_with(&self, F: &Mat3, frame: &WallAxes, U: &Volumetric) -> Mat3 {
        let [axial, around] =
            [frame.axial, frame.circumferential].map(|direction| direction.into());
        lanes::matrix(&self.stress_of(&lanes::rows(F), [&axial, &around], U.slope))
    }

    fn stresses(
        &self,
        F: &Tensor<Lanes>,
        directions: [&Vector<Lanes>; 2],
        slope: Lanes,
    ) -> Tensor<Lanes> {
        #[multiversion(targets = "simd")]
        fn stresses(
            material: &HolzapfelGasserOgden,
            F: &Tensor<Lanes>,
            directions: [&Vector<Lanes>; 2],
            slope: Lanes,
        ) -> Tensor<Lanes> {
            material.stress_of(F, directions, slope)
        }
        stresses(self, F, directions, slope)
    }

    /// With `G = F⁻ᵀ`:
    /// `A_ijkl = mu J^{-2/3} (δ_ik δ_jl - 2/3 (F_ij G_kl + G_ij F_kl) + 2/9 I_C G_ij G_kl + I_C/3 G_il G_kj)
    /// + (U'' J² + U' J) G_ij G_kl - U' J G_il G_kj + Σ_f 4 psi'' M_ij M_kl
    /// + 2 psi' δ_ik (κ δ_jl + (1 - 3 κ) a_j a_l)`.
    fn tangent_with(&self, F: &Mat3, frame: &WallAxes, U: &Volumetric) -> Tensor4 {
        let (G, J) = inverse_transpose(F);
        let mu = self.mu * J.cbrt().powi(-2);
        let I_C = F.norm_squared();
        let mut A = Tensor4::identity() * mu;
        let volumetric = (U.curvature * J + U.slope) * J;
        // All terms with G as a factor at once: H ⊗ G + G ⊗ H.
        let H = F * (-2.0 / 3.0 * mu) + G * (mu * I_C / 9.0 + 0.5 * volumetric);
        add_dyadic(&mut A, 1.0, &H, &G);
        add_dyadic(&mut A, 1.0, &G, &H);
        add_crossed(&mut A, mu * I_C / 3.0 - U.slope * J, &G, &G);
        let mut structure = Mat3::zeros();
        for a in self.fibres(frame) {
            let (E, M) = self.strain(F, &a);
            let [_, first, second] = self.fibre_energy(E);
            add_dyadic(&mut A, 4.0 * second, &M, &M);
            let aligned = a * a.transpose() * (1.0 - 3.0 * self.dispersion);
            structure += (aligned + Mat3::identity() * self.dispersion) * (2.0 * first);
        }
        add_parallel(&mut A, &Mat3::identity(), &structure);
        A
    }

    fn fibre_directions(&self, frame: &WallAxes) -> Option<[Vec3; 2]> {
        Some(self.fibres(frame))
    }

    /// `U = kappa/2 (J - 1)²`.
    fn volumetric(&self, change: f64) -> Volumetric {
        Volumetric {
            energy: 0.5 * self.kappa * change * change,
            slope: self.kappa * change,
            curvature: self.kappa,
        }
    }

    fn is_volumetric_slope_linear(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::verification::check;

    #[test]
    fn derivatives_symmetry_and_objectivity() {
        let material = |mu, kappa, k1, k2, angle: f64, tension_only| HolzapfelGasserOgden {
            mu,
            kappa,
            k1,
            k2,
            fibre: [angle.to_radians().cos(), angle.to_radians().sin()],
            dispersion: 0.0,
            tension_only,
        };
        let dispersed = |dispersion| HolzapfelGasserOgden {
            dispersion,
            ..material(1.0, 2.0, 3.0, 1.5, 35.0, false)
        };
        check(&dispersed(0.1));
        check(&dispersed(1.0 / 3.0));
        check(&material(5.4e4, 1e9, 640.0, 3.54, 10.0, false));
        check(&material(5.4e3, 1e8, 5.1e3, 2.0, 40.0, false));
        // Fibres that are not drowned by the bulk modulus.
        check(&material(1.0, 2.0, 3.0, 1.5, 35.0, false));
        check(&material(1.0, 2.0, 3.0, 0.0, 35.0, false));
    }

    #[test]
    fn dispersed_evenly_the_fibres_have_no_direction() {
        let material = |dispersion, angle: f64| HolzapfelGasserOgden {
            mu: 1.0,
            kappa: 2.0,
            k1: 3.0,
            k2: 1.5,
            fibre: [angle.cos(), angle.sin()],
            dispersion,
            tension_only: false,
        };
        let frame = WallAxes::from_tangents(&Vec3::x(), &Vec3::y());
        let F = Mat3::new(1.2, 0.1, 0.0, -0.2, 0.9, 0.3, 0.1, 0.0, 1.1);
        let third = 1.0 / 3.0;
        let [a, b] = [0.1, 1.3].map(|angle| material(third, angle).stress(&F, &frame));
        assert!((a - b).norm() < 1e-14 * a.norm());
        // The same as fibres of the mean strain (I_C - 3)/3, twice.
        let strain = (F.norm_squared() - 3.0) / 3.0;
        let fibres = material(third, 0.1).energy(&F, &frame)
            - HolzapfelGasserOgden {
                k1: 0.0,
                ..material(third, 0.1)
            }
            .energy(&F, &frame);
        assert!((fibres / (2.0 * ((1.5 * strain * strain).exp() - 1.0)) - 1.0).abs() < 1e-13);
        // In between, neither limit.
        let [none, some] = [0.0, 0.2].map(|kappa| material(kappa, 0.1).stress(&F, &frame));
        assert!((some - none).norm() > 0.1 * none.norm() && (some - a).norm() > 0.1 * a.norm());
    }

    #[test]
    fn compressed_fibres_carry_no_load_if_tension_only() {
        let mut material = HolzapfelGasserOgden {
            mu: 1.0,
            kappa: 2.0,
            k1: 3.0,
            k2: 1.5,
            fibre: [1.0, 0.0],
            dispersion: 0.0,
            tension_only: true,
        };
        let frame = WallAxes::from_tangents(&Vec3::x(), &Vec3::y());
        let compressed = Mat3::from_diagonal(&Vec3::new(1.1, 0.8, 1.1));
        let stretched = Mat3::from_diagonal(&Vec3::new(0.9, 1.2, 0.9));
        let energies = [compressed, stretched].map(|F| material.energy(&F, &frame));
        let stresses = [compressed, stretched].map(|F| material.stress(&F, &frame));
        material.tension_only = false;
        assert!(material.energy(&compressed, &frame) > energies[0]);
        assert_eq!(material.energy(&stretched, &frame), energies[1]);
        assert_eq!(material.stress(&stretched, &frame), stresses[1]);
        material.k1 = 0.0;
        assert_eq!(material.energy(&compressed, &frame), energies[0]);
        assert_eq!(material.stress(&compressed, &frame), stresses[0]);
    }
}
