//! Natural modes of the undeformed body by subspace iteration (Bathe, *Finite Element Procedures*, section 11.6).

use super::super::SolidError;
use super::super::discretization::Discretization;
use super::super::linear_algebra::sparse::ScalarMatrix;
use nalgebra::{DMatrix, DVector};

/// Relative change of the eigenvalues at which the iteration ends.
const TOLERANCE: f64 = 1e-12;

/// A natural mode.
#[derive(Debug, Clone, PartialEq)]
pub struct NaturalMode {
    /// Angular frequency, rad/s.
    pub angular_frequency: f64,
    /// Displacement coefficients, scaled to a kinetic energy of `1/2` J at a velocity of the same coefficients.
    pub shape: Vec<f64>,
}

/// The `count` lowest modes; `mass` in kg.
pub fn lowest(
    body: &Discretization,
    mass: &ScalarMatrix,
    count: usize,
) -> Result<Vec<NaturalMode>, SolidError> {
    let zero = vec![0.0; body.coefficients()];
    let mut stiffness = body.tangent(&zero, None, &[])?;
    body.pattern.hold(&mut stiffness);
    let factorization = body.factorize(&stiffness)?;
    let equations = body.pattern.len();
    let width = (2 * count).max(count + 8).min(body.degrees_of_freedom());
    // Pseudo-random start: no mode is orthogonal to it.
    let mut seed = 1u64;
    let mut random = |_, _| {
        seed = (seed.wrapping_mul(6364136223846793005)).wrapping_add(1442695040888963407);
        (seed >> 33) as f64 / (1u64 << 31) as f64 - 0.5
    };
    let mut columns: Vec<DVector<f64>> = (0..width)
        .map(|_| DVector::from_fn(equations, &mut random))
        .collect();
    let times_mass = |x: &DVector<f64>| -> DVector<f64> {
        let full = body.moved(&zero, x.as_slice(), 1.0);
        DVector::from_vec(body.restrict(&mass.multiply(&full)))
    };
    let mut values = vec![0.0; width];
    for _ in 0..500 {
        let mut images = Vec::with_capacity(width);
        let mut loads = Vec::with_capacity(width);
        for column in &columns {
            let load = times_mass(column);
            let mut image = load.clone();
            factorization.solve(image.as_mut_slice())?;
            images.push(image);
            loads.push(load);
        }
        let weighted: Vec<DVector<f64>> = images.iter().map(&times_mass).collect();
        let (new, coefficients) = ritz(&images, &loads, &weighted)?;
        columns = (coefficients.column_iter())
            .map(|coefficients| {
                let mut column = DVector::zeros(equations);
                for (share, image) in coefficients.iter().zip(&images) {
                    column.axpy(*share, image, 1.0);
                }
                column
            })
            .collect();
        let converged = (0..count).all(|i| (new[i] - values[i]).abs() <= TOLERANCE * new[i].abs());
        values = new;
        if converged {
            break;
        }
    }
    let modes = values.iter().zip(&columns).take(count);
    Ok(modes
        .map(|(value, column)| NaturalMode {
            angular_frequency: value.sqrt(),
            shape: body.moved(&zero, column.as_slice(), 1.0),
        })
        .collect())
}

/// Rayleigh and Ritz: eigenvalues of stiffness and mass on the subspace of the images `x`, with `loads` `K x` and
/// `weighted` `M x`, the lowest first, and the coefficients of each eigenvector, a column each.
fn ritz(
    images: &[DVector<f64>],
    loads: &[DVector<f64>],
    weighted: &[DVector<f64>],
) -> Result<(Vec<f64>, DMatrix<f64>), SolidError> {
    let width = images.len();
    let k = DMatrix::from_fn(width, width, |i, j| images[i].dot(&loads[j]));
    let m = DMatrix::from_fn(width, width, |i, j| images[i].dot(&weighted[j]));
    let inverse = (m.cholesky().and_then(|factor| factor.l().try_inverse())).ok_or_else(|| {
        SolidError::Model("the mass matrix is singular on the lowest modes".into())
    })?;
    let reduced = &inverse * (&k + k.transpose()) * 0.5 * inverse.transpose();
    let eigen = reduced.symmetric_eigen();
    let mut order: Vec<usize> = (0..width).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let coefficients = inverse.transpose() * &eigen.eigenvectors;
    let values = order.iter().map(|&c| eigen.eigenvalues[c]).collect();
    Ok((values, coefficients.select_columns(&order)))
}
