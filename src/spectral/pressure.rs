//! The preconditioner: the block factorization of the saddle point with the diagonal of the momentum operator.
//!
//! With `D` the diagonal of mass and viscosity, the pressure's Schur complement is `S = B D⁻¹ Bᵀ`, as sparse as a
//! Laplacian on a wider neighbourhood and, at time steps that resolve the flow, close to the true one. Its Cholesky
//! factor is made seldom, for a geometry that is kept until the mesh has moved far from it.

use super::FlowError;
use super::block_cholesky::{BlockCholesky, TriangleRow};
use super::contraction::LANES;
use super::metric::Metric;
use super::spectral_elements::SpectralElements;
use rayon::prelude::*;

/// A factorized Schur complement.
pub struct SchurComplement {
    factor: BlockCholesky,
}

/// Part of the matrix `B`: the velocity components of a node.
#[derive(Clone, Copy)]
struct NodeEntry {
    index: u32,
    values: [f64; 3],
}

impl SchurComplement {
    /// For a geometry and the inverse of `D` at each node, zero where the velocity is prescribed.
    ///
    /// # Errors
    /// If the matrix is not positive definite: the pressure is not fixed by any outlet.
    pub fn new(
        space: &SpectralElements,
        metric: &Metric,
        inverse_diagonal: &[f64],
    ) -> Result<Self, FlowError> {
        let rows = divergence_rows(space, metric);
        let mut columns: Vec<Vec<NodeEntry>> = vec![Vec::new(); space.space.nodes];
        for (j, row) in rows.iter().enumerate() {
            for entry in row {
                if inverse_diagonal[entry.index as usize] > 0.0 {
                    columns[entry.index as usize].push(NodeEntry {
                        index: j as u32,
                        ..*entry
                    });
                }
            }
        }
        let is_free = |entry: &&NodeEntry| inverse_diagonal[entry.index as usize] > 0.0;
        let rows: Vec<TriangleRow> = (rows.par_iter().enumerate())
            .map_init(
                || (vec![0.0; rows.len()], vec![false; rows.len()]),
                |(values, is_met), (i, row)| {
                    let mut met = vec![i as u32];
                    is_met[i] = true;
                    for entry in row.iter().filter(is_free) {
                        let d = inverse_diagonal[entry.index as usize];
                        let [a, b, c] = entry.values.map(|v| v * d);
                        // Rows of a column ascend, and only the lower triangle is wanted
                        let column = columns[entry.index as usize].iter();
                        for other in column.take_while(|other| other.index as usize <= i) {
                            let ([x, y, z], j) = (other.values, other.index as usize);
                            values[j] += a * x + b * y + c * z;
                            if !std::mem::replace(&mut is_met[j], true) {
                                met.push(other.index);
                            }
                        }
                    }
                    met.sort_unstable();
                    let taken = met.into_iter().map(|j| {
                        is_met[j as usize] = false;
                        (j, std::mem::take(&mut values[j as usize]))
                    });
                    taken.collect()
                },
            )
            .collect();
        let factor = BlockCholesky::new(&space.space.pressure_chains, &rows).map_err(|_| {
            FlowError::Model(
                "the pressure's matrix cannot be factorized: is there no outlet?".into(),
            )
        })?;
        Ok(Self { factor })
    }

    /// Solves in place.
    pub fn solve(&self, rhs: &mut [f64]) {
        self.factor.solve(rhs);
    }
}

/// Rows of `-∫ q_j div v_i`.
fn divergence_rows(space: &SpectralElements, metric: &Metric) -> Vec<Vec<NodeEntry>> {
    let (n3, m3, p3) = (
        space.node_count(),
        space.gauss_count(),
        space.pressure_count(),
    );
    // Local rows of each group of elements: those of its transpose, one unit pressure after the other
    let (row_length, gauss) = (3 * n3 * LANES, 9 * m3 * LANES);
    let local: Vec<Vec<f64>> = (0..space.groups())
        .into_par_iter()
        .map_init(
            || (space.kernel.scratch(), vec![0.0; p3 * LANES]),
            |(scratch, unit), group| {
                let g = &metric.cofactors[gauss * group..gauss * (group + 1)];
                let mut rows = vec![0.0; p3 * row_length];
                for (j, row) in rows.chunks_exact_mut(row_length).enumerate() {
                    unit[j * LANES..(j + 1) * LANES].fill(1.0);
                    space.kernel.minus_gradient(g, unit, row, scratch);
                    unit[j * LANES..(j + 1) * LANES].fill(0.0);
                }
                rows
            },
        )
        .collect();
    let numbering = &space.space;
    (0..numbering.pressures)
        .into_par_iter()
        .map_init(
            || vec![u32::MAX; numbering.nodes],
            |position, j| {
                let places = numbering.pressure_starts[j] as usize
                    ..numbering.pressure_starts[j + 1] as usize;
                let mut row: Vec<NodeEntry> = Vec::new();
                for &place in &numbering.pressure_places[places] {
                    let (e, q) = (place as usize / p3, place as usize % p3);
                    let values = &local[e / LANES][q * row_length..(q + 1) * row_length];
                    let lane = e % LANES;
                    for (i, &node) in numbering.element(e).iter().enumerate() {
                        let at = &mut position[node as usize];
                        if *at == u32::MAX {
                            *at = row.len() as u32;
                            row.push(NodeEntry {
                                index: node,
                                values: [0.0; 3],
                            });
                        }
                        let entry = &mut row[*at as usize].values;
                        for c in 0..3 {
                            entry[c] += values[(c * n3 + i) * LANES + lane];
                        }
                    }
                }
                row.iter()
                    .for_each(|entry| position[entry.index as usize] = u32::MAX);
                row
            },
        )
        .collect()
}
