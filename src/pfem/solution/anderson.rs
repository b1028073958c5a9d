//! Anderson's acceleration of a fixed-point iteration `u ← u + g(u)`: with the differences `ΔU` and `ΔG` of all
//! iterates
//! ```text
//! u ← u + g - (ΔU + ΔG) γ,       γ = argmin |g - ΔG γ|
//! ```
//! (Walker and Ni, *Anderson acceleration for fixed-point iterations*, SIAM J. Numer. Anal. 49, 2011), which for a
//! linear problem is GMRES.

use nalgebra::{DMatrix, DVector};

/// Anderson's acceleration, from the differences of all iterates.
#[derive(Default)]
pub(super) struct Anderson {
    /// The last fixed-point residual and the change of the iterate that followed.
    last: Option<(DVector<f64>, DVector<f64>)>,
    /// `(Δu, Δg)`.
    differences: Vec<(DVector<f64>, DVector<f64>)>,
}

impl Anderson {
    /// The change of the iterate after the fixed-point residual `g`.
    pub(super) fn step(&mut self, g: DVector<f64>) -> DVector<f64> {
        if let Some((before, change)) = self.last.take() {
            self.differences.push((change, &g - before));
        }
        let mut change = g.clone();
        if !self.differences.is_empty() {
            let columns: Vec<_> = self.differences.iter().map(|(_, dg)| dg.clone()).collect();
            let matrix = DMatrix::from_columns(&columns);
            let (q, r) = matrix.qr().unpack();
            // Columns that say nothing new make `R` singular: then the plain step remains.
            if let Some(gamma) = r.solve_upper_triangular(&q.tr_mul(&g)) {
                for ((du, dg), gamma) in self.differences.iter().zip(gamma.iter()) {
                    change.axpy(-gamma, du, 1.0);
                    change.axpy(-gamma, dg, 1.0);
                }
            }
        }
        self.last = Some((g, change.clone()));
        change
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Anderson solves a linear problem that the plain iteration diverges from.
    #[test]
    fn anderson_solves_where_plain_iteration_diverges() {
        // u = A u + b with eigenvalues -2, 0.5 and 3 of A.
        let a = DVector::from_vec(vec![-2.0, 0.5, 3.0]);
        let b = DVector::from_vec(vec![3.0, 1.0, -4.0]);
        let mut u = DVector::zeros(3);
        let mut acceleration = Anderson::default();
        for _ in 0..4 {
            let g = a.component_mul(&u) + &b - &u;
            u += acceleration.step(g);
        }
        let exact = DVector::from_vec(vec![1.0, 2.0, 2.0]);
        assert!((u - exact).norm() < 1e-12);
    }
}
