//! Gauss-Legendre and Gauss-Lobatto rules with any number of points; Legendre polynomials.

/// Legendre polynomials `P_0(x), …, P_n(x)` by the three-term recurrence.
pub fn legendre(n: usize, x: f64) -> Vec<f64> {
    let mut p = Vec::with_capacity(n + 1);
    p.push(1.0);
    if n > 0 {
        p.push(x);
    }
    for k in 2..=n {
        let kf = k as f64;
        p.push(((2.0 * kf - 1.0) * x * p[k - 1] - (kf - 1.0) * p[k - 2]) / kf);
    }
    p
}

/// Points and weights of a quadrature rule on [-1, 1].
#[derive(Debug, Clone, PartialEq)]
pub struct Rule {
    /// Points in ascending order.
    pub points: Vec<f64>,
    /// Weights; their sum is 2.
    pub weights: Vec<f64>,
}

impl Rule {
    /// `n` points, exact for polynomials of degree `2n - 1`. The points are the roots of `P_n`, found by Newton's
    /// method; the weights are `2 / ((1 - x²) P_n'(x)²)`.
    pub fn gauss_legendre(n: usize) -> Self {
        let (mut points, mut weights) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n.div_ceil(2) {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let slope = |x: f64| {
                let p = legendre(n, x);
                let previous = if n > 1 { p[n - 1] } else { 1.0 };
                (p[n], n as f64 * (previous - x * p[n]) / (1.0 - x * x))
            };
            for _ in 0..100 {
                let (value, derivative) = slope(x);
                let step = value / derivative;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            if 2 * i + 1 == n {
                x = 0.0;
            }
            let derivative = slope(x).1;
            let weight = 2.0 / ((1.0 - x * x) * derivative * derivative);
            (points[i], points[n - 1 - i]) = (-x, x);
            (weights[i], weights[n - 1 - i]) = (weight, weight);
        }
        Self { points, weights }
    }

    /// `n >= 2` points that include both ends, exact for polynomials of degree `2n - 3`. The inner points are the
    /// roots of `P_{n-1}'`; the weights are `2 / (n (n-1) P_{n-1}(x)²)`.
    pub fn gauss_lobatto(n: usize) -> Self {
        assert!(n >= 2, "a Gauss-Lobatto rule has at least two points");
        let m = n - 1;
        let (mut points, mut weights) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n.div_ceil(2) {
            let mut x = (std::f64::consts::PI * i as f64 / m as f64).cos();
            if i > 0 {
                for _ in 0..100 {
                    let p = legendre(m, x);
                    let first = m as f64 * (p[m - 1] - x * p[m]) / (1.0 - x * x);
                    let second = (2.0 * x * first - (m * (m + 1)) as f64 * p[m]) / (1.0 - x * x);
                    let step = first / second;
                    x -= step;
                    if step.abs() < 1e-16 {
                        break;
                    }
                }
            }
            if 2 * i + 1 == n {
                x = 0.0;
            }
            let value = legendre(m, x)[m];
            let weight = 2.0 / ((n * m) as f64 * value * value);
            (points[i], points[n - 1 - i]) = (-x, x);
            (weights[i], weights[n - 1 - i]) = (weight, weight);
        }
        Self { points, weights }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether the rule has no points.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integral of `x^k` over [-1, 1].
    fn monomial(k: usize) -> f64 {
        if k.is_multiple_of(2) {
            2.0 / (k as f64 + 1.0)
        } else {
            0.0
        }
    }

    fn integrate(rule: &Rule, k: usize) -> f64 {
        let terms = rule.points.iter().zip(&rule.weights);
        terms.map(|(x, w)| w * x.powi(k as i32)).sum()
    }

    #[test]
    fn rules_are_exact_to_their_degree() {
        for n in 1..=20 {
            for k in 0..2 * n {
                let error = integrate(&Rule::gauss_legendre(n), k) - monomial(k);
                assert!(error.abs() < 2e-14, "Legendre {n}, x^{k}: {error:e}");
            }
        }
        for n in 2..=20 {
            for k in 0..2 * n - 2 {
                let error = integrate(&Rule::gauss_lobatto(n), k) - monomial(k);
                assert!(error.abs() < 2e-14, "Lobatto {n}, x^{k}: {error:e}");
            }
        }
    }
}
