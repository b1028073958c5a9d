//! Quadrature points of an element side by side, as the internal forces are computed.

use super::super::material::HyperelasticMaterial;
use super::super::material::lanes::{self, LANES, Lanes, Real, Tensor, Vector};
use super::super::space::shapes::Shapes;
use super::ElementPoint;
use crate::Vec3;
use faer::MatRef;
use multiversion::multiversion;

/// [`LANES`] quadrature points of an element side by side.
#[derive(Debug, Clone)]
pub(super) struct Group {
    /// `∂ξ/∂X S`, with the prestretch `S`.
    inverse_jacobian: Tensor<Lanes>,
    /// See [`Fabric::prestretch`](super::Fabric::prestretch).
    prestretch: f64,
    /// Quadrature weight times `det ∂X/∂ξ`, m³; zero where there is no point.
    pub(super) weight: Lanes,
    /// Axial and circumferential direction.
    pub(super) directions: [Vector<Lanes>; 2],
}

impl Group {
    /// `F - 1` for the gradients `H` of an element, where this is the group number `g`.
    #[inline(always)]
    pub(super) fn change(&self, values: &[f64], g: usize) -> Tensor<Lanes> {
        let component = values.len() / 3;
        let mut local = [[Lanes::default(); 3]; 3];
        for i in 0..3 {
            for alpha in 0..3 {
                local[i][alpha] = Lanes::load(&values[i * component + (3 * g + alpha) * LANES..]);
            }
        }
        let mut change = lanes::product(&local, &self.inverse_jacobian);
        if self.prestretch != 1.0 {
            // S - 1.
            let across = 1.0 / self.prestretch.sqrt();
            let along = Lanes::of(self.prestretch - across);
            let axial = &self.directions[0];
            for i in 0..3 {
                change[i][i] += Lanes::of(across - 1.0);
                for j in 0..3 {
                    change[i][j] += along * axial[i] * axial[j];
                }
            }
        }
        change
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
pub(super) fn deform(deformed: &mut [DeformedGroup], values: &[f64], changes: &mut [f64]) {
    let changes = changes.chunks_exact_mut(LANES);
    for ((g, deformed), changes) in deformed.iter_mut().enumerate().zip(changes) {
        let mut F = deformed.group.change(values, g);
        changes.copy_from_slice(&lanes::volume_change(&F).to_array());
        add_identity(&mut F);
        deformed.F = F;
    }
}

/// `Q = w P (∂ξ/∂X)ᵀ` of an element, in the order of the groups, component by component.
#[multiversion(targets = "simd")]
pub(super) fn fluxes(groups: &[Group], stresses: &[Tensor<Lanes>], values: &mut [f64]) {
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
    pub fn new(shapes: &Shapes, points: &[Vec<ElementPoint>], prestretch: f64) -> Self {
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
                prestretch,
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
