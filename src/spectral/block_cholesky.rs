//! Cholesky factor, in single precision, of a matrix whose unknowns lie in blocks along one or several chains that
//! meet: the cross-sections of a tube, or of the branches of a tree. A block meets the next few of its chain only, and
//! some of another chain where the two meet.
//!
//! A single chain is eliminated from both ends towards its middle; of several each from its free end up to where it
//! meets another. So threads work side by side, and each block that meets another is kept as a dense matrix: a solution
//! reads every number of the factor twice, one after the other. The factor is computed in double precision and scaled
//! so that the matrix had ones on its diagonal.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, Par, Side};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// The matrix is not positive definite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotPositive;

/// Numbers in a row are padded to a multiple of this.
const WIDTH: usize = 16;
/// Rows of a block that are worked on together.
const TOGETHER: usize = 8;

/// A row of the lower triangle of a matrix: columns up to the diagonal, which is the last, and values.
pub type TriangleRow = Vec<(u32, f64)>;

/// Blocks of unknowns, and how they follow each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chains {
    /// Block of each unknown.
    pub block_of: Vec<u32>,
    /// Blocks of each chain. Where there are several, they come from the first one on in the order in which they
    /// divide, as the branches of a tree do.
    pub chains: Vec<Vec<usize>>,
}

impl Chains {
    /// A single chain of blocks of so many unknowns each, in the order of their numbers.
    pub fn single(blocks: usize, size: usize) -> Self {
        Self {
            block_of: (0..blocks * size).map(|i| (i / size) as u32).collect(),
            chains: vec![(0..blocks).collect()],
        }
    }
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

/// What the elimination of a block leaves: the inverse of its diagonal block's factor, and the blocks below with their
/// places in the order of elimination.
struct FactorColumn {
    inverse: DenseBlock,
    below: Vec<(usize, DenseBlock)>,
}

/// The factor.
pub struct BlockCholesky {
    processor: Arch,
    /// Unknowns of each block, in the order of elimination.
    unknowns: Vec<Vec<u32>>,
    /// Where each of them begins in a vector of all, padded; the last one is its length.
    starts: Vec<usize>,
    /// Where the parts begin that do not meet each other; the last one is where what remains begins.
    parts: Vec<usize>,
    /// Inverse roots of the diagonal.
    scale: Vec<f64>,
    columns: Vec<FactorColumn>,
}

impl BlockCholesky {
    /// Of the symmetric matrix with these rows of its lower triangle.
    ///
    /// # Errors
    /// If the matrix is not positive definite.
    pub fn new(chains: &Chains, rows: &[TriangleRow]) -> Result<Self, NotPositive> {
        let diagonal = rows.iter().map(|row| row.last().map_or(0.0, |last| last.1));
        let scale: Vec<f64> = diagonal.map(|value| 1.0 / value.sqrt()).collect();
        if !scale.iter().all(|s| s.is_finite()) {
            return Err(NotPositive);
        }
        let block = |i: usize| chains.block_of[i] as usize;
        let meets = meeting(chains, rows);
        let blocks = meets.len();
        let (order, parts) = order(&chains.chains, &meets);
        let mut place = vec![0; blocks];
        for (k, &block) in order.iter().enumerate() {
            place[block] = k;
        }
        let mut unknowns = vec![Vec::new(); blocks];
        let mut within = vec![0; rows.len()];
        for (i, within) in within.iter_mut().enumerate() {
            let own: &mut Vec<u32> = &mut unknowns[place[block(i)]];
            *within = own.len();
            own.push(i as u32);
        }
        let sizes: Vec<usize> = unknowns.iter().map(Vec::len).collect();
        let below = filled(&meets, &place);
        let bounds = [&parts[..], &[blocks]].concat();
        let ranges = bounds.windows(2).map(|pair| pair[0]..pair[1]);
        let mut of_parts: Vec<Blocks> = ranges
            .map(|range| {
                let pairs =
                    range.flat_map(|k| below[k].iter().map(move |&i| (i, k)).chain([(k, k)]));
                pairs
                    .map(|(i, k)| ((i, k), Mat::zeros(sizes[i], sizes[k])))
                    .collect()
            })
            .collect();
        for (i, row) in rows.iter().enumerate() {
            for &(j, value) in row {
                if value == 0.0 {
                    continue;
                }
                let j = j as usize;
                let value = value * scale[i] * scale[j];
                let (a, b) = (place[block(i)], place[block(j)]);
                let (i, j) = (within[i], within[j]);
                // The first part ends with the second one's beginning.
                let part = parts[1..]
                    .iter()
                    .filter(|start| a.min(b) >= **start)
                    .count();
                if a >= b {
                    of_parts[part].get_mut(&(a, b)).expect("they meet")[(i, j)] = value;
                }
                if b >= a {
                    of_parts[part].get_mut(&(b, a)).expect("they meet")[(j, i)] = value;
                }
            }
        }
        let columns = eliminate_parts(&sizes, &parts, &below, of_parts)?;
        let mut starts = vec![0];
        for (k, size) in sizes.iter().enumerate() {
            starts.push(starts[k] + size.next_multiple_of(WIDTH));
        }
        Ok(Self {
            processor: Arch::new(),
            unknowns,
            starts,
            parts,
            scale,
            columns,
        })
    }

