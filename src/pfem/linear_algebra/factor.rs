//! Sparse direct factorization: symbolic once, numeric as often as the tangent changes.

use super::super::SolidError;
use super::multifrontal::{Fronts, Stop, Task, operations};
use super::sparse::Pattern;
use super::substitution::Substitution;
use super::tree::Tree;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::reborrow::Reborrow;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::supernodal::{
    SupernodalLdltRef, SupernodalLltRef, SymbolicSupernodalCholesky,
};
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::traits::RealField;
use faer::{Conj, MatMut, Par, Side};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Operations of a factorization from which on every factor is stored in single precision: walls of some 30,000
/// unknowns.
pub const LARGE: f64 = 1.5e10;

/// How the entries of a factor are stored. All are computed in double precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// As they are computed.
    Double,
    /// Rounded: half the memory, and half the time of a solution, which waits for memory. Good enough for an iteration
    /// that measures its residual in double precision, of a matrix that is well conditioned.
    Single,
}

/// Elimination order and structure of the factor.
#[derive(Debug, Clone)]
pub struct Symbolic {
    structure: Arc<SymbolicCholesky<usize>>,
    substitution: Arc<Substitution>,
    fronts: Arc<Fronts>,
}

/// Which factorization was possible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FactorKind {
    /// `L Lᵀ`: the matrix is positive definite.
    Llt,
    /// `L D Lᵀ`: it is not.
    Ldlt,
}

/// Entries of a factor.
#[derive(Debug, Clone)]
enum Values {
    Double(Vec<f64>),
    Single(Vec<f32>),
}

/// A factorized symmetric matrix.
#[derive(Debug, Clone)]
pub struct Factorization {
    symbolic: Symbolic,
    kind: FactorKind,
    values: Values,
}

/// Working memory for faer.
pub(super) fn memory(request: faer::dyn_stack::StackReq) -> Result<MemBuffer, SolidError> {
    MemBuffer::try_new(request).map_err(|_| {
        SolidError::Model("not enough memory for the factorization of the structure".into())
    })
}

/// An error of the symbolic analysis.
pub(super) fn symbolic_failed(error: faer::sparse::FaerError) -> SolidError {
    SolidError::Model(format!("symbolic factorization failed: {error:?}"))
}

impl Symbolic {
    /// Finds the structure of the factor of a matrix whose rows are in the order of elimination.
    pub fn new(pattern: &Pattern) -> Result<Self, SolidError> {
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        // Without a permutation, faer takes the upper triangle here, though the lower one later.
        let upper = pattern
            .symbolic()
            .transpose()
            .to_col_major()
            .map_err(symbolic_failed)?;
        let ordering = SymmetricOrdering::Identity;
        let symbolic = factorize_symbolic_cholesky(upper.rb(), Side::Upper, ordering, parameters)
            .map_err(symbolic_failed)?;
        let tree = Tree::new(supernodal(&symbolic));
        Ok(Self {
            substitution: Arc::new(Substitution::new(supernodal(&symbolic), &tree)),
            fronts: Arc::new(Fronts::new(supernodal(&symbolic), tree)),
            structure: Arc::new(symbolic),
        })
    }

    /// The rows in another order with the same entries of the factor, whose elimination two threads can share: the
    /// tree is taken at its middle, and branches begin at its ends. Minimum degree often sweeps a tube from one end to
    /// the other.
    pub fn balanced(&self) -> Vec<usize> {
        let structure = supernodal(&self.structure);
        let tree = Tree::new(structure);
        tree.rooted_at(structure, tree.centre(operations(structure)))
    }

    /// Bytes that a factorization takes, at most.
    pub fn bytes(&self, precision: Precision) -> f64 {
        let entry = match precision {
            Precision::Double => 8.0,
            Precision::Single => 4.0,
        };
        entry * self.entries() as f64 + self.fronts.bytes(supernodal(&self.structure))
    }

    /// Number of entries of the factor.
    pub fn entries(&self) -> usize {
        self.structure.len_val()
    }

    /// Multiplications and additions of a factorization.
    pub fn operations(&self) -> f64 {
        operations(supernodal(&self.structure)).iter().sum()
    }

