//! Cholesky factor, in single precision, of a matrix whose unknowns lie in planes along a sweep and meet those of the
//! next few planes only.
//!
//! Planes are eliminated from both ends towards the middle, so that two threads work side by side, and each block that
//! meets another is kept as a dense matrix: a solution reads every number of the factor twice, one after the other. The
//! factor is computed in double precision and scaled so that the matrix had ones on its diagonal.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, Par, Side};
use pulp::{Arch, Simd, WithSimd};
use std::collections::{BTreeMap, BTreeSet};

/// The matrix is not positive definite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotPositive;

/// Numbers in a row are padded to a multiple of this.
const WIDTH: usize = 16;
/// Rows of a block that are worked on together.
const TOGETHER: usize = 8;

/// A row of the lower triangle of a matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleRow {
    /// Column of the first value.
    pub first: usize,
    /// Values up to the diagonal.
    pub values: Vec<f64>,
}

/// A dense matrix by rows.
struct DenseBlock {
    rows: usize,
    width: usize,
    values: Vec<f32>,
}

impl DenseBlock {
    fn new(matrix: &Mat<f64>) -> Self {
        let (rows, columns) = (matrix.nrows(), matrix.ncols());
        let width = columns.next_multiple_of(WIDTH);
        let mut values = vec![0.0; rows * width];
        for (i, row) in values.chunks_exact_mut(width).enumerate() {
            for j in 0..columns {
                row[j] = matrix[(i, j)] as f32;
            }
        }
        Self {
            rows,
            width,
            values,
        }
    }

    /// The rows from `from` on that are worked on together, and how many of them there are: the last one is repeated.
    #[inline(always)]
    fn together<S: Simd>(&self, from: usize) -> (usize, [&[S::f32s]; TOGETHER]) {
        let count = TOGETHER.min(self.rows - from);
        let row = |i: usize| {
            let first = (from + i.min(count - 1)) * self.width;
            S::as_simd_f32s(&self.values[first..first + self.width]).0
        };
        (count, std::array::from_fn(row))
    }
}

/// What the elimination of a plane leaves: the inverse of its diagonal block's factor, and the blocks below with the
/// places of their planes in the order of elimination.
struct FactorColumn {
    inverse: DenseBlock,
    below: Vec<(usize, DenseBlock)>,
}

/// The factor.
pub struct PlaneCholesky {
    processor: Arch,
    /// Unknowns of a plane.
    size: usize,
    /// Planes in the order of elimination.
    order: Vec<usize>,
    /// How many of them belong to the first end, and to the second.
    ends: [usize; 2],
    /// Inverse roots of the diagonal.
    scale: Vec<f64>,
    columns: Vec<FactorColumn>,
}

