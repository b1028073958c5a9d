//! Energy and internal forces.

use super::super::SolidError;
use super::super::material::HyperelasticMaterial;
use super::super::material::lanes::{self, LANES, Lanes, Real, Tensor, Vector};
use super::super::space::shapes::Shapes;
use super::deformation::{CHUNK, scatter};
use super::{Body, ElementPoint, Elements};
use crate::Vec3;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// [`LANES`] quadrature points of an element side by side.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// `∂ξ/∂X`.
    inverse_jacobian: Tensor<Lanes>,
    /// Quadrature weight times `det ∂X/∂ξ`, m³; zero where there is no point.
    weight: Lanes,
    /// Axial and circumferential direction.
    pub(super) directions: [Vector<Lanes>; 2],
}

/// A group in a deformed element.
pub(super) struct DeformedGroup<'a> {
    pub(super) group: &'a Group,
    /// The deformation gradient.
    pub(super) F: Tensor<Lanes>,
    /// `U'`, Pa; projected in the mixed form.
    slope: Lanes,
}

impl DeformedGroup<'_> {
    /// The first Piola-Kirchhoff stress, Pa.
    #[inline(always)]
    pub(super) fn stress(&self, material: &dyn HyperelasticMaterial) -> Tensor<Lanes> {
        let [axial, around] = &self.group.directions;
        material.stresses(&self.F, [axial, around], self.slope)
    }
}

/// The points of all elements in groups, and the gradients of the modes in their order: the points of a group fastest,
/// then the local directions, then the groups. The last group is filled up with points without weight.
#[derive(Debug, Clone)]
pub struct Groups {
    of_element: Vec<Vec<Group>>,
    /// Modes (fastest) times the order of the groups.
    gradients: Vec<f64>,
    /// Groups of an element.
    count: usize,
}

impl Groups {
    /// Arranges the points of all elements.
    pub fn new(shapes: &Shapes, points: &[Vec<ElementPoint>]) -> Self {
        let (n, count) = (shapes.modes, shapes.points.div_ceil(LANES));
        let mut gradients = vec![0.0; n * 3 * LANES * count];
        for q in 0..shapes.points {
            for alpha in 0..3 {
                let column = (q / LANES * 3 + alpha) * LANES + q % LANES;
                let from = (3 * q + alpha) * n;
                gradients[column * n..(column + 1) * n]
                    .copy_from_slice(&shapes.gradients[from..from + n]);
            }
        }
        let group = |points: &[ElementPoint]| {
            let side_by_side = |f: &dyn Fn(&ElementPoint) -> f64| {
                Lanes::new(std::array::from_fn(|lane| {
                    f(&points[lane.min(points.len() - 1)])
                }))
            };
            let vector =
                |f: &dyn Fn(&ElementPoint) -> Vec3| [0, 1, 2].map(|i| side_by_side(&|p| f(p)[i]));
            let mut weight = [0.0; LANES];
            (weight.iter_mut().zip(points)).for_each(|(w, point)| *w = point.weight);
            Group {
                inverse_jacobian: [0, 1, 2]
                    .map(|i| [0, 1, 2].map(|j| side_by_side(&|p| p.inverse_jacobian[(i, j)]))),
                weight: Lanes::new(weight),
                directions: [
                    vector(&|p| p.frame.axial),
                    vector(&|p| p.frame.circumferential),
                ],
            }
        };
        let groups = |points: &Vec<ElementPoint>| points.chunks(LANES).map(group).collect();
        Self {
            of_element: points.iter().map(groups).collect(),
            gradients,
            count,
        }
    }

