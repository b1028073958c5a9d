//! Where the volumetric energy takes the volume ratio from.
//!
//! In a nearly incompressible material the volume ratio `J = det F` must be one nearly everywhere, which is more than
//! the modes of an element can fulfil: elements lock, and `U'(J)` oscillates from point to point. The mixed form
//! of Simo, Taylor and Pister (*Variational and projection methods for the volume constraint in finite deformation
//! elasto-plasticity*, 1985) lets dilatation and pressure live in a lower space of each element, discontinuous between
//! elements, from which both are eliminated:
//! ```text
//! W = ∫ W_rest(F) + U(J̄) dV,       J̄ = Π J,       Π the L2 projection onto span(ψ) in each element
//! δW = ∫ (∂W_rest/∂F + p̄ ∂J/∂F) : δF dV,          p̄ = Π U'(J̄)
//! K  = ∫ δF : (∂²W_rest/∂F² + p̄ ∂²J/∂F²) : δF dV + Bᵀ M⁻¹ D M⁻¹ B,
//! M = ∫ ψ ψᵀ dV,    D = ∫ U''(J̄) ψ ψᵀ dV,    B = ∫ ψ ∂J/∂F : δF dV
//! ```
//! All integrals are sums over the same quadrature points, so that forces and tangent are the derivatives of the energy
//! that is computed: displacements are the only unknowns, and the tangent is symmetric.

use super::super::material::lanes::{LANES, Lanes, Real};
use super::super::material::{Volumetric, inverse_transpose};
use super::super::space::{Mode, Space, SpaceKind};
use super::mapping::lattice;
use super::{ElementPoint, PAIRS};
use crate::Mat3;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use fsi_numerics::quadrature::legendre;
use fsi_numerics::{dot, words};
use multiversion::multiversion;
use nalgebra::DMatrix;

words! {
    /// Which volume ratio the volumetric energy of the wall sees.
    #[derive(Default)]
    pub enum Formulation {
        /// Its projection onto a lower space in each element: no volumetric locking.
        Mixed = "mixed" (default),
        /// That of the displacement at every point: locks at low degrees.
        Displacement = "displacement",
    }
}

/// Degree from which on the trunk space has internal modes.
const INTERNAL: usize = 6;

/// Products of Legendre polynomials that span dilatation and pressure in an element of a space, with the largest degree
/// `p`: those of total degree `p - 1` (`Q_p`-`P_{p-1}` with the tensor product space), and of `p - 2` in a trunk space,
/// which has too few modes for more: it would lock, and where it has internal ones the pressure would jump between
/// elements. With these, powers `p - 1` of each single direction can be added, which tubes need. In each direction less
/// than its own degree. Measured in `docs/wall.md`.
pub fn modes(space: &Space) -> Vec<Mode> {
    let p = space.max_degree();
    let total = match space.kind {
        SpaceKind::Trunk => p.saturating_sub(2),
        SpaceKind::TensorProduct => p.saturating_sub(1),
    };
    let mut modes = polynomials(space.degrees.map(|p| p.saturating_sub(1)), total);
    if space.kind == SpaceKind::Trunk && p >= INTERNAL {
        let power = |d: usize| {
            let mut mode = [0; 3];
            mode[d] = space.degrees[d].saturating_sub(1);
            mode
        };
        modes.extend(
            (0..3)
                .map(power)
                .filter(|mode| mode.iter().sum::<usize>() > total),
        );
    }
    modes
}

/// Products of Legendre polynomials of a total degree, and in each direction of at most these degrees.
pub fn polynomials(degrees: [usize; 3], total: usize) -> Vec<Mode> {
    let [d0, d1, d2] = degrees.map(|p| p.min(total));
    let all = (0..=d2).flat_map(|k| (0..=d1).flat_map(move |j| (0..=d0).map(move |i| [i, j, k])));
    all.filter(|mode| mode.iter().sum::<usize>() <= total)
        .collect()
}

/// The functions `ψ` of dilatation and pressure at the points of a lattice.
#[derive(Debug, Clone)]
pub struct Basis {
    /// Number of functions.
    pub functions: usize,
    /// Functions (fastest) times points.
    values: Vec<f64>,
}

