//! Factorization front by front.
//!
//! The columns of a supernode, with the changes that its children in the elimination tree make to them and to the rows
//! below, are a dense matrix, the *front*; its elimination leaves the columns of the factor and the change that goes on
//! to the parent (Duff, Reid: *The multifrontal solution of indefinite sparse symmetric linear equations*, 1983; Liu:
//! *The multifrontal method for sparse matrix solution: theory and practice*, 1992). Compared with a factorization
//! column by column, which faer has:
//! - disjoint subtrees are eliminated side by side, so that all threads have work, not only within a front;
//! - the factor can be stored in single precision as soon as its columns are eliminated in double precision, so that it
//!   never takes the memory of the latter;
//! - large fronts are products of large matrices.

use super::tree::{Tree, columns};
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
use std::sync::{Mutex, PoisonError};

type Structure = SymbolicSupernodalCholesky<usize>;

/// The branches of a subtree are eliminated side by side if it has more than this share of the operations.
const SHARE: f64 = 0.06;
/// Columns of a change that are computed at a time, and lie together in memory.
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
    /// Supernodes whose branches are eliminated side by side.
    is_divided: Vec<bool>,
}

/// What is factorized.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// Structure of the factor.
    pub symbolic: &'a Structure,
    /// The lower triangle of the matrix.
    pub matrix: SparseColMatRef<'a, usize, f64>,
    /// `L D Lᵀ` in place of `L Lᵀ`.
    pub is_indefinite: bool,
    /// Set when nobody waits for the factor any more.
    pub cancelled: &'a AtomicBool,
}

/// Changes of the rows below eliminated supernodes, until their parents take them: lower triangles in strips of
/// `WIDTH` columns, each a matrix of the rows from its first column on.
type Changes = HashMap<usize, Vec<f64>>;

/// Stores the columns of a supernode.
type Store<'a> = dyn Fn(usize, &[f64]) + Sync + 'a;

/// Memory of one thread, used again for each front.
#[derive(Default)]
struct Workspace {
    /// The columns of the supernode, all rows of the front.
    own: Vec<f64>,
    /// `L D` of the rows below.
    scaled: Vec<f64>,
}

impl Fronts {
    /// Of a factor with this structure.
    pub fn new(symbolic: &Structure, tree: Tree) -> Self {
        let mut is_divided = vec![false; symbolic.n_supernodes()];
        for s in tree.divide(operations(symbolic), SHARE).top {
            is_divided[s] = true;
        }
        Self { tree, is_divided }
    }

    /// Bytes of the fronts that are in memory at the same time, at most, on two threads. Those of the factor come on
    /// top.
    pub fn bytes(&self, symbolic: &Structure) -> f64 {
        let count = symbolic.n_supernodes();
        let mut change = vec![0.0; count];
        // Entries that a subtree takes with one thread, and with two.
        let (mut one, mut two) = (vec![0.0_f64; count], vec![0.0_f64; count]);
        for s in 0..count {
            let rows = symbolic.supernode(s).pattern().len();
            let columns = columns(symbolic, s).len();
            change[s] = begin(rows, rows) as f64;
            let children = &self.tree.children[s];
            // While one branch is eliminated, the changes of all others may wait.
            let waiting: f64 = children.iter().map(|&c| change[c]).sum();
            let mut beyond: Vec<f64> = children.iter().map(|&c| one[c] - change[c]).collect();
            beyond.sort_by(|a, b| b.total_cmp(a));
            let side_by_side: f64 = beyond.iter().take(2).sum();
            let both = children.iter().map(|&c| two[c] - change[c]);
            let own = waiting + ((columns + rows) * columns) as f64 + change[s];
            one[s] = own.max(waiting + beyond.first().unwrap_or(&0.0));
            two[s] = match self.is_divided[s] {
                true => own.max(waiting + both.fold(side_by_side, f64::max)),
                false => one[s],
            };
        }
        8.0 * self.tree.roots.iter().map(|&root| two[root]).sum::<f64>()
    }

