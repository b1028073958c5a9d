//! Orders of elimination, on which the size of the factor depends.
//!
//! **Minimum degree** eliminates next what has the fewest neighbours left. **Nested dissection**: The elements are cut
//! in two halves across the axis that leaves the fewest functions on the cut, the halves again, down to single
//! elements. A function belongs to the smallest part that contains all its elements; parts are eliminated before the
//! larger part that contains them. So internal modes come first, and the functions on a cut, which separate two halves,
//! last (George: *Nested dissection of a regular finite element mesh*, 1973).

use super::super::SolidError;
use super::super::space::numbering::Numbering;
use super::factor::{memory, symbolic_failed};
use super::sparse::Pattern;
use crate::Vec3;
use faer::dyn_stack::MemStack;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;
use std::collections::HashSet;

/// The functions that have rows, in the order of elimination by approximate minimum degree.
pub fn minimum_degree(pattern: &Pattern) -> Result<Vec<usize>, SolidError> {
    let order = amd_order(pattern.block_symbolic())?;
    Ok(order
        .into_iter()
        .map(|row| pattern.functions[row])
        .collect())
}

fn amd_order(blocks: SymbolicSparseColMatRef<'_, usize>) -> Result<Vec<usize>, SolidError> {
    let n = blocks.nrows();
    let (mut order, mut inverse) = (vec![0; n], vec![0; n]);
    let mut buffer = memory(amd::order_scratch::<usize>(n, blocks.compute_nnz()))?;
    let (control, stack) = (amd::Control::default(), MemStack::new(&mut buffer));
    amd::order(&mut order, &mut inverse, blocks, control, stack).map_err(symbolic_failed)?;
    Ok(order)
}

/// The functions that have rows: those of two halves of the mesh by approximate minimum degree, then those that the
/// halves have in common. The halves are independent of each other.
pub fn two_halves(
    pattern: &Pattern,
    numbering: &Numbering,
    centres: &[Vec3],
) -> Result<Vec<usize>, SolidError> {
    let parts = Parts::none(numbering, centres);
    let (lower, upper) = parts.halves((0..centres.len()).collect());
    let cut = parts.common_functions(&lower, &upper);
    let is_cut: Vec<bool> = (pattern.functions.iter())
        .map(|f| cut.contains(f))
        .collect();
    // As if they shared an element: then minimum degree leaves them for the end by itself, or nearly so.
    let blocks = pattern.block_symbolic();
    let n = blocks.nrows();
    let separator: Vec<usize> = (0..n).filter(|&row| is_cut[row]).collect();
    let (mut starts, mut rows) = (vec![0], Vec::new());
    for column in 0..n {
        let own = blocks.row_idx_of_col(column);
        if is_cut[column] {
            rows.extend(own.filter(|&row| !is_cut[row]));
            let from = separator.partition_point(|&row| row < column);
            rows.extend(&separator[from..]);
            rows[*starts.last().unwrap_or(&0)..].sort_unstable();
        } else {
            rows.extend(own);
        }
        starts.push(rows.len());
    }
    let joined = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
    let order = amd_order(joined)?;
    let (last, first): (Vec<usize>, Vec<usize>) = order.into_iter().partition(|&row| is_cut[row]);
    Ok((first.into_iter().chain(last))
        .map(|row| pattern.functions[row])
        .collect())
}

/// All functions, in the order in which they are eliminated.
pub fn nested_dissection(numbering: &Numbering, centres: &[Vec3]) -> Vec<usize> {
    let mut parts = Parts::none(numbering, centres);
    parts.divide((0..centres.len()).collect());
    let mut smallest: Vec<Option<usize>> = vec![None; numbering.functions];
    for (e, functions) in numbering.of_element.iter().enumerate() {
        for &f in functions.iter().flatten() {
            let leaf = parts.leaf[e];
            smallest[f] = Some(smallest[f].map_or(leaf, |part| parts.common(part, leaf)));
        }
    }
    let mut order: Vec<usize> = (0..numbering.functions).collect();
    order.sort_by_key(|&f| smallest[f]);
    order
}

/// Parts of the mesh, numbered such that a part comes after all those that it contains.
struct Parts<'a> {
    numbering: &'a Numbering,
    centres: &'a [Vec3],
    /// The part of which a part is one half.
    parent: Vec<usize>,
    /// The part that an element is alone in.
    leaf: Vec<usize>,
}

impl<'a> Parts<'a> {
    fn none(numbering: &'a Numbering, centres: &'a [Vec3]) -> Self {
        Self {
            numbering,
            centres,
            parent: Vec::new(),
            leaf: vec![0; centres.len()],
        }
    }

    /// Divides a set of elements; returns the number of the part.
    fn divide(&mut self, elements: Vec<usize>) -> usize {
        let halves = if elements.len() > 1 {
            let (lower, upper) = self.halves(elements.clone());
            vec![self.divide(lower), self.divide(upper)]
        } else {
            Vec::new()
        };
        let part = self.parent.len();
        self.parent.push(part);
        if let [element] = elements[..]
            && halves.is_empty()
        {
            self.leaf[element] = part;
        }
        halves.into_iter().for_each(|half| self.parent[half] = part);
        part
    }

    /// Cuts a set of elements across the axis that leaves the fewest functions on the cut.
    fn halves(&self, elements: Vec<usize>) -> (Vec<usize>, Vec<usize>) {
        let cuts = [0, 1, 2].map(|axis| {
            let mut lower = elements.clone();
            lower.sort_by(|&a, &b| self.centres[a][axis].total_cmp(&self.centres[b][axis]));
            let upper = lower.split_off(lower.len() / 2);
            (self.common_functions(&lower, &upper).len(), lower, upper)
        });
        let best = cuts.into_iter().min_by_key(|(common, _, _)| *common);
        let (_, lower, upper) = best.unwrap_or_default();
        (lower, upper)
    }

    /// Functions that two sets of elements have in common.
    fn common_functions(&self, lower: &[usize], upper: &[usize]) -> HashSet<usize> {
        let functions = |elements: &[usize]| -> HashSet<usize> {
            elements
                .iter()
                .flat_map(|&e| self.numbering.of_element[e].iter().flatten().copied())
                .collect()
        };
        &functions(lower) & &functions(upper)
    }

    /// The smallest part that contains both.
    fn common(&self, mut a: usize, mut b: usize) -> usize {
        while a != b {
            if a < b {
                a = self.parent[a];
            } else {
                b = self.parent[b];
            }
        }
        a
    }
}
