//! Factorization front by front, for large matrices.
//!
//! The columns of a supernode, with the changes that its children in the elimination tree make to them and to the rows
//! below, are a dense matrix, the *front*; its elimination leaves the columns of the factor and the change that goes on
//! to the parent (Duff, Reid: *The multifrontal solution of indefinite sparse symmetric linear equations*, 1983; Liu:
//! *The multifrontal method for sparse matrix solution: theory and practice*, 1992). Compared with a factorization
//! column by column, which faer has:
//! - disjoint subtrees are eliminated side by side, so that all threads have work, not only within a front;
//! - the factor can be stored in single precision as soon as its columns are eliminated in double precision, so that it
//!   never takes the memory of the latter.

use super::tree::{Division, Tree, columns};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt::factor as ldlt, llt::factor as llt};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_unit_lower_triangular_in_place,
};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;
use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};

type Structure = SymbolicSupernodalCholesky<usize>;

/// Subtrees are divided until none has more than this share of the operations.
const SHARE: f64 = 0.06;
/// Columns of a change that are computed at a time.
const WIDTH: usize = 128;

/// Why a factorization ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stop {
    /// A pivot is not positive, for `L Lᵀ`, or zero, for `L D Lᵀ`.
    Pivot,
    /// Nobody waits for it any more.
    Cancelled,
}

/// The order in which the fronts of a matrix are eliminated.
#[derive(Debug)]
pub struct Fronts {
    tree: Tree,
    /// Subtrees, in postorder, so that few changes wait for their parents.
    subtrees: Vec<Vec<usize>>,
    top: Vec<usize>,
}

/// What is factorized, and how.
#[derive(Clone, Copy)]
pub struct Task<'a, S> {
    /// Structure of the factor.
    pub symbolic: &'a Structure,
    /// The lower triangle of the matrix.
    pub matrix: SparseColMatRef<'a, usize, f64>,
    /// `L D Lᵀ` in place of `L Lᵀ`.
    pub is_indefinite: bool,
    /// How an entry of the factor is stored.
    pub store: fn(f64) -> S,
    /// Set when nobody waits for the factor any more.
    pub cancelled: &'a AtomicBool,
}

/// Changes of the rows below eliminated supernodes, lower triangles column by column, until their parents take them.
type Changes = HashMap<usize, Vec<f64>>;

/// Memory of one thread, used again for each front.
#[derive(Default)]
struct Workspace {
    /// The columns of the supernode, all rows of the front.
    own: Vec<f64>,
    /// `L D` of the rows below.
    scaled: Vec<f64>,
    /// A few columns of the change of those rows.
    product: Vec<f64>,
}

impl Fronts {
    /// Of a factor with this structure.
    pub fn new(symbolic: &Structure) -> Self {
        let tree = Tree::new(symbolic);
        let operations = (0..symbolic.n_supernodes()).map(|s| operations(symbolic, s));
        let Division { roots, top } = tree.divide(operations.collect(), SHARE);
        Self {
            subtrees: roots.iter().map(|&root| tree.postorder(root)).collect(),
            tree,
            top,
        }
    }

    /// Bytes of the fronts that are in memory at the same time, at most, on two threads. Those of the factor come on
    /// top.
    pub fn bytes(&self, symbolic: &Structure) -> f64 {
        let rows = |s: usize| symbolic.supernode(s).pattern().len() as f64;
        let (mut waiting, mut most) = (0.0, 0.0_f64);
        let mut subtrees: Vec<f64> = Vec::new();
        let largest = |supernodes: &[usize], waiting: &mut f64| {
            let mut most = 0.0_f64;
            for &s in supernodes {
                let (columns, below) = (columns(symbolic, s).len() as f64, rows(s));
                let front = (columns + below) * columns + below * WIDTH as f64;
                most = most.max(*waiting + front + 0.5 * below * below);
                let children = self.tree.children[s].iter();
                let taken: f64 = children.map(|&c| 0.5 * rows(c).powi(2)).sum();
                *waiting += 0.5 * below * below - taken;
            }
            most
        };
        for subtree in &self.subtrees {
            let mut left = 0.0;
            subtrees.push(largest(subtree, &mut left));
            waiting += left;
        }
        subtrees.sort_by(f64::total_cmp);
        let side_by_side: f64 = subtrees.iter().rev().take(2).sum();
        most = most.max(waiting + side_by_side);
        8.0 * most.max(largest(&self.top, &mut waiting))
    }

