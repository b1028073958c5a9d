//! Element matrices by sum factorization.
//!
//! The entries of a stiffness block are sums over the points `(q_0, q_1, q_2)` of a lattice of products of
//! one-dimensional functions, `K_{mm'} = Σ_{αβ} Σ_q ∂_α N_m Â_αβ ∂_β N_m'`. Carried out one direction after the other,
//! ```text
//! T1_{ii'}  (q_1, q_2) = Σ_{q_0} R0_{ii'}(q_0) Â(q_0, q_1, q_2)
//! T2_{ii'jj'}  (q_2)   = Σ_{q_1} R1_{jj'}(q_1) T1_{ii'}(q_1, q_2)
//! K_{ii'jj'kk'}        = Σ_{q_2} R2_{kk'}(q_2) T2_{ii'jj'}(q_2)
//! ```
//! they cost `O(p^7)` instead of `O(p^9)` operations, all of them matrix products. `R_{ii'}` are products of two
//! functions, of a function and a derivative, or of two derivatives, as `α` and `β` demand. All six blocks of an
//! element are done at once. (Melenk, Gerdes, Schwab: *Fully discrete hp-finite elements: fast quadrature*, 2001.)

use super::super::space::basis::BasisTable;
use super::super::space::{Mode, Space};
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

/// The pairs `(α, β)` in the order of their factors along direction 0, so that those with the same factor are together.
const DERIVATIVES: [(usize, usize); 9] = [
    (0, 0),
    (0, 1),
    (0, 2),
    (1, 0),
    (2, 0),
    (1, 1),
    (1, 2),
    (2, 1),
    (2, 2),
];

/// First and last plus one of [`DERIVATIVES`] with each kind of factor along direction 0.
const SAME_FACTOR: [(usize, usize); 4] = [(0, 1), (1, 3), (3, 5), (5, 9)];

/// Products of two one-dimensional functions at the points of one direction.
#[derive(Debug, Clone)]
struct Products {
    /// Number of functions.
    functions: usize,
    /// Number of points.
    points: usize,
    /// `(i + functions i')` times points, for neither derived, `i'` derived, `i` derived, both derived.
    values: Vec<f64>,
}

impl Products {
    fn new(degree: usize, points: &[f64]) -> Self {
        let table = BasisTable::new(degree, points);
        let factors = [&table.values, &table.derivatives];
        let n = table.values.len();
        let product = |s: usize, t: usize| -> Vec<f64> {
            (0..points.len())
                .flat_map(|q| {
                    (0..n * n).map(move |ii| factors[s][ii % n][q] * factors[t][ii / n][q])
                })
                .collect()
        };
        Self {
            functions: n,
            points: points.len(),
            values: [product(0, 0), product(0, 1), product(1, 0), product(1, 1)].concat(),
        }
    }

    fn pairs(&self) -> usize {
        self.functions * self.functions
    }

    /// The products with `i` (`s`) and `i'` (`t`) derived or not.
    fn matrix(&self, s: bool, t: bool) -> MatRef<'_, f64> {
        let kind = 2 * s as usize + t as usize;
        self.all().subcols(kind * self.points, self.points)
    }

    /// All four kinds side by side.
    fn all(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.values, self.pairs(), 4 * self.points)
    }
}

/// Memory for the intermediate results, used again for many elements.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    /// `Â`, to be filled by the caller; see [`SumFactorization::places`].
    pub coefficients: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
    third: Vec<f64>,
}

/// Tables for the element matrices of a space and a lattice of quadrature points.
#[derive(Debug, Clone)]
pub struct SumFactorization {
    modes: Vec<Mode>,
    products: [Products; 3],
    /// Number of blocks that are done together.
    blocks: usize,
}

impl SumFactorization {
    /// Prepares `blocks` element matrices at a time.
    pub fn new(modes: &[Mode], space: &Space, axes: [&[f64]; 3], blocks: usize) -> Self {
        Self {
            modes: modes.to_vec(),
            products: std::array::from_fn(|d| Products::new(space.degrees[d], axes[d])),
            blocks,
        }
    }

    /// Memory for [`Self::matrices`].
    pub fn workspace(&self) -> Workspace {
        let [p0, p1, p2] = &self.products;
        let points = p0.points * p1.points * p2.points;
        let planes = p0.pairs() * self.blocks * p1.pairs();
        Workspace {
            coefficients: vec![0.0; 9 * points * self.blocks],
            first: vec![0.0; 9 * p0.pairs() * self.blocks * p1.points * p2.points],
            second: vec![0.0; 4 * p2.points * planes],
            third: vec![0.0; planes * p2.pairs()],
        }
    }