impl Basis {
    /// Tabulates products of Legendre polynomials at the lattice of `axes`, first direction fastest.
    pub fn new(modes: &[Mode], axes: [&[f64]; 3]) -> Self {
        let degree = modes.iter().flatten().copied().max().unwrap_or(0);
        let value = |xi: [f64; 3]| {
            let tables = xi.map(|x| legendre(degree, x));
            let product = move |m: &Mode| -> f64 { (0..3).map(|d| tables[d][m[d]]).product() };
            modes.iter().map(product).collect::<Vec<f64>>()
        };
        Self {
            functions: modes.len(),
            values: lattice(axes).flat_map(value).collect(),
        }
    }

    /// The functions at each point.
    fn rows(&self) -> impl Iterator<Item = &[f64]> {
        self.values.chunks_exact(self.functions)
    }

    /// Values at the points of the field with these coefficients.
    pub fn evaluate(&self, coefficients: &[f64]) -> Vec<f64> {
        self.rows().map(|psi| dot(psi, coefficients)).collect()
    }
}

/// The projection `Π` at the quadrature points of all elements.
#[derive(Debug, Clone)]
pub struct Projection {
    basis: Basis,
    /// The functions one after the other, each at the points of an element, with zeros to fill up the last group.
    by_function: Vec<f64>,
    /// `M⁻¹` of each element.
    inverse_masses: Vec<DMatrix<f64>>,
}

/// Sums over points in groups of each function times a field.
#[multiversion(targets = "simd")]
fn sum_products(functions: &[[f64; LANES]], field: &[[f64; LANES]], sums: &mut [f64]) {
    for (function, to) in functions.chunks_exact(field.len()).zip(sums) {
        let mut sum = Lanes::default();
        for (psi, value) in function.iter().zip(field) {
            sum += Lanes::new(*psi) * Lanes::new(*value);
        }
        *to = sum.sum();
    }
}

/// The sum of functions with these coefficients, at points in groups.
#[multiversion(targets = "simd")]
fn combine(functions: &[[f64; LANES]], coefficients: &[f64], field: &mut [[f64; LANES]]) {
    field.fill([0.0; LANES]);
    for (function, coefficient) in functions.chunks_exact(field.len()).zip(coefficients) {
        let coefficient = Lanes::of(*coefficient);
        for (value, psi) in field.iter_mut().zip(function) {
            *value = (Lanes::new(*value) + coefficient * Lanes::new(*psi)).to_array();
        }
    }
}

impl Projection {
    /// Prepares the projection onto products of Legendre polynomials for the quadrature `points` of all elements at the
    /// lattice of `axes`.
    pub fn new(modes: &[Mode], axes: [&[f64]; 3], points: &[Vec<ElementPoint>]) -> Self {
        let basis = Basis::new(modes, axes);
        let inverse = |points: &Vec<ElementPoint>| {
            let mass = basis.weighted_products(points.iter().map(|point| point.weight));
            let cholesky = mass.cholesky();
            cholesky
                .expect("the weights are positive and more than the functions")
                .inverse()
        };
        Self {
            inverse_masses: points.iter().map(inverse).collect(),
            by_function: basis.by_function(),
            basis,
        }
    }

    /// Replaces a field at the points of an element by its projection; points lie side by side, in groups with these
    /// weights, and a field is zero where there is none.
    pub(super) fn project_groups(
        &self,
        element: usize,
        weights: impl Iterator<Item = Lanes>,
        field: &mut [f64],
    ) {
        let length = field.len();
        let (groups, _) = field.as_chunks_mut::<LANES>();
        for (value, weight) in groups.iter_mut().zip(weights) {
            *value = (Lanes::new(*value) * weight).to_array();
        }
        let mut moments = vec![0.0; self.by_function.len() / length];
        let (functions, _) = self.by_function.as_chunks::<LANES>();
        sum_products(functions, groups, &mut moments);
        let inverse = &self.inverse_masses[element];
        let coefficients: Vec<f64> = (0..moments.len())
            .map(|a| dot(inverse.column(a).as_slice(), &moments))
            .collect();
        combine(functions, &coefficients, groups);
    }

    /// Coefficients of the projection of a field given at the points of an element.
    pub fn coefficients(&self, element: usize, points: &[ElementPoint], field: &[f64]) -> Vec<f64> {
        let mut moments = vec![0.0; self.basis.functions];
        for ((psi, point), value) in self.basis.rows().zip(points).zip(field) {
            let scale = point.weight * value;
            moments
                .iter_mut()
                .zip(psi)
                .for_each(|(m, psi)| *m += scale * psi);
        }
        let inverse = &self.inverse_masses[element];
        (0..moments.len())
            .map(|a| dot(inverse.column(a).as_slice(), &moments))
            .collect()
    }