    /// The entries of the factor, each as `store` keeps it, supernode by supernode, in the layout of faer.
    ///
    /// # Errors
    /// If a pivot has the wrong sign, or the task is cancelled.
    pub fn factorize<S: Copy + Default + Send>(
        &self,
        task: Task,
        store: impl Fn(f64) -> S + Sync,
    ) -> Result<Vec<S>, Stop> {
        let mut factor = vec![S::default(); task.symbolic.len_val()];
        let mut rest = &mut factor[..];
        let mut columns_of = Vec::with_capacity(task.symbolic.n_supernodes());
        for ends in task.symbolic.col_ptr_for_val().windows(2) {
            let (own, tail) = rest.split_at_mut(ends[1] - ends[0]);
            columns_of.push(own);
            rest = tail;
        }
        let to: Vec<Mutex<&mut [S]>> = columns_of.into_iter().map(Mutex::new).collect();
        let store = |s: usize, columns: &[f64]| {
            let mut to = to[s].lock().unwrap_or_else(PoisonError::into_inner);
            let entries = to.iter_mut().zip(columns);
            entries.for_each(|(to, &entry)| *to = store(entry));
        };
        let roots = self.tree.roots.par_iter();
        roots.try_for_each(|&root| self.subtree(task, root, &store).map(drop))?;
        drop(to);
        Ok(factor)
    }

    /// Eliminates a subtree, and has the columns of each supernode stored. Returns the change of the rows below.
    fn subtree(&self, task: Task, root: usize, store: &Store) -> Result<Vec<f64>, Stop> {
        let mut workspace = Workspace::default();
        if !self.is_divided[root] {
            // In postorder few changes wait for their parents.
            let mut changes = Changes::new();
            for s in self.tree.postorder(root) {
                let change =
                    self.eliminate(task, s, store, &mut changes, &mut workspace, Par::Seq)?;
                changes.insert(s, change);
            }
            return Ok(changes.remove(&root).unwrap_or_default());
        }
        let branches = self.tree.children[root].par_iter();
        let mut changes = branches
            .map(|&child| Ok((child, self.subtree(task, child, store)?)))
            .collect::<Result<Changes, Stop>>()?;
        let par = match rayon::current_num_threads() {
            1 => Par::Seq,
            _ => Par::rayon(0),
        };
        self.eliminate(task, root, store, &mut changes, &mut workspace, par)
    }

    /// Assembles the front of a supernode and eliminates its columns, which are stored. Returns the change of the rows
    /// below.
    fn eliminate(
        &self,
        task: Task,
        s: usize,
        store: &Store,
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
        let mut change = vec![0.0; begin(rows, rows)];
        for &child in &self.tree.children[s] {
            if let Some(of_child) = changes.remove(&child) {
                let supernode = task.symbolic.supernode(child);
                let own = &mut workspace.own;
                front.add_change(supernode.pattern(), &of_child, own, &mut change);
            }
        }
        front.eliminate(task.is_indefinite, workspace, &mut change, par)?;
        store(s, &workspace.own);
        Ok(change)
    }
}

/// Multiplications and additions of the elimination of each supernode.
pub fn operations(symbolic: &Structure) -> Vec<f64> {
    let of_supernode = |s: usize| -> f64 {
        let below = symbolic.supernode(s).pattern().len();
        let lengths = (0..columns(symbolic, s).len()).map(|j| (1 + j + below) as f64);
        lengths.map(|length| length * length).sum()
    };
    (0..symbolic.n_supernodes()).map(of_supernode).collect()
}

/// Makes `memory` so many zeros.
fn zeroed(memory: &mut Vec<f64>, length: usize) {
    memory.clear();
    memory.resize(length, 0.0);
}

