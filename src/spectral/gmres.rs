//! Generalized minimal residuals (Saad and Schultz 1986), preconditioned from the left: what is made small is the
//! preconditioned residual, an estimate of the error.

use pulp::Arch;
use rayon::prelude::*;

/// A system `A x = b` with a preconditioner `P`.
pub trait System {
    /// `P⁻¹ (b - A x)`.
    fn preconditioned_residual(&mut self, x: &[f64], out: &mut [f64]);

    /// `P⁻¹ A v`.
    fn preconditioned_product(&mut self, v: &[f64], out: &mut [f64]);

    /// Weights of the squares of the unknowns in the norm.
    fn weights(&self) -> &[f64];

    /// Whether the solution is no longer needed.
    fn is_given_up(&self) -> bool {
        false
    }
}

/// What an iteration did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Products with the matrix.
    pub iterations: usize,
    /// Norm of the preconditioned residual in the end.
    pub residual: f64,
}

/// Vectors that are kept from one solution to the next, as to allocate them takes time.
#[derive(Debug, Default)]
pub struct Workspace {
    basis: Vec<Vec<f64>>,
}

/// Vectors until the iteration starts again from its result.
const RESTART: usize = 60;

/// Numbers that one thread works on at a time.
const CHUNK: usize = 4096;

/// Numbers that stay in the innermost cache while many vectors pass.
const BLOCK: usize = 2048;

/// Sums side by side, always in the same order.
const SIDE: usize = 8;

/// Adds the products of two blocks to the sums side by side, and to that of what is left over.
#[inline(always)]
fn add_products(a: &[f64], b: &[f64], (sums, rest): &mut ([f64; SIDE], f64)) {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<SIDE>(), b.as_chunks::<SIDE>());
    for (a, b) in a.iter().zip(b) {
        (0..SIDE).for_each(|i| sums[i] += a[i] * b[i]);
    }
    a_rest.iter().zip(b_rest).for_each(|(a, b)| *rest += a * b);
}

/// Scalar products of `a` with each of `others`, and with itself; the same whatever the number of threads.
fn products(weights: &[f64], others: &[Vec<f64>], a: &[f64]) -> Vec<f64> {
    let processor = Arch::new();
    let of_chunk = |(chunk, (weights, a)): (usize, (&[f64], &[f64]))| -> Vec<f64> {
        let mut sums = vec![([0.0; SIDE], 0.0); others.len() + 1];
        let mut weighted = [0.0; BLOCK];
        processor.dispatch(|| {
            for (block, (weights, a)) in weights.chunks(BLOCK).zip(a.chunks(BLOCK)).enumerate() {
                let weighted = &mut weighted[..a.len()];
                for (weighted, (w, a)) in weighted.iter_mut().zip(weights.iter().zip(a)) {
                    *weighted = w * a;
                }
                let first = chunk * CHUNK + block * BLOCK;
                let others = others.iter().map(|other| &other[first..first + a.len()]);
                for (sums, other) in sums.iter_mut().zip(others.chain([a])) {
                    add_products(weighted, other, sums);
                }
            }
        });
        let sums = sums.iter();
        sums.map(|(side, rest)| side.iter().sum::<f64>() + rest)
            .collect()
    };
    let chunks = weights.par_chunks(CHUNK).zip(a.par_chunks(CHUNK));
    let parts: Vec<Vec<f64>> = chunks.enumerate().map(of_chunk).collect();
    (0..=others.len())
        .map(|i| parts.iter().map(|part| part[i]).sum())
        .collect()
}

/// Adds `shares` of `others` to `a`.
fn add(shares: &[f64], others: &[Vec<f64>], a: &mut [f64]) {
    let processor = Arch::new();
    a.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, a)| {
        processor.dispatch(|| {
            for (block, a) in a.chunks_mut(BLOCK).enumerate() {
                let first = chunk * CHUNK + block * BLOCK;
                for (share, other) in shares.iter().zip(others) {
                    let other = &other[first..first + a.len()];
                    a.iter_mut().zip(other).for_each(|(a, o)| *a += share * o);
                }
            }
        });
    });
}

fn scale(factor: f64, a: &mut [f64]) {
    a.par_chunks_mut(CHUNK)
        .for_each(|a| a.iter_mut().for_each(|a| *a *= factor));
}

/// Norm of a vector with these weights.
pub fn norm(weights: &[f64], a: &[f64]) -> f64 {
    products(weights, &[], a)[0].sqrt()
}

/// Share of a vector's square that must remain for its sums to be trusted: orthogonality is then kept to 1e-14, which
/// does for residuals that fall by [`TRUSTED`]. What the preconditioner leaves is often a tenth of a vector.
const REMAINS: f64 = 1e-4;

/// Makes `a` orthogonal to `others`, which are so to each other: shares of these, and the norm of what remains.
/// Classical Gram-Schmidt, a second time where much was lost (Daniel, Gragg, Kaufman and Stewart 1976).
fn orthogonalize(weights: &[f64], others: &[Vec<f64>], a: &mut [f64]) -> (Vec<f64>, f64) {
    let mut shares = vec![0.0; others.len()];
    let mut found = products(weights, others, a);
    loop {
        let before = found.pop().expect("that with itself is the last");
        let minus: Vec<f64> = found.iter().map(|share| -share).collect();
        add(&minus, others, a);
        (shares.iter_mut().zip(&found)).for_each(|(sum, share)| *sum += share);
        let after = before - found.iter().map(|share| share * share).sum::<f64>();
        // What remains is known well enough from the difference if it is a good part
        if after > REMAINS * before {
            return (shares, after.sqrt());
        }
        found = products(weights, others, a);
        let remains = found[others.len()];
        let kept = remains > REMAINS * before || remains.is_nan();
        let clean = found[..others.len()].iter().map(|s| s * s).sum::<f64>() <= 1e-20 * remains;
        if kept || clean || remains == 0.0 {
            return (shares, remains.sqrt());
        }
    }
}

