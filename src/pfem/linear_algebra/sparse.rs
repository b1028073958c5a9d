//! Symmetric sparse matrices of 3×3 blocks, one block per pair of functions that share an element.
//!
//! Only the lower triangle is stored, by columns of scalars, as the factorization takes it. Functions held in all three
//! components have no rows; a component held alone keeps its row with a one on the diagonal.

use super::super::element::PAIRS;
use super::super::space::numbering::Numbering;
use faer::reborrow::Reborrow;
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat, SymbolicSparseColMatRef};
use rayon::prelude::*;

/// Stands for a function without rows.
const ABSENT: usize = usize::MAX;

/// Where the entries of element matrices go.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Function of each block row.
    pub functions: Vec<usize>,
    /// First block of each block column; rows ascend, the diagonal is first.
    starts: Vec<usize>,
    /// Block row of each block.
    rows: Vec<usize>,
    /// Scalar columns as faer takes them.
    scalar: SymbolicSparseColMat<usize>,
    elements: Vec<ElementPattern>,
    /// Entries of rows and columns held alone: zeroed, and their diagonals, set to one.
    held_entries: Vec<usize>,
    held_diagonals: Vec<usize>,
}

/// Modes of an element in ascending order of their block rows, and the ranks of their blocks in the columns.
#[derive(Debug, Clone)]
struct ElementPattern {
    /// `(mode, block row, sign)`.
    order: Vec<(usize, usize, f64)>,
    /// Rank in its block column of each pair, column by column, from the diagonal down.
    ranks: Vec<u32>,
}

/// A matrix with the same scalar on the diagonal of each block, for products.
#[derive(Debug, Clone)]
pub struct ScalarMatrix {
    /// Functions, and the functions and scalars of their rows.
    rows: Vec<(usize, Vec<(usize, f64)>)>,
}

impl ScalarMatrix {
    /// Product with a vector of all degrees of freedom; entries of functions without rows are neither read nor written.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (function, row) in &self.rows {
            let mut sum = [0.0; 3];
            for &(other, value) in row {
                let x = &x[3 * other..3 * other + 3];
                (0..3).for_each(|i| sum[i] += value * x[i]);
            }
            y[3 * function..3 * function + 3].copy_from_slice(&sum);
        }
        y
    }
}

/// The lower triangle of scalars of a lower triangle of blocks.
fn expand(starts: &[usize], rows: &[usize]) -> SymbolicSparseColMat<usize> {
    let (mut column_starts, mut row_indices) = (vec![0], Vec::new());
    for column in 0..starts.len() - 1 {
        for c in 0..3 {
            for &row in &rows[starts[column]..starts[column + 1]] {
                let first = if row == column { c } else { 0 };
                row_indices.extend((first..3).map(|r| 3 * row + r));
            }
            column_starts.push(row_indices.len());
        }
    }
    let n = column_starts.len() - 1;
    SymbolicSparseColMat::new_checked(n, n, column_starts, None, row_indices)
}

/// Functions of an element that have a row: their numbers in it, rows and signs, in the order of the rows.
type ElementRows = Vec<(usize, usize, f64)>;

/// Rows of the blocks of each column of the lower triangle, and where a column's begin: functions meet in an element.
fn blocks(elements_of: &[Vec<usize>], orders: &[ElementRows]) -> (Vec<usize>, Vec<usize>) {
    let (mut starts, mut rows) = (vec![0], Vec::new());
    let mut seen = vec![ABSENT; elements_of.len()];
    for column in 0..elements_of.len() {
        let first = rows.len();
        for &e in &elements_of[column] {
            for &(_, row, _) in &orders[e] {
                if row >= column && seen[row] != column {
                    seen[row] = column;
                    rows.push(row);
                }
            }
        }
        rows[first..].sort_unstable();
        starts.push(rows.len());
    }
    (starts, rows)
}

/// Entries of held rows or columns, those on the diagonal first.
fn held_places(
    scalar: &SymbolicSparseColMat<usize>,
    is_held: &dyn Fn(usize) -> bool,
) -> [Vec<usize>; 2] {
    let (mut diagonals, mut others) = (Vec::new(), Vec::new());
    for column in 0..scalar.ncols() {
        let entries = scalar.col_range(column);
        for (entry, &row) in entries.clone().zip(&scalar.row_idx()[entries]) {
            if is_held(row) || is_held(column) {
                let list = match row == column {
                    true => &mut diagonals,
                    false => &mut others,
                };
                list.push(entry);
            }
        }
    }
    [diagonals, others]
}

