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

use super::SolidError;
use super::basis::BasisTable;
use super::mapping::{Mapping, lattice};
use super::material::{Frame, HyperelasticMaterial, inverse_transpose, von_mises};
use super::numbering::Numbering;
use super::pool::Pool;
use super::quadrature::Rule;
use super::space::{Mode, Space};
use super::sum_factorization::{SumFactorization, Workspace};
use crate::{Mat3, Vec3};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Elements whose internal forces are computed by one matrix product.
const CHUNK: usize = 8;

/// The six blocks `K^{ik}`, `i <= k`, of a symmetric element matrix.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Values and gradients of the modes at the points of a lattice in the reference hexahedron.
#[derive(Debug, Clone)]
pub struct Shapes {
    /// Number of modes.
    pub modes: usize,
    /// Number of points.
    pub points: usize,
    /// Modes (fastest) times points.
    pub values: Vec<f64>,
    /// Modes (fastest) times local directions times points.
    pub gradients: Vec<f64>,
}

impl Shapes {
    /// Tabulates `modes` at the lattice of `axes`, first direction fastest.
    pub fn new(modes: &[Mode], space: &Space, axes: [&[f64]; 3]) -> Self {
        let tables: [BasisTable; 3] =
            std::array::from_fn(|d| BasisTable::new(space.degrees[d], axes[d]));
        let sizes = axes.map(<[f64]>::len);
        let points: usize = sizes.iter().product();
        let mut values = Vec::with_capacity(modes.len() * points);
        let mut gradients = Vec::with_capacity(3 * modes.len() * points);
        for q in 0..points {
            let at = [
                q % sizes[0],
                q / sizes[0] % sizes[1],
                q / (sizes[0] * sizes[1]),
            ];
            let factor = |mode: &Mode, d: usize, derived: Option<usize>| {
                let table = &tables[d];
                if derived == Some(d) {
                    table.derivatives[mode[d]][at[d]]
                } else {
                    table.values[mode[d]][at[d]]
                }
            };
            let product = |mode: &Mode, derived| -> f64 {
                (0..3).map(|d| factor(mode, d, derived)).product()
            };
            values.extend(modes.iter().map(|m| product(m, None)));
            for alpha in 0..3 {
                gradients.extend(modes.iter().map(|m| product(m, Some(alpha))));
            }
        }
        Self {
            modes: modes.len(),
            points,
            values,
            gradients,
        }
    }

    fn gradient_matrix(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.gradients, self.modes, 3 * self.points)
    }

    fn value_matrix(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.values, self.modes, self.points)
    }
}

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
    /// Quadrature points of the reference hexahedron.
    pub local: Vec<[f64; 3]>,
    /// `points[e][q]`.
    pub points: Vec<Vec<ElementPoint>>,
}

/// Everything that the integrals need besides the displacement.
#[derive(Clone, Copy)]
pub struct Body<'a> {
    /// Global numbers of the modes.
    pub numbering: &'a Numbering,
    /// Material of each region.
    pub materials: &'a [Box<dyn HyperelasticMaterial>],
    /// Region of each element.
    pub regions: &'a [usize],
    /// Shape of the elements.
    pub mapping: &'a Mapping,
}

