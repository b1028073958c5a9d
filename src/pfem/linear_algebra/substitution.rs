//! Forward and backward substitution with a supernodal Cholesky factor on several threads.
//!
//! Disjoint subtrees of the elimination tree go side by side: forwards before the columns that they have in common,
//! backwards after them.

use super::tree::{Division, Tree, columns};
use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky};
use faer::traits::RealField;
use faer::{Accum, ColMut, ColRef, MatMut, Par, linalg};
use rayon::prelude::*;

/// Subtrees are divided until none has more than this share of the factor: enough for two threads.
const SHARE: f64 = 0.5;

/// Supernodes of a factor, those of disjoint subtrees apart; each list in the order of elimination.
#[derive(Debug)]
pub struct Substitution {
    subtrees: Vec<Vec<usize>>,
    /// What lies above them.
    top: Vec<usize>,
}

impl Substitution {
    /// Divides the elimination tree.
    pub fn new(symbolic: &SymbolicSupernodalCholesky<usize>, tree: &Tree) -> Self {
        let weights = (symbolic.col_ptr_for_val().windows(2))
            .map(|ends| (ends[1] - ends[0]) as f64)
            .collect();
        let Division { roots, top } = tree.divide(weights, SHARE);
        let subtrees = roots.into_iter().map(|root| {
            let mut all = tree.postorder(root);
            all.sort_unstable();
            all
        });
        Self {
            subtrees: subtrees.collect(),
            top,
        }
    }

    /// Solves `L Lᵀ x = b` in place.
    pub fn solve<T: RealField + Copy>(&self, factor: SupernodalLltRef<usize, T>, x: &mut [T]) {
        let symbolic = factor.symbolic();
        let forwards = |supernodes: &Vec<usize>| {
            let mut part = vec![T::zero_impl(); x.len()];
            for &s in supernodes {
                let own = columns(symbolic, s);
                part[own.clone()].copy_from_slice(&x[own]);
            }
            forward(factor, supernodes, &mut part);
            part
        };
        let parts: Vec<_> = self.subtrees.par_iter().map(forwards).collect();
        for (supernodes, part) in self.subtrees.iter().zip(&parts) {
            for own in supernodes.iter().map(|&s| columns(symbolic, s)) {
                x[own.clone()].copy_from_slice(&part[own]);
            }
            for row in self.top.iter().flat_map(|&s| columns(symbolic, s)) {
                x[row] += part[row];
            }
        }
        forward(factor, &self.top, x);
        backward(factor, &self.top, x);
        let backwards = |supernodes: &Vec<usize>| {
            let mut part = x.to_vec();
            backward(factor, supernodes, &mut part);
            part
        };
        let parts: Vec<_> = self.subtrees.par_iter().map(backwards).collect();
        for (supernodes, part) in self.subtrees.iter().zip(&parts) {
            for own in supernodes.iter().map(|&s| columns(symbolic, s)) {
                x[own.clone()].copy_from_slice(&part[own]);
            }
        }
    }
}

/// `x ← L⁻¹ x` for the columns of some supernodes.
fn forward<T: RealField + Copy>(
    factor: SupernodalLltRef<usize, T>,
    supernodes: &[usize],
    x: &mut [T],
) {
    let mut product = Vec::new();
    for &s in supernodes {
        let own = columns(factor.symbolic(), s);
        let supernode = factor.supernode(s);
        let (diagonal, below) = supernode.val().split_at_row(own.len());
        let unknowns = MatMut::from_column_major_slice_mut(&mut x[own.clone()], own.len(), 1);
        linalg::triangular_solve::solve_lower_triangular_in_place(diagonal, unknowns, Par::Seq);
        product.clear();
        product.resize(supernode.pattern().len(), T::zero_impl());
        linalg::matmul::matmul(
            ColMut::from_slice_mut(&mut product),
            Accum::Replace,
            below,
            ColRef::from_slice(&x[own]),
            T::one_impl(),
            Par::Seq,
        );
        for (&row, change) in supernode.pattern().iter().zip(&product) {
            x[row] -= *change;
        }
    }
}

