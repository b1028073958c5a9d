//! The coarse level of the Schur complement.

use super::super::contraction::LANES;
use super::super::divergence::{Functions, TriangleRow, rows, schur_rows};
use super::super::spectral_elements::{CHUNK, SpectralElements};
use super::super::taylor_hood_space::inverse;
use super::{NotPositive, add_sums};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::cholesky::{
    LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, Triplet};
use faer::{Conj, MatMut, Par, Side};
use rayon::prelude::*;

/// Corners of an element.
const CORNERS: usize = 8;

/// The trilinear functions of the corners, whose equations are solved by a sparse factor.
pub(super) struct Corners {
    /// Numbers of the corners of groups of elements, lane by lane.
    of_group: Vec<u32>,
    /// Where each corner appears: slots of `of_group` from `starts[i]` on.
    starts: Vec<u32>,
    slots: Vec<u32>,
    /// Values of the corners' functions at the nodes of an element.
    values: Vec<[f64; CORNERS]>,
    /// One over the number of elements that share each unknown.
    shares: Vec<f64>,
    factor: SparseFactor,
}

impl Corners {
    pub fn new(
        space: &SpectralElements,
        of_elements: &[Vec<f64>],
        inverse_diagonal: &[f64],
    ) -> Result<Self, NotPositive> {
        let numbering = &space.space;
        let values = trilinear(&space.basis.pressure_nodes.points);
        let (of_element, count) = corners(space);
        let (starts, places) = inverse(&of_element, count);
        // Rows of the matrix of the divergence for the corners, then as for the pressure's own unknowns
        let size = 3 * space.node_count();
        let of_corners: Vec<Vec<f64>> = (of_elements.par_iter())
            .map(|own| {
                let mut rows = vec![0.0; CORNERS * size];
                for (own, shares) in own.chunks_exact(size).zip(&values) {
                    for (row, share) in rows.chunks_exact_mut(size).zip(shares) {
                        row.iter_mut()
                            .zip(own)
                            .for_each(|(row, own)| *row += share * own);
                    }
                }
                rows
            })
            .collect();
        let functions = Functions {
            count: CORNERS,
            starts: &starts,
            places: &places,
        };
        let rows = rows(numbering, &functions, &of_corners);
        let factor = SparseFactor::new(&schur_rows(&rows, inverse_diagonal))?;
        let slot = |&place: &u32| {
            let (element, corner) = (place as usize / CORNERS, place as usize % CORNERS);
            ((element / LANES * CORNERS + corner) * LANES + element % LANES) as u32
        };
        let of_group = (0..space.groups() * CORNERS * LANES).map(|slot| {
            let (row, lane) = (slot / LANES, slot % LANES);
            let element = (row / CORNERS * LANES + lane).min(numbering.elements - 1);
            of_element[element * CORNERS + row % CORNERS]
        });
        let shared = numbering.pressure_starts.windows(2);
        Ok(Self {
            of_group: of_group.collect(),
            slots: places.iter().map(slot).collect(),
            starts,
            values,
            shares: shared
                .map(|ends| f64::from(ends[1] - ends[0]).recip())
                .collect(),
            factor,
        })
    }

    /// Adds the correction for a residual `r`, `scale` times, to `x`; `local` is memory for the results of the
    /// elements.
    pub fn add(
        &self,
        space: &SpectralElements,
        r: &[f64],
        scale: f64,
        local: &mut [f64],
        x: &mut [f64],
    ) {
        let p3 = space.pressure_count() * LANES;
        let weighted: Vec<f64> = (r.par_iter().zip(&self.shares).with_min_len(CHUNK))
            .map(|(r, share)| r * share * scale)
            .collect();
        let mut of_corners = vec![0.0; self.of_group.len()];
        (of_corners.par_chunks_mut(CORNERS * LANES).enumerate()).for_each_init(
            || vec![0.0; p3],
            |own, (group, corners)| {
                space.gather_pressures(group, &weighted, own);
                for (own, shares) in own.chunks_exact(LANES).zip(&self.values) {
                    for (corner, share) in corners.chunks_exact_mut(LANES).zip(shares) {
                        (0..LANES).for_each(|lane| corner[lane] += share * own[lane]);
                    }
                }
            },
        );
        let mut coarse: Vec<f64> = (self.starts.par_windows(2).with_min_len(CHUNK))
            .map(|ends| {
                let slots = &self.slots[ends[0] as usize..ends[1] as usize];
                slots.iter().map(|&slot| of_corners[slot as usize]).sum()
            })
            .collect();
        self.factor.solve(&mut coarse);
        (local
            .par_chunks_mut(p3)
            .zip(self.of_group.par_chunks(CORNERS * LANES)))
        .for_each(|(local, numbers)| {
            for (local, shares) in local.chunks_exact_mut(LANES).zip(&self.values) {
                local.fill(0.0);
                for (numbers, share) in numbers.chunks_exact(LANES).zip(shares) {
                    let values = local.iter_mut().zip(numbers);
                    values.for_each(|(local, &i)| *local += share * coarse[i as usize]);
                }
            }
        });
        add_sums(space, local, &self.shares, x);
    }
}

