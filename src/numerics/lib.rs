//! # fsi-numerics: what several solvers need
//!
//! Small things without physics, shared by `fsi-pfem` (the wall), `fsi-spectral` (the blood), `fsi-coupling` (their
//! fixed point) and `fsi-driver`, which joins them:
//!
//! * [`Vec3`] and [`Mat3`], vectors and tensors of space;
//! * [`quadrature`]: Gauss-Legendre and Gauss-Lobatto rules of any size, Legendre polynomials;
//! * [`lagrange`]: the polynomials that are 1 at one of some points and 0 at the others;
//! * [`Layers`]: the order of what lies layer by layer along a sweep, [`subdivided`]: where nodes lie on it;
//! * [`words!`]: an enumeration whose variants are words of a file of settings;
//! * [`dot`], the scalar product of lists; [`half_cosine`], a smooth start;
//! * [`twelve_digits`]: times without the rounding of their sums.
//!
//! ```
//! use fsi_numerics::{lagrange, quadrature::Rule};
//!
//! // The integral of x⁴ over [-1, 1], by interpolation at the points of a Gauss-Lobatto rule.
//! let (nodes, rule) = (Rule::gauss_lobatto(5), Rule::gauss_legendre(3));
//! let values: Vec<f64> = nodes.points.iter().map(|x| x.powi(4)).collect();
//! let at = |x: f64| -> f64 {
//!     let polynomials = lagrange::values(&nodes.points, x);
//!     polynomials.iter().zip(&values).map(|(l, f)| l * f).sum()
//! };
//! let points = rule.points.iter().zip(&rule.weights);
//! let integral: f64 = points.map(|(&x, weight)| weight * at(x)).sum();
//! assert!((integral - 0.4).abs() < 1e-15);
//! ```

use std::f64::consts::PI;

pub mod lagrange;
mod layers;
pub mod quadrature;
mod words;

pub use layers::Layers;

/// The scalar product, summed from the first entries on.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A vector of space: position or displacement (m), velocity (m/s), traction (Pa).
pub type Vec3 = nalgebra::Vector3<f64>;
/// A second-order tensor of space, such as a deformation gradient or a stress.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// Half a cosine from 0 at the time `t` = 0 to 1 at `duration`, then 1: once continuously differentiable.
pub fn half_cosine(t: f64, duration: f64) -> f64 {
    if t >= duration {
        1.0
    } else {
        0.5 * (1.0 - (PI * t.max(0.0) / duration).cos())
    }
}

/// A time (s) in 12 digits, as OpenFOAM spells it in the names of folders (`timePrecision`): 0.018 where sums of time
/// steps give 0.018000000000000002.
pub fn twelve_digits(time: f64) -> f64 {
    let text = format!("{time:.11e}");
    text.parse().unwrap_or(time)
}

/// Places from 0 to 1 of the nodes of `elements` equal elements in a row, whose own lie at `nodes` in [-1, 1].
pub fn subdivided(elements: usize, nodes: &[f64]) -> Vec<f64> {
    let degree = nodes.len() - 1;
    let place = |i: usize| {
        let (element, node) = (i / degree, i % degree);
        (element as f64 + 0.5 * (1.0 + nodes[node])) / elements as f64
    };
    let mut places: Vec<f64> = (0..=elements * degree).map(place).collect();
    places[elements * degree] = 1.0;
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_spelt_without_the_rounding_of_their_sums() {
        let mut time = 0.0;
        for n in 1..=2000 {
            time = twelve_digits(time + 0.002);
            assert_eq!(time.to_string(), (f64::from(2 * n) / 1000.0).to_string());
        }
        assert_eq!(twelve_digits(0.018000000000000002), 0.018);
        assert_eq!(twelve_digits(0.0), 0.0);
        assert_eq!(twelve_digits(1.0 / 3.0), 0.333333333333);
    }
}
