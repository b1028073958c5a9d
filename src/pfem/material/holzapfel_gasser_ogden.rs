//! Holzapfel-Gasser-Ogden, equation (5).

use super::{
    Frame, HyperelasticMaterial, Tensor4, Volumetric, add_crossed, add_dyadic, add_parallel,
    inverse_transpose,
};
use crate::{Mat3, Vec3};

/// Ground substance and two families of fibres:
/// `W = k1/(2 k2) Σ_f (exp(k2 (IV_f - 1)²) - 1) + mu/2 (J^{-2/3} I_C - 3) + kappa/2 (J - 1)²`
/// with `IV_f = a_f · C a_f`. As in the paper, the fibres see the full `C`, not its isochoric part, and resist
/// compression as well unless `tension_only` is set.
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
    /// Fibres shorter than in the reference configuration carry no load.
    pub tension_only: bool,
}

impl HolzapfelGasserOgden {
    /// Directions `a_1`, `a_2` of the fibres in the reference configuration.
    fn fibres(&self, frame: &Frame) -> [Vec3; 2] {
        let [cos, sin] = self.fibre;
        [
            frame.circumferential * cos + frame.axial * sin,
            frame.circumferential * cos - frame.axial * sin,
        ]
    }

    /// `psi(E) = k1/(2 k2) (exp(k2 E²) - 1)` with `E = IV - 1`, and its first two derivatives by `IV`.
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
}

impl HyperelasticMaterial for HolzapfelGasserOgden {
    fn energy_with(&self, F: &Mat3, frame: &Frame, U: &Volumetric) -> f64 {
        let J = F.determinant();
        let fibres: f64 = self
            .fibres(frame)
            .iter()
            .map(|a| self.fibre_energy((F * a).norm_squared() - 1.0)[0])
            .sum();
        fibres + 0.5 * self.mu * (F.norm_squared() * J.cbrt().powi(-2) - 3.0) + U.energy
    }

    /// `P = mu J^{-2/3} (F - I_C/3 F⁻ᵀ) + U' J F⁻ᵀ + Σ_f 2 psi' (F a_f) ⊗ a_f`.
    fn stress_with(&self, F: &Mat3, frame: &Frame, U: &Volumetric) -> Mat3 {
        let (G, J) = inverse_transpose(F);
        let mu = self.mu * J.cbrt().powi(-2);
        let mut P = F * mu + G * (U.slope * J - mu * F.norm_squared() / 3.0);
        for a in self.fibres(frame) {
            let Fa = F * a;
            let [_, first, _] = self.fibre_energy(Fa.norm_squared() - 1.0);
            P += Fa * a.transpose() * (2.0 * first);
        }
        P
    }

    /// With `G = F⁻ᵀ`:
    /// `A_ijkl = mu J^{-2/3} (δ_ik δ_jl - 2/3 (F_ij G_kl + G_ij F_kl) + 2/9 I_C G_ij G_kl + I_C/3 G_il G_kj)
    /// + (U'' J² + U' J) G_ij G_kl - U' J G_il G_kj + Σ_f 4 psi'' (F a)_i a_j (F a)_k a_l + 2 psi' δ_ik a_j a_l`.
    fn tangent_with(&self, F: &Mat3, frame: &Frame, U: &Volumetric) -> Tensor4 {
        let (G, J) = inverse_transpose(F);
        let mu = self.mu * J.cbrt().powi(-2);
        let I_C = F.norm_squared();
        let mut A = Tensor4::identity() * mu;
        let volumetric = (U.curvature * J + U.slope) * J;
        // All terms with G as a factor at once: H ⊗ G + G ⊗ H.
        let H = F * (-2.0 / 3.0 * mu) + G * (mu * I_C / 9.0 + 0.5 * volumetric);
        add_dyadic(&mut A, 1.0, &H, &G);
        add_dyadic(&mut A, 1.0, &G, &H);
        add_crossed(&mut A, mu * I_C / 3.0 - U.slope * J, &G);
        let mut structure = Mat3::zeros();
        for a in self.fibres(frame) {
            let Fa = F * a;
            let [_, first, second] = self.fibre_energy(Fa.norm_squared() - 1.0);
            let M = Fa * a.transpose();
            add_dyadic(&mut A, 4.0 * second, &M, &M);
            structure += a * a.transpose() * (2.0 * first);
        }
        add_parallel(&mut A, &Mat3::identity(), &structure);
        A
    }

    fn fibre_directions(&self, frame: &Frame) -> Option<[Vec3; 2]> {
        Some(self.fibres(frame))
    }

    /// `U = kappa/2 (J - 1)²`.
    fn volumetric(&self, J: f64) -> Volumetric {
        Volumetric {
            energy: 0.5 * self.kappa * (J - 1.0) * (J - 1.0),
            slope: self.kappa * (J - 1.0),
            curvature: self.kappa,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pfem::material::verification::check;

    #[test]
    fn derivatives_symmetry_and_objectivity() {
        let material = |mu, kappa, k1, k2, angle: f64, tension_only| HolzapfelGasserOgden {
            mu,
            kappa,
            k1,
            k2,
            fibre: [angle.to_radians().cos(), angle.to_radians().sin()],
            tension_only,
        };
        check(&material(5.4e4, 1e9, 640.0, 3.54, 10.0, false));
        check(&material(5.4e3, 1e8, 5.1e3, 2.0, 40.0, false));
        // Fibres that are not drowned by the bulk modulus.
        check(&material(1.0, 2.0, 3.0, 1.5, 35.0, false));
        check(&material(1.0, 2.0, 3.0, 0.0, 35.0, false));
    }

    #[test]
    fn compressed_fibres_carry_no_load_if_tension_only() {
        let mut material = HolzapfelGasserOgden {
            mu: 1.0,
            kappa: 2.0,
            k1: 3.0,
            k2: 1.5,
            fibre: [1.0, 0.0],
            tension_only: true,
        };
        let frame = Frame::from_tangents(&Vec3::x(), &Vec3::y());
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
