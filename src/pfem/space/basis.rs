//! Hierarchic one-dimensional shape functions: integrated Legendre polynomials.
//!
//! On [-1, 1] the functions of degree `p` are (Szabó, Babuška: *Finite Element Analysis*, 1991, section 3.1)
//! ```text
//! N_0(x) = (1 - x)/2,   N_1(x) = (1 + x)/2,
//! N_k(x) = sqrt((2k-1)/2) ∫_{-1}^{x} P_{k-1}(t) dt = (P_k(x) - P_{k-2}(x)) / sqrt(2(2k-1)),   k = 2, …, p.
//! ```
//! `N_k` vanishes at both ends for `k >= 2` and has the parity of `k`: `N_k(-x) = (-1)^k N_k(x)`, which is all that
//! continuity between elements of different orientation needs.

use fsi_numerics::quadrature::legendre;

/// Values and derivatives of the `p + 1` shape functions at `x`.
pub fn shape_functions(p: usize, x: f64) -> (Vec<f64>, Vec<f64>) {
    let legendre = legendre(p, x);
    let mut values = vec![0.5 * (1.0 - x), 0.5 * (1.0 + x)];
    let mut derivatives = vec![-0.5, 0.5];
    for k in 2..=p {
        let kf = k as f64;
        values.push((legendre[k] - legendre[k - 2]) / (2.0 * (2.0 * kf - 1.0)).sqrt());
        derivatives.push((0.5 * (2.0 * kf - 1.0)).sqrt() * legendre[k - 1]);
    }
    (values, derivatives)
}

/// Values and derivatives of the shape functions at a set of points.
#[derive(Debug, Clone)]
pub struct BasisTable {
    /// `values[k][q]`: function `k` at point `q`.
    pub values: Vec<Vec<f64>>,
    /// `derivatives[k][q]`: derivative of function `k` at point `q`.
    pub derivatives: Vec<Vec<f64>>,
}

impl BasisTable {
    /// Tabulates the functions of degree `p`.
    pub fn new(p: usize, points: &[f64]) -> Self {
        let mut values = vec![Vec::with_capacity(points.len()); p.max(1) + 1];
        let mut derivatives = values.clone();
        for &x in points {
            let (v, d) = shape_functions(p, x);
            for k in 0..v.len() {
                values[k].push(v[k]);
                derivatives[k].push(d[k]);
            }
        }
        Self {
            values,
            derivatives,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsi_numerics::quadrature::Rule;

    #[test]
    fn derivatives_of_the_modes_are_orthonormal() {
        let rule = Rule::gauss_legendre(12);
        let table = BasisTable::new(10, &rule.points);
        for i in 2..=10 {
            for j in 2..=10 {
                let sum: f64 = (0..12)
                    .map(|q| rule.weights[q] * table.derivatives[i][q] * table.derivatives[j][q])
                    .sum();
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((sum - expected).abs() < 1e-13, "{i} {j}: {sum}");
            }
        }
    }

    #[test]
    fn modes_vanish_at_the_ends_and_have_the_parity_of_their_degree() {
        for k in 2..=12 {
            for end in [-1.0, 1.0] {
                assert!(shape_functions(k, end).0[k].abs() < 1e-14);
            }
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let (plus, minus) = (shape_functions(k, 0.3).0[k], shape_functions(k, -0.3).0[k]);
            assert!((minus - sign * plus).abs() < 1e-15);
        }
    }
}
