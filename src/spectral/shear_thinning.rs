//! Blood whose viscosity depends on the rate of shear `γ = sqrt(2 D:D)`: the viscosity at the Gauss points, and the
//! part of the viscous stress that the operator of a constant viscosity leaves out.
//!
//! `div(2 mu D) = div(mu ∇u) + (∇u)ᵀ ∇mu` where `div u = 0`; the second term is a force, known from the extrapolated
//! velocity as the viscosity is. It vanishes in developed flow, also where that leaves through an outlet.

use super::contraction::LANES;
use super::metric::Metric;
use super::spectral_elements::SpectralElements;
use crate::rheology::Rheology;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// The viscosity of a flow.
pub struct VariableViscosity {
    /// Dynamic viscosity at the Gauss points, Pa s: `M³` values an element, [`LANES`] elements side by side.
    pub at_gauss: Vec<f64>,
    /// `∫ v_i · (∇u)ᵀ ∇mu`, N, one component after the other.
    pub force: Vec<f64>,
}

impl VariableViscosity {
    /// For a velocity (m/s) at the nodes.
    pub fn new(space: &SpectralElements, metric: &Metric, rheology: &Rheology, u: &[f64]) -> Self {
        let (n3, m3) = (space.node_count() * LANES, space.gauss_count() * LANES);
        let groups = space.groups();
        let mut at_gauss = vec![0.0; groups * m3];
        let mut local_force = vec![0.0; groups * 3 * n3];
        at_gauss
            .par_chunks_mut(m3)
            .zip(local_force.par_chunks_mut(3 * n3))
            .enumerate()
            .for_each_init(
                || {
                    let gradients = [(); 9].map(|()| vec![0.0; m3]);
                    (space.kernel.scratch(), vec![0.0; 3 * n3], gradients)
                },
                |(scratch, local, gradients), (group, (viscosity, force))| {
                    space.gather_group(group, u, local);
                    for (u, out) in local.chunks_exact(n3).zip(gradients.chunks_exact_mut(3)) {
                        let [a, b, c] = out else { unreachable!() };
                        space.kernel.gradient(u, [a, b, c], scratch);
                    }
                    let g = &metric.cofactors[9 * m3 * group..9 * m3 * (group + 1)];
                    let inverse = |q: usize| Inverse::new(g, m3, q, space.gauss_weights[q / LANES]);
                    let of_velocity = |q: usize| {
                        // ∂u_i/∂ξ_d
                        Matrix3::from_fn(|i, d| gradients[3 * i + d][q])
                    };
                    for q in 0..m3 {
                        let gradient = of_velocity(q) * inverse(q).matrix;
                        viscosity[q] = rheology.viscosity(rate_of_shear(&gradient));
                    }
                    let slopes = gauss_gradient(space, viscosity);
                    let mut at_points = vec![0.0; 3 * m3];
                    for q in 0..m3 {
                        let Inverse { matrix, volume } = inverse(q);
                        let gradient = of_velocity(q) * matrix;
                        let slope = matrix.transpose()
                            * crate::Vec3::new(slopes[0][q], slopes[1][q], slopes[2][q]);
                        let f = gradient.transpose() * slope * volume;
                        for c in 0..3 {
                            at_points[c * m3 + q] = f[c];
                        }
                    }
                    for (out, at) in force.chunks_exact_mut(n3).zip(at_points.chunks_exact(m3)) {
                        integrate(space, at, out);
                    }
                },
            );
        let mut force = vec![0.0; 3 * space.space.nodes];
        space.sum_vectors(&local_force, &mut force, |_, sums, force| {
            (force.into_iter().zip(sums)).for_each(|(force, sum)| *force = sum);
        });
        Self { at_gauss, force }
    }
}

/// `sqrt(2 D:D)` (1/s) of a gradient `∂u_i/∂x_j` (1/s).
pub fn rate_of_shear(gradient: &Matrix3<f64>) -> f64 {
    let twice = gradient + gradient.transpose();
    (0.5 * twice.norm_squared()).sqrt()
}

/// The inverse of the mapping at a Gauss point.
struct Inverse {
    /// `∂ξ_d/∂x_k`.
    matrix: Matrix3<f64>,
    /// Volume with the quadrature weight, m³.
    volume: f64,
}

impl Inverse {
    /// From `G = w det J J⁻¹`, whose determinant is `w³ (det J)²`.
    fn new(cofactors: &[f64], m3: usize, q: usize, weight: f64) -> Self {
        let g = Matrix3::from_fn(|d, k| cofactors[(3 * d + k) * m3 + q]);
        let volume = (g.determinant() / weight).sqrt();
        Self {
            matrix: g / volume,
            volume,
        }
    }
}

/// Derivatives along the three local directions of values at the Gauss points of a group of elements.
fn gauss_gradient(space: &SpectralElements, values: &[f64]) -> [Vec<f64>; 3] {
    let m = space.basis.gauss.len();
    let rows = &space.basis.gauss_derivative;
    [1, m, m * m].map(|stride| {
        let mut out = vec![0.0; values.len()];
        for q in 0..m * m * m {
            let i = q / stride % m;
            for (j, slope) in rows[i].iter().enumerate() {
                let from = q + j * stride - i * stride;
                for lane in 0..LANES {
                    out[q * LANES + lane] += slope * values[from * LANES + lane];
                }
            }
        }
        out
    })
}

/// `sum_q φ_i(q) f_q` for each node of a group of elements.
fn integrate(space: &SpectralElements, at_gauss: &[f64], out: &mut [f64]) {
    let (n, m) = (space.basis.nodes.len(), space.basis.gauss.len());
    let values = &space.basis.to_gauss;
    let mut sizes = [m, m, m];
    let mut value = at_gauss.to_vec();
    for axis in [2, 1, 0] {
        let inner = LANES * sizes[..axis].iter().product::<usize>();
        let outer: usize = sizes[axis + 1..].iter().product();
        let mut next = vec![0.0; outer * n * inner];
        for o in 0..outer {
            for i in 0..n {
                for (q, row) in values.iter().enumerate() {
                    for r in 0..inner {
                        next[(o * n + i) * inner + r] += row[i] * value[(o * m + q) * inner + r];
                    }
                }
            }
        }
        sizes[axis] = n;
        value = next;
    }
    out.copy_from_slice(&value);
}