/// `x ← L⁻ᵀ x` for the columns of some supernodes.
fn backward<T: RealField + Copy>(
    factor: SupernodalLltRef<usize, T>,
    supernodes: &[usize],
    x: &mut [T],
) {
    let mut known = Vec::new();
    for &s in supernodes.iter().rev() {
        let own = columns(factor.symbolic(), s);
        let supernode = factor.supernode(s);
        let (diagonal, below) = supernode.val().split_at_row(own.len());
        known.clear();
        known.extend(supernode.pattern().iter().map(|&row| x[row]));
        linalg::matmul::matmul(
            ColMut::from_slice_mut(&mut x[own.clone()]),
            Accum::Add,
            below.transpose(),
            ColRef::from_slice(&known),
            -T::one_impl(),
            Par::Seq,
        );
        let unknowns = MatMut::from_column_major_slice_mut(&mut x[own.clone()], own.len(), 1);
        linalg::triangular_solve::solve_upper_triangular_in_place(
            diagonal.transpose(),
            unknowns,
            Par::Seq,
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use faer::dyn_stack::{MemBuffer, MemStack};
    use faer::sparse::linalg::SupernodalThreshold;
    use faer::sparse::linalg::cholesky::{
        CholeskySymbolicParams, LltRef, SymbolicCholeskyRaw, SymmetricOrdering,
        factorize_symbolic_cholesky,
    };
    use faer::sparse::{SparseColMat, Triplet};
    use faer::{Conj, Side};

    /// Laplace's equation on a strip, whose elimination tree has branches.
    fn strip(length: usize, width: usize) -> SparseColMat<usize, f64> {
        let n = length * width;
        let mut entries = Vec::new();
        for i in 0..n {
            entries.push(Triplet::new(i, i, 4.5));
            for (near, j) in [
                (i % width > 0, i.wrapping_sub(1)),
                (i >= width, i.wrapping_sub(width)),
            ] {
                if near {
                    entries.push(Triplet::new(i, j, -1.0));
                }
            }
        }
        SparseColMat::try_new_from_triplets(n, n, &entries).unwrap()
    }

    #[test]
    fn subtrees_side_by_side_give_the_solution_of_the_whole() {
        let matrix = strip(60, 7);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(
            matrix.symbolic(),
            Side::Lower,
            SymmetricOrdering::Amd,
            parameters,
        )
        .unwrap();
        let mut values = vec![0.0; symbolic.len_val()];
        let mut buffer = MemBuffer::new(
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
        );
        symbolic
            .factorize_numeric_llt(
                &mut values,
                matrix.as_ref(),
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut buffer),
                Default::default(),
            )
            .unwrap();
        let SymbolicCholeskyRaw::Supernodal(supernodal) = symbolic.raw() else {
            panic!("forced");
        };
        let substitution = Substitution::new(supernodal, &Tree::new(supernodal));
        assert!(substitution.subtrees.len() > 1 && !substitution.top.is_empty());

        let (perm, inverse) = symbolic.perm().unwrap().arrays();
        let rhs: Vec<f64> = (0..matrix.nrows()).map(|i| (i as f64).sin()).collect();
        let mut found: Vec<f64> = perm.iter().map(|&i| rhs[i]).collect();
        substitution.solve(SupernodalLltRef::new(supernodal, &values), &mut found);
        let mut expected = rhs.clone();
        let mut buffer = MemBuffer::new(symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        LltRef::new(&symbolic, &values[..]).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut expected, rhs.len(), 1),
            Par::Seq,
            MemStack::new(&mut buffer),
        );
        for (i, expected) in expected.iter().enumerate() {
            assert!((found[inverse[i]] - expected).abs() < 1e-13, "row {i}");
        }
    }
}
