//! Energy and internal forces.

use super::super::SolidError;
use super::super::material::HyperelasticMaterial;
use super::super::material::lanes::{self, LANES, Lanes, Real, Tensor, Vector};
use super::super::space::shapes::Shapes;
use super::deformation::{CHUNK, scatter};
use super::predicted_pressure::{ElementVolumes, Origin, Volumes};
use super::{Body, ElementPoint, Elements};
use crate::Vec3;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use multiversion::multiversion;

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

impl Group {
    /// `H ∂ξ/∂X` for the gradients `H` of an element, where this is the group number `g`.
    #[inline(always)]
    pub(super) fn displacement_gradient(&self, values: &[f64], g: usize) -> Tensor<Lanes> {
        let component = values.len() / 3;
        let mut local = [[Lanes::default(); 3]; 3];
        for i in 0..3 {
            for alpha in 0..3 {
                local[i][alpha] = Lanes::load(&values[i * component + (3 * g + alpha) * LANES..]);
            }
        }
        lanes::product(&local, &self.inverse_jacobian)
    }
}

/// `F = 1 + H`.
#[inline(always)]
pub(super) fn add_identity(H: &mut Tensor<Lanes>) {
    for i in 0..3 {
        H[i][i] += Lanes::of(1.0);
    }
}

/// A group in a deformed element.
pub(super) struct DeformedGroup<'a> {
    pub(super) group: &'a Group,
    /// The deformation gradient.
    pub(super) F: Tensor<Lanes>,
    /// `U'`, Pa; projected in the mixed form.
    pub(super) slope: Lanes,
}

impl DeformedGroup<'_> {
    /// Makes `slope` (Pa) the volumetric stress; what is left of the one before.
    pub(super) fn replace_slope(&mut self, slope: Lanes) -> Lanes {
        let left = self.slope - slope;
        self.slope = slope;
        left
    }

    /// The first Piola-Kirchhoff stress, Pa.
    #[inline(always)]
    pub(super) fn stress(&self, material: &dyn HyperelasticMaterial) -> Tensor<Lanes> {
        let [axial, around] = &self.group.directions;
        material.stresses(&self.F, [axial, around], self.slope)
    }
}

/// Sets `F` for the gradients `H` of an element, and its `J - 1`.
#[multiversion(targets = "simd")]
fn deform(deformed: &mut [DeformedGroup], values: &[f64], changes: &mut [f64]) {
    let changes = changes.chunks_exact_mut(LANES);
    for ((g, deformed), changes) in deformed.iter_mut().enumerate().zip(changes) {
        let mut F = deformed.group.displacement_gradient(values, g);
        changes.copy_from_slice(&lanes::volume_change(&F).to_array());
        add_identity(&mut F);
        deformed.F = F;
    }
}

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

/// `Q = w P (∂ξ/∂X)ᵀ` of an element, in the order of the groups, component by component.
#[multiversion(targets = "simd")]
fn fluxes(groups: &[Group], stresses: &[Tensor<Lanes>], values: &mut [f64]) {
    let component = values.len() / 3;
    for (g, (group, P)) in groups.iter().zip(stresses).enumerate() {
        for i in 0..3 {
            let flux = lanes::apply(&group.inverse_jacobian, &P[i]);
            for alpha in 0..3 {
                let to = i * component + (3 * g + alpha) * LANES;
                let flux = flux[alpha] * group.weight;
                values[to..to + LANES].copy_from_slice(&flux.to_array());
            }
        }
    }
}

/// The points of all elements in groups, and the gradients of the modes in their order: the points of a group fastest,
/// then the local directions, then the groups. The last group is filled up with points without weight.
#[derive(Debug, Clone)]
pub struct Groups {
    pub(super) of_element: Vec<Vec<Group>>,
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