impl Pattern {
    /// The pattern of all element matrices; `held[3 f + i]` says whether component `i` of function `f` is fixed,
    /// `order` has the functions in the order of their rows.
    pub fn new(numbering: &Numbering, held: &[bool], order: &[usize]) -> Self {
        let active = |f: usize| !(held[3 * f] && held[3 * f + 1] && held[3 * f + 2]);
        let functions: Vec<usize> = order.iter().copied().filter(|&f| active(f)).collect();
        let mut row_of = vec![ABSENT; numbering.functions];
        for (row, &f) in functions.iter().enumerate() {
            row_of[f] = row;
        }
        let mut orders: Vec<ElementRows> = Vec::new();
        let mut elements_of = vec![Vec::new(); functions.len()];
        for (e, (modes, signs)) in numbering
            .of_element
            .iter()
            .zip(&numbering.signs)
            .enumerate()
        {
            let mut order: Vec<_> = (0..modes.len())
                .filter_map(|m| modes[m].map(|f| (m, row_of[f], signs[m])))
                .filter(|&(_, row, _)| row != ABSENT)
                .collect();
            order.sort_unstable_by_key(|&(_, row, _)| row);
            for &(_, row, _) in &order {
                elements_of[row].push(e);
            }
            orders.push(order);
        }
        let (starts, rows) = blocks(&elements_of, &orders);
        let elements = orders
            .into_par_iter()
            .map(|order| {
                let mut ranks = Vec::with_capacity(order.len() * (order.len() + 1) / 2);
                for (b, &(_, column, _)) in order.iter().enumerate() {
                    let candidates = &rows[starts[column]..starts[column + 1]];
                    let mut rank = 0;
                    for &(_, row, _) in &order[b..] {
                        rank += candidates[rank..].partition_point(|&r| r < row);
                        ranks.push(rank as u32);
                    }
                }
                ElementPattern { order, ranks }
            })
            .collect();
        let scalar = expand(&starts, &rows);
        let is_held = |row: usize| held[3 * functions[row / 3] + row % 3];
        let [held_diagonals, held_entries] = held_places(&scalar, &is_held);
        Self {
            functions,
            starts,
            rows,
            scalar,
            elements,
            held_entries,
            held_diagonals,
        }
    }

    /// Number of scalar rows.
    pub fn len(&self) -> usize {
        3 * self.functions.len()
    }

    /// Whether everything is held.
    pub fn is_empty(&self) -> bool {
        self.functions.is_empty()
    }

    /// Number of scalar entries of the lower triangle.
    pub fn entries(&self) -> usize {
        self.scalar.row_idx().len()
    }

