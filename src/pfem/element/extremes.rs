//! Extreme stresses at the quadrature points, several points side by side: they are asked for after each time step.

use super::super::SolidError;
use super::super::evaluation::extremes::Extremes;
use super::super::evaluation::stress::{eigenvalues, largest_eigenvalue_bound};
use super::super::material::lanes::{self, LANES, Lanes, Real, Tensor, Vector};
use super::groups::DeformedGroup;
use super::{Body, Elements};
use crate::Mat3;
use multiversion::multiversion;

/// Stresses at the points of a group.
struct GroupStresses {
    /// The Cauchy stress, Pa.
    cauchy: Tensor<Lanes>,
    /// Along the deformed vessel, Pa.
    axial: Lanes,
    /// Around it, perpendicular to the axial direction in the deformed wall, Pa.
    hoop: Lanes,
    /// `det F`.
    jacobian: Lanes,
}

/// The stress of `tensor` along `a`.
#[inline(always)]
fn along(tensor: &Tensor<Lanes>, a: &Vector<Lanes>) -> Lanes {
    lanes::dot(a, &lanes::apply(tensor, a)) / lanes::dot(a, a)
}

impl GroupStresses {
    /// The Cauchy stress at one of the points.
    fn at(&self, lane: usize) -> Mat3 {
        Mat3::from_fn(|i, j| self.cauchy[i][j].to_array()[lane])
    }

    /// Von Mises stress, Pa.
    #[inline(always)]
    fn von_mises(&self) -> [f64; LANES] {
        let S = &self.cauchy;
        let mean = (S[0][0] + S[1][1] + S[2][2]) * Lanes::of(1.0 / 3.0);
        let mut deviator = *S;
        for i in 0..3 {
            deviator[i][i] -= mean;
        }
        (lanes::norm_squared(&deviator) * Lanes::of(1.5))
            .to_array()
            .map(f64::sqrt)
    }
}

/// From the first Piola-Kirchhoff stress `P`, Pa.
#[multiversion(targets = "simd")]
fn group_stresses(deformed: &DeformedGroup, P: &Tensor<Lanes>) -> GroupStresses {
    let F = &deformed.F;
    let J = lanes::dot(&F[0], &lanes::cofactors(F)[0]);
    let half = Lanes::of(0.5) * J.inverse();
    // σ = P Fᵀ / J is symmetric but for round-off.
    let mut cauchy = *P;
    for i in 0..3 {
        for j in 0..3 {
            cauchy[i][j] = (lanes::dot(&P[i], &F[j]) + lanes::dot(&P[j], &F[i])) * half;
        }
    }
    let [axial, around] = deformed.group.directions.each_ref();
    let (a, mut c) = (lanes::apply(F, axial), lanes::apply(F, around));
    let share = lanes::dot(&a, &c) / lanes::dot(&a, &a);
    for i in 0..3 {
        c[i] -= share * a[i];
    }
    GroupStresses {
        axial: along(&cauchy, &a),
        hoop: along(&cauchy, &c),
        cauchy,
        jacobian: J,
    }
}

impl Elements {
    /// Largest von Mises stress (Pa) over all quadrature points with its element and local coordinates, and the
    /// smallest and largest Jacobian `det F`.
    pub fn extremes(&self, body: Body, displacement: &[f64]) -> Result<Extremes, SolidError> {
        let all = self.element_extremes(body, displacement)?;
        Ok(all.iter().fold(Extremes::default(), |a, b| a.with(b)))
    }

    /// The same for each element.
    pub fn element_extremes(
        &self,
        body: Body,
        displacement: &[f64],
    ) -> Result<Vec<Extremes>, SolidError> {
        let matrix = self.groups.gradient_matrix();
        let parts = self.chunks(body, displacement, matrix, |chunk, gradients| {
            let size = gradients.len() / chunk.len();
            let of = |(&e, gradients): (&usize, &[f64])| self.extremes_of(body, e, gradients);
            let all = chunk.iter().zip(gradients.chunks_exact(size)).map(of);
            all.collect::<Result<Vec<_>, _>>()
        })?;
        Ok(parts.concat())
    }