    /// Modes times the order of the groups.
    pub(super) fn gradient_matrix(&self) -> MatRef<'_, f64> {
        let columns = 3 * LANES * self.count;
        let modes = self.gradients.len() / columns;
        MatRef::from_column_major_slice(&self.gradients, modes, columns)
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
        let n = self.shapes.modes;
        let matrix = self.groups.gradient_matrix();
        let parts = self.chunks(body, displacement, matrix, |chunk, gradients| {
            let mut fluxes = gradients;
            let size = fluxes.len() / chunk.len();
            for (&e, fluxes) in chunk.iter().zip(fluxes.chunks_exact_mut(size)) {
                self.element_fluxes(body, e, fluxes)?;
            }
            let mut forces = vec![0.0; n * 3 * chunk.len()];
            matmul(
                MatMut::from_column_major_slice_mut(&mut forces, n, 3 * chunk.len()),
                Accum::Replace,
                matrix,
                MatRef::from_column_major_slice(&fluxes, size / 3, 3 * chunk.len()),
                1.0,
                Par::Seq,
            );
            Ok(forces)
        })?;
        let mut total = vec![0.0; displacement.len()];
        for (chunk, forces) in parts.iter().enumerate() {
            for (c, local) in forces.chunks_exact(3 * n).enumerate() {
                scatter(body.numbering, chunk * CHUNK + c, local, &mut total);
            }
        }
        Ok(total)
    }

    /// Replaces the gradients `H` of an element by its `Q`, both in the order of the groups, component by component.
    fn element_fluxes(
        &self,
        body: Body,
        element: usize,
        values: &mut [f64],
    ) -> Result<(), SolidError> {
        let material = &*body.materials[body.regions[element]];
        let component = values.len() / 3;
        for (g, deformed) in self
            .deformed_groups(body, element, values)?
            .iter()
            .enumerate()
        {
            let group = deformed.group;
            let P = deformed.stress(material);
            for (i, row) in P.iter().enumerate() {
                let row = row.map(|P| P * group.weight);
                let flux = lanes::apply(&group.inverse_jacobian, &row);
                for (alpha, flux) in flux.iter().enumerate() {
                    let to = i * component + (3 * g + alpha) * LANES;
                    values[to..to + LANES].copy_from_slice(&flux.to_array());
                }
            }
        }
        Ok(())
    }

    /// The groups of an element with these gradients `H`, which stand in the order of the groups, component by component.
    pub(super) fn deformed_groups(
        &self,
        body: Body,
        element: usize,
        values: &[f64],
    ) -> Result<Vec<DeformedGroup<'_>>, SolidError> {
        let groups = &self.groups.of_element[element];
        let component = values.len() / 3;
        let mut deformed = Vec::with_capacity(groups.len());
        let mut changes = Vec::with_capacity(groups.len() * LANES);
        for (g, group) in groups.iter().enumerate() {
            let local = [0, 1, 2].map(|i| {
                [0, 1, 2]
                    .map(|alpha| lanes::load(&values[i * component + (3 * g + alpha) * LANES..]))
            });
            let H = lanes::product(&local, &group.inverse_jacobian);
            changes.extend(lanes::volume_change(&H).to_array());
            let mut F = H;
            for (i, row) in F.iter_mut().enumerate() {
                row[i] += Lanes::of(1.0);
            }
            deformed.push(DeformedGroup {
                group,
                F,
                slope: Lanes::of(0.0),
            });
        }
        changes.truncate(self.shapes.points);
        let slopes = self.slopes(body, element, changes)?;
        for (deformed, slopes) in deformed.iter_mut().zip(slopes.chunks_exact(LANES)) {
            deformed.slope = lanes::load(slopes);
        }
        Ok(deformed)
    }

    /// `U'` at the points of an element with these `J - 1`, and zeros to fill up the last group; projected in the mixed form.
    fn slopes(
        &self,
        body: Body,
        element: usize,
        mut changes: Vec<f64>,
    ) -> Result<Vec<f64>, SolidError> {
        let material = &*body.materials[body.regions[element]];
        let points = &self.points[element];
        self.check_volumes(body, element, &changes)?;
        if let Some(projection) = &self.projection {
            changes = projection.project(element, points, &changes);
            self.check_volumes(body, element, &changes)?;
        }
        let mut slopes = changes;
        material.volumetric_slopes(&mut slopes);
        if let Some(projection) = &self.projection {
            slopes = projection.project(element, points, &slopes);
        }
        slopes.resize(self.groups.count * LANES, 0.0);
        Ok(slopes)
    }
}
