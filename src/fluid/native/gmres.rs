//! Generalized minimal residuals (Saad and Schultz 1986), preconditioned from the left: what is made small is the
//! preconditioned residual, an estimate of the error.

/// A system `A x = b` with a preconditioner `P`.
pub trait System {
    /// `P⁻¹ (b - A x)`.
    fn preconditioned_residual(&mut self, x: &[f64], out: &mut [f64]);

    /// `P⁻¹ A v`.
    fn preconditioned_product(&mut self, v: &[f64], out: &mut [f64]);

    /// Weights of the squares of the unknowns in the norm.
    fn weights(&self) -> &[f64];
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

fn dot(weights: &[f64], a: &[f64], b: &[f64]) -> f64 {
    // Four sums side by side, always in the same order
    let mut sums = [0.0; 4];
    let chunks = weights
        .chunks_exact(4)
        .zip(a.chunks_exact(4).zip(b.chunks_exact(4)));
    for (w, (a, b)) in chunks {
        for i in 0..4 {
            sums[i] += w[i] * a[i] * b[i];
        }
    }
    let rest = weights.len() / 4 * 4;
    let tail: f64 = (rest..weights.len())
        .map(|i| weights[i] * a[i] * b[i])
        .sum();
    sums.iter().sum::<f64>() + tail
}

/// Norm of a vector with these weights.
pub fn norm(weights: &[f64], a: &[f64]) -> f64 {
    dot(weights, a, a).sqrt()
}

/// Improves `x` until the norm of the preconditioned residual is below `tolerance`, with at most `most` products.
pub fn solve(
    system: &mut impl System,
    x: &mut [f64],
    tolerance: f64,
    most: usize,
    workspace: &mut Workspace,
) -> Outcome {
    let n = x.len();
    let weights = system.weights().to_vec();
    let mut iterations = 0;
    loop {
        let basis = &mut workspace.basis;
        grow(basis, 1, n);
        system.preconditioned_residual(x, &mut basis[0]);
        let size = norm(&weights, &basis[0]);
        // Not a number ends it too
        if size.is_nan() || size <= tolerance || iterations >= most {
            return Outcome {
                iterations,
                residual: size,
            };
        }
        basis[0].iter_mut().for_each(|v| *v /= size);
        // QR factorization of the Hessenberg matrix by Givens' rotations
        let (mut columns, mut rotations): (Vec<Vec<f64>>, Vec<[f64; 2]>) = Default::default();
        let mut rhs = vec![size];
        while columns.len() < RESTART && iterations < most {
            let k = columns.len();
            grow(basis, k + 2, n);
            let (known, next) = basis.split_at_mut(k + 1);
            let next = &mut next[0];
            system.preconditioned_product(&known[k], next);
            iterations += 1;
            let mut column = Vec::with_capacity(k + 2);
            for v in known.iter() {
                let share = dot(&weights, v, next);
                next.iter_mut().zip(v).for_each(|(n, v)| *n -= share * v);
                column.push(share);
            }
            let rest = norm(&weights, next);
            if rest > 0.0 {
                next.iter_mut().for_each(|v| *v /= rest);
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
        if columns.is_empty() {
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
        for (share, v) in shares.iter().zip(basis.iter()) {
            x.iter_mut().zip(v).for_each(|(x, v)| *x += share * v);
        }
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
    fn a_system_that_is_not_symmetric_is_solved_also_across_a_restart() {
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
            let mut x = vec![0.0; n];
            let outcome = solve(
                &mut system,
                &mut x,
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
