//! Integrals over the elements: energy, internal forces, stiffness, mass.
//!
//! All elements share the values and gradients of the modes at the quadrature points of the reference hexahedron.
//! With `G` their matrix (modes times `3 n_q`), `H = Gᵀ U` holds the displacement gradients with respect to the local
//! coordinates of all points of an element, and everything that depends on its shape is pulled back to the points:
//! ```text
//! F       = 1 + H ∂ξ/∂X                                deformation gradient
//! f       = G Q,          Q_αi     = w Σ_j ∂ξ_α/∂X_j P_ij                            internal forces
//! K^{ik}  = G Â^{ik} Gᵀ,  Â^{ik}_αβ = w Σ_jl ∂ξ_α/∂X_j A_ijkl ∂ξ_β/∂X_l              stiffness
//! ```
//! with `w` the quadrature weight times `det ∂X/∂ξ`; so all work but the material is matrix products.

pub mod foundation;
pub mod mapping;
mod pool;
pub mod sum_factorization;
pub mod surface;
pub mod volume;

use super::SolidError;
use super::evaluation::extremes::Extremes;
use super::evaluation::stress::StressState;
use super::material::{Frame, HyperelasticMaterial, KelvinVoigt, Volumetric, inverse_transpose};
use super::space::numbering::Numbering;
use super::space::shapes::Shapes;
use super::space::{Mode, Space};
use crate::quadrature::Rule;
use crate::{Mat3, Vec3};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use mapping::{Mapping, lattice};
use pool::Pool;
use rayon::prelude::*;
use sum_factorization::{SumFactorization, Workspace};
use volume::{Basis, Formulation, Projection};

/// Elements whose internal forces are computed by one matrix product.
const CHUNK: usize = 8;

/// The six blocks `K^{ik}`, `i <= k`, of a symmetric element matrix.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// What an element's shape contributes at a quadrature point.
#[derive(Debug, Clone, Copy)]
pub struct ElementPoint {
    /// `∂ξ/∂X`.
    pub inverse_jacobian: Mat3,
    /// Quadrature weight times `det ∂X/∂ξ`, m³.
    pub weight: f64,
    /// Directions of the wall.
    pub frame: Frame,
}

/// Tensor product Gauss quadrature over all elements of a mesh.
pub struct Elements {
    /// Modes at the quadrature points.
    pub shapes: Shapes,
    /// Element matrices.
    sums: SumFactorization,
    workspaces: Pool<Workspace>,
    /// Coordinates of the points along the three directions.
    axes: [Vec<f64>; 3],
    /// Quadrature points of the reference hexahedron.
    pub local: Vec<[f64; 3]>,
    /// `points[e][q]`.
    pub points: Vec<Vec<ElementPoint>>,
    /// Whence the volumetric energy takes the volume ratio; absent if from `det F` at each point.
    projection: Option<Projection>,
}

/// Deformation of an element at its points.
struct Deformed {
    F: Vec<Mat3>,
    /// The volumetric energy, its derivatives as far as the stress goes: with a projection, `U' = p̄`.
    U: Vec<Volumetric>,
}

/// Everything that the integrals need besides the displacement.
#[derive(Clone, Copy)]
pub struct Body<'a> {
    /// Global numbers of the modes.
    pub numbering: &'a Numbering,
    /// Material of each region.
    pub materials: &'a [Box<dyn HyperelasticMaterial>],
    /// Viscous part of it, if it has one.
    pub viscous: &'a [Option<KelvinVoigt>],
    /// Region of each element.
    pub regions: &'a [usize],
    /// Shape of the elements.
    pub mapping: &'a Mapping,
}

/// How a body moves.
#[derive(Debug, Clone, Copy)]
pub struct Motion<'a> {
    /// Velocity coefficients, m/s.
    pub velocity: &'a [f64],
    /// Derivative of the velocity by the displacement in the time integration, 1/s.
    pub slope: f64,
}