/// The residual is computed again at the end, and the iteration continues where that is needed, if it was to fall by
/// more than this factor: the preconditioner has the round-off of single precision.
const TRUSTED: f64 = 1e-5;

/// Improves `x`, whose preconditioned residual is `first`, until the norm of that is below `tolerance`, with at most
/// `most` products.
pub fn solve(
    system: &mut impl System,
    x: &mut [f64],
    first: &[f64],
    tolerance: f64,
    most: usize,
    workspace: &mut Workspace,
) -> Outcome {
    let n = x.len();
    let weights = system.weights().to_vec();
    let mut iterations = 0;
    grow(&mut workspace.basis, 1, n);
    workspace.basis[0].copy_from_slice(first);
    loop {
        let basis = &mut workspace.basis;
        let size = norm(&weights, &basis[0]);
        // Not a number ends it too
        if size.is_nan() || size <= tolerance || iterations >= most {
            return Outcome {
                iterations,
                residual: size,
            };
        }
        scale(1.0 / size, &mut basis[0]);
        // QR factorization of the Hessenberg matrix by Givens' rotations
        let (mut columns, mut rotations): (Vec<Vec<f64>>, Vec<[f64; 2]>) = Default::default();
        let mut rhs = vec![size];
        while columns.len() < RESTART && iterations < most && !system.is_given_up() {
            let k = columns.len();
            grow(basis, k + 2, n);
            let (known, next) = basis.split_at_mut(k + 1);
            let next = &mut next[0];
            system.preconditioned_product(&known[k], next);
            iterations += 1;
            let (mut column, rest) = orthogonalize(&weights, known, next);
            if rest > 0.0 {
                scale(1.0 / rest, next);
            }
            column.push(rest);
            for (i, [c, s]) in rotations.iter().enumerate() {
                let (a, b) = (column[i], column[i + 1]);
                (column[i], column[i + 1]) = (c * a + s * b, c * b - s * a);
            }
            let length = column[k].hypot(column[k + 1]);
            if length.is_nan() || length == 0.0 {
                break;
            }
            let [c, s] = [column[k] / length, column[k + 1] / length];
            rotations.push([c, s]);
            column.truncate(k + 1);
            column[k] = length;
            columns.push(column);
            let last = rhs[k];
            rhs[k] = c * last;
            rhs.push(-s * last);
            if rhs[k + 1].abs() <= 0.9 * tolerance {
                break;
            }
        }
        if columns.is_empty() || system.is_given_up() {
            return Outcome {
                iterations,
                residual: f64::NAN,
            };
        }
        let mut shares = rhs[..columns.len()].to_vec();
        for k in (0..shares.len()).rev() {
            shares[k] /= columns[k][k];
            for i in 0..k {
                shares[i] -= columns[k][i] * shares[k];
            }
        }
        add(&shares, basis, x);
        let estimate = rhs[columns.len()].abs();
        if estimate <= tolerance && tolerance >= TRUSTED * size {
            return Outcome {
                iterations,
                residual: estimate,
            };
        }
        system.preconditioned_residual(x, &mut basis[0]);
    }
}

fn grow(basis: &mut Vec<Vec<f64>>, count: usize, n: usize) {
    if basis.first().is_some_and(|v| v.len() != n) {
        basis.clear();
    }
    while basis.len() < count {
        basis.push(vec![0.0; n]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Dense {
        rows: Vec<Vec<f64>>,
        b: Vec<f64>,
        weights: Vec<f64>,
    }

    impl System for Dense {
        fn preconditioned_residual(&mut self, x: &[f64], out: &mut [f64]) {
            self.preconditioned_product(x, out);
            out.iter_mut().zip(&self.b).for_each(|(o, b)| *o = b - *o);
        }

        fn preconditioned_product(&mut self, v: &[f64], out: &mut [f64]) {
            for (o, row) in out.iter_mut().zip(&self.rows) {
                *o = row.iter().zip(v).map(|(a, v)| a * v).sum();
            }
        }

        fn weights(&self) -> &[f64] {
            &self.weights
        }
    }

    #[test]
    fn an_unsymmetric_system_is_solved_across_restarts() {
        let n = 150;
        let entry = |i: usize, j: usize| match i.abs_diff(j) {
            0 => 2.0 + (i % 7) as f64,
            1 if i < j => 1.5,
            1 => -0.8,
            _ => 0.01 * ((i * 31 + j * 17) % 11) as f64 / 11.0,
        };
        let rows: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..n).map(|j| entry(i, j)).collect())
            .collect();
        let solution: Vec<f64> = (0..n).map(|i| (i as f64 * 0.37).sin()).collect();
        let mut b = vec![0.0; n];
        let weights = (0..n).map(|i| 0.5 + (i % 3) as f64).collect();
        let mut system = Dense {
            rows,
            b: b.clone(),
            weights,
        };
        system.preconditioned_product(&solution, &mut b);
        system.b = b;
        for tolerance in [1e-4, 1e-11] {
            let (mut x, mut first) = (vec![0.0; n], vec![0.0; n]);
            system.preconditioned_residual(&x, &mut first);
            let outcome = solve(
                &mut system,
                &mut x,
                &first,
                tolerance,
                500,
                &mut Workspace::default(),
            );
            assert!(
                outcome.residual <= tolerance && outcome.iterations < 200,
                "{outcome:?}"
            );
            let error = x
                .iter()
                .zip(&solution)
                .map(|(a, b)| (a - b).abs())
                .fold(0.0, f64::max);
            assert!(error < 10.0 * tolerance, "{error}");
        }
    }
}
