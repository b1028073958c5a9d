//! A mean by few expensive samples and many cheap ones: a control variate.

/// A mean with and without a control variate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlledMean {
    /// Mean of the expensive samples alone, and its standard error.
    pub plain: [f64; 2],
    /// Mean with the cheap ones, and its standard error.
    pub controlled: [f64; 2],
    /// Correlation of expensive and cheap values at the same points.
    pub correlation: f64,
}

impl ControlledMean {
    /// Of expensive values and cheap ones at the same `n` points, and cheap ones at `N` points that contain these:
    /// `mean(f) + a (mean_N(g) - mean_n(g))` with `a = cov(f, g) / var(g)`, whose variance is
    /// `var(f) (1/n - r² (1/n - 1/N))` for independent points (Giles 2015, Acta Numerica 24, section 1.2). `None` of
    /// fewer than three points, or of values that are all the same.
    pub fn new(expensive: &[f64], cheap: &[f64], cheap_everywhere: &[f64]) -> Option<Self> {
        let n = expensive.len() as f64;
        let all = cheap_everywhere.len() as f64;
        if expensive.len() < 3 || expensive.len() != cheap.len() || all < n {
            return None;
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (f, g) = (mean(expensive), mean(cheap));
        let sum = |term: &dyn Fn(f64, f64) -> f64| {
            let pairs = expensive.iter().zip(cheap);
            pairs.map(|(x, y)| term(x - f, y - g)).sum::<f64>() / (n - 1.0)
        };
        let (of_f, of_g) = (sum(&|x, _| x * x), sum(&|_, y| y * y));
        let both = sum(&|x, y| x * y);
        if of_f <= 0.0 || of_g <= 0.0 {
            return None;
        }
        let correlation = both / (of_f * of_g).sqrt();
        let left = 1.0 / n - correlation.powi(2) * (1.0 / n - 1.0 / all);
        Some(Self {
            plain: [f, (of_f / n).sqrt()],
            controlled: [
                f + both / of_g * (mean(cheap_everywhere) - g),
                (of_f * left).sqrt(),
            ],
            correlation,
        })
    }

    /// By what the variance of the mean is divided.
    pub fn variance_reduction(&self) -> f64 {
        (self.plain[1] / self.controlled[1]).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::super::design::Random;
    use super::*;

    /// f = x + 0.1 y and g = 2 x + 5 with independent x and y, uniform from 0 to 1: the correlation is
    /// 1 / sqrt(1.01), and 20 of 2000 points leave 1 - 0.99 / 1.01 of the variance. Over many repetitions the means
    /// scatter as the formula says, about 0.55.
    #[test]
    fn means_scatter_as_the_formula_says() {
        let mut random = Random(5);
        let mut found = Vec::new();
        for _ in 0..400 {
            let points: Vec<[f64; 2]> = (0..2000).map(|_| [random.unit(), random.unit()]).collect();
            let f: Vec<f64> = points[..20].iter().map(|[x, y]| x + 0.1 * y).collect();
            let g: Vec<f64> = points.iter().map(|[x, _]| 2.0 * x + 5.0).collect();
            found.push(ControlledMean::new(&f, &g[..20], &g).unwrap());
        }
        let count = found.len() as f64;
        let scatter = |of: &dyn Fn(&ControlledMean) -> f64| {
            let squares = found.iter().map(|mean| (of(mean) - 0.55).powi(2));
            (squares.sum::<f64>() / count).sqrt()
        };
        let exact = (1.01_f64 / 12.0 / 20.0).sqrt();
        let plain = scatter(&|m| m.plain[0]) / exact;
        assert!((0.92..1.08).contains(&plain), "{plain}");
        let left: f64 = (1.0 - 0.99_f64 / 1.01).sqrt();
        let controlled = scatter(&|m| m.controlled[0]) / (exact * left);
        assert!((0.92..1.12).contains(&controlled), "{controlled}");
        let said = found.iter().map(|m| m.controlled[1]).sum::<f64>() / count;
        assert!((0.85..1.05).contains(&(said / (exact * left))), "{said}");
        let correlation = found.iter().map(|m| m.correlation).sum::<f64>() / count;
        assert!(
            (correlation - 1.0 / 1.01_f64.sqrt()).abs() < 1e-3,
            "{correlation}"
        );
    }

    #[test]
    fn values_that_do_not_vary_have_no_control() {
        assert!(ControlledMean::new(&[1.0, 2.0], &[1.0, 2.0], &[1.0, 2.0]).is_none());
        assert!(ControlledMean::new(&[1.0; 4], &[1.0, 2.0, 3.0, 4.0], &[1.0; 4]).is_none());
    }
}