impl Elements {
    /// Prepares quadrature with `points` Gauss points in each local direction.
    pub fn gauss(
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
        elements: usize,
        points: [usize; 3],
        formulation: Formulation,
    ) -> Result<Self, SolidError> {
        let rules = points.map(Rule::gauss_legendre);
        let mut prepared = Self::new(numbering, space, mapping, elements, &rules)?;
        if formulation == Formulation::Mixed {
            prepared.projection = Some(prepared.projection(&volume::modes(space)));
        }
        Ok(prepared)
    }

    /// Prepares the points of a tensor product of three rules.
    pub fn new(
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
        elements: usize,
        rules: &[Rule; 3],
    ) -> Result<Self, SolidError> {
        let axes = [
            &rules[0].points[..],
            &rules[1].points[..],
            &rules[2].points[..],
        ];
        let weights: Vec<f64> = lattice([&rules[0].weights, &rules[1].weights, &rules[2].weights])
            .map(|[a, b, c]| a * b * c)
            .collect();
        let points = (0..elements)
            .into_par_iter()
            .map(|e| {
                let mapped = mapping.at_lattice(e, axes);
                let point = |(m, w): (&mapping::MappedPoint, &f64)| {
                    let determinant = m.jacobian.determinant();
                    let inverse = m.jacobian.try_inverse().filter(|_| determinant > 0.0);
                    let inverse_jacobian = inverse.ok_or_else(|| SolidError::Inverted {
                        element: e,
                        jacobian: determinant,
                        position: m.position.into(),
                    })?;
                    let [g0, g1] = [0, 1].map(|d| Vec3::from(m.jacobian.column(d)));
                    Ok(ElementPoint {
                        inverse_jacobian,
                        weight: w * determinant,
                        frame: Frame::from_tangents(&g0, &g1),
                    })
                };
                mapped.iter().zip(&weights).map(point).collect()
            })
            .collect::<Result<_, SolidError>>()?;
        Ok(Self {
            shapes: Shapes::new(&numbering.modes, space, axes),
            sums: SumFactorization::new(&numbering.modes, space, axes, PAIRS.len()),
            workspaces: Pool::default(),
            local: lattice(axes).collect(),
            axes: axes.map(<[f64]>::to_vec),
            points,
            projection: None,
        })
    }

    /// The projection at the points onto products of Legendre polynomials.
    pub fn projection(&self, modes: &[Mode]) -> Projection {
        Projection::new(
            modes,
            self.axes.each_ref().map(|axis| &axis[..]),
            &self.points,
        )
    }

    /// Strain energy, J.
    pub fn energy(&self, body: Body, displacement: &[f64]) -> Result<f64, SolidError> {
        let parts = self.chunks(body, displacement, |chunk, gradients| {
            let mut sum = 0.0;
            for (c, &e) in chunk.iter().enumerate() {
                let material = &body.materials[body.regions[e]];
                let deformed = self.deformed(body, e, gradients, c, None)?;
                for (point, (F, U)) in self.points[e].iter().zip(deformed.points()) {
                    sum += point.weight * material.energy_with(F, &point.frame, U);
                }
            }
            Ok(sum)
        })?;
        Ok(parts.iter().sum())
    }

