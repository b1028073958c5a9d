//! One-dimensional operators of an element: nodes, quadrature points, and the matrices between them.

use fsi_numerics::lagrange;
use fsi_numerics::quadrature::Rule;

/// Lagrange polynomials on Gauss-Lobatto points, for velocity and geometry of degree `N` and pressure of degree `N -
/// 1`, with the Gauss points at which all integrals but the mass are taken.
///
/// `3N/2` (rounded up; at least `N + 2`) Gauss points integrate the convective term of a straight-sided element
/// exactly, so it is not aliased, and volumes and areas of curved ones too.
#[derive(Debug, Clone, PartialEq)]
pub struct Basis {
    /// Nodes of velocity and geometry, with their weights.
    pub nodes: Rule,
    /// Nodes of the pressure.
    pub pressure_nodes: Rule,
    /// Gauss points.
    pub gauss: Rule,
    /// Row `q`: values of the nodal polynomials at Gauss point `q`.
    pub to_gauss: Vec<Vec<f64>>,
    /// The same for the pressure.
    pub pressure_to_gauss: Vec<Vec<f64>>,
    /// Row `q`: derivatives at Gauss point `q` of the polynomials that interpolate the Gauss points.
    pub gauss_derivative: Vec<Vec<f64>>,
    /// Row `i`: derivatives at node `i` of the nodal polynomials.
    pub nodal_derivative: Vec<Vec<f64>>,
}

impl Basis {
    /// The lowest and the highest degree of the velocity.
    pub const DEGREES: [usize; 2] = [3, 8];

    /// Operators for velocity of degree `degree`.
    pub fn new(degree: usize) -> Self {
        let nodes = Rule::gauss_lobatto(degree + 1);
        let pressure_nodes = Rule::gauss_lobatto(degree);
        let gauss = Rule::gauss_legendre(Self::gauss_points(degree));
        let table = |from: &Rule, to: &Rule| -> Vec<Vec<f64>> {
            (to.points.iter())
                .map(|&x| lagrange::values(&from.points, x))
                .collect()
        };
        let slopes = |rule: &Rule| -> Vec<Vec<f64>> {
            (rule.points.iter())
                .map(|&x| lagrange::derivatives(&rule.points, x))
                .collect()
        };
        Self {
            to_gauss: table(&nodes, &gauss),
            pressure_to_gauss: table(&pressure_nodes, &gauss),
            gauss_derivative: slopes(&gauss),
            nodal_derivative: slopes(&nodes),
            nodes,
            pressure_nodes,
            gauss,
        }
    }

    /// Gauss points per direction.
    pub const fn gauss_points(degree: usize) -> usize {
        let exact = (3 * degree).div_ceil(2);
        if exact < degree + 2 {
            degree + 2
        } else {
            exact
        }
    }

    /// Degree of the velocity.
    pub fn degree(&self) -> usize {
        self.nodes.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Polynomials of the degree are interpolated and differentiated exactly.
    #[test]
    fn basis_is_exact_for_its_polynomials() {
        for degree in Basis::DEGREES[0]..=Basis::DEGREES[1] {
            let basis = Basis::new(degree);
            let f = |x: f64| (0.3 + x).powi(degree as i32);
            let slope = |x: f64| degree as f64 * (0.3 + x).powi(degree as i32 - 1);
            let at = |rule: &Rule| -> Vec<f64> { rule.points.iter().map(|&x| f(x)).collect() };
            let apply = |rows: &[Vec<f64>], values: &[f64]| -> Vec<f64> {
                let dot = |row: &Vec<f64>| row.iter().zip(values).map(|(a, b)| a * b).sum();
                rows.iter().map(dot).collect()
            };
            let interpolated = apply(&basis.to_gauss, &at(&basis.nodes));
            let slopes = apply(&basis.gauss_derivative, &at(&basis.gauss));
            let nodal = apply(&basis.nodal_derivative, &at(&basis.nodes));
            for (q, &x) in basis.gauss.points.iter().enumerate() {
                assert!((interpolated[q] - f(x)).abs() < 1e-12);
                assert!((slopes[q] - slope(x)).abs() < 1e-10);
            }
            for (i, &x) in basis.nodes.points.iter().enumerate() {
                assert!((nodal[i] - slope(x)).abs() < 1e-10);
            }
        }
    }
}
