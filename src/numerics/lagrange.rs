//! Lagrange polynomials: those that are 1 at one of some points and 0 at the others.

use crate::{Mat3, Vec3};

/// Their values at `x`.
pub fn values(points: &[f64], x: f64) -> Vec<f64> {
    let value = |i: usize| -> f64 {
        let others = points.iter().enumerate().filter(|(j, _)| *j != i);
        others
            .map(|(_, &other)| (x - other) / (points[i] - other))
            .product()
    };
    (0..points.len()).map(value).collect()
}

/// Their derivatives at `x`.
pub fn derivatives(points: &[f64], x: f64) -> Vec<f64> {
    let n = points.len();
    let derivative = |i: usize| -> f64 {
        // Product rule: one factor is differentiated at a time.
        let term = |k: usize| -> f64 {
            let others = (0..n).filter(|&j| j != i && j != k);
            others
                .map(|j| (x - points[j]) / (points[i] - points[j]))
                .product::<f64>()
                / (points[i] - points[k])
        };
        (0..n).filter(|&k| k != i).map(term).sum()
    };
    (0..n).map(derivative).collect()
}

/// Both, by recurrence over the factors: cheaper, and rounded otherwise.
pub fn values_and_derivatives(points: &[f64], x: f64) -> (Vec<f64>, Vec<f64>) {
    let n = points.len();
    let mut values = vec![1.0; n];
    let mut derivatives = vec![0.0; n];
    for i in 0..n {
        for j in (0..n).filter(|&j| j != i) {
            let scale = 1.0 / (points[i] - points[j]);
            derivatives[i] = (derivatives[i] * (x - points[j]) + values[i]) * scale;
            values[i] *= (x - points[j]) * scale;
        }
    }
    (values, derivatives)
}

/// A vector field in a hexahedron, from its `nodal` values at `points` in each of the local coordinates, fastest along
/// the first: its value at `xi`, and its derivatives by the local coordinates as columns. Not generic over where the
/// values come from: `fsi-driver`, whose own code is not compiled for speed, would compile it.
pub fn vector_and_slopes(points: &[f64], nodal: &[Vec3], xi: &Vec3) -> (Vec3, Mat3) {
    let along = [0, 1, 2].map(|d| values(points, xi[d]));
    let shapes = products(&along);
    let derived = [0, 1, 2].map(|d| {
        let mut factors = along.clone();
        factors[d] = derivatives(points, xi[d]);
        products(&factors)
    });
    let (mut value, mut slopes) = (Vec3::zeros(), Mat3::zeros());
    for (i, f) in nodal.iter().enumerate() {
        value += shapes[i] * f;
        for d in 0..3 {
            let mut column = slopes.column_mut(d);
            column += derived[d][i] * f;
        }
    }
    (value, slopes)
}

/// The smallest scaled Jacobian at a node of a hexahedron, the triple product of unit vectors along its axes, and which
/// node that is. The nodes' positions `x` are given fastest along the first axis; `slopes[i][j]` is the derivative of
/// the polynomial of node `j` at node `i`. Where nodes coincide, and there is no direction, -1.
pub fn worst_scaled_jacobian(slopes: &[Vec<f64>], x: &[Vec3]) -> (f64, usize) {
    let n = slopes.len();
    let mut worst = (f64::INFINITY, 0);
    for k in 0..x.len() {
        let axes = [(k % n, 1), (k / n % n, n), (k / n / n, n * n)].map(|(place, stride)| {
            let mut along = Vec3::zeros();
            for (j, slope) in slopes[place].iter().enumerate() {
                along += x[k - place * stride + j * stride] * *slope;
            }
            along.normalize()
        });
        let volume = axes[0].cross(&axes[1]).dot(&axes[2]);
        let volume = if volume.is_nan() { -1.0 } else { volume };
        if volume < worst.0 {
            worst = (volume, k);
        }
    }
    worst
}

/// Products of values along three directions, fastest along the first.
pub fn products([x, y, z]: &[Vec<f64>; 3]) -> Vec<f64> {
    let mut products = Vec::with_capacity(x.len() * y.len() * z.len());
    for c in z {
        for b in y {
            let bc = b * c;
            products.extend(x.iter().map(|a| a * bc));
        }
    }
    products
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials of the degree are interpolated and differentiated exactly, in both ways.
    #[test]
    fn polynomials_of_the_degree_are_exact() {
        let points = [-1.0, -0.3, 0.2, 0.9];
        let f = |x: f64| (0.3 + x).powi(3);
        let sum = |weights: &[f64]| -> f64 {
            let terms = weights.iter().zip(&points);
            terms.map(|(weight, &x)| weight * f(x)).sum()
        };
        for x in [-0.7, 0.2, 1.1] {
            let slope = 3.0 * (0.3_f64 + x).powi(2);
            let (both, slopes) = values_and_derivatives(&points, x);
            for (found, expected) in [
                (sum(&values(&points, x)), f(x)),
                (sum(&both), f(x)),
                (sum(&derivatives(&points, x)), slope),
                (sum(&slopes), slope),
            ] {
                assert!((found - expected).abs() < 1e-13, "{found} {expected}");
            }
        }
    }

    /// A field that is of the degree in each direction has its own value and gradient within a hexahedron.
    #[test]
    fn fields_in_hexahedra_are_exact() {
        let points = [-1.0, 0.1, 0.8];
        let field = |x: &Vec3| Vec3::new(x.x * x.x * x.y, x.y * x.z * x.z, x.x - x.y * x.y * x.z);
        let nodal: Vec<Vec3> = (0..27)
            .map(|i| field(&Vec3::new(points[i % 3], points[i / 3 % 3], points[i / 9])))
            .collect();
        let x = Vec3::new(0.3, -0.6, 0.9);
        let (value, slopes) = vector_and_slopes(&points, &nodal, &x);
        let expected = Mat3::new(
            2.0 * x.x * x.y,
            x.x * x.x,
            0.0,
            0.0,
            x.z * x.z,
            2.0 * x.y * x.z,
            1.0,
            -2.0 * x.y * x.z,
            -x.y * x.y,
        );
        assert!((value - field(&x)).norm() < 1e-14, "{value}");
        assert!((slopes - expected).norm() < 1e-13, "{slopes}");
    }
}
