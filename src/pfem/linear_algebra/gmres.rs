//! The method of generalized minimal residuals, for operators that are known by what they make of a vector.

use super::super::SolidError;
use nalgebra::{DMatrix, DVector};

/// Finds `x` with `|b - A x| <= tolerance |b|`, or as good as `most` applications of `apply`, `x ↦ A x`, make it (Saad
/// and Schultz, *GMRES*, SIAM J. Sci. Stat. Comput. 7, 1986). Returns it with the number of applications.
///
/// # Errors
/// Those of `apply`.
pub fn solve(
    b: &DVector<f64>,
    tolerance: f64,
    most: usize,
    mut apply: impl FnMut(&DVector<f64>) -> Result<DVector<f64>, SolidError>,
) -> Result<(DVector<f64>, usize), SolidError> {
    let size = b.norm();
    if size == 0.0 {
        return Ok((b.clone(), 0));
    }
    let mut basis = vec![b / size];
    // Columns of the Hessenberg matrix of A in the basis.
    let mut columns: Vec<Vec<f64>> = Vec::new();
    loop {
        let mut image = apply(&basis[columns.len()])?;
        let mut column = Vec::new();
        for q in &basis {
            let along = q.dot(&image);
            image.axpy(-along, q, 1.0);
            column.push(along);
        }
        let rest = image.norm();
        column.push(rest);
        columns.push(column);
        let n = columns.len();
        let hessenberg = DMatrix::from_fn(n + 1, n, |i, j| {
            columns[j].get(i).copied().unwrap_or_default()
        });
        let mut goal = DVector::zeros(n + 1);
        goal[0] = size;
        let (q, r) = hessenberg.clone().qr().unpack();
        let Some(shares) = r.solve_upper_triangular(&q.tr_mul(&goal)) else {
            return Err(SolidError::NoEquilibrium(
                "the linearized problem is singular".into(),
            ));
        };
        let left = (goal - hessenberg * &shares).norm();
        if left <= tolerance * size || n == most || rest <= f64::EPSILON * size {
            let mut x = DVector::zeros(b.len());
            (basis.iter().zip(shares.iter())).for_each(|(q, share)| x.axpy(*share, q, 1.0));
            return Ok((x, n));
        }
        basis.push(image / rest);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An operator without symmetry is inverted in as many steps as it has rows.
    #[test]
    fn gmres_inverts_in_as_many_steps_as_rows() {
        let a = DMatrix::from_row_slice(3, 3, &[1.0, 4.0, 0.0, -2.0, 0.5, 1.0, 3.0, 0.0, 2.0]);
        let exact = DVector::from_vec(vec![1.0, -2.0, 0.5]);
        let (x, applications) = solve(&(&a * &exact), 1e-12, 10, |x| Ok(&a * x)).unwrap();
        assert_eq!(applications, 3);
        assert!((x - &exact).norm() < 1e-12);
        // One application short of it, the residual is the smallest that two directions allow.
        let b = &a * &exact;
        let (x, _) = solve(&b, 1e-12, 2, |x| Ok(&a * x)).unwrap();
        let left = (&b - &a * x).norm() / b.norm();
        assert!(left > 1e-3 && left < 1.0, "{left}");
    }
}