    /// The entries of the factor, supernode by supernode, in the layout of faer.
    ///
    /// # Errors
    /// If a pivot has the wrong sign, or the task is cancelled.
    pub fn factorize<S: Copy + Default + Send>(&self, task: Task<S>) -> Result<Vec<S>, Stop> {
        let mut factor = vec![S::default(); task.symbolic.len_val()];
        let mut rest = &mut factor[..];
        let mut columns_of = Vec::with_capacity(task.symbolic.n_supernodes());
        for ends in task.symbolic.col_ptr_for_val().windows(2) {
            let (own, tail) = rest.split_at_mut(ends[1] - ends[0]);
            columns_of.push(own);
            rest = tail;
        }
        let mut columns_of: Vec<Option<&mut [S]>> = columns_of.into_iter().map(Some).collect();
        let mut take = |supernodes: &[usize]| -> Vec<(usize, &mut [S])> {
            let own = |&s: &usize| Some((s, columns_of[s].take()?));
            supernodes.iter().filter_map(own).collect()
        };
        let subtrees: Vec<_> = self.subtrees.iter().map(|subtree| take(subtree)).collect();
        let top = take(&self.top);
        let eliminate = |supernodes: Vec<(usize, &mut [S])>, mut changes: Changes, par: Par| {
            let mut workspace = Workspace::default();
            for (s, to) in supernodes {
                let change = self.eliminate(task, s, to, &mut changes, &mut workspace, par)?;
                changes.insert(s, change);
            }
            Ok(changes)
        };
        let changes = (subtrees.into_par_iter())
            .map(|subtree| eliminate(subtree, Changes::new(), Par::Seq))
            .collect::<Result<Vec<_>, Stop>>()?;
        let par = match rayon::current_num_threads() {
            1 => Par::Seq,
            _ => Par::rayon(0),
        };
        eliminate(top, changes.into_iter().flatten().collect(), par)?;
        Ok(factor)
    }

    /// Assembles the front of a supernode and eliminates its columns, which go `to` the factor. Returns the change of
    /// the rows below.
    fn eliminate<S: Copy>(
        &self,
        task: Task<S>,
        s: usize,
        to: &mut [S],
        changes: &mut Changes,
        workspace: &mut Workspace,
        par: Par,
    ) -> Result<Vec<f64>, Stop> {
        if task.cancelled.load(Ordering::Relaxed) {
            return Err(Stop::Cancelled);
        }
        let supernode = task.symbolic.supernode(s);
        let front = Front {
            own: columns(task.symbolic, s),
            below: supernode.pattern(),
        };
        let (columns, rows) = (front.own.len(), front.below.len());
        zeroed(&mut workspace.own, (columns + rows) * columns);
        front.add_matrix(task.matrix, &mut workspace.own);
        let mut change = vec![0.0; rows * (rows + 1) / 2];
        for &child in &self.tree.children[s] {
            if let Some(of_child) = changes.remove(&child) {
                let supernode = task.symbolic.supernode(child);
                let own = &mut workspace.own;
                front.add_change(supernode.pattern(), &of_child, own, &mut change);
            }
        }
        front.eliminate(task.is_indefinite, workspace, &mut change, par)?;
        let entries = to.iter_mut().zip(&workspace.own);
        entries.for_each(|(to, &entry)| *to = (task.store)(entry));
        Ok(change)
    }
}

/// Multiplications and additions that eliminate a supernode.
pub fn operations(symbolic: &Structure, s: usize) -> f64 {
    let (columns, below) = (
        columns(symbolic, s).len(),
        symbolic.supernode(s).pattern().len(),
    );
    let lengths = (0..columns).map(|j| (columns - j + below) as f64);
    lengths.map(|length| length * length).sum()
}

/// Makes `memory` so many zeros.
fn zeroed(memory: &mut Vec<f64>, length: usize) {
    memory.clear();
    memory.resize(length, 0.0);
}

/// Where a column of a lower triangle with so many rows begins.
fn packed(rows: usize, column: usize) -> usize {
    column * rows - column * column.saturating_sub(1) / 2
}

