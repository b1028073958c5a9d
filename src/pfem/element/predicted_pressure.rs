//! Newton's method with the pressure as an unknown of its own.
//!
//! In a nearly incompressible body the pressure `p̄ = Π U'(Π J(d))` of an iterate is wrong by the bulk modulus times
//! the terms of second order of the step before. The three-field form has the pressure as an unknown, which changes by
//! what the linearized equations say, and is eliminated from them again (Simo, Taylor, Pister 1985). With a tangent
//! that was assembled at `d_0`, the step from the iterate `d_k` to the next one leads to
//! ```text
//! p_{k+1} = p̄_k + κ Π(∂J/∂F|_0 : (F_{k+1} - F_k)),            κ = U''(1)
//! r_{k+1} = ∫ (∂W_rest/∂F + p_{k+1} ∂J/∂F + (p̄_{k+1} - p_{k+1}) ∂J/∂F|_0) : δF dV - …
//! ```
//! whose last term is what the elimination makes of the defect of the pressure. Where the iteration ends, `p = p̄`, and
//! the forces are the derivatives of the energy. On the way the defect, which is multiplied by the bulk modulus, acts
//! in the very directions that the kept tangent knows to be stiff; taken along `∂J/∂F` of the iterate, it leads a
//! tangent that is older astray, by the bulk modulus times what the wall has strained since.

use super::super::SolidError;
use super::super::material::lanes::{self, LANES, Lanes, Real, Tensor};
use super::groups::{DeformedGroup, Group, add_identity};
use super::{Body, Elements};
use multiversion::multiversion;

/// `∂J/∂F` where a tangent was assembled, at the points of all elements in their groups.
#[derive(Debug, Clone)]
pub struct VolumeGradients {
    of_element: Vec<Vec<Tensor<Lanes>>>,
}

impl VolumeGradients {
    /// In one element.
    pub(super) fn of(&self, element: usize) -> &[Tensor<Lanes>] {
        &self.of_element[element]
    }
}

/// The volumes of an iterate, from which the pressure of the next one is predicted, at the points of all elements.
#[derive(Debug, Clone)]
pub struct Volumes {
    of_element: Vec<ElementVolumes>,
}

impl Volumes {
    /// Of all elements in order.
    pub(super) fn new(of_element: Vec<ElementVolumes>) -> Self {
        Self { of_element }
    }
}

/// The same in one element.
#[derive(Debug, Clone)]
pub(super) struct ElementVolumes {
    /// `p̄`, Pa.
    pressure: Vec<Lanes>,
    /// `∂J/∂F|_0 : F`.
    linear: Vec<Lanes>,
}

/// Whence an iterate comes.
#[derive(Clone, Copy)]
pub struct Origin<'a> {
    /// The kept tangent's.
    pub gradients: &'a VolumeGradients,
    /// Those of the iterate before, if a step of the linearized equations led from there.
    pub before: Option<&'a Volumes>,
}

/// `∂J/∂F|_0 : F` of an element.
#[multiversion(targets = "simd")]
fn contractions(deformed: &[DeformedGroup], gradients: &[Tensor<Lanes>], linear: &mut [Lanes]) {
    for ((deformed, gradient), linear) in deformed.iter().zip(gradients).zip(linear) {
        let F = &deformed.F;
        *linear = lanes::dot(&F[0], &gradient[0])
            + lanes::dot(&F[1], &gradient[1])
            + lanes::dot(&F[2], &gradient[2]);
    }
}

impl Elements {
    /// `∂J/∂F` at the points of all elements for a displacement.
    pub fn volume_gradients(
        &self,
        body: Body,
        displacement: &[f64],
    ) -> Result<VolumeGradients, SolidError> {
        let matrix = self.groups.gradient_matrix();
        let parts = self.chunks(body, displacement, matrix, |chunk, gradients| {
            let size = gradients.len() / chunk.len();
            let of_element = |(&e, values): (&usize, &[f64])| {
                let groups = self.groups.of_element[e].iter().enumerate();
                let cofactors = |(g, group): (usize, &Group)| {
                    let mut F = group.change(values, g);
                    add_identity(&mut F);
                    lanes::cofactors(&F)
                };
                groups.map(cofactors).collect()
            };
            let elements = chunk.iter().zip(gradients.chunks_exact(size));
            Ok(elements.map(of_element).collect::<Vec<_>>())
        })?;
        Ok(VolumeGradients {
            of_element: parts.concat(),
        })
    }

    /// Gives the groups of an element the predicted pressure in place of their own; what is left of that, Pa, and the
    /// volumes.
    pub(super) fn predict_pressure(
        &self,
        body: Body,
        element: usize,
        deformed: &mut [DeformedGroup],
        origin: Origin,
    ) -> (Vec<Lanes>, ElementVolumes) {
        let gradients = origin.gradients.of(element);
        let mut linear = vec![Lanes::default(); deformed.len()];
        contractions(deformed, gradients, &mut linear);
        let volumes = ElementVolumes {
            pressure: deformed.iter().map(|deformed| deformed.slope).collect(),
            linear,
        };
        let defects = match origin.before {
            None => vec![Lanes::of(0.0); deformed.len()],
            Some(before) => {
                let before = &before.of_element[element];
                let material = &body.materials[body.regions[element]];
                let bulk_modulus = Lanes::of(material.volumetric(0.0).curvature);
                let linear = volumes.linear.iter().zip(&before.linear);
                let mut steps: Vec<f64> = linear
                    .flat_map(|(new, old)| (*new - *old).to_array())
                    .collect();
                self.project_groups(element, &mut steps);
                let steps = steps.chunks_exact(LANES).map(Lanes::load);
                let pressure = before.pressure.iter().zip(steps);
                let pressure = pressure.map(|(pressure, step)| *pressure + bulk_modulus * step);
                let replaced = deformed.iter_mut().zip(pressure);
                replaced
                    .map(|(deformed, pressure)| deformed.replace_slope(pressure))
                    .collect()
            }
        };
        (defects, volumes)
    }
}