impl PlaneCholesky {
    /// Of the symmetric matrix with these rows of its lower triangle, for planes of `size` unknowns in the order of
    /// their numbers.
    ///
    /// # Errors
    /// If the matrix is not positive definite.
    pub fn new(size: usize, rows: &[TriangleRow]) -> Result<Self, NotPositive> {
        let diagonal = rows
            .iter()
            .enumerate()
            .map(|(i, row)| row.values[i - row.first]);
        let scale: Vec<f64> = diagonal.map(|value| 1.0 / value.sqrt()).collect();
        if !scale.iter().all(|s| s.is_finite()) {
            return Err(NotPositive);
        }
        let planes = rows.len() / size;
        // The first plane that meets each one
        let reach: Vec<usize> = (0..planes)
            .map(|plane| {
                let rows = &rows[plane * size..(plane + 1) * size];
                let first = rows.iter().map(|row| row.first / size).min();
                first.expect("planes are not empty")
            })
            .collect();
        let (order, ends) = from_both_ends(&reach);
        let mut place = vec![0; planes];
        for (k, &plane) in order.iter().enumerate() {
            place[plane] = k;
        }
        let below = filled(&reach, &place);
        let [one, two] = ends;
        let parts = [0..one, one..one + two, one + two..planes];
        let mut blocks = parts.clone().map(|part| {
            let pairs = part.flat_map(|k| below[k].iter().map(move |&i| (i, k)).chain([(k, k)]));
            pairs
                .map(|pair| (pair, Mat::zeros(size, size)))
                .collect::<Blocks>()
        });
        for (i, row) in rows.iter().enumerate() {
            for (j, value) in (row.first..).zip(&row.values) {
                if *value == 0.0 {
                    continue;
                }
                let value = value * scale[i] * scale[j];
                let (a, b) = (place[i / size], place[j / size]);
                let (i, j) = (i % size, j % size);
                let part = usize::from(a.min(b) >= one) + usize::from(a.min(b) >= one + two);
                if a >= b {
                    blocks[part].get_mut(&(a, b)).expect("they meet")[(i, j)] = value;
                }
                if b >= a {
                    blocks[part].get_mut(&(b, a)).expect("they meet")[(j, i)] = value;
                }
            }
        }
        let [first, second, middle] = &mut blocks;
        let eliminate = |k: usize, blocks: &mut Blocks, later: &mut Blocks| {
            eliminate(size, k, &below[k], blocks, later)
        };
        // What the second end takes from the middle is added afterwards: the same for any number of threads
        let mut other = Blocks::new();
        let (ends, others) = rayon::join(
            || -> Result<Vec<FactorColumn>, NotPositive> {
                (0..one).map(|k| eliminate(k, first, middle)).collect()
            },
            || -> Result<Vec<FactorColumn>, NotPositive> {
                let columns = (one..one + two).map(|k| eliminate(k, second, &mut other));
                columns.collect()
            },
        );
        for (pair, minus) in other {
            *middle.get_mut(&pair).expect("filled") += minus;
        }
        let mut columns = ends?;
        columns.extend(others?);
        let mut none = Blocks::new();
        for k in one + two..planes {
            columns.push(eliminate(k, middle, &mut none)?);
        }
        Ok(Self {
            processor: Arch::new(),
            size,
            order,
            ends: [one, two],
            scale,
            columns,
        })
    }

    /// Solves in place.
    pub fn solve(&self, rhs: &mut [f64]) {
        let (size, width) = (self.size, self.size.next_multiple_of(WIDTH));
        let mut x = vec![0.0f32; self.order.len() * width];
        for (x, &plane) in x.chunks_exact_mut(width).zip(&self.order) {
            for i in 0..size {
                let k = plane * size + i;
                x[i] = (rhs[k] * self.scale[k]) as f32;
            }
        }
        let [one, two] = self.ends;
        let (first, rest) = x.split_at_mut(one * width);
        let (second, middle) = rest.split_at_mut(two * width);
        let sweep = |range: std::ops::Range<usize>, own: &mut [f32], middle: &mut [f32], back| {
            let parts = Sweep {
                columns: &self.columns[range.clone()],
                first: range.start,
                middle_from: one + two,
                width,
                own,
                middle,
                back,
            };
            self.processor.dispatch(parts);
        };
        // What the second end takes from the middle is added afterwards: the same for any number of threads
        let mut other = vec![0.0; middle.len()];
        rayon::join(
            || sweep(0..one, first, middle, false),
            || sweep(one..one + two, second, &mut other, false),
        );
        middle.iter_mut().zip(&other).for_each(|(m, o)| *m += o);
        sweep(one + two..self.order.len(), middle, &mut [], false);
        sweep(one + two..self.order.len(), middle, &mut [], true);
        other.copy_from_slice(middle);
        rayon::join(
            || sweep(0..one, first, middle, true),
            || sweep(one..one + two, second, &mut other, true),
        );
        for (x, &plane) in x.chunks_exact(width).zip(&self.order) {
            for i in 0..size {
                let k = plane * size + i;
                rhs[k] = f64::from(x[i]) * self.scale[k];
            }
        }
    }
}

/// Blocks by the places of their planes in the order of elimination, the later one first.
type Blocks = BTreeMap<(usize, usize), Mat<f64>>;