/// Rows of a front.
struct Front<'a> {
    /// Those of the columns that are eliminated.
    own: std::ops::Range<usize>,
    /// Those below.
    below: &'a [usize],
}

impl Front<'_> {
    /// The places in the front of rows, which ascend.
    fn places<'a>(
        &'a self,
        rows: impl Iterator<Item = usize> + 'a,
    ) -> impl Iterator<Item = usize> + 'a {
        let mut at = 0;
        rows.map(move |row| {
            if row < self.own.end {
                return row - self.own.start;
            }
            while self.below[at] < row {
                at += 1;
            }
            self.own.len() + at
        })
    }

    /// Adds the columns of the matrix.
    fn add_matrix(&self, matrix: SparseColMatRef<'_, usize, f64>, own: &mut [f64]) {
        let length = self.own.len() + self.below.len();
        for (column, to) in self.own.clone().zip(own.chunks_exact_mut(length)) {
            let places = self.places(matrix.row_idx_of_col(column));
            for (place, value) in places.zip(matrix.val_of_col(column)) {
                to[place] += value;
            }
        }
    }

    /// Adds the change that a child makes to its `rows`.
    fn add_change(&self, rows: &[usize], of_child: &[f64], own: &mut [f64], change: &mut [f64]) {
        let (columns, below) = (self.own.len(), self.below.len());
        let places: Vec<usize> = self.places(rows.iter().copied()).collect();
        let mut rest = of_child;
        for (j, &column) in places.iter().enumerate() {
            let (values, tail) = rest.split_at(places.len() - j);
            rest = tail;
            let pairs = places[j..].iter().zip(values);
            if column < columns {
                let to = &mut own[column * (columns + below)..][..columns + below];
                pairs.for_each(|(&place, value)| to[place] += value);
            } else {
                let column = column - columns;
                let to = &mut change[packed(below, column)..][..below - column];
                pairs.for_each(|(&place, value)| to[place - columns - column] += value);
            }
        }
    }

    /// Eliminates the columns, and adds what that changes below.
    fn eliminate(
        &self,
        is_indefinite: bool,
        workspace: &mut Workspace,
        change: &mut [f64],
        par: Par,
    ) -> Result<(), Stop> {
        let (columns, rows) = (self.own.len(), self.below.len());
        let Workspace {
            own,
            scaled,
            product,
        } = workspace;
        let front = MatMut::from_column_major_slice_mut(own, columns + rows, columns);
        let (diagonal, mut below) = front.split_at_row_mut(columns);
        if !is_indefinite {
            definite(diagonal, below.as_mut(), par)?;
            let below = below.as_ref();
            subtract(below, below, change, product, par);
            return Ok(());
        }
        zeroed(scaled, rows * columns);
        let mut scaled = MatMut::from_column_major_slice_mut(scaled, rows, columns);
        indefinite(diagonal, below.as_mut(), scaled.as_mut(), par)?;
        subtract(below.as_ref(), scaled.as_ref(), change, product, par);
        Ok(())
    }
}

/// `L Lᵀ` of the rows of the columns, and `L` of the rows `below`.
fn definite(mut diagonal: MatMut<'_, f64>, below: MatMut<'_, f64>, par: Par) -> Result<(), Stop> {
    let request = llt::cholesky_in_place_scratch::<f64>(diagonal.nrows(), par, Default::default());
    let mut buffer = MemBuffer::new(request);
    let stack = MemStack::new(&mut buffer);
    let (plain, parameters) = (Default::default(), Default::default());
    llt::cholesky_in_place(diagonal.as_mut(), plain, par, stack, parameters)
        .map_err(|_| Stop::Pivot)?;
    solve_lower_triangular_in_place(diagonal.as_ref(), below.transpose_mut(), par);
    Ok(())
}