    /// Solves in place.
    pub fn solve(&self, rhs: &mut [f64]) {
        let starts = &self.starts;
        let mut x = vec![0.0f32; starts[self.unknowns.len()]];
        for (unknowns, start) in self.unknowns.iter().zip(starts) {
            for (x, &k) in x[*start..].iter_mut().zip(unknowns) {
                *x = (rhs[k as usize] * self.scale[k as usize]) as f32;
            }
        }
        let middle_from = self.parts[self.parts.len() - 1];
        let (mut of_parts, middle) = x.split_at_mut(starts[middle_from]);
        let mut slices = Vec::new();
        for ends in self.parts.windows(2) {
            let (own, others) = of_parts.split_at_mut(starts[ends[1]] - starts[ends[0]]);
            slices.push((ends[0]..ends[1], own, vec![0.0; middle.len()]));
            of_parts = others;
        }
        let sweep = |range: std::ops::Range<usize>, own: &mut [f32], middle: &mut [f32], back| {
            self.processor.dispatch(Sweep {
                columns: &self.columns[range.clone()],
                first: range.start,
                middle_from,
                starts,
                own,
                middle,
                back,
            });
        };
        // What the other parts take from the middle is added afterwards: the same for any number of threads
        if let Some(((range, own, _), others)) = slices.split_first_mut() {
            rayon::join(
                || sweep(range.clone(), own, middle, false),
                || {
                    let others = others.par_iter_mut();
                    others
                        .for_each(|(range, own, middle)| sweep(range.clone(), own, middle, false));
                },
            );
            for (_, _, other) in others {
                middle.iter_mut().zip(other).for_each(|(m, o)| *m += *o);
            }
        }
        let rest = middle_from..self.unknowns.len();
        sweep(rest.clone(), middle, &mut [], false);
        sweep(rest, middle, &mut [], true);
        let known: &[f32] = middle;
        slices.par_iter_mut().for_each(|(range, own, copy)| {
            copy.copy_from_slice(known);
            sweep(range.clone(), own, copy, true);
        });
        for (unknowns, start) in self.unknowns.iter().zip(starts) {
            for (x, &k) in x[*start..].iter().zip(unknowns) {
                rhs[k as usize] = f64::from(*x) * self.scale[k as usize];
            }
        }
    }
}

/// Dense matrices by the places of two blocks in the order of elimination, the later one first.
type Blocks = BTreeMap<(usize, usize), Mat<f64>>;

/// For each block those of smaller numbers that it meets.
fn meeting(chains: &Chains, rows: &[TriangleRow]) -> Vec<BTreeSet<usize>> {
    let block = |i: usize| chains.block_of[i] as usize;
    let mut meets = vec![BTreeSet::new(); chains.chains.iter().map(Vec::len).sum()];
    for (i, row) in rows.iter().enumerate() {
        for &(j, _) in row {
            let (a, b) = (block(i), block(j as usize));
            if a != b {
                meets[a.max(b)].insert(a.min(b));
            }
        }
    }
    meets
}

/// What the elimination of each block fills below it, by their places in its order.
fn filled(meets: &[BTreeSet<usize>], place: &[usize]) -> Vec<BTreeSet<usize>> {
    let mut below = vec![BTreeSet::new(); meets.len()];
    for (a, others) in meets.iter().enumerate() {
        for &b in others {
            let (a, b) = (place[a].max(place[b]), place[a].min(place[b]));
            below[b].insert(a);
        }
    }
    // What is left of a column goes on to the next block that it meets
    for k in 0..meets.len() {
        let others: Vec<usize> = below[k].iter().copied().collect();
        if let Some((&next, rest)) = others.split_first() {
            below[next].extend(rest);
        }
    }
    below
}

/// Eliminates the parts side by side, then what remains, whose blocks are the last of `of_parts`; `parts` are where
/// they begin.
fn eliminate_parts(
    sizes: &[usize],
    parts: &[usize],
    below: &[BTreeSet<usize>],
    mut of_parts: Vec<Blocks>,
) -> Result<Vec<FactorColumn>, NotPositive> {
    let mut middle = of_parts.pop().expect("what remains is the last");
    let all = |range: std::ops::Range<usize>, own: &mut Blocks, later: &mut Blocks| {
        let columns = range.map(|k| eliminate(sizes, k, &below[k], own, later));
        columns.collect::<Result<Vec<FactorColumn>, NotPositive>>()
    };
    let mut columns = Vec::with_capacity(sizes.len());
    if let Some((first, others)) = of_parts.split_first_mut() {
        // What the other parts take from the middle is added afterwards: the same for any number of threads
        let (first, others) = rayon::join(
            || all(parts[0]..parts[1], first, &mut middle),
            || {
                let pairs = others.par_iter_mut().zip(parts[1..].par_windows(2));
                let parts = pairs.map(|(own, ends)| {
                    let mut later = Blocks::new();
                    all(ends[0]..ends[1], own, &mut later).map(|columns| (columns, later))
                });
                parts.collect::<Vec<_>>()
            },
        );
        columns.extend(first?);
        for part in others {
            let (of_part, later) = part?;
            columns.extend(of_part);
            for (pair, minus) in later {
                *middle.get_mut(&pair).expect("filled") += minus;
            }
        }
    }
    let rest = parts[parts.len() - 1]..sizes.len();
    columns.extend(all(rest, &mut middle, &mut Blocks::new())?);
    Ok(columns)
}

/// Eliminates block `k`, which meets those `below`. What lies between two that come `later` is not among its own.
fn eliminate(
    sizes: &[usize],
    k: usize,
    below: &BTreeSet<usize>,
    blocks: &mut Blocks,
    later: &mut Blocks,
) -> Result<FactorColumn, NotPositive> {
    let diagonal = blocks.remove(&(k, k)).expect("it is there");
    let factor = diagonal.llt(Side::Lower).map_err(|_| NotPositive)?;
    let mut inverse = Mat::identity(sizes[k], sizes[k]);
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
                None => (later.entry((*i, *j))).or_insert_with(|| Mat::zeros(sizes[*i], sizes[*j])),
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

/// Blocks in the order of elimination, where the parts of that begin that do not meet each other, and last where what
/// remains begins. `meets` are the blocks of smaller numbers that meet each one.
fn order(chains: &[Vec<usize>], meets: &[BTreeSet<usize>]) -> (Vec<usize>, Vec<usize>) {
    if let [_] = chains {
        let first =
            |(block, others): (usize, &BTreeSet<usize>)| others.first().copied().unwrap_or(block);
        let first: Vec<usize> = meets.iter().enumerate().map(first).collect();
        return from_both_ends(&first);
    }
    let mut chain_of = vec![0; meets.len()];
    for (chain, blocks) in chains.iter().enumerate() {
        blocks.iter().for_each(|&block| chain_of[block] = chain);
    }
    let mut meets_others = vec![false; meets.len()];
    for (a, others) in meets.iter().enumerate() {
        for &b in others {
            if chain_of[a] != chain_of[b] {
                (meets_others[a], meets_others[b]) = (true, true);
            }
        }
    }
    // The deepest come first, each towards where it began; the first chain comes last, towards where it divides.
    let oriented = chains.iter().rev().map(|chain| {
        let is_free = chain.first().is_some_and(|first| !meets_others[*first]);
        let blocks = chain.iter().copied();
        match is_free {
            true => blocks.collect(),
            false => blocks.rev().collect(),
        }
    });
    let oriented: Vec<Vec<usize>> = oriented.collect();
    let (mut order, mut rest): (Vec<usize>, Vec<usize>) = Default::default();
    let mut parts = vec![0];
    for chain in &oriented {
        let alone = chain
            .iter()
            .take_while(|block| !meets_others[**block])
            .count();
        order.extend(&chain[..alone]);
        rest.extend(&chain[alone..]);
        if alone > 0 {
            parts.push(order.len());
        }
    }
    order.extend(rest);
    (order, parts)
}

/// A single chain from both ends towards the middle: the blocks of one end do not meet the other's. `first` is the
/// first block that meets each one.
fn from_both_ends(first: &[usize]) -> (Vec<usize>, Vec<usize>) {
    let blocks = first.len();
    // The last one that it or any before it meets
    let mut reach: Vec<usize> = (0..blocks).collect();
    for (block, &first) in first.iter().enumerate() {
        reach[first..block].iter_mut().for_each(|r| *r = block);
    }
    // The first block of the middle, near half of the way, that leaves the fewest in it
    let near = blocks / 2 - blocks / 8..=blocks / 2;
    let after = |from: usize| if from == 0 { 0 } else { reach[from - 1] + 1 };
    let from = near.min_by_key(|&from| (after(from) - from, blocks - from));
    let from = from.unwrap_or(0);
    let to = after(from);
    let order = (0..from).chain((to..blocks).rev()).chain(from..to);
    (order.collect(), vec![0, from, from + blocks - to])
}

/// Forward or backward substitution over some columns, whose unknowns are `own`; those of the middle are not among
/// them.
struct Sweep<'a> {
    columns: &'a [FactorColumn],
    first: usize,
    middle_from: usize,
    starts: &'a [usize],
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
            starts,
            own,
            middle,
            back,
        } = self;
        let widths = columns.iter().map(|column| column.inverse.width);
        let mut result = vec![0.0f32; widths.max().unwrap_or(0)];
        let in_own = |i: usize| i < middle_from || first >= middle_from;
        if back {
            for (k, column) in columns.iter().enumerate().rev() {
                let [from, to] = [first + k, first + k + 1].map(|k| starts[k] - starts[first]);
                let (own, later) = own.split_at_mut(to);
                let x = &mut own[from..];
                let result = &mut result[..to - from];
                for (i, block) in &column.below {
                    let part = if in_own(*i) {
                        &later[starts[*i] - starts[first] - to..]
                    } else {
                        &middle[starts[*i] - starts[middle_from]..]
                    };
                    add_transposed::<S, true>(simd, block, part, x);
                }
                result.fill(0.0);
                add_transposed::<S, false>(simd, &column.inverse, x, result);
                x.copy_from_slice(result);
            }
        } else {
            for (k, column) in columns.iter().enumerate() {
                let [from, to] = [first + k, first + k + 1].map(|k| starts[k] - starts[first]);
                let (own, later) = own.split_at_mut(to);
                let x = &mut own[from..];
                let result = &mut result[..to - from];
                result.fill(0.0);
                add_product::<S, false>(simd, &column.inverse, x, result);
                x.copy_from_slice(result);
                for (i, block) in &column.below {
                    let part = if in_own(*i) {
                        &mut later[starts[*i] - starts[first] - to..]
                    } else {
                        &mut middle[starts[*i] - starts[middle_from]..]
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
                let entries = (0..=i).map(|j| (j as u32, entry(i, j)));
                entries.filter(|entry| entry.1 != 0.0).collect()
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
            let chain = Chains::single(planes, size);
            BlockCholesky::new(&chain, &rows).unwrap().solve(&mut x);
            let errors = x.iter().zip(&solution).map(|(a, b)| (a - b).abs());
            let error = errors.fold(0.0, f64::max);
            assert!(error < 2e-6 && error > 0.0, "{planes} planes: {error:e}");
        }
    }

    /// Four chains that meet at two places: blocks of different sizes, in numbers without any order.
    #[test]
    fn chains_that_meet_are_solved_to_single_precision() {
        let chains = vec![
            vec![0, 1, 2, 3],
            vec![4, 5],
            vec![6, 7, 8],
            vec![11, 10, 9],
            vec![12],
        ];
        // Neighbours along the chains, and where these meet.
        let mut pairs = vec![(3, 5), (3, 12), (5, 12), (12, 8), (12, 9), (8, 9)];
        for chain in &chains {
            pairs.extend(chain.windows(2).map(|pair| (pair[0], pair[1])));
            pairs.extend(chain.windows(3).map(|three| (three[0], three[2])));
        }
        let n = 150;
        let block_of: Vec<u32> = (0..n).map(|i| ((i * i + 3 * i) % 13) as u32).collect();
        let meet =
            |a: usize, b: usize| a == b || pairs.contains(&(a, b)) || pairs.contains(&(b, a));
        let block_of: Vec<u32> = block_of
            .iter()
            .enumerate()
            .map(|(i, b)| if i < 13 { i as u32 } else { *b })
            .collect();
        let entry = |i: usize, j: usize| match meet(block_of[i] as usize, block_of[j] as usize) {
            _ if i == j => 60.0 + (i % 5) as f64,
            true => ((i * 7 + j * 3 + i * j) % 11) as f64 / 11.0 - 0.4,
            false => 0.0,
        };
        let row = |i: usize| {
            let entries = (0..=i).map(|j| (j as u32, entry(i, j)));
            entries.filter(|entry| entry.1 != 0.0).collect()
        };
        let rows: Vec<TriangleRow> = (0..n).map(row).collect();
        let solution: Vec<f64> = (0..n).map(|i| (i as f64 * 0.7).cos()).collect();
        let product = |i: usize| {
            (0..n)
                .map(|j| entry(i.max(j), i.min(j)) * solution[j])
                .sum()
        };
        let mut x: Vec<f64> = (0..n).map(product).collect();
        let factor = BlockCholesky::new(&Chains { block_of, chains }, &rows).unwrap();
        assert_eq!(factor.parts.len(), 5);
        factor.solve(&mut x);
        let errors = x.iter().zip(&solution).map(|(a, b)| (a - b).abs());
        let error = errors.fold(0.0, f64::max);
        assert!(error < 2e-6 && error > 0.0, "{error:e}");
    }

    #[test]
    fn a_matrix_that_is_not_positive_is_refused() {
        let rows = [vec![(0, 1.0)], vec![(0, 2.0), (1, 1.0)]];
        let chain = Chains::single(2, 1);
        assert_eq!(BlockCholesky::new(&chain, &rows).err(), Some(NotPositive));
    }
}