    /// Factorizes: `L Lᵀ` if the matrix is positive definite, `L D Lᵀ` if not. The result does not depend on the number
    /// of threads.
    ///
    /// # Errors
    /// If the matrix is singular, or nobody waits for the factor any more.
    pub fn factorize(
        &self,
        pattern: &Pattern,
        values: &[f64],
        precision: Precision,
        cancelled: &AtomicBool,
    ) -> Result<Factorization, SolidError> {
        let eliminated = |kind: FactorKind| {
            let task = self.task(pattern, values, kind, cancelled);
            Ok(match precision {
                Precision::Double => Values::Double(self.fronts.factorize(task, |entry| entry)?),
                Precision::Single => {
                    Values::Single(self.fronts.factorize(task, |entry| entry as f32)?)
                }
            })
        };
        let mut kind = FactorKind::Llt;
        let mut factor = eliminated(kind);
        if matches!(factor, Err(Stop::Pivot)) {
            kind = FactorKind::Ldlt;
            factor = eliminated(kind);
        }
        let factor = factor.map_err(|stop| {
            SolidError::NoEquilibrium(match stop {
                Stop::Pivot => "the tangent is singular".into(),
                Stop::Cancelled => "nobody waits for the tangent any more".into(),
            })
        })?;
        Ok(Factorization {
            symbolic: self.clone(),
            kind,
            values: factor,
        })
    }

    /// Whether a matrix is positive definite. No factor is stored.
    pub fn is_positive_definite(&self, pattern: &Pattern, values: &[f64]) -> bool {
        let wanted = AtomicBool::new(false);
        let task = self.task(pattern, values, FactorKind::Llt, &wanted);
        self.fronts.factorize(task, |_| ()).is_ok()
    }

    fn task<'a>(
        &'a self,
        pattern: &'a Pattern,
        values: &'a [f64],
        kind: FactorKind,
        cancelled: &'a AtomicBool,
    ) -> Task<'a> {
        Task {
            symbolic: supernodal(&self.structure),
            matrix: pattern.matrix(values),
            is_indefinite: kind == FactorKind::Ldlt,
            cancelled,
        }
    }
}

/// The structure is always made of supernodes.
fn supernodal(symbolic: &SymbolicCholesky<usize>) -> &SymbolicSupernodalCholesky<usize> {
    match symbolic.raw() {
        SymbolicCholeskyRaw::Supernodal(symbolic) => symbolic,
        SymbolicCholeskyRaw::Simplicial(_) => unreachable!("FORCE_SUPERNODAL"),
    }
}

impl Factorization {
    /// Number of negative eigenvalues of the matrix: of negative entries of `D` in `L D Lᵀ` (Sylvester's law of
    /// inertia).
    pub fn negative_eigenvalues(&self) -> usize {
        match (&self.values, self.kind) {
            (_, FactorKind::Llt) => 0,
            (Values::Double(values), FactorKind::Ldlt) => negative_pivots(&self.symbolic, values),
            (Values::Single(values), FactorKind::Ldlt) => negative_pivots(&self.symbolic, values),
        }
    }

    /// Solves in place.
    pub fn solve(&self, rhs: &mut [f64]) -> Result<(), SolidError> {
        match &self.values {
            Values::Double(values) => self.solve_with(values, rhs),
            Values::Single(values) => {
                // Forces may lie outside the range of single precision.
                let scale = rhs.iter().fold(0.0, |largest: f64, r| largest.max(r.abs()));
                if scale == 0.0 {
                    return Ok(());
                }
                let mut single: Vec<f32> = rhs.iter().map(|r| (r / scale) as f32).collect();
                self.solve_with(values, &mut single)?;
                rhs.iter_mut()
                    .zip(single)
                    .for_each(|(r, s)| *r = scale * f64::from(s));
                Ok(())
            }
        }
    }

    fn solve_with<T: RealField + Copy>(
        &self,
        values: &[T],
        rhs: &mut [T],
    ) -> Result<(), SolidError> {
        let symbolic = &*self.symbolic.structure;
        if self.kind == FactorKind::Llt {
            let factor = SupernodalLltRef::new(supernodal(symbolic), values);
            self.symbolic.substitution.solve(factor, rhs);
            return Ok(());
        }
        let n = rhs.len();
        let mut buffer = memory(symbolic.solve_in_place_scratch::<T>(1, Par::Seq))?;
        let stack = MemStack::new(&mut buffer);
        let rhs = MatMut::from_column_major_slice_mut(rhs, n, 1);
        LdltRef::new(symbolic, values).solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack);
        Ok(())
    }
}

/// Negative entries of `D`, which stands on the diagonal of the factor.
fn negative_pivots<T: RealField + Copy>(symbolic: &Symbolic, values: &[T]) -> usize {
    let symbolic = supernodal(&symbolic.structure);
    let factor = SupernodalLdltRef::new(symbolic, values);
    let of_supernode = |s: usize| {
        let block = factor.supernode(s).val();
        (0..block.ncols())
            .filter(|&j| block[(j, j)] < T::zero_impl())
            .count()
    };
    (0..symbolic.n_supernodes()).map(of_supernode).sum()
}