/// Eliminates plane `k`, which meets those `below`. Blocks between planes that come `later` are not among its own.
fn eliminate(
    size: usize,
    k: usize,
    below: &BTreeSet<usize>,
    blocks: &mut Blocks,
    later: &mut Blocks,
) -> Result<FactorColumn, NotPositive> {
    let diagonal = blocks.remove(&(k, k)).expect("it is there");
    let factor = diagonal.llt(Side::Lower).map_err(|_| NotPositive)?;
    let mut inverse = Mat::identity(size, size);
    solve_lower_triangular_in_place(factor.L(), inverse.as_mut(), Par::Seq);
    let below: Vec<(usize, Mat<f64>)> = (below.iter())
        .map(|&i| {
            let block = blocks.remove(&(i, k)).expect("it is there");
            (i, &block * inverse.transpose())
        })
        .collect();
    for (a, (i, left)) in below.iter().enumerate() {
        for (j, right) in &below[..=a] {
            let block = match blocks.get_mut(&(*i, *j)) {
                Some(block) => block,
                None => (later.entry((*i, *j))).or_insert_with(|| Mat::zeros(size, size)),
            };
            matmul(block, Accum::Add, left, right.transpose(), -1.0, Par::Seq);
        }
    }
    Ok(FactorColumn {
        inverse: DenseBlock::new(&inverse),
        below: (below.iter())
            .map(|(i, block)| (*i, DenseBlock::new(block)))
            .collect(),
    })
}

/// What the elimination of each plane fills below it, by their places in its order.
fn filled(reach: &[usize], place: &[usize]) -> Vec<BTreeSet<usize>> {
    let planes = reach.len();
    let mut below = vec![BTreeSet::new(); planes];
    for a in 0..planes {
        for b in reach[a]..a {
            let (a, b) = (place[a].max(place[b]), place[a].min(place[b]));
            below[b].insert(a);
        }
    }
    // What is left of a column goes on to the next plane that it meets
    for k in 0..planes {
        let others: Vec<usize> = below[k].iter().copied().collect();
        if let Some((&next, rest)) = others.split_first() {
            below[next].extend(rest);
        }
    }
    below
}

/// Planes from both ends towards the middle, and how many there are of either; those of one end do not meet the
/// other's. `first` is the first plane that meets each one.
fn from_both_ends(first: &[usize]) -> (Vec<usize>, [usize; 2]) {
    let planes = first.len();
    // The last one that it or any before it meets
    let mut reach: Vec<usize> = (0..planes).collect();
    for (plane, &first) in first.iter().enumerate() {
        reach[first..plane].iter_mut().for_each(|r| *r = plane);
    }
    // The first plane of the middle, near half of the way, that leaves the fewest in it
    let near = planes / 2 - planes / 8..=planes / 2;
    let after = |from: usize| if from == 0 { 0 } else { reach[from - 1] + 1 };
    let from = near.min_by_key(|&from| (after(from) - from, planes - from));
    let from = from.unwrap_or(0);
    let to = after(from);
    let order = (0..from).chain((to..planes).rev()).chain(from..to);
    (order.collect(), [from, planes - to])
}

/// Forward or backward substitution over some columns, whose unknowns are `own`; those of the middle are not among
/// them.
struct Sweep<'a> {
    columns: &'a [FactorColumn],
    first: usize,
    middle_from: usize,
    width: usize,
    own: &'a mut [f32],
    middle: &'a mut [f32],
    back: bool,
}

impl WithSimd for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            columns,
            first,
            middle_from,
            width,
            own,
            middle,
            back,
        } = self;
        let mut result = vec![0.0f32; width];
        let in_own = |i: usize| i < middle_from || first >= middle_from;
        if back {
            for (k, column) in columns.iter().enumerate().rev() {
                let (own, later) = own.split_at_mut((k + 1) * width);
                let x = &mut own[k * width..];
                for (i, block) in &column.below {
                    let part = if in_own(*i) {
                        &later[(i - first - k - 1) * width..]
                    } else {
                        &middle[(i - middle_from) * width..]
                    };
                    add_transposed::<S, true>(simd, block, part, x);
                }
                result.fill(0.0);
                add_transposed::<S, false>(simd, &column.inverse, x, &mut result);
                x.copy_from_slice(&result);
            }
        } else {
            for (k, column) in columns.iter().enumerate() {
                let (own, later) = own.split_at_mut((k + 1) * width);
                let x = &mut own[k * width..];
                result.fill(0.0);
                add_product::<S, false>(simd, &column.inverse, x, &mut result);
                x.copy_from_slice(&result);
                for (i, block) in &column.below {
                    let part = if in_own(*i) {
                        &mut later[(i - first - k - 1) * width..]
                    } else {
                        &mut middle[(i - middle_from) * width..]
                    };
                    add_product::<S, true>(simd, block, x, part);
                }
            }
        }
    }
}