/// `L D Lᵀ` of the rows of the columns, `L` of the rows `below`, and their `L D`.
fn indefinite(
    mut diagonal: MatMut<'_, f64>,
    mut below: MatMut<'_, f64>,
    mut scaled: MatMut<'_, f64>,
    par: Par,
) -> Result<(), Stop> {
    let request = ldlt::cholesky_in_place_scratch::<f64>(diagonal.nrows(), par, Default::default());
    let mut buffer = MemBuffer::new(request);
    let stack = MemStack::new(&mut buffer);
    let (plain, parameters) = (Default::default(), Default::default());
    ldlt::cholesky_in_place(diagonal.as_mut(), plain, par, stack, parameters)
        .map_err(|_| Stop::Pivot)?;
    let transposed = below.as_mut().transpose_mut();
    solve_unit_lower_triangular_in_place(diagonal.as_ref(), transposed, par);
    scaled.copy_from(below.as_ref());
    for j in 0..below.ncols() {
        let pivot = diagonal[(j, j)];
        (0..below.nrows()).for_each(|i| below[(i, j)] /= pivot);
    }
    Ok(())
}

/// Subtracts the lower triangle of `left rightᵀ` from a packed one, some columns at a time.
fn subtract(
    left: MatRef<'_, f64>,
    right: MatRef<'_, f64>,
    change: &mut [f64],
    product: &mut Vec<f64>,
    par: Par,
) {
    let rows = left.nrows();
    for first in (0..rows).step_by(WIDTH) {
        let (width, length) = (WIDTH.min(rows - first), rows - first);
        product.resize(length * width, 0.0);
        matmul(
            MatMut::from_column_major_slice_mut(product, length, width),
            Accum::Replace,
            left.subrows(first, length),
            right.subrows(first, width).transpose(),
            1.0,
            par,
        );
        for (j, column) in product.chunks_exact(length).enumerate() {
            let to = &mut change[packed(rows, first + j)..][..length - j];
            let pairs = to.iter_mut().zip(&column[j..]);
            pairs.for_each(|(to, product)| *to -= product);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::Side;
    use faer::sparse::linalg::SupernodalThreshold;
    use faer::sparse::linalg::cholesky::{
        CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
        factorize_symbolic_cholesky,
    };
    use faer::sparse::{SparseColMat, Triplet};

    const SIDE: usize = 60;

    /// Laplace's equation on a square less a number, in an order whose elimination tree has branches: the lower
    /// triangle.
    fn square(shift: f64) -> SparseColMat<usize, f64> {
        // Halves of halves, what divides them last.
        fn order(
            rows: std::ops::Range<usize>,
            columns: std::ops::Range<usize>,
            to: &mut Vec<usize>,
        ) {
            let (height, width) = (rows.len(), columns.len());
            if height * width <= 4 {
                to.extend(rows.flat_map(|i| columns.clone().map(move |j| i * SIDE + j)));
            } else if height > width {
                let cut = rows.start + height / 2;
                order(rows.start..cut, columns.clone(), to);
                order(cut + 1..rows.end, columns.clone(), to);
                to.extend(columns.map(|j| cut * SIDE + j));
            } else {
                let cut = columns.start + width / 2;
                order(rows.clone(), columns.start..cut, to);
                order(rows.clone(), cut + 1..columns.end, to);
                to.extend(rows.map(|i| i * SIDE + cut));
            }
        }
        let mut points = Vec::new();
        order(0..SIDE, 0..SIDE, &mut points);
        let mut place = vec![0; points.len()];
        (points.iter().enumerate()).for_each(|(at, &point)| place[point] = at);
        let mut entries = Vec::new();
        for point in 0..points.len() {
            entries.push(Triplet::new(place[point], place[point], 4.0 - shift));
            for near in [point + 1, point + SIDE] {
                if near < points.len() && (near != point + 1 || near % SIDE != 0) {
                    let (a, b) = (place[point], place[near]);
                    entries.push(Triplet::new(a.max(b), a.min(b), -1.0));
                }
            }
        }
        SparseColMat::try_new_from_triplets(points.len(), points.len(), &entries).unwrap()
    }

    fn structure(matrix: &SparseColMat<usize, f64>) -> SymbolicCholesky<usize> {
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let upper = matrix.symbolic().transpose().to_col_major().unwrap();
        let ordering = SymmetricOrdering::Identity;
        factorize_symbolic_cholesky(upper.as_ref(), Side::Upper, ordering, parameters).unwrap()
    }

    fn supernodes(symbolic: &SymbolicCholesky<usize>) -> &Structure {
        match symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(symbolic) => symbolic,
            SymbolicCholeskyRaw::Simplicial(_) => unreachable!("forced"),
        }
    }

    /// The factor by fronts, and the one that faer makes column by column.
    fn both(shift: f64, is_indefinite: bool) -> (Result<Vec<f64>, Stop>, Vec<f64>) {
        let (matrix, never) = (square(shift), AtomicBool::new(false));
        let symbolic = structure(&matrix);
        let fronts = Fronts::new(supernodes(&symbolic));
        assert!(fronts.subtrees.len() > 8 && fronts.top.len() > 4);
        let found = fronts.factorize(Task {
            symbolic: supernodes(&symbolic),
            matrix: matrix.as_ref(),
            is_indefinite,
            store: |entry| entry,
            cancelled: &never,
        });
        let mut expected = vec![0.0; symbolic.len_val()];
        let (plain, par) = (Default::default(), Par::Seq);
        let request = symbolic
            .factorize_numeric_llt_scratch::<f64>(par, plain)
            .or(symbolic.factorize_numeric_ldlt_scratch::<f64>(par, Default::default()));
        let mut buffer = MemBuffer::new(request);
        let stack = MemStack::new(&mut buffer);
        let (matrix, to) = (matrix.as_ref(), &mut expected[..]);
        let regular = match is_indefinite {
            false => {
                let none = Default::default();
                let done = symbolic.factorize_numeric_llt(
                    to,
                    matrix,
                    Side::Lower,
                    none,
                    par,
                    stack,
                    plain,
                );
                done.is_ok()
            }
            true => {
                let (none, plain) = (Default::default(), Default::default());
                let done = symbolic.factorize_numeric_ldlt(
                    to,
                    matrix,
                    Side::Lower,
                    none,
                    par,
                    stack,
                    plain,
                );
                done.is_ok()
            }
        };
        assert_eq!(regular, found.is_ok());
        (found, expected)
    }

    #[test]
    fn fronts_give_the_factor_that_columns_give() {
        // With the shift, the matrix has 11 negative eigenvalues.
        for (shift, is_indefinite) in [(0.0, false), (0.0, true), (0.05, true)] {
            let (found, expected) = both(shift, is_indefinite);
            let (found, matrix) = (found.unwrap(), square(shift));
            let symbolic = structure(&matrix);
            let mut pivots = 0;
            for s in 0..supernodes(&symbolic).n_supernodes() {
                let (own, below) = (
                    columns(supernodes(&symbolic), s).len(),
                    supernodes(&symbolic).supernode(s).pattern().len(),
                );
                let begin = supernodes(&symbolic).col_ptr_for_val()[s];
                // Above the diagonal is what nobody reads.
                for (j, i) in (0..own).flat_map(|j| (j..own + below).map(move |i| (j, i))) {
                    let place = begin + j * (own + below) + i;
                    let error = (found[place] - expected[place]).abs();
                    assert!(
                        error < 1e-11 * (1.0 + expected[place].abs()),
                        "{s} {i} {j}: {error:e}"
                    );
                    pivots += usize::from(i == j && found[place] < 0.0);
                }
            }
            assert_eq!(pivots, if shift > 0.0 { 11 } else { 0 });
        }
    }

    #[test]
    fn an_indefinite_matrix_has_no_positive_pivots() {
        assert_eq!(both(0.05, false).0, Err(Stop::Pivot));
    }

    #[test]
    fn a_cancelled_factorization_ends() {
        let matrix = square(0.0);
        let symbolic = structure(&matrix);
        let fronts = Fronts::new(supernodes(&symbolic));
        let task = |cancelled| {
            fronts.factorize(Task {
                symbolic: supernodes(&symbolic),
                matrix: matrix.as_ref(),
                is_indefinite: false,
                store: |_| (),
                cancelled,
            })
        };
        let [cancelled, wanted] = [true, false].map(AtomicBool::new);
        assert_eq!(task(&cancelled), Err(Stop::Cancelled));
        assert!(task(&wanted).is_ok());
    }

    /// A front of one row and one of many: where their columns begin.
    #[test]
    fn packed_columns_follow_each_other() {
        for rows in [1, 2, 7] {
            let mut begin = 0;
            for column in 0..rows {
                assert_eq!(packed(rows, column), begin);
                begin += rows - column;
            }
            assert_eq!(begin, rows * (rows + 1) / 2);
        }
    }
}