/// Values of the eight trilinear functions at the nodes of an element with these points along each direction.
fn trilinear(points: &[f64]) -> Vec<[f64; CORNERS]> {
    let n = points.len();
    let at = |node: usize| [node % n, node / n % n, node / n / n].map(|i| points[i]);
    let value = |place: [f64; 3], corner: usize| -> f64 {
        let sign = |axis: usize| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
        (0..3)
            .map(|axis| 0.5 * (1.0 + sign(axis) * place[axis]))
            .product()
    };
    let nodes = (0..n.pow(3)).map(at);
    nodes
        .map(|place| std::array::from_fn(|corner| value(place, corner)))
        .collect()
}

/// Numbers of the corners of each element, and how many there are.
fn corners(space: &SpectralElements) -> (Vec<u32>, usize) {
    let numbering = &space.space;
    let n = numbering.degree;
    let steps = [1, n, n * n].map(|stride| (n - 1) * stride);
    let places: [usize; CORNERS] =
        std::array::from_fn(|corner| (0..3).map(|axis| (corner >> axis & 1) * steps[axis]).sum());
    let unknowns_of = |e: usize| places.map(|i| numbering.element_pressures(e)[i] as usize);
    let mut unknowns: Vec<usize> = (0..numbering.elements).flat_map(unknowns_of).collect();
    unknowns.sort_unstable();
    unknowns.dedup();
    let mut number = vec![u32::MAX; numbering.pressures];
    (unknowns.iter().enumerate()).for_each(|(i, &unknown)| number[unknown] = i as u32);
    let of_element = (0..numbering.elements)
        .flat_map(unknowns_of)
        .map(|unknown| number[unknown]);
    (of_element.collect(), unknowns.len())
}

/// Sums over rows that are smaller than this, relative to the diagonal, are taken for zero.
const ROUNDING: f64 = 1e-9;

/// A sparse Cholesky factor, of one thread so that it does not depend on their number.
struct SparseFactor {
    structure: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl SparseFactor {
    /// Of the matrix with these rows of its lower triangle, whose null space, if it has one, are the constants.
    fn new(rows: &[TriangleRow]) -> Result<Self, NotPositive> {
        let mut sums = vec![0.0; rows.len()];
        for (i, row) in rows.iter().enumerate() {
            for &(j, value) in row {
                sums[i] += value;
                if j as usize != i {
                    sums[j as usize] += value;
                }
            }
        }
        let of_rows = sums.iter().zip(rows);
        let is_zero = |(sum, row): (&f64, &TriangleRow)| {
            row.last()
                .is_none_or(|(_, diagonal)| sum.abs() < ROUNDING * diagonal)
        };
        if of_rows.into_iter().all(is_zero) {
            return Err(NotPositive);
        }
        let entries: Vec<Triplet<usize, usize, f64>> = (rows.iter().enumerate())
            .flat_map(|(i, row)| {
                row.iter()
                    .map(move |&(j, value)| Triplet::new(i, j as usize, value))
            })
            .collect();
        let matrix = SparseColMat::try_new_from_triplets(rows.len(), rows.len(), &entries);
        let matrix = matrix.map_err(|_| NotPositive)?;
        let order = SymmetricOrdering::Amd;
        let structure =
            factorize_symbolic_cholesky(matrix.symbolic(), Side::Lower, order, Default::default());
        let structure = structure.map_err(|_| NotPositive)?;
        let mut values = vec![0.0; structure.len_val()];
        let memory = structure.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        (structure.factorize_numeric_llt(
            &mut values,
            matrix.as_ref(),
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(memory)),
            Default::default(),
        ))
        .map_err(|_| NotPositive)?;
        Ok(Self { structure, values })
    }

    /// Solves in place.
    fn solve(&self, rhs: &mut [f64]) {
        let rows = rhs.len();
        let memory = self.structure.solve_in_place_scratch::<f64>(1, Par::Seq);
        LltRef::new(&self.structure, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(rhs, rows, 1),
            Par::Seq,
            MemStack::new(&mut MemBuffer::new(memory)),
        );
    }
}
