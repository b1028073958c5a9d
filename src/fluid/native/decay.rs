//! How much of the velocity stands in the highest polynomials of the elements: where that is much, the next ones would
//! matter too (Mavriplis 1989; Willberg's and others' error indicators of spectral elements).

use super::spectral_elements::SpectralElements;
use crate::fluid::HighestModes;
use rayon::prelude::*;

/// Mean squares of the velocity (one component after the other, m/s) in each element: of its Legendre polynomials of
/// the highest degree along any local axis, and of all of it. In local coordinates, by the nodes' own rule.
pub fn highest_modes(space: &SpectralElements, velocity: &[f64]) -> Vec<HighestModes> {
    let rule = &space.basis.nodes;
    let (n, degree) = (rule.len(), space.basis.degree());
    // The coefficient of the highest polynomial on a line is the sum of these times the nodal values: the nodes' rule
    // takes its square to be 2/N, where it is 2/(2N + 1).
    let onto: Vec<f64> = (rule.points.iter().zip(&rule.weights))
        .map(|(&x, w)| 0.5 * degree as f64 * w * legendre(degree, x))
        .collect();
    let square = 2.0 / (2 * degree + 1) as f64;
    let of_element = |e: usize| {
        let mut local = vec![0.0; 3 * space.node_count()];
        space.gather(e, velocity, &mut local);
        let mut found = HighestModes::default();
        for values in local.chunks_exact(space.node_count()) {
            let weighted = space.node_weights.iter().zip(values);
            found.all += weighted.map(|(w, u)| w * u * u).sum::<f64>();
            for stride in [1, n, n * n] {
                for i in 0..n {
                    for j in 0..n {
                        // The lines along one axis begin where its index is 0.
                        let first = match stride {
                            1 => n * (i + n * j),
                            s if s == n => i + n * n * j,
                            _ => i + n * j,
                        };
                        let nodal = onto.iter().enumerate();
                        let c: f64 = nodal.map(|(k, f)| f * values[first + k * stride]).sum();
                        found.highest += rule.weights[i] * rule.weights[j] * square * c * c;
                    }
                }
            }
        }
        // The cube of local coordinates has the volume 8.
        HighestModes {
            highest: found.highest / 8.0,
            all: found.all / 8.0,
        }
    };
    (0..space.space.elements)
        .into_par_iter()
        .map(of_element)
        .collect()
}

/// Legendre's polynomial.
fn legendre(degree: usize, x: f64) -> f64 {
    let (mut before, mut last) = (1.0, x);
    for n in 1..degree {
        let n = n as f64;
        (before, last) = (last, ((2.0 * n + 1.0) * x * last - n * before) / (n + 1.0));
    }
    if degree == 0 { before } else { last }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fluid::native::taylor_hood_space::{Plane, TaylorHoodSpace};
    use approx::assert_relative_eq;

    #[test]
    fn only_the_highest_polynomial_of_each_axis_counts() {
        let degree = 4;
        let plane = |degree| Plane::grid([1, 1], degree);
        let space = TaylorHoodSpace::swept(&plane(degree), &plane(degree - 1), degree, 1);
        let space = SpectralElements::new(space).unwrap();
        let at = &space.basis.nodes.points;
        let field = |f: &dyn Fn(f64, f64, f64) -> f64| -> Vec<f64> {
            let n = at.len();
            let mut values = vec![0.0; 3 * space.space.nodes];
            for (k, &node) in space.space.element(0).iter().enumerate() {
                values[space.space.nodes + node as usize] =
                    f(at[k % n], at[k / n % n], at[k / n / n]);
            }
            values
        };
        let smooth = highest_modes(&space, &field(&|x, y, z| x.powi(3) * y - z.powi(2)));
        assert!(smooth[0].highest < 1e-28 * smooth[0].all);
        // Mean squares over the cube: 1/9 of P4, 1/3 of z
        type F = fn(f64, f64, f64) -> f64;
        let fields: [F; 3] = [
            |x, _, z| 3.0 * legendre(4, x) + z,
            |x, y, _| 3.0 * legendre(4, y) + x,
            |_, y, z| 3.0 * legendre(4, z) + y,
        ];
        for f in fields {
            let found = highest_modes(&space, &field(&f))[0];
            assert_relative_eq!(found.highest, 1.0, max_relative = 1e-12);
        }
    }
}