/// Adds, or subtracts, `block x`.
#[inline(always)]
fn add_product<S: Simd, const MINUS: bool>(
    simd: S,
    block: &DenseBlock,
    x: &[f32],
    out: &mut [f32],
) {
    let (x, _) = S::as_simd_f32s(&x[..block.width]);
    let mut from = 0;
    while from < block.rows {
        let (count, rows) = block.together::<S>(from);
        let mut sums = [simd.splat_f32s(0.0); TOGETHER];
        for (j, &x) in x.iter().enumerate() {
            for i in 0..TOGETHER {
                sums[i] = simd.mul_add_e_f32s(rows[i][j], x, sums[i]);
            }
        }
        for (out, sum) in out[from..from + count].iter_mut().zip(sums) {
            let sum = simd.reduce_sum_f32s(sum);
            *out += if MINUS { -sum } else { sum };
        }
        from += TOGETHER;
    }
}

/// Adds, or subtracts, the product of the transposed block with `x`.
#[inline(always)]
fn add_transposed<S: Simd, const MINUS: bool>(
    simd: S,
    block: &DenseBlock,
    x: &[f32],
    out: &mut [f32],
) {
    let (out, _) = S::as_mut_simd_f32s(&mut out[..block.width]);
    let mut from = 0;
    while from < block.rows {
        let (count, rows) = block.together::<S>(from);
        let mut factors = [simd.splat_f32s(0.0); TOGETHER];
        for i in 0..count {
            factors[i] = simd.splat_f32s(if MINUS { -x[from + i] } else { x[from + i] });
        }
        for (j, out) in out.iter_mut().enumerate() {
            let mut sum = *out;
            for i in 0..TOGETHER {
                sum = simd.mul_add_e_f32s(rows[i][j], factors[i], sum);
            }
            *out = sum;
        }
        from += TOGETHER;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_banded_system_is_solved_to_single_precision() {
        for (planes, size, reach) in [(1, 7, 0), (9, 5, 2), (14, 20, 3), (4, 3, 3)] {
            let n = planes * size;
            let entry = |i: usize, j: usize| match i / size - j / size {
                _ if i == j => 40.0 + (i % 5) as f64,
                d if d <= reach => ((i * 7 + j * 3) % 11) as f64 / 11.0 - 0.4,
                _ => 0.0,
            };
            let row = |i: usize| {
                let first = (0..=i).find(|&j| entry(i, j) != 0.0).expect("the diagonal");
                let values = (first..=i).map(|j| entry(i, j)).collect();
                TriangleRow { first, values }
            };
            let rows: Vec<TriangleRow> = (0..n).map(row).collect();
            let solution: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).cos()).collect();
            let mut x: Vec<f64> = (0..n)
                .map(|i| {
                    (0..n)
                        .map(|j| entry(i.max(j), i.min(j)) * solution[j])
                        .sum()
                })
                .collect();
            PlaneCholesky::new(size, &rows).unwrap().solve(&mut x);
            let errors = x.iter().zip(&solution).map(|(a, b)| (a - b).abs());
            let error = errors.fold(0.0, f64::max);
            assert!(error < 2e-6 && error > 0.0, "{planes} planes: {error:e}");
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_is_refused() {
        let row = |values: &[f64]| TriangleRow {
            first: 0,
            values: values.to_vec(),
        };
        let rows = [row(&[1.0]), row(&[2.0, 1.0])];
        assert_eq!(PlaneCholesky::new(1, &rows).err(), Some(NotPositive));
    }
}