    /// Of one element with these `gradients` in the order of the groups.
    fn extremes_of(
        &self,
        body: Body,
        element: usize,
        gradients: &[f64],
    ) -> Result<Extremes, SolidError> {
        let material = &*body.materials[body.regions[element]];
        let mut extremes = Extremes::default();
        let deformed = self.deformed_groups(body, element, gradients)?;
        for (g, group) in deformed.iter().enumerate() {
            let stresses = group_stresses(group, &group.stress(material));
            let von_mises = stresses.von_mises();
            let [axial, hoop, J] =
                [stresses.axial, stresses.hoop, stresses.jacobian].map(Lanes::to_array);
            let points = self.points[element].iter().enumerate().skip(g * LANES);
            for (lane, (q, point)) in points.take(LANES).enumerate() {
                let cauchy = stresses.at(lane);
                // The eigenvalues cost more than all else; few points can have the largest.
                let may_be_largest = largest_eigenvalue_bound(&cauchy) > extremes.max_principal;
                let principal = match may_be_largest {
                    true => eigenvalues(&cauchy)[0],
                    false => f64::NEG_INFINITY,
                };
                let F = || Mat3::from_fn(|i, j| group.F[i][j].to_array()[lane]);
                let fibres = material.fibre_directions(&point.frame);
                let stretches = fibres.into_iter().flatten().map(|a| (F() * a).norm());
                extremes = extremes.with(&Extremes {
                    von_mises: von_mises[lane],
                    max_principal: principal,
                    max_hoop: hoop[lane],
                    max_axial: axial[lane],
                    max_fibre_stretch: stretches.fold(f64::NEG_INFINITY, f64::max),
                    element,
                    local: self.local[q],
                    min_jacobian: J[lane],
                    max_jacobian: J[lane],
                });
            }
        }
        Ok(extremes)
    }
}

#[cfg(test)]
mod tests {
    use crate::discretization::{Discretization, Options};
    use crate::material::{HolzapfelGasserOgden, Law, NeoHooke};
    use crate::mesh::tube_mesh;
    use crate::{Formulation, Space, SpaceKind};

    #[test]
    fn they_are_those_of_the_states_one_by_one() {
        let graft = NeoHooke {
            mu: 3.33e5,
            kappa: 1.67e9,
        };
        let media = HolzapfelGasserOgden {
            mu: 5.4e4,
            kappa: 1e9,
            k1: 640.0,
            k2: 3.54,
            fibre: [10_f64.to_radians().cos(), 10_f64.to_radians().sin()],
            dispersion: 0.0,
            tension_only: false,
        };
        let laws = [Law::from(&graft), Law::from(&media)];
        let mesh = tube_mesh(3e-3, &[5e-4, 4e-4], 4e-3, 1, 4, 1);
        for formulation in [Formulation::Mixed, Formulation::Displacement] {
            let options = Options {
                formulation,
                ..Options::new(Space::isotropic(SpaceKind::Trunk, 2))
            };
            let body = Discretization::new(&mesh, &laws, &[], &options).expect("well posed");
            let waves = |i: usize| 2e-5 * (1.7 * i as f64).sin();
            let displacement: Vec<f64> = (0..body.coefficients()).map(waves).collect();
            let elements = &body.elements;
            let found = elements
                .element_extremes(body.body(), &displacement)
                .expect("regular");
            let states = elements
                .states(body.body(), &displacement, None)
                .expect("regular");
            let per_element = states.len() / found.len();
            assert_ne!(
                per_element % super::LANES,
                0,
                "the last group shall not be full"
            );
            for (e, (extremes, states)) in found.iter().zip(states.chunks(per_element)).enumerate()
            {
                let largest = |f: &dyn Fn(&crate::StressState) -> f64| {
                    states.iter().map(f).fold(f64::NEG_INFINITY, f64::max)
                };
                for (value, expected) in [
                    (extremes.von_mises, largest(&|s| s.von_mises())),
                    (
                        extremes.max_principal,
                        largest(&|s| s.principal_stresses()[0]),
                    ),
                    (extremes.max_hoop, largest(&|s| s.hoop_stress())),
                    (extremes.max_axial, largest(&|s| s.axial_stress())),
                ] {
                    let size = largest(&|s| s.cauchy.norm());
                    assert!(
                        (value - expected).abs() < 1e-9 * size,
                        "{e}: {value} {expected}"
                    );
                }
                let stretch = largest(&|s| s.fibre_stretches[0].max(s.fibre_stretches[1]));
                match stretch.is_finite() {
                    true => assert!((extremes.max_fibre_stretch - stretch).abs() < 1e-12),
                    false => assert_eq!(extremes.max_fibre_stretch, f64::NEG_INFINITY),
                }
                assert_eq!(extremes.element, e);
            }
        }
    }
}