    /// Internal forces `∂W/∂d`, N, at every degree of freedom.
    pub fn internal_forces(
        &self,
        body: Body,
        displacement: &[f64],
    ) -> Result<Vec<f64>, SolidError> {
        let (n, nq) = (self.shapes.modes, self.shapes.points);
        let parts = self.chunks(body, displacement, |chunk, gradients| {
            let mut fluxes = vec![0.0; 9 * nq * chunk.len()];
            for (c, &e) in chunk.iter().enumerate() {
                let material = &body.materials[body.regions[e]];
                let deformed = self.deformed(body, e, gradients, c, None)?;
                for (q, (F, U)) in deformed.points().enumerate() {
                    let point = &self.points[e][q];
                    let P = material.stress_with(F, &point.frame, U);
                    let Q = point.inverse_jacobian * P.transpose() * point.weight;
                    for i in 0..3 {
                        let column = (3 * c + i) * 3 * nq;
                        for alpha in 0..3 {
                            fluxes[column + 3 * q + alpha] = Q[(alpha, i)];
                        }
                    }
                }
            }
            let mut forces = vec![0.0; n * 3 * chunk.len()];
            matmul(
                MatMut::from_column_major_slice_mut(&mut forces, n, 3 * chunk.len()),
                Accum::Replace,
                self.shapes.gradient_matrix(),
                MatRef::from_column_major_slice(&fluxes, 3 * nq, 3 * chunk.len()),
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

    /// The blocks `K^{ik}` of [`PAIRS`] of one element, each modes times modes, one after the other.
    ///
    /// If the displacement is the result of a step of Newton's method from `linearized_at`, the volumetric stress is the
    /// one that the linearized equations gave, `U'(J_0) + U''(J_0) J_0 F_0⁻ᵀ : (F - F_0)` (all of it projected in the
    /// mixed form), and not yet `U'(J)`, which
    /// the terms of second order of a long step spoil in a nearly incompressible material (Magisano, Leonetti, Garcea:
    /// *How to improve efficiency and robustness of the Newton method in geometrically non-linear structural problem
    /// discretized via displacement-based finite elements*, 2017).
    pub fn stiffness(
        &self,
        body: Body,
        element: usize,
        displacement: &[f64],
        linearized_at: Option<&[f64]>,
        motion: Option<&Motion>,
    ) -> Result<Vec<f64>, SolidError> {
        let gradients = self.gradients(body, &[element], displacement);
        let viscous = motion.zip(body.viscous[body.regions[element]]);
        let viscous = viscous.map(|(motion, law)| {
            let rates = self.rates(body, element, motion.velocity);
            (law, rates, motion.slope)
        });
        let old_gradients = linearized_at.map(|old| self.gradients(body, &[element], old));
        let material = &body.materials[body.regions[element]];
        let deformed = self.deformed(body, element, &gradients, 0, old_gradients.as_deref())?;
        let mut workspace = self
            .workspaces
            .take()
            .unwrap_or_else(|| self.sums.workspace());
        for (q, (F, U)) in deformed.points().enumerate() {
            let point = &self.points[element][q];
            // With a projection, points act on each other through the volume.
            let local = match &self.projection {
                None => *U,
                Some(_) => Volumetric {
                    curvature: 0.0,
                    ..*U
                },
            };
            let mut A = material.tangent_with(F, &point.frame, &local);
            if let Some((law, rates, slope)) = &viscous {
                A += law.symmetric_tangent(F, &rates[q], *slope);
            }
            let places = self.sums.places(q);
            for (pair, (i, k)) in PAIRS.into_iter().enumerate() {
                let block: Mat3 = A.fixed_view::<3, 3>(3 * i, 3 * k).into();
                let B = &point.inverse_jacobian;
                let pulled_back = B * block * B.transpose() * point.weight;
                for alpha in 0..3 {
                    for beta in 0..3 {
                        let place = places[3 * alpha + beta] + pair * self.sums.stride();
                        workspace.coefficients[place] = pulled_back[(alpha, beta)];
                    }
                }
            }
        }
        let mut matrices = self.sums.matrices(&mut workspace);
        self.workspaces.give(workspace);
        if let Some(projection) = &self.projection
            && deformed.U.iter().any(|U| U.curvature != 0.0)
        {
            let (points, gradients) = (&self.points[element], self.shapes.gradient_matrix());
            let Deformed { F, U } = &deformed;
            projection.add_stiffness(element, points, gradients, F, U, &mut matrices);
        }
        Ok(matrices)
    }

    /// Forces of the viscous stresses at every degree of freedom, N.
    pub fn viscous_forces(&self, body: Body, displacement: &[f64], velocity: &[f64]) -> Vec<f64> {
        let (n, nq) = (self.shapes.modes, self.shapes.points);
        let all: Vec<usize> = (0..self.points.len()).collect();
        let of_element = |&e: &usize| -> Option<(usize, Vec<f64>)> {
            let law = body.viscous[body.regions[e]]?;
            let F = self.deformation(e, &self.gradients(body, &[e], displacement), 0);
            let rates = self.rates(body, e, velocity);
            let mut fluxes = vec![0.0; 9 * nq];
            for (q, point) in self.points[e].iter().enumerate() {
                let P = law.stress(&F[q], &rates[q]);
                let Q = point.inverse_jacobian * P.transpose() * point.weight;
                for (i, alpha) in (0..9).map(|k| (k / 3, k % 3)) {
                    fluxes[i * 3 * nq + 3 * q + alpha] = Q[(alpha, i)];
                }
            }
            let mut forces = vec![0.0; 3 * n];
            matmul(
                MatMut::from_column_major_slice_mut(&mut forces, n, 3),
                Accum::Replace,
                self.shapes.gradient_matrix(),
                MatRef::from_column_major_slice(&fluxes, 3 * nq, 3),
                1.0,
                Par::Seq,
            );
            Some((e, forces))
        };
        let parts: Vec<_> = all.par_iter().filter_map(of_element).collect();
        let mut total = vec![0.0; displacement.len()];
        for (e, local) in &parts {
            scatter(body.numbering, *e, local, &mut total);
        }
        total
    }

    /// `Ḟ` at the points of an element, 1/s.
    fn rates(&self, body: Body, element: usize, velocity: &[f64]) -> Vec<Mat3> {
        let gradients = self.gradients(body, &[element], velocity);
        let mut rates = self.deformation(element, &gradients, 0);
        rates.iter_mut().for_each(|F| *F -= Mat3::identity());
        rates
    }

    /// `∫ N_a N_b dV` of one element, m³, modes times modes.
    pub fn mass(&self, element: usize) -> Vec<f64> {
        let n = self.shapes.modes;
        let mut weighted = self.shapes.values.clone();
        for (column, point) in weighted.chunks_exact_mut(n).zip(&self.points[element]) {
            column.iter_mut().for_each(|v| *v *= point.weight);
        }
        let mut mass = vec![0.0; n * n];
        matmul(
            MatMut::from_column_major_slice_mut(&mut mass, n, n),
            Accum::Replace,
            self.shapes.value_matrix(),
            MatRef::from_column_major_slice(&weighted, n, self.shapes.points).transpose(),
            1.0,
            Par::Seq,
        );
        mass
    }

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
        let parts = self.chunks(body, displacement, |chunk, gradients| {
            let mut all = Vec::with_capacity(chunk.len());
            for (c, &e) in chunk.iter().enumerate() {
                let mut extremes = Extremes::default();
                let material = &*body.materials[body.regions[e]];
                let deformed = self.deformed(body, e, gradients, c, None)?;
                for (q, (F, U)) in deformed.points().enumerate() {
                    let state = StressState::new(material, F, &self.points[e][q].frame, U);
                    let J = F.determinant();
                    extremes = extremes.with(&Extremes {
                        von_mises: state.von_mises(),
                        max_principal: state.principal_stresses()[0],
                        element: e,
                        local: self.local[q],
                        min_jacobian: J,
                        max_jacobian: J,
                    });
                }
                all.push(extremes);
            }
            Ok(all)
        })?;
        Ok(parts.concat())
    }

    /// Coefficients of the pressure `p̄` in each element, if there is a projection.
    pub fn pressures(
        &self,
        body: Body,
        displacement: &[f64],
    ) -> Result<Option<Vec<Vec<f64>>>, SolidError> {
        let Some(projection) = &self.projection else {
            return Ok(None);
        };
        let parts = self.chunks(body, displacement, |chunk, gradients| {
            let of = |(c, &e): (usize, &usize)| {
                let deformed = self.deformed(body, e, gradients, c, None)?;
                let slopes: Vec<f64> = deformed.U.iter().map(|U| U.slope).collect();
                Ok(projection.coefficients(e, &self.points[e], &slopes))
            };
            chunk
                .iter()
                .enumerate()
                .map(of)
                .collect::<Result<Vec<_>, SolidError>>()
        })?;
        Ok(Some(parts.concat()))
    }

    /// Stresses and strains at all points, element by element; `pressures` are those of [`Self::pressures`] with their
    /// functions at these points, else the points' own volumetric stress counts. NaN where `det F <= 0`, as
    /// may be in the very corner of an element.
    pub fn states(
        &self,
        body: Body,
        displacement: &[f64],
        pressures: Option<(&Basis, &[Vec<f64>])>,
    ) -> Result<Vec<StressState>, SolidError> {
        let parts = self.chunks(body, displacement, |chunk, gradients| {
            let mut states = Vec::with_capacity(chunk.len() * self.shapes.points);
            for (c, &e) in chunk.iter().enumerate() {
                let material = &*body.materials[body.regions[e]];
                let deformed = match pressures {
                    None => self.deformed(body, e, gradients, c, None)?,
                    Some((basis, coefficients)) => {
                        let slopes = basis.evaluate(&coefficients[e]);
                        let of = |slope| Volumetric {
                            slope,
                            ..Volumetric::default()
                        };
                        Deformed {
                            F: self.deformation(e, gradients, c),
                            U: slopes.into_iter().map(of).collect(),
                        }
                    }
                };
                let of = |((F, U), point): ((&Mat3, &Volumetric), &ElementPoint)| {
                    StressState::new(material, F, &point.frame, U)
                };
                states.extend(deformed.points().zip(&self.points[e]).map(of));
            }
            Ok(states)
        })?;
        Ok(parts.concat())
    }

    /// Displacement (m) at all points, element by element.
    pub fn displacement(&self, numbering: &Numbering, displacement: &[f64]) -> Vec<Vec3> {
        let n = self.shapes.modes;
        let mut local = vec![0.0; 3 * n];
        let mut all = Vec::with_capacity(self.points.len() * self.shapes.points);
        for e in 0..self.points.len() {
            gather(numbering, e, displacement, &mut local);
            let component = |values: &[f64], i: usize| -> f64 {
                values.iter().zip(&local[i * n..]).map(|(v, u)| v * u).sum()
            };
            let at = |values: &[f64]| Vec3::from_fn(|i, _| component(values, i));
            all.extend(self.shapes.values.chunks_exact(n).map(at));
        }
        all
    }

    /// Runs `f` on chunks of elements and their displacement gradients, in parallel; results in order.
    fn chunks<T: Send>(
        &self,
        body: Body,
        displacement: &[f64],
        f: impl Fn(&[usize], &[f64]) -> Result<T, SolidError> + Sync,
    ) -> Result<Vec<T>, SolidError> {
        let all: Vec<usize> = (0..self.points.len()).collect();
        all.par_chunks(CHUNK)
            .map(|chunk| f(chunk, &self.gradients(body, chunk, displacement)))
            .collect()
    }

    /// `H`: gradients of the displacement by the local coordinates; `(α, point)` times `(component, element)`.
    fn gradients(&self, body: Body, chunk: &[usize], displacement: &[f64]) -> Vec<f64> {
        let (n, nq) = (self.shapes.modes, self.shapes.points);
        let mut local = vec![0.0; n * 3 * chunk.len()];
        for (&e, to) in chunk.iter().zip(local.chunks_exact_mut(3 * n)) {
            gather(body.numbering, e, displacement, to);
        }
        let mut gradients = vec![0.0; 3 * nq * 3 * chunk.len()];
        matmul(
            MatMut::from_column_major_slice_mut(&mut gradients, 3 * nq, 3 * chunk.len()),
            Accum::Replace,
            self.shapes.gradient_matrix().transpose(),
            MatRef::from_column_major_slice(&local, n, 3 * chunk.len()),
            1.0,
            Par::Seq,
        );
        gradients
    }

    /// `F = 1 + H ∂ξ/∂X` at the points of the element at `place` in its chunk, and the volumetric energy there, of the
    /// linearized equations if they are `linearized_at` other gradients; an error if `det F <= 0` or `J̄ <= 0`.
    fn deformed(
        &self,
        body: Body,
        element: usize,
        gradients: &[f64],
        place: usize,
        linearized_at: Option<&[f64]>,
    ) -> Result<Deformed, SolidError> {
        let material = &body.materials[body.regions[element]];
        let points = &self.points[element];
        let positive = |ratios: &[f64]| match ratios.iter().position(|&J| J.is_nan() || J <= 0.0) {
            None => Ok(()),
            Some(q) => Err(SolidError::Inverted {
                element,
                jacobian: ratios[q],
                position: body.mapping.at(element, self.local[q]).position.into(),
            }),
        };
        let project = |field: Vec<f64>| match &self.projection {
            None => field,
            Some(projection) => projection.project(element, points, &field),
        };
        let F = self.deformation(element, gradients, place);
        let ratios: Vec<f64> = F.iter().map(Mat3::determinant).collect();
        positive(&ratios)?;
        let ratios = project(ratios);
        positive(&ratios)?;
        let mut U: Vec<Volumetric> = ratios.iter().map(|&J| material.volumetric(J)).collect();
        if let Some(gradients) = linearized_at {
            let F0 = self.deformation(element, gradients, 0);
            let change = |(F, F0): (&Mat3, &Mat3)| {
                let (G0, J0) = inverse_transpose(F0);
                J0 * G0.dot(&(F - F0))
            };
            let changes = project(F.iter().zip(&F0).map(change).collect());
            let ratios = project(F0.iter().map(Mat3::determinant).collect());
            for ((U, J0), change) in U.iter_mut().zip(ratios).zip(changes) {
                let U0 = material.volumetric(J0);
                U.slope = U0.slope + U0.curvature * change;
            }
        }
        let slopes = project(U.iter().map(|U| U.slope).collect());
        U.iter_mut().zip(slopes).for_each(|(U, p)| U.slope = p);
        Ok(Deformed { F, U })
    }

    /// `F` at the points of the element at `place` in its chunk.
    fn deformation(&self, element: usize, gradients: &[f64], place: usize) -> Vec<Mat3> {
        let stride = 3 * self.shapes.points;
        let at = |(q, point): (usize, &ElementPoint)| {
            let H = Mat3::from_fn(|i, alpha| gradients[(3 * place + i) * stride + 3 * q + alpha]);
            Mat3::identity() + H * point.inverse_jacobian
        };
        self.points[element].iter().enumerate().map(at).collect()
    }
}

impl Deformed {
    fn points(&self) -> impl Iterator<Item = (&Mat3, &Volumetric)> {
        self.F.iter().zip(&self.U)
    }
}

/// Coefficients of an element's modes: modes (fastest) times components.
pub fn gather(numbering: &Numbering, element: usize, global: &[f64], local: &mut [f64]) {
    let (functions, signs) = (&numbering.of_element[element], &numbering.signs[element]);
    let n = functions.len();
    for m in 0..n {
        for i in 0..3 {
            local[i * n + m] = functions[m].map_or(0.0, |f| signs[m] * global[3 * f + i]);
        }
    }
}

/// Adds forces of an element's modes (fastest) and components to the global vector.
pub fn scatter(numbering: &Numbering, element: usize, local: &[f64], global: &mut [f64]) {
    let (functions, signs) = (&numbering.of_element[element], &numbering.signs[element]);
    let n = functions.len();
    for m in 0..n {
        if let Some(f) = functions[m] {
            for i in 0..3 {
                global[3 * f + i] += signs[m] * local[i * n + m];
            }
        }
    }
}
