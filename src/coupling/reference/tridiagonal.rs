//! Tridiagonal systems.

/// A tridiagonal matrix whose elimination needs no pivoting (diagonally dominant, or symmetric positive definite).
#[derive(Debug, Clone, PartialEq)]
pub struct Tridiagonal {
    /// Entries (i, i - 1); the first is not used.
    pub lower: Vec<f64>,
    /// Entries (i, i).
    pub diagonal: Vec<f64>,
    /// Entries (i, i + 1); the last is not used.
    pub upper: Vec<f64>,
}

impl Tridiagonal {
    /// The matrix of zeros of size `n`.
    pub fn zeros(n: usize) -> Self {
        Self {
            lower: vec![0.0; n],
            diagonal: vec![0.0; n],
            upper: vec![0.0; n],
        }
    }

    /// The pivots of the elimination without exchange of rows; a positive definite matrix has positive ones.
    pub fn pivots(&self) -> Vec<f64> {
        let mut pivots = self.diagonal.clone();
        for i in 1..pivots.len() {
            pivots[i] -= self.lower[i] / pivots[i - 1] * self.upper[i - 1];
        }
        pivots
    }

    /// The solution for `right` (Thomas).
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let (n, pivots, mut x) = (right.len(), self.pivots(), right.to_vec());
        for i in 1..n {
            x[i] -= self.lower[i] / pivots[i - 1] * x[i - 1];
        }
        for i in (0..n).rev() {
            if i + 1 < n {
                x[i] -= self.upper[i] * x[i + 1];
            }
            x[i] /= pivots[i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_fulfils_the_equations() {
        let a = Tridiagonal {
            lower: vec![0.0, 1.0, -2.0, 0.5],
            diagonal: vec![4.0, 5.0, 6.0, 3.0],
            upper: vec![1.0, 2.0, -1.0, 0.0],
        };
        let b = [1.0, -2.0, 3.0, 4.0];
        let x = a.solve(&b);
        for i in 0..4 {
            let previous = if i > 0 { a.lower[i] * x[i - 1] } else { 0.0 };
            let after = if i < 3 { a.upper[i] * x[i + 1] } else { 0.0 };
            assert!((previous + a.diagonal[i] * x[i] + after - b[i]).abs() < 1e-14);
        }
    }
}