impl Elements {
    /// Prepares quadrature with `points` Gauss points in each local direction.
    pub fn gauss(
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
        elements: usize,
        points: [usize; 3],
    ) -> Result<Self, SolidError> {
        let rules = points.map(Rule::gauss_legendre);
        Self::new(numbering, space, mapping, elements, &rules)
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
                let point = |(m, w): (&super::mapping::MappedPoint, &f64)| {
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
            points,
        })
    }

    /// Strain energy, J.
    pub fn energy(&self, body: Body, displacement: &[f64]) -> Result<f64, SolidError> {
        let parts = self.chunks(body, displacement, |chunk, gradients| {
            let mut sum = 0.0;
            for (c, &e) in chunk.iter().enumerate() {
                let material = &body.materials[body.regions[e]];
                for (q, point) in self.points[e].iter().enumerate() {
                    let F = self.deformation(body, e, q, gradients, c)?;
                    sum += point.weight * material.energy(&F, &point.frame);
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
                for (q, point) in self.points[e].iter().enumerate() {
                    let F = self.deformation(body, e, q, gradients, c)?;
                    let P = material.stress(&F, &point.frame);
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
    /// one that the linearized equations gave, `U'(J_0) + U''(J_0) J_0 F_0⁻ᵀ : (F - F_0)`, and not yet `U'(J)`, which
    /// the terms of second order of a long step spoil in a nearly incompressible material (Magisano, Leonetti, Garcea:
    /// *How to improve efficiency and robustness of the Newton method in geometrically non-linear structural problem
    /// discretized via displacement-based finite elements*, 2017).
    pub fn stiffness(
        &self,
        body: Body,
        element: usize,
        displacement: &[f64],
        linearized_at: Option<&[f64]>,
    ) -> Result<Vec<f64>, SolidError> {
        let gradients = self.gradients(body, &[element], displacement);
        let old_gradients = linearized_at.map(|old| self.gradients(body, &[element], old));
        let material = &body.materials[body.regions[element]];
        let mut workspace = self
            .workspaces
            .take()
            .unwrap_or_else(|| self.sums.workspace());
        for (q, point) in self.points[element].iter().enumerate() {
            let F = self.deformation(body, element, q, &gradients, 0)?;
            let A = match &old_gradients {
                None => material.tangent(&F, &point.frame),
                Some(old) => {
                    let F0 = self.deformation(body, element, q, old, 0)?;
                    let (G0, J0) = inverse_transpose(&F0);
                    let [slope, curvature] = material.volumetric(J0);
                    let slope = slope + curvature * J0 * G0.dot(&(F - F0));
                    material.tangent_with(&F, &point.frame, slope)
                }
            };
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
        let matrices = self.sums.matrices(&mut workspace);
        self.workspaces.give(workspace);
        Ok(matrices)
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
                let material = &body.materials[body.regions[e]];
                for (q, point) in self.points[e].iter().enumerate() {
                    let F = self.deformation(body, e, q, gradients, c)?;
                    let stress = von_mises(&material.stress(&F, &point.frame), &F);
                    let J = F.determinant();
                    extremes = extremes.with(&Extremes {
                        von_mises: stress,
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

    /// Displacement (m) and von Mises stress (Pa) at all points, element by element.
    pub fn fields(&self, body: Body, displacement: &[f64]) -> Result<Vec<(Vec3, f64)>, SolidError> {
        let n = self.shapes.modes;
        let parts = self.chunks(body, displacement, |chunk, gradients| {
            let mut fields = Vec::with_capacity(chunk.len() * self.shapes.points);
            let mut local = vec![0.0; 3 * n];
            for (c, &e) in chunk.iter().enumerate() {
                let material = &body.materials[body.regions[e]];
                gather(body.numbering, e, displacement, &mut local);
                for (q, point) in self.points[e].iter().enumerate() {
                    let F = self.deformation(body, e, q, gradients, c)?;
                    let values = &self.shapes.values[q * n..(q + 1) * n];
                    let component = |i: usize| -> f64 {
                        values.iter().zip(&local[i * n..]).map(|(v, u)| v * u).sum()
                    };
                    let u = Vec3::new(component(0), component(1), component(2));
                    fields.push((u, von_mises(&material.stress(&F, &point.frame), &F)));
                }
            }
            Ok(fields)
        })?;
        Ok(parts.into_iter().flatten().collect())
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

    /// `F = 1 + H ∂ξ/∂X` at a point of the element at `place` in its chunk; an error if `det F <= 0`.
    fn deformation(
        &self,
        body: Body,
        element: usize,
        q: usize,
        gradients: &[f64],
        place: usize,
    ) -> Result<Mat3, SolidError> {
        let stride = 3 * self.shapes.points;
        let H = Mat3::from_fn(|i, alpha| gradients[(3 * place + i) * stride + 3 * q + alpha]);
        let F = Mat3::identity() + H * self.points[element][q].inverse_jacobian;
        let jacobian = F.determinant();
        if jacobian > 0.0 {
            Ok(F)
        } else {
            Err(SolidError::Inverted {
                element,
                jacobian,
                position: body.mapping.at(element, self.local[q]).position.into(),
            })
        }
    }
}

/// Extreme values over the quadrature points of a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes {
    /// Largest von Mises stress, Pa.
    pub von_mises: f64,
    /// Element where it is.
    pub element: usize,
    /// Local coordinates where it is.
    pub local: [f64; 3],
    /// Smallest `det F`.
    pub min_jacobian: f64,
    /// Largest `det F`.
    pub max_jacobian: f64,
}

impl Default for Extremes {
    fn default() -> Self {
        Self {
            von_mises: -1.0,
            element: 0,
            local: [0.0; 3],
            min_jacobian: f64::INFINITY,
            max_jacobian: f64::NEG_INFINITY,
        }
    }
}

impl Extremes {
    fn with(self, other: &Self) -> Self {
        let larger = if other.von_mises > self.von_mises {
            *other
        } else {
            self
        };
        Self {
            min_jacobian: self.min_jacobian.min(other.min_jacobian),
            max_jacobian: self.max_jacobian.max(other.max_jacobian),
            ..larger
        }
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