    /// The scalar pattern for faer.
    pub fn symbolic(&self) -> SymbolicSparseColMatRef<'_, usize> {
        self.scalar.rb()
    }

    /// The scalar matrix for faer.
    pub fn matrix<'a>(&'a self, values: &'a [f64]) -> SparseColMatRef<'a, usize, f64> {
        SparseColMatRef::new(self.symbolic(), values)
    }

    /// The block pattern for faer.
    pub fn block_symbolic(&self) -> SymbolicSparseColMatRef<'_, usize> {
        let n = self.functions.len();
        SymbolicSparseColMatRef::new_checked(n, n, &self.starts, None, &self.rows)
    }

    /// Adds the element matrices `(element, blocks of PAIRS)` to the values. Each thread owns a range of columns and
    /// adds the elements in the given order, so the sums do not depend on the number of threads.
    pub fn add(&self, elements: &[(usize, Vec<f64>)], values: &mut [f64]) {
        self.columns_in_parallel(values, |columns, first, values| {
            for (e, blocks) in elements {
                self.add_columns(&self.elements[*e], blocks, columns.clone(), first, values);
            }
        });
    }

    /// Zeroes the rows and columns held alone and sets their diagonals.
    pub fn hold(&self, values: &mut [f64]) {
        self.held_entries
            .iter()
            .for_each(|&entry| values[entry] = 0.0);
        self.held_diagonals
            .iter()
            .for_each(|&entry| values[entry] = 1.0);
    }

    /// Adds a number to the diagonal.
    pub fn add_diagonal(&self, number: f64, values: &mut [f64]) {
        let columns = &self.scalar.col_ptr()[..self.len()];
        columns.iter().for_each(|&first| values[first] += number);
    }

    /// Adds `scale` times a symmetric matrix with one scalar per block (see [`Self::scalar_values`]) to the values.
    pub fn add_scalar(&self, scale: f64, scalars: &[f64], values: &mut [f64]) {
        self.columns_in_parallel(values, |columns, first, values| {
            for column in columns {
                let count = self.starts[column + 1] - self.starts[column];
                for c in 0..3 {
                    let start = self.scalar.col_ptr()[3 * column + c] - first;
                    for rank in 0..count {
                        values[start + 3 * rank] += scale * scalars[self.starts[column] + rank];
                    }
                }
            }
        });
    }

    /// Sums element matrices with one scalar per pair of modes into one scalar per block.
    pub fn scalar_values(&self, element_matrix: impl Fn(usize) -> Vec<f64>) -> Vec<f64> {
        let mut scalars = vec![0.0; self.rows.len()];
        for (e, element) in self.elements.iter().enumerate() {
            let matrix = element_matrix(e);
            let n = matrix.len().isqrt();
            let mut ranks = element.ranks.iter();
            for (b, &(mode_b, column, sign_b)) in element.order.iter().enumerate() {
                for (&(mode_a, _, sign_a), &rank) in element.order[b..].iter().zip(ranks.by_ref()) {
                    scalars[self.starts[column] + rank as usize] +=
                        sign_a * sign_b * matrix[mode_a + n * mode_b];
                }
            }
        }
        scalars
    }

    /// The matrix with one scalar per block, both triangles of it.
    pub fn scalar_matrix(&self, scalars: &[f64]) -> ScalarMatrix {
        let mut rows = vec![Vec::new(); self.functions.len()];
        for column in 0..self.functions.len() {
            for block in self.starts[column]..self.starts[column + 1] {
                let (row, value) = (self.rows[block], scalars[block]);
                rows[row].push((self.functions[column], value));
                if row != column {
                    rows[column].push((self.functions[row], value));
                }
            }
        }
        ScalarMatrix {
            rows: (self.functions.iter().copied()).zip(rows).collect(),
        }
    }

    /// Splits the values into ranges of block columns, one per thread, and runs `f(columns, first entry, values)`.
    fn columns_in_parallel(
        &self,
        values: &mut [f64],
        f: impl Fn(std::ops::Range<usize>, usize, &mut [f64]) + Sync,
    ) {
        let parts = rayon::current_num_threads().max(1);
        let mut pieces = Vec::with_capacity(parts);
        let (mut rest, mut column, mut first) = (values, 0, 0);
        for part in 1..=parts {
            let target = self.entries() * part / parts;
            let end = if part == parts {
                self.functions.len()
            } else {
                (self.scalar.col_ptr().partition_point(|&s| s < target) / 3)
                    .clamp(column, self.functions.len())
            };
            let last = self.scalar.col_ptr()[3 * end];
            let (piece, tail) = rest.split_at_mut(last - first);
            pieces.push((column..end, first, piece));
            (rest, column, first) = (tail, end, last);
        }
        pieces
            .into_par_iter()
            .for_each(|(columns, first, piece)| f(columns, first, piece));
    }

    /// Adds the columns of one element matrix that lie in `columns`.
    fn add_columns(
        &self,
        element: &ElementPattern,
        blocks: &[f64],
        columns: std::ops::Range<usize>,
        first: usize,
        values: &mut [f64],
    ) {
        let size = blocks.len() / 6;
        let n = size.isqrt();
        let block: [[(&[f64], bool); 3]; 3] = std::array::from_fn(|r| {
            std::array::from_fn(|c| {
                let pair = PAIRS
                    .iter()
                    .position(|&p| p == (r.min(c), r.max(c)))
                    .unwrap_or(0);
                (&blocks[pair * size..(pair + 1) * size], r > c)
            })
        });
        let begin = element
            .order
            .partition_point(|&(_, row, _)| row < columns.start);
        let end = element
            .order
            .partition_point(|&(_, row, _)| row < columns.end);
        let count = element.order.len();
        for b in begin..end {
            let (mode_b, column, sign_b) = element.order[b];
            let skipped = b * count - b * b.saturating_sub(1) / 2;
            let ranks = &element.ranks[skipped..skipped + count - b];
            for c in 0..3 {
                let start = self.scalar.col_ptr()[3 * column + c] - first;
                let sources = [0, 1, 2].map(|r| block[r][c]);
                for (&(mode_a, _, sign_a), &rank) in element.order[b..].iter().zip(ranks) {
                    let sign = sign_a * sign_b;
                    for r in if rank == 0 { c..3 } else { 0..3 } {
                        let (source, transposed) = sources[r];
                        let entry = if transposed {
                            mode_b + n * mode_a
                        } else {
                            mode_a + n * mode_b
                        };
                        values[start + 3 * rank as usize + r - c] += sign * source[entry];
                    }
                }
            }
        }
    }
}
