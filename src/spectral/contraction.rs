//! Products of tensors contracted one direction at a time, for several elements side by side.
//!
//! Eight elements (*lanes*) lie side by side in every array, so that one instruction works on as many of them as the
//! processor's registers hold: `S::f64s` is such a register, and a value of all lanes is [`registers`] of them.

use pulp::Simd;

/// Elements side by side.
pub const LANES: usize = 8;

/// Registers that hold one value of all lanes.
#[inline(always)]
pub const fn registers<S: Simd>() -> usize {
    LANES / S::F64_LANES
}

/// A slice as registers.
#[inline(always)]
pub fn view<S: Simd>(values: &[f64]) -> &[S::f64s] {
    S::as_simd_f64s(values).0
}

/// A slice as registers.
#[inline(always)]
pub fn view_mut<S: Simd>(values: &mut [f64]) -> &mut [S::f64s] {
    S::as_mut_simd_f64s(values).0
}

/// A matrix that maps `A` values to `B`: `[b][a]`.
pub type Map<const A: usize, const B: usize> = [[f64; A]; B];

/// The matrix with these `B` rows of `A` values.
pub fn map<const A: usize, const B: usize>(rows: &[Vec<f64>]) -> Map<A, B> {
    assert_eq!((rows.len(), rows[0].len()), (B, A));
    std::array::from_fn(|b| std::array::from_fn(|a| rows[b][a]))
}

/// Its transpose.
pub fn transposed<const A: usize, const B: usize>(map: &Map<A, B>) -> Map<B, A> {
    std::array::from_fn(|a| std::array::from_fn(|b| map[b][a]))
}

/// Applies `map` to the index of `[outer][A][inner]` in the middle; adds to `output` if `ADD`.
#[inline(always)]
pub fn contract<S: Simd, const A: usize, const B: usize, const ADD: bool>(
    simd: S,
    map: &Map<A, B>,
    [outer, inner]: [usize; 2],
    input: &[S::f64s],
    output: &mut [S::f64s],
) {
    for o in 0..outer {
        let block = &input[o * A * inner..(o + 1) * A * inner];
        let rows: [&[S::f64s]; A] = std::array::from_fn(|a| &block[a * inner..(a + 1) * inner]);
        let out = &mut output[o * B * inner..(o + 1) * B * inner];
        for i in 0..inner {
            let x: [S::f64s; A] = std::array::from_fn(|a| rows[a][i]);
            for b in 0..B {
                let mut sum = if ADD {
                    out[b * inner + i]
                } else {
                    simd.splat_f64s(0.0)
                };
                for a in 0..A {
                    sum = simd.mul_add_e_f64s(simd.splat_f64s(map[b][a]), x[a], sum);
                }
                out[b * inner + i] = sum;
            }
        }
    }
}

/// `A³` values become `B³`.
#[inline(always)]
pub fn interpolate<S: Simd, const A: usize, const B: usize>(
    simd: S,
    map: &Map<A, B>,
    input: &[S::f64s],
    output: &mut [S::f64s],
    [first, second]: [&mut [S::f64s]; 2],
) {
    let r = registers::<S>();
    contract::<S, A, B, false>(simd, map, [A * A, r], input, first);
    contract::<S, A, B, false>(simd, map, [A, B * r], first, second);
    contract::<S, A, B, false>(simd, map, [1, B * B * r], second, output);
}

/// Derivatives of `M³` values along the three directions.
#[inline(always)]
pub fn differentiate<S: Simd, const M: usize>(
    simd: S,
    map: &Map<M, M>,
    values: &[S::f64s],
    [x, y, z]: [&mut [S::f64s]; 3],
) {
    let r = registers::<S>();
    contract::<S, M, M, false>(simd, map, [M * M, r], values, x);
    contract::<S, M, M, false>(simd, map, [M, M * r], values, y);
    contract::<S, M, M, false>(simd, map, [1, M * M * r], values, z);
}

/// Adds the transpose of [`differentiate`], whose matrix is `map`.
#[inline(always)]
pub fn add_integrated<S: Simd, const M: usize>(
    simd: S,
    map: &Map<M, M>,
    [x, y, z]: [&[S::f64s]; 3],
    values: &mut [S::f64s],
) {
    let r = registers::<S>();
    contract::<S, M, M, true>(simd, map, [M * M, r], x, values);
    contract::<S, M, M, true>(simd, map, [M, M * r], y, values);
    contract::<S, M, M, true>(simd, map, [1, M * M * r], z, values);
}