/// Where a column of a change of so many rows begins, with the first row of its strip; where the change ends for the
/// column after the last one.
fn begin(rows: usize, column: usize) -> usize {
    let (strips, inside) = (column / WIDTH, column % WIDTH);
    let first = strips * WIDTH;
    // The strips before this one have `rows`, `rows - WIDTH`, ... rows.
    strips * WIDTH * rows - WIDTH * WIDTH * strips * strips.saturating_sub(1) / 2
        + inside * (rows - first)
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
        for (j, &column) in places.iter().enumerate() {
            let values = &of_child[begin(places.len(), j) + j % WIDTH..];
            let pairs = places[j..].iter().zip(values);
            if column < columns {
                let to = &mut own[column * (columns + below)..][..columns + below];
                pairs.for_each(|(&place, value)| to[place] += value);
            } else {
                let column = column - columns;
                let first = column - column % WIDTH;
                let to = &mut change[begin(below, column)..][..below - first];
                pairs.for_each(|(&place, value)| to[place - columns - first] += value);
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
        let Workspace { own, scaled } = workspace;
        let front = MatMut::from_column_major_slice_mut(own, columns + rows, columns);
        let (diagonal, mut below) = front.split_at_row_mut(columns);
        if !is_indefinite {
            definite(diagonal, below.as_mut(), par)?;
            let below = below.as_ref();
            subtract(below, below, change, par);
            return Ok(());
        }
        zeroed(scaled, rows * columns);
        let mut scaled = MatMut::from_column_major_slice_mut(scaled, rows, columns);
        indefinite(diagonal, below.as_mut(), scaled.as_mut(), par)?;
        subtract(below.as_ref(), scaled.as_ref(), change, par);
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

/// Subtracts the lower triangle of `left rightᵀ` from a change, strip by strip.
fn subtract(left: MatRef<'_, f64>, right: MatRef<'_, f64>, change: &mut [f64], par: Par) {
    let (rows, mut rest) = (left.nrows(), change);
    for first in (0..rows).step_by(WIDTH) {
        let (width, length) = (WIDTH.min(rows - first), rows - first);
        let (strip, tail) = rest.split_at_mut(length * width);
        rest = tail;
        matmul(
            MatMut::from_column_major_slice_mut(strip, length, width),
            Accum::Add,
            left.subrows(first, length),
            right.subrows(first, width).transpose(),
            -1.0,
            par,
        );
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
        laplace(&points, SIDE, shift)
    }

    /// The same on a rectangle so many points wide, the points in a given order.
    fn laplace(points: &[usize], width: usize, shift: f64) -> SparseColMat<usize, f64> {
        let mut place = vec![0; points.len()];
        (points.iter().enumerate()).for_each(|(at, &point)| place[point] = at);
        let mut entries = Vec::new();
        for point in 0..points.len() {
            entries.push(Triplet::new(place[point], place[point], 4.0 - shift));
            for near in [point + 1, point + width] {
                if near < points.len() && (near != point + 1 || near % width != 0) {
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

    fn fronts(symbolic: &SymbolicCholesky<usize>) -> Fronts {
        Fronts::new(supernodes(symbolic), Tree::new(supernodes(symbolic)))
    }

    /// The factor by fronts, and the one that faer makes column by column.
    fn both(shift: f64, is_indefinite: bool) -> (Result<Vec<f64>, Stop>, Vec<f64>) {
        let (matrix, never) = (square(shift), AtomicBool::new(false));
        let symbolic = structure(&matrix);
        let fronts = fronts(&symbolic);
        let divided = fronts.is_divided.iter().filter(|&&divided| divided);
        assert!(divided.count() > 4);
        let task = Task {
            symbolic: supernodes(&symbolic),
            matrix: matrix.as_ref(),
            is_indefinite,
            cancelled: &never,
        };
        let found = fronts.factorize(task, |entry| entry);
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
        let task = |cancelled| {
            let task = Task {
                symbolic: supernodes(&symbolic),
                matrix: matrix.as_ref(),
                is_indefinite: false,
                cancelled,
            };
            fronts(&symbolic).factorize(task, |_| ())
        };
        let [cancelled, wanted] = [true, false].map(AtomicBool::new);
        assert_eq!(task(&cancelled), Err(Stop::Cancelled));
        assert!(task(&wanted).is_ok());
    }

    /// A long strip, swept from one end to the other: the same order from its middle.
    #[test]
    fn a_balanced_tree_has_two_branches_and_no_more_entries() {
        let swept: Vec<usize> = (0..10 * 200).collect();
        // Of the heaviest branch below the root, as a share of all operations; and entries.
        let branch = |points: &[usize]| {
            let symbolic = structure(&laplace(points, 10, 0.0));
            let structure = supernodes(&symbolic);
            let tree = Tree::new(structure);
            let [root] = tree.roots[..] else {
                panic!("{:?}", tree.roots)
            };
            let all = operations(structure);
            let of_branch = |&child: &usize| -> f64 {
                let subtree = tree.postorder(child);
                subtree.iter().map(|&s| all[s]).sum()
            };
            let branches = tree.children[root].iter().map(of_branch);
            let heaviest = branches.fold(0.0, f64::max) / all.iter().sum::<f64>();
            let balanced = tree.rooted_at(structure, tree.centre(all));
            (heaviest, symbolic.len_val(), balanced)
        };
        let (one_sided, entries, balanced) = branch(&swept);
        let mut sorted = balanced.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, swept);
        let (share, fewer, _) = branch(&balanced);
        assert!(one_sided > 0.95 && (0.45..0.6).contains(&share), "{share}");
        assert!(fewer as f64 <= 1.05 * entries as f64, "{fewer} {entries}");
    }

    #[test]
    fn strips_follow_each_other() {
        for rows in [1, WIDTH - 1, WIDTH, 3 * WIDTH + 7] {
            let mut expected = 0;
            for column in 0..rows {
                assert_eq!(begin(rows, column), expected);
                expected += rows - column / WIDTH * WIDTH;
            }
            assert_eq!(begin(rows, rows), expected);
        }
    }
}
