//! The geometry of the elements at a moment: what the integrals need at the Gauss points, and the nodes' masses.

use super::FlowError;
use super::contraction::LANES;
use super::rheology::ViscosityField;
use super::spectral_elements::SpectralElements;
use rayon::prelude::*;

/// The mapping of every element, in groups of [`LANES`] side by side.
#[derive(Debug, Clone)]
pub struct Metric {
    /// `G = w det J ∂ξ_d/∂x_k` at the Gauss points: `9 M³` values an element, component `3 d + k` after the other.
    pub cofactors: Vec<f64>,
    /// `G Gᵀ/(w det J)`: components 00, 01, 02, 11, 12, 22.
    pub stiffness: Vec<f64>,
    /// Integral of each nodal function by the nodes' own rule, m³: the diagonal mass matrix.
    pub mass: Vec<f64>,
    /// Volumes of the elements by the Gauss rule, m³.
    pub volumes: Vec<f64>,
    /// Their sum, m³.
    pub volume: f64,
}

/// Tangents `∂x/∂ξ_d` at points, `[x, y, z]` of each.
struct Tangents<'a>([[&'a [f64]; 3]; 3]);

impl Tangents<'_> {
    fn at(&self, i: usize) -> [[f64; 3]; 3] {
        self.0.map(|components| components.map(|values| values[i]))
    }
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Metric {
    /// For nodes at `positions` (m, one component after the other).
    ///
    /// # Errors
    /// If an element is inside out.
    pub fn new(space: &SpectralElements, positions: &[f64]) -> Result<Self, FlowError> {
        let (n3, m3) = (space.node_count() * LANES, space.gauss_count() * LANES);
        let groups = space.groups();
        let mut cofactors = vec![0.0; groups * 9 * m3];
        let mut stiffness = vec![0.0; groups * 6 * m3];
        let mut local_mass = vec![0.0; groups * n3];
        // Volume and smallest Jacobian of the elements
        let found: Vec<[[f64; 2]; LANES]> = cofactors
            .par_chunks_mut(9 * m3)
            .zip(stiffness.par_chunks_mut(6 * m3))
            .zip(local_mass.par_chunks_mut(n3))
            .enumerate()
            .map_init(
                || {
                    let tangents = [(); 9].map(|()| vec![0.0; m3]);
                    (space.kernel.scratch(), vec![0.0; 3 * n3], tangents)
                },
                |(scratch, x, tangents), (group, ((cofactors, stiffness), mass))| {
                    space.gather_group(group, positions, x);
                    let components = || x.chunks_exact(n3);
                    for (x, out) in components().zip(tangents.chunks_exact_mut(3)) {
                        let [a, b, c] = out else { unreachable!() };
                        (space.kernel).gradient(x, [a, b, c], scratch);
                    }
                    let mut found = [[0.0, f64::INFINITY]; LANES];
                    let at = by_direction(tangents);
                    for q in 0..m3 {
                        let [a, b, c] = at.at(q);
                        let weight = space.gauss_weights[q / LANES];
                        let g = [cross(b, c), cross(c, a), cross(a, b)];
                        let determinant = dot(a, g[0]);
                        let inverse = weight / determinant;
                        for d in 0..3 {
                            for k in 0..3 {
                                cofactors[(3 * d + k) * m3 + q] = weight * g[d][k];
                            }
                        }
                        for (i, (d, e)) in PAIRS.into_iter().enumerate() {
                            stiffness[i * m3 + q] = inverse * dot(g[d], g[e]);
                        }
                        note(&mut found[q % LANES], determinant);
                        found[q % LANES][0] += weight * determinant;
                    }
                    for (x, out) in components().zip(tangents.chunks_exact_mut(3)) {
                        let [a, b, c] = out else { unreachable!() };
                        (space.kernel).nodal_gradient(x, [a, b, c]);
                    }
                    let at = by_direction(tangents);
                    for (i, mass) in mass.iter_mut().enumerate() {
                        let [a, b, c] = at.at(i);
                        let determinant = dot(a, cross(b, c));
                        note(&mut found[i % LANES], determinant);
                        *mass = space.node_weights[i / LANES] * determinant;
                    }
                    found
                },
            )
            .collect();
        let elements = &found.as_flattened()[..space.space.elements];
        let inverted = |[_, jacobian]: &[f64; 2]| jacobian.is_nan() || *jacobian <= 0.0;
        if let Some(e) = elements.iter().position(inverted) {
            let nodes = space.space.element(e);
            let middle = nodes[nodes.len() / 2] as usize;
            return Err(FlowError::Inverted {
                element: e,
                jacobian: elements[e][1],
                position: [0, 1, 2].map(|c| positions[c * space.space.nodes + middle]),
            });
        }
        let volumes: Vec<f64> = elements.iter().map(|[volume, _]| *volume).collect();
        let mut mass = vec![0.0; space.space.nodes];
        space.sum_nodes(&local_mass, &mut mass);
        Ok(Self {
            cofactors,
            stiffness,
            mass,
            volume: volumes.iter().sum(),
            volumes,
        })
    }

    /// `density G a` at the Gauss points for the convecting velocity `a` (m/s) at the nodes: `3 M³` values an element.
    pub fn convection(&self, space: &SpectralElements, density: f64, a: &[f64]) -> Vec<f64> {
        let (n3, m3) = (space.node_count() * LANES, space.gauss_count() * LANES);
        let mut convection = vec![0.0; space.groups() * 3 * m3];
        convection
            .par_chunks_mut(3 * m3)
            .zip(self.cofactors.par_chunks(9 * m3))
            .enumerate()
            .for_each_init(
                || (space.kernel.scratch(), vec![0.0; 3 * n3], vec![0.0; 3 * m3]),
                |(scratch, nodal, at_gauss), (group, (convection, g))| {
                    space.gather_group(group, a, nodal);
                    for (nodal, at_gauss) in
                        nodal.chunks_exact(n3).zip(at_gauss.chunks_exact_mut(m3))
                    {
                        space.kernel.to_gauss(nodal, at_gauss, scratch);
                    }
                    for (convection, g) in
                        convection.chunks_exact_mut(m3).zip(g.chunks_exact(3 * m3))
                    {
                        for q in 0..m3 {
                            let at = |k: usize| g[k * m3 + q] * at_gauss[k * m3 + q];
                            convection[q] = density * (at(0) + at(1) + at(2));
                        }
                    }
                },
            );
        convection
    }

    /// Diagonal of the viscous stresses, `∫ mu |∇v_i|²`, for each node, Pa s m.
    pub fn viscous_diagonal(
        &self,
        space: &SpectralElements,
        viscosity: &ViscosityField,
    ) -> Vec<f64> {
        match viscosity {
            ViscosityField::Constant(viscosity) => {
                let mut diagonal = self.laplacian_diagonal(space, &self.stiffness);
                diagonal.iter_mut().for_each(|d| *d *= viscosity);
                diagonal
            }
            ViscosityField::AtGauss(viscosity) => {
                let m3 = space.gauss_count() * LANES;
                let mut stiffness = self.stiffness.clone();
                for (stiffness, viscosity) in
                    (stiffness.chunks_exact_mut(6 * m3)).zip(viscosity.chunks_exact(m3))
                {
                    for (k, s) in stiffness.iter_mut().enumerate() {
                        *s *= viscosity[k % m3];
                    }
                }
                self.laplacian_diagonal(space, &stiffness)
            }
        }
    }

    /// `∫ |∇v_i|²` for each node, m, of this `stiffness`.
    fn laplacian_diagonal(&self, space: &SpectralElements, stiffness: &[f64]) -> Vec<f64> {
        let (n3, m3) = (space.node_count(), space.gauss_count());
        let (n, m) = (space.basis.nodes.len(), space.basis.gauss.len());
        // Squares and products of the one-dimensional functions and their slopes at the Gauss points
        let values = &space.basis.to_gauss;
        let slopes: Vec<Vec<f64>> = (space.basis.gauss.points.iter())
            .map(|&x| fsi_numerics::lagrange::derivatives(&space.basis.nodes.points, x))
            .collect();
        let product = |q: usize, i: usize, kind: usize| match kind {
            0 => values[q][i] * values[q][i],
            1 => values[q][i] * slopes[q][i],
            _ => slopes[q][i] * slopes[q][i],
        };
        let mut local = vec![0.0; space.groups() * n3 * LANES];
        local
            .par_chunks_mut(n3 * LANES)
            .zip(stiffness.par_chunks(6 * m3 * LANES))
            .for_each(|(diagonal, stiffness)| {
                for d in 0..3 {
                    for d2 in 0..3 {
                        let kind = |axis: usize| usize::from(d == axis) + usize::from(d2 == axis);
                        let pair = (d.min(d2), d.max(d2));
                        let i = PAIRS.iter().position(|&p| p == pair).expect("all pairs");
                        let size = m3 * LANES;
                        let mut value = stiffness[i * size..(i + 1) * size].to_vec();
                        // One direction after the other, the slowest first
                        let mut sizes = [m, m, m];
                        for axis in [2, 1, 0] {
                            let inner = LANES * sizes[..axis].iter().product::<usize>();
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

/// Components of a symmetric tensor.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// Gradients of the three components of the position, by direction.
fn by_direction(tangents: &[Vec<f64>; 9]) -> Tangents<'_> {
    Tangents(std::array::from_fn(|d| {
        std::array::from_fn(|k| &tangents[3 * k + d][..])
    }))
}

/// Keeps the smallest Jacobian, or one that is not a number.
fn note(found: &mut [f64; 2], determinant: f64) {
    if determinant.is_nan() || determinant < found[1] {
        found[1] = determinant;
    }
}
