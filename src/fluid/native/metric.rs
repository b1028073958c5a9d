//! The geometry of the elements at a moment: what the integrals need at the Gauss points, and the nodes' masses.

use super::FlowError;
use super::discretization::Discretization;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// The mapping of every element.
#[derive(Debug, Clone)]
pub struct Metric {
    /// `w det J ∂ξ_d/∂x_k` at the Gauss points: `9 M³` values an element, component `3 d + k` after the other.
    pub cofactors: Vec<f64>,
    /// `1/(w det J)`: `M³` values an element.
    pub inverse_weights: Vec<f64>,
    /// Integral of each nodal function by the nodes' own rule, m³: the diagonal mass matrix.
    pub mass: Vec<f64>,
    /// Volume by the Gauss rule, m³.
    pub volume: f64,
}

impl Metric {
    /// For nodes at `positions` (m, one component after the other).
    ///
    /// # Errors
    /// If an element is inside out.
    pub fn new(space: &Discretization, positions: &[f64]) -> Result<Self, FlowError> {
        let (n3, m3) = (space.node_count(), space.gauss_count());
        let elements = space.space.elements;
        let mut cofactors = vec![0.0; elements * 9 * m3];
        let mut inverse_weights = vec![0.0; elements * m3];
        let mut local_mass = vec![0.0; elements * n3];
        let found: Vec<Result<f64, (usize, f64)>> = cofactors
            .par_chunks_mut(9 * m3)
            .zip(inverse_weights.par_chunks_mut(m3))
            .zip(local_mass.par_chunks_mut(n3))
            .enumerate()
            .map_init(
                || (space.kernel.scratch(), vec![0.0; 3 * n3], vec![0.0; 9 * m3]),
                |(scratch, x, tangents), (e, ((cofactors, inverse), mass))| {
                    space.gather(e, positions, x);
                    for (c, tangents) in tangents.chunks_exact_mut(3 * m3).enumerate() {
                        let (first, rest) = tangents.split_at_mut(m3);
                        let (second, third) = rest.split_at_mut(m3);
                        let x = &x[c * n3..(c + 1) * n3];
                        (space.kernel).gradient(x, &mut [first, second, third], scratch);
                    }
                    let mut volume = 0.0;
                    for q in 0..m3 {
                        let jacobian = Matrix3::from_fn(|k, d| tangents[(3 * k + d) * m3 + q]);
                        let determinant = jacobian.determinant();
                        if determinant.is_nan() || determinant <= 0.0 {
                            return Err((e, determinant));
                        }
                        let weight = space.gauss_weights[q];
                        let [a, b, c] = [0, 1, 2].map(|d| jacobian.column(d).into_owned());
                        for (d, row) in [b.cross(&c), c.cross(&a), a.cross(&b)].iter().enumerate() {
                            for k in 0..3 {
                                cofactors[(3 * d + k) * m3 + q] = weight * row[k];
                            }
                        }
                        inverse[q] = 1.0 / (weight * determinant);
                        volume += weight * determinant;
                    }
                    for i in 0..n3 {
                        let determinant = space.jacobian_at_node(x, i).determinant();
                        if determinant.is_nan() || determinant <= 0.0 {
                            return Err((e, determinant));
                        }
                        mass[i] = space.node_weights[i] * determinant;
                    }
                    Ok(volume)
                },
            )
            .collect();
        let mut volume = 0.0;
        for element in found {
            match element {
                Ok(part) => volume += part,
                Err((e, jacobian)) => {
                    let nodes = space.space.element(e);
                    let middle = nodes[nodes.len() / 2] as usize;
                    return Err(FlowError::Inverted {
                        element: e,
                        jacobian,
                        position: [0, 1, 2].map(|c| positions[c * space.space.nodes + middle]),
                    });
                }
            }
        }
        let mut mass = vec![0.0; space.space.nodes];
        space.sum_nodes(&local_mass, &mut mass);
        Ok(Self {
            cofactors,
            inverse_weights,
            mass,
            volume,
        })
    }

