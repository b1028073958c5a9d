//! Energy and internal forces.

use super::super::SolidError;
use super::super::material::lanes::{LANES, Lanes, Tensor};
use super::deformation::{CHUNK, scatter};
use super::groups::{DeformedGroup, deform, fluxes};
use super::predicted_pressure::{ElementVolumes, Origin, Volumes};
use super::{Body, Elements};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use multiversion::multiversion;

/// Adds tensors with a factor each.
#[multiversion(targets = "simd")]
fn add_scaled(sums: &mut [Tensor<Lanes>], tensors: &[Tensor<Lanes>], factors: &[Lanes]) {
    for ((sum, tensor), factor) in sums.iter_mut().zip(tensors).zip(factors) {
        for i in 0..3 {
            for j in 0..3 {
                sum[i][j] += *factor * tensor[i][j];
            }
        }
    }
}

impl Elements {
    /// Strain energy, J.
    pub fn energy(&self, body: Body, displacement: &[f64]) -> Result<f64, SolidError> {
        let parts = self.chunks(
            body,
            displacement,
            self.shapes.gradient_matrix(),
            |chunk, gradients| {
                let mut sum = 0.0;
                for (c, &e) in chunk.iter().enumerate() {
                    let material = &body.materials[body.regions[e]];
                    let deformed = self.deformed(body, e, &gradients, c, None)?;
                    for (point, (F, U)) in self.points[e].iter().zip(deformed.points()) {
                        sum += point.weight * material.energy_with(F, &point.frame, U);
                    }
                }
                Ok(sum)
            },
        )?;
        Ok(parts.iter().sum())
    }

    /// Internal forces `∂W/∂d`, N, at every degree of freedom.
    pub fn internal_forces(
        &self,
        body: Body,
        displacement: &[f64],
    ) -> Result<Vec<f64>, SolidError> {
        Ok(self.forces_from(body, displacement, None)?.0)
    }

    /// The same with the pressure that the step from its `origin` predicts ([`super::predicted_pressure`]), and the
    /// volumes.
    pub fn forces_from(
        &self,
        body: Body,
        displacement: &[f64],
        origin: Option<Origin>,
    ) -> Result<(Vec<f64>, Option<Volumes>), SolidError> {
        let n = self.shapes.modes;
        let matrix = self.groups.gradient_matrix();
        let parts = self.chunks(body, displacement, matrix, |chunk, gradients| {
            let mut fluxes = gradients;
            let size = fluxes.len() / chunk.len();
            let elements = chunk.iter().zip(fluxes.chunks_exact_mut(size));
            let volumes: Vec<_> = elements
                .map(|(&e, fluxes)| self.element_fluxes(body, e, fluxes, origin))
                .collect::<Result<_, _>>()?;
            let mut forces = vec![0.0; n * 3 * chunk.len()];
            matmul(
                MatMut::from_column_major_slice_mut(&mut forces, n, 3 * chunk.len()),
                Accum::Replace,
                matrix,
                MatRef::from_column_major_slice(&fluxes, size / 3, 3 * chunk.len()),
                1.0,
                Par::Seq,
            );
            Ok((forces, volumes))
        })?;
        let mut total = vec![0.0; displacement.len()];
        for (chunk, (forces, _)) in parts.iter().enumerate() {
            for (c, local) in forces.chunks_exact(3 * n).enumerate() {
                scatter(body.numbering, chunk * CHUNK + c, local, &mut total);
            }
        }
        let volumes = parts.into_iter().flat_map(|(_, volumes)| volumes);
        Ok((total, volumes.collect::<Option<_>>().map(Volumes::new)))
    }

    /// Replaces the gradients `H` of an element by its `Q`, both in the order of the groups, component by component.
    fn element_fluxes(
        &self,
        body: Body,
        element: usize,
        values: &mut [f64],
        origin: Option<Origin>,
    ) -> Result<Option<ElementVolumes>, SolidError> {
        let material = &*body.materials[body.regions[element]];
        let mut deformed = self.deformed_groups(body, element, values)?;
        let predicted = origin.map(|origin| {
            let (defects, volumes) = self.predict_pressure(body, element, &mut deformed, origin);
            (origin.gradients.of(element), defects, volumes)
        });
        let mut stresses: Vec<_> = deformed.iter().map(|d| d.stress(material)).collect();
        if let Some((gradients, defects, _)) = &predicted {
            add_scaled(&mut stresses, gradients, defects);
        }
        let groups = &self.groups.of_element[element];
        fluxes(groups, &stresses, values);
        Ok(predicted.map(|(_, _, volumes)| volumes))
    }

    /// The groups of an element with these gradients `H`, which stand in the order of the groups, component by
    /// component.
    pub(super) fn deformed_groups(
        &self,
        body: Body,
        element: usize,
        values: &[f64],
    ) -> Result<Vec<DeformedGroup<'_>>, SolidError> {
        let groups = &self.groups.of_element[element];
        let undeformed = |group| DeformedGroup {
            group,
            F: Tensor::default(),
            slope: Lanes::default(),
        };
        let mut deformed: Vec<_> = groups.iter().map(undeformed).collect();
        let mut changes = vec![0.0; groups.len() * LANES];
        deform(&mut deformed, values, &mut changes);
        changes[self.shapes.points..].fill(0.0);
        self.check_volumes(body, element, &changes)?;
        if self.projection.is_some() {
            self.project_groups(element, &mut changes);
            self.check_volumes(body, element, &changes)?;
        }
        let material = &body.materials[body.regions[element]];
        let mut pressure = changes;
        material.volumetric_slopes(&mut pressure);
        if !material.is_volumetric_slope_linear() {
            self.project_groups(element, &mut pressure);
        }
        for (deformed, pressure) in deformed.iter_mut().zip(pressure.chunks_exact(LANES)) {
            deformed.slope = Lanes::load(pressure);
        }
        Ok(deformed)
    }

    /// Replaces a field at the points of an element, in the order of the groups, by its projection in the mixed form.
    pub(super) fn project_groups(&self, element: usize, field: &mut [f64]) {
        if let Some(projection) = &self.projection {
            let groups = self.groups.of_element[element].iter();
            projection.project_groups(element, groups.map(|group| group.weight), field);
        }
    }
}