    /// Where `Â_αβ` of each `(α, β)` (3 α + β) of block 0 at a point belongs; blocks are [`Self::stride`] apart.
    pub fn places(&self, point: usize) -> [usize; 9] {
        let [n0, n1, n2] = [0, 1, 2].map(|d| self.products[d].points);
        let (q0, rest) = (point % n0, point / n0);
        let size = n0 * n1 * n2 * self.blocks;
        std::array::from_fn(|ab| {
            let place = DERIVATIVES
                .iter()
                .position(|&(a, b)| 3 * a + b == ab)
                .unwrap_or(0);
            place * size + q0 + n0 * self.blocks * rest
        })
    }

    /// Distance between the coefficients of two blocks.
    pub fn stride(&self) -> usize {
        self.products[0].points
    }

    /// The matrices for the coefficients in `workspace`, modes times modes, one after the other.
    pub fn matrices(&self, workspace: &mut Workspace) -> Vec<f64> {
        let Workspace {
            coefficients,
            first,
            second,
            third,
        } = workspace;
        let [p0, p1, p2] = &self.products;
        let (n0, n1, n2) = (p0.points, p1.points, p2.points);
        let (ii, jj, kk) = (p0.pairs(), p1.pairs(), p2.pairs());
        let rows = ii * self.blocks;

        // Direction 0: rows (i, i'), columns (block, q_1, q_2, αβ).
        let columns = self.blocks * n1 * n2;
        for (begin, end) in SAME_FACTOR {
            let (a, b) = DERIVATIVES[begin];
            matmul(
                MatMut::from_column_major_slice_mut(
                    &mut first[begin * ii * columns..end * ii * columns],
                    ii,
                    (end - begin) * columns,
                ),
                Accum::Replace,
                p0.matrix(a == 0, b == 0),
                MatRef::from_column_major_slice(
                    &coefficients[begin * n0 * columns..end * n0 * columns],
                    n0,
                    (end - begin) * columns,
                ),
                1.0,
                Par::Seq,
            );
        }

        // Direction 1: rows (i, i', block), columns (j, j'), for each q_2 and kind of factor along direction 2.
        let mut started = [false; 4];
        for (place, &(a, b)) in DERIVATIVES.iter().enumerate() {
            let kind = 2 * (a == 2) as usize + (b == 2) as usize;
            let accumulate = if started[kind] {
                Accum::Add
            } else {
                Accum::Replace
            };
            started[kind] = true;
            for q2 in 0..n2 {
                let from = (place * n2 + q2) * n1 * rows;
                let to = (kind * n2 + q2) * rows * jj;
                matmul(
                    MatMut::from_column_major_slice_mut(&mut second[to..to + rows * jj], rows, jj),
                    accumulate,
                    MatRef::from_column_major_slice(&first[from..from + n1 * rows], rows, n1),
                    p1.matrix(a == 1, b == 1).transpose(),
                    1.0,
                    Par::Seq,
                );
            }
        }

        // Direction 2: rows (i, i', block, j, j'), columns (k, k').
        matmul(
            MatMut::from_column_major_slice_mut(third, rows * jj, kk),
            Accum::Replace,
            MatRef::from_column_major_slice(second, rows * jj, 4 * n2),
            p2.all().transpose(),
            1.0,
            Par::Seq,
        );
        self.select(third)
    }

    /// The entries that belong to modes of the space.
    fn select(&self, all: &[f64]) -> Vec<f64> {
        let [p0, p1, p2] = &self.products;
        let n = self.modes.len();
        let (ii, jj) = (p0.pairs(), p1.pairs());
        let row = |m: &Mode| m[0] + ii * self.blocks * (m[1] + jj * m[2]);
        let column = |m: &Mode| {
            m[0] * p0.functions
                + ii * self.blocks * (m[1] * p1.functions + jj * m[2] * p2.functions)
        };
        let rows: Vec<usize> = self.modes.iter().map(row).collect();
        let columns: Vec<usize> = self.modes.iter().map(column).collect();
        let mut selected = Vec::with_capacity(self.blocks * n * n);
        for block in 0..self.blocks {
            for column in &columns {
                let all = &all[block * ii + column..];
                selected.extend(rows.iter().map(|row| all[*row]));
            }
        }
        selected
    }
}
