//! Polynomials that are orthonormal for the distribution of a germ, and products of them.

use super::distribution::Germ;
use crate::quadrature::Rule;

/// Gauss points by which the moments of a bounded normal germ are integrated.
const GAUSS_POINTS: usize = 200;
/// A normal germ beyond this weighs less than the last digit.
const FAR: f64 = 9.0;

/// Orthonormal polynomials of one germ: `sqrt(b[n+1]) p[n+1] = (t - a[n]) p[n] - sqrt(b[n]) p[n-1]`.
#[derive(Debug, Clone)]
pub struct Polynomials {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Polynomials {
    /// Up to a degree: Legendre's, Hermite's, or for a bounded normal germ by Stieltjes' procedure.
    pub fn new(germ: Germ, degree: usize) -> Self {
        let n = 0..=degree;
        match germ {
            Germ::Uniform => Self {
                a: vec![0.0; degree + 1],
                b: n.map(|n| (n * n) as f64 / (4.0 * (n * n) as f64 - 1.0))
                    .collect(),
            },
            Germ::Normal(low, high) if low == f64::NEG_INFINITY && high == f64::INFINITY => Self {
                a: vec![0.0; degree + 1],
                b: n.map(|n| n as f64).collect(),
            },
            Germ::Normal(low, high) => Self::of_bounded_normal(low, high, degree),
        }
    }

    fn of_bounded_normal(low: f64, high: f64, degree: usize) -> Self {
        let (low, high) = (low.max(-FAR.max(-high - 1.0)), high.min(FAR.max(low + 1.0)));
        let rule = Rule::gauss_legendre(GAUSS_POINTS);
        let nodes: Vec<f64> = (rule.points.iter())
            .map(|x| 0.5 * (low + high + (high - low) * x))
            .collect();
        let weights: Vec<f64> = (nodes.iter().zip(&rule.weights))
            .map(|(t, w)| w * (-0.5 * t * t).exp())
            .collect();
        let mean = |f: &dyn Fn(usize) -> f64| {
            let sum: f64 = (0..nodes.len()).map(|i| weights[i] * f(i)).sum();
            sum / weights.iter().sum::<f64>()
        };
        let mut found = Self {
            a: Vec::new(),
            b: vec![0.0],
        };
        let (mut before, mut p) = (vec![0.0; nodes.len()], vec![1.0; nodes.len()]);
        for n in 0..=degree {
            found.a.push(mean(&|i| nodes[i] * p[i] * p[i]));
            let next = |i: usize| (nodes[i] - found.a[n]) * p[i] - found.b[n].sqrt() * before[i];
            let next: Vec<f64> = (0..nodes.len()).map(next).collect();
            let square = mean(&|i| next[i] * next[i]);
            found.b.push(square);
            before = std::mem::replace(&mut p, next.iter().map(|x| x / square.sqrt()).collect());
        }
        found
    }

    /// Those up to a degree.
    pub fn up_to(&self, degree: usize) -> Self {
        Self {
            a: self.a[..=degree].to_vec(),
            b: self.b[..=degree].to_vec(),
        }
    }

    /// The values of all of them.
    pub fn values(&self, t: f64) -> Vec<f64> {
        let mut p = vec![1.0];
        for n in 0..self.a.len() - 1 {
            let before = if n > 0 {
                self.b[n].sqrt() * p[n - 1]
            } else {
                0.0
            };
            p.push(((t - self.a[n]) * p[n] - before) / self.b[n + 1].sqrt());
        }
        p
    }
}

/// The degrees in each germ of all products whose degrees n have at most this `norm` q, `(sum of (n/w)^q)^(1/q)`, with
/// the `weights` w of the germs (1 or less), the constant first: up to a total degree with q = 1, fewer with high
/// degrees in several germs below.
pub fn terms(weights: &[f64], degree: usize, norm: f64) -> Vec<Vec<usize>> {
    let size = |term: &[usize]| -> f64 {
        let powers = term.iter().zip(weights).filter(|(n, _)| **n > 0);
        powers.map(|(n, w)| (*n as f64 / w).powf(norm)).sum()
    };
    let inputs = weights.len();
    let most = (degree as f64).powf(norm) + 1e-9;
    let mut all = vec![vec![0; inputs]];
    let mut last = all.clone();
    for _ in 0..degree {
        let mut next = Vec::new();
        for term in &last {
            // A factor is added from the last one on, so that each product is made once.
            let from = term.iter().rposition(|&n| n > 0).unwrap_or(0);
            let longer = (from..inputs).map(|i| {
                let mut term: Vec<usize> = term.clone();
                term[i] += 1;
                term
            });
            next.extend(longer.filter(|term| size(term) <= most));
        }
        all.extend_from_slice(&next);
        last = next;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the quantiles of their distributions; Hermite's are those of tables.
    #[test]
    fn polynomials_are_orthonormal() {
        use super::super::Distribution;
        for distribution in [
            Distribution::uniform(-1.0, 1.0),
            Distribution::normal(0.0, 1.0, [-1.0, 2.0]),
            Distribution::normal(0.0, 1.0, [1.5, 2.5]),
        ] {
            let polynomials = Polynomials::new(distribution.germ, 4);
            let count = 20_000;
            let values: Vec<Vec<f64>> = (0..count)
                .map(|i| distribution.quantile((f64::from(i) + 0.5) / f64::from(count)))
                .map(|t| polynomials.values(t))
                .collect();
            for i in 0..=4 {
                for j in 0..=i {
                    let sum: f64 = values.iter().map(|p| p[i] * p[j]).sum();
                    let expected = f64::from(u8::from(i == j));
                    let error = sum / f64::from(count) - expected;
                    assert!(error.abs() < 1e-6, "{distribution:?} {i} {j}: {error}");
                }
            }
        }
        // (t³ - 3 t)/sqrt(6) and (t⁴ - 6 t² + 3)/sqrt(24)
        let hermite = Polynomials::new(Germ::Normal(f64::NEG_INFINITY, f64::INFINITY), 4);
        let found = hermite.values(1.5);
        assert!((found[3] - (3.375 - 4.5) / 6.0_f64.sqrt()).abs() < 1e-14);
        assert!((found[4] - (5.0625 - 13.5 + 3.0) / 24.0_f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn products_are_made_once() {
        let mut all = terms(&[1.0; 6], 2, 1.0);
        assert_eq!(all.len(), 28);
        assert_eq!(all[0], [0; 6]);
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 28);
        assert_eq!(terms(&[1.0; 3], 10, 1.0).len(), 286);
        // 1, x, .., x⁴, the same of y, and x y: (1 + 1)² = 4
        assert_eq!(terms(&[1.0; 2], 4, 0.5).len(), 10);
    }
}