    /// `density G a` at the Gauss points for the convecting velocity `a` (m/s) at the nodes: `3 M³` values an element.
    pub fn convection(&self, space: &Discretization, density: f64, a: &[f64]) -> Vec<f64> {
        let (n3, m3) = (space.node_count(), space.gauss_count());
        let mut convection = vec![0.0; space.space.elements * 3 * m3];
        convection
            .par_chunks_mut(3 * m3)
            .zip(self.cofactors.par_chunks(9 * m3))
            .enumerate()
            .for_each_init(
                || (space.kernel.scratch(), vec![0.0; 3 * n3], vec![0.0; 3 * m3]),
                |(scratch, nodal, a_gauss), (e, (convection, g))| {
                    space.gather(e, a, nodal);
                    for c in 0..3 {
                        let out = &mut a_gauss[c * m3..(c + 1) * m3];
                        (space.kernel).to_gauss(&nodal[c * n3..(c + 1) * n3], out, scratch);
                    }
                    for d in 0..3 {
                        for q in 0..m3 {
                            let at = |k: usize| g[(3 * d + k) * m3 + q] * a_gauss[k * m3 + q];
                            convection[d * m3 + q] = density * (at(0) + at(1) + at(2));
                        }
                    }
                },
            );
        convection
    }

    /// Diagonal of the Laplacian, `∫ |∇v_i|²`, for each node, m.
    pub fn laplacian_diagonal(&self, space: &Discretization) -> Vec<f64> {
        let (n3, m3) = (space.node_count(), space.gauss_count());
        let (n, m) = (space.basis.nodes.len(), space.basis.gauss.len());
        // Squares and products of the one-dimensional functions and their slopes at the Gauss points
        let values = &space.basis.to_gauss;
        let slopes: Vec<Vec<f64>> = (space.basis.gauss.points.iter())
            .map(|&x| super::basis::lagrange_derivatives(&space.basis.nodes.points, x))
            .collect();
        let product = |q: usize, i: usize, kind: usize| match kind {
            0 => values[q][i] * values[q][i],
            1 => values[q][i] * slopes[q][i],
            _ => slopes[q][i] * slopes[q][i],
        };
        let mut local = vec![0.0; space.space.elements * n3];
        local
            .par_chunks_mut(n3)
            .zip(self.cofactors.par_chunks(9 * m3))
            .zip(self.inverse_weights.par_chunks(m3))
            .for_each(|((diagonal, g), inverse)| {
                for d in 0..3 {
                    for d2 in 0..3 {
                        let kind = |axis: usize| usize::from(d == axis) + usize::from(d2 == axis);
                        let mut value: Vec<f64> = (0..m3)
                            .map(|q| {
                                let g = |d: usize, k: usize| g[(3 * d + k) * m3 + q];
                                inverse[q] * (0..3).map(|k| g(d, k) * g(d2, k)).sum::<f64>()
                            })
                            .collect();
                        // One direction after the other, the slowest first
                        let mut sizes = [m, m, m];
                        for axis in [2, 1, 0] {
                            let inner: usize = sizes[..axis].iter().product();
                            let outer: usize = sizes[axis + 1..].iter().product();
                            let mut next = vec![0.0; outer * n * inner];
                            for o in 0..outer {
                                for i in 0..n {
                                    for q in 0..m {
                                        let c = product(q, i, kind(axis));
                                        for r in 0..inner {
                                            next[(o * n + i) * inner + r] +=
                                                c * value[(o * m + q) * inner + r];
                                        }
                                    }
                                }
                            }
                            sizes[axis] = n;
                            value = next;
                        }
                        diagonal.iter_mut().zip(&value).for_each(|(d, v)| *d += v);
                    }
                }
            });
        let mut diagonal = vec![0.0; space.space.nodes];
        space.sum_nodes(&local, &mut diagonal);
        diagonal
    }
}