    /// The projection of a field, at the points of an element.
    pub fn project(&self, element: usize, points: &[ElementPoint], field: &[f64]) -> Vec<f64> {
        self.basis
            .evaluate(&self.coefficients(element, points, field))
    }

    /// Adds `Bᵀ M⁻¹ D M⁻¹ B` to the blocks of [`PAIRS`] of an element, with `modes` times `3 points` gradients of the
    /// displacement's modes.
    pub fn add_stiffness(
        &self,
        element: usize,
        points: &[ElementPoint],
        gradients: MatRef<'_, f64>,
        F: &[Mat3],
        U: &[Volumetric],
        blocks: &mut [f64],
    ) {
        let (n, size) = (gradients.nrows(), self.basis.functions);
        let rows = gradients.ncols();
        // ∂J/∂F, pulled back to the local directions, times ψ.
        let mut fluxes = vec![0.0; rows * 3 * size];
        for (q, (point, F)) in points.iter().zip(F).enumerate() {
            let (G, J) = inverse_transpose(F);
            let pulled_back = point.inverse_jacobian * G.transpose() * (point.weight * J);
            let psi = &self.basis.values[q * size..(q + 1) * size];
            for (column, fluxes) in fluxes.chunks_exact_mut(rows).enumerate() {
                let (i, psi) = (column / size, psi[column % size]);
                for alpha in 0..3 {
                    fluxes[3 * q + alpha] = pulled_back[(alpha, i)] * psi;
                }
            }
        }
        let mut B = vec![0.0; n * 3 * size];
        product(
            &mut B,
            Accum::Replace,
            gradients,
            MatRef::from_column_major_slice(&fluxes, rows, 3 * size),
        );
        let weights = points
            .iter()
            .zip(U)
            .map(|(point, U)| point.weight * U.curvature);
        let D = self.basis.weighted_products(weights);
        let inverse = &self.inverse_masses[element];
        let S = inverse * D * inverse;
        let S = MatRef::from_column_major_slice(S.as_slice(), size, size);
        let part = |matrix: &'_ [f64], i: usize| -> std::ops::Range<usize> {
            let length = matrix.len() / 3;
            i * length..(i + 1) * length
        };
        let mut BS = vec![0.0; n * 3 * size];
        for i in 0..3 {
            let range = part(&B, i);
            let B = MatRef::from_column_major_slice(&B[range.clone()], n, size);
            product(&mut BS[range], Accum::Replace, B, S);
        }
        for (pair, (i, k)) in PAIRS.into_iter().enumerate() {
            let left = MatRef::from_column_major_slice(&BS[part(&BS, i)], n, size);
            let right = MatRef::from_column_major_slice(&B[part(&B, k)], n, size).transpose();
            let block = &mut blocks[pair * n * n..(pair + 1) * n * n];
            product(block, Accum::Add, left, right);
        }
    }
}

impl Basis {
    /// The functions one after the other, each at all points, filled up to whole groups.
    fn by_function(&self) -> Vec<f64> {
        let points = self.values.len() / self.functions;
        let length = points.next_multiple_of(LANES);
        let mut all = vec![0.0; self.functions * length];
        for (q, psi) in self.rows().enumerate() {
            for (a, value) in psi.iter().enumerate() {
                all[a * length + q] = *value;
            }
        }
        all
    }

    /// `Σ w ψ ψᵀ` over the points.
    fn weighted_products(&self, weights: impl Iterator<Item = f64>) -> DMatrix<f64> {
        let n = self.functions;
        let points = self.values.len() / n;
        let mut weighted = self.values.clone();
        for (column, weight) in weighted.chunks_exact_mut(n).zip(weights) {
            column.iter_mut().for_each(|v| *v *= weight);
        }
        let mut products = DMatrix::zeros(n, n);
        product(
            products.as_mut_slice(),
            Accum::Replace,
            MatRef::from_column_major_slice(&weighted, n, points),
            MatRef::from_column_major_slice(&self.values, n, points).transpose(),
        );
        products
    }
}

/// `to = left right`, or added to it.
fn product(to: &mut [f64], accumulate: Accum, left: MatRef<'_, f64>, right: MatRef<'_, f64>) {
    let to = MatMut::from_column_major_slice_mut(to, left.nrows(), right.ncols());
    matmul(to, accumulate, left, right, 1.0, Par::Seq);
}
