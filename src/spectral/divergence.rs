//! The matrix `B` of the divergence, `-∫ q_j div v_i`, and that of the Schur complement `B D⁻¹ Bᵀ`, row by row: for
//! pressures, or for sums of these such as the trilinear functions of the corners.

use super::contraction::LANES;
use super::metric::Metric;
use super::spectral_elements::SpectralElements;
use super::taylor_hood_space::TaylorHoodSpace;
use rayon::prelude::*;

/// A row of the lower triangle of a matrix: columns up to the diagonal, which is the last, and values.
pub type TriangleRow = Vec<(u32, f64)>;

/// Part of a row of `B`: the velocity components of a node.
#[derive(Clone, Copy)]
pub struct NodeEntry {
    /// The node.
    pub index: u32,
    /// One value for each component.
    pub values: [f64; 3],
}

/// Functions of the pressure: how many an element has, and for each one where it appears, at `element * count +
/// function`, as [`TaylorHoodSpace::pressure_places`].
pub struct Functions<'a> {
    /// Functions of an element.
    pub count: usize,
    /// Places of function `j` from `starts[j]` on.
    pub starts: &'a [u32],
    /// See `starts`.
    pub places: &'a [u32],
}

impl<'a> Functions<'a> {
    /// The pressure's own.
    pub fn nodal(space: &'a TaylorHoodSpace) -> Self {
        Self {
            count: space.degree.pow(3),
            starts: &space.pressure_starts,
            places: &space.pressure_places,
        }
    }

    /// Element and number in it of each appearance of function `j`.
    pub fn places(&self, j: usize) -> impl Iterator<Item = (usize, usize)> {
        let places = &self.places[self.starts[j] as usize..self.starts[j + 1] as usize];
        let at = |&place: &u32| (place as usize / self.count, place as usize % self.count);
        places.iter().map(at)
    }
}

/// Rows of the elements, `count` after each other in each: `3 (N + 1)³` values, one component after the other.
pub fn element_rows(space: &SpectralElements, metric: &Metric) -> Vec<Vec<f64>> {
    let (n3, m3, p3) = (
        space.node_count(),
        space.gauss_count(),
        space.pressure_count(),
    );
    let gauss = 9 * m3 * LANES;
    let of_groups: Vec<Vec<Vec<f64>>> = (0..space.groups())
        .into_par_iter()
        .map_init(
            || {
                let zeros = |size: usize| vec![0.0; size * LANES];
                (space.kernel.scratch(), zeros(p3), zeros(3 * n3))
            },
            |(scratch, unit, row), group| {
                let lanes = LANES.min(space.space.elements - group * LANES);
                let mut of_lanes = vec![Vec::with_capacity(3 * n3 * p3); lanes];
                let g = &metric.cofactors[gauss * group..gauss * (group + 1)];
                for j in 0..p3 {
                    // Those of the transpose, one unit pressure after the other
                    unit[j * LANES..(j + 1) * LANES].fill(1.0);
                    space.kernel.minus_gradient(g, unit, row, scratch);
                    unit[j * LANES..(j + 1) * LANES].fill(0.0);
                    for (lane, of_lane) in of_lanes.iter_mut().enumerate() {
                        of_lane.extend(row.iter().skip(lane).step_by(LANES));
                    }
                }
                of_lanes
            },
        )
        .collect();
    of_groups.into_iter().flatten().collect()
}

/// Rows of `B` from those of the elements.
pub fn rows(
    space: &TaylorHoodSpace,
    functions: &Functions,
    of_elements: &[Vec<f64>],
) -> Vec<Vec<NodeEntry>> {
    let n3 = (space.degree + 1).pow(3);
    (0..functions.starts.len() - 1)
        .into_par_iter()
        .map_init(
            || vec![u32::MAX; space.nodes],
            |position, j| {
                let mut row: Vec<NodeEntry> = Vec::new();
                for (e, q) in functions.places(j) {
                    let values = &of_elements[e][q * 3 * n3..(q + 1) * 3 * n3];
                    for (i, &node) in space.element(e).iter().enumerate() {
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
                            entry[c] += values[c * n3 + i];
                        }
                    }
                }
                (row.iter()).for_each(|entry| position[entry.index as usize] = u32::MAX);
                row
            },
        )
        .collect()
}

/// Rows of the lower triangle of `B D⁻¹ Bᵀ`, with the inverse of `D` at each node.
pub fn schur_rows(rows: &[Vec<NodeEntry>], inverse_diagonal: &[f64]) -> Vec<TriangleRow> {
    let mut columns: Vec<Vec<NodeEntry>> = vec![Vec::new(); inverse_diagonal.len()];
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
    (rows.par_iter().enumerate())
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
        .collect()
}

/// Entries of one element's pressures in a column of `B`: those of a node outside the element.
type Column = Vec<(usize, [f64; 3])>;

/// Memory for [`block`].
pub struct BlockScratch {
    position: Vec<u32>,
    outside: Vec<Column>,
}

impl BlockScratch {
    /// For the nodes of a space.
    pub fn new(space: &TaylorHoodSpace) -> Self {
        Self {
            position: vec![u32::MAX; space.nodes],
            outside: Vec::new(),
        }
    }
}

/// `B D⁻¹ Bᵀ` of an element's own pressures, with what the elements around add.
pub fn block(
    space: &TaylorHoodSpace,
    of_elements: &[Vec<f64>],
    inverse_diagonal: &[f64],
    element: usize,
    scratch: &mut BlockScratch,
) -> faer::Mat<f64> {
    let (n3, p3) = ((space.degree + 1).pow(3), space.degree.pow(3));
    let BlockScratch { position, outside } = scratch;
    for (i, &node) in space.element(element).iter().enumerate() {
        position[node as usize] = i as u32;
    }
    // Entries at the element's own nodes fill a matrix; those of other nodes, few in each column, are listed
    let mut inside = faer::Mat::<f64>::zeros(p3, 3 * n3);
    let mut met = Vec::new();
    let functions = Functions::nodal(space);
    for (row, &j) in space.element_pressures(element).iter().enumerate() {
        for (e, q) in functions.places(j as usize) {
            let values = &of_elements[e][q * 3 * n3..(q + 1) * 3 * n3];
            for (i, &node) in space.element(e).iter().enumerate() {
                let root = inverse_diagonal[node as usize].sqrt();
                if root == 0.0 {
                    continue;
                }
                let entry = [0, 1, 2].map(|c| values[c * n3 + i] * root);
                let at = &mut position[node as usize];
                if (*at as usize) < n3 {
                    (0..3).for_each(|c| inside[(row, c * n3 + *at as usize)] += entry[c]);
                    continue;
                }
                if *at == u32::MAX {
                    *at = (n3 + met.len()) as u32;
                    met.push(node);
                    if outside.len() < met.len() {
                        outside.push(Column::new());
                    }
                }
                let column = &mut outside[*at as usize - n3];
                match column.last_mut().filter(|last| last.0 == row) {
                    Some((_, sum)) => (0..3).for_each(|c| sum[c] += entry[c]),
                    None => column.push((row, entry)),
                }
            }
        }
    }
    let mut block = &inside * inside.transpose();
    for column in &mut outside[..met.len()] {
        for (i, a) in column.iter() {
            for (j, b) in column.iter() {
                block[(*i, *j)] += a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            }
        }
        column.clear();
    }
    let touched = space.element(element).iter().chain(&met);
    touched.for_each(|&node| position[node as usize] = u32::MAX);
    block
}
