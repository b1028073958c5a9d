//! Distributions of inputs, and the map from the unit cube to their values, dependent by a Gaussian copula.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::f64::consts::{PI, SQRT_2};

/// The distribution function of the standard normal distribution.
pub(super) fn normal_cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z / SQRT_2)
}

/// Its inverse: a rough value (Abramowitz and Stegun, 26.2.23), improved by Halley's method.
pub(super) fn normal_quantile(u: f64) -> f64 {
    if u <= 0.0 || u >= 1.0 {
        return if u <= 0.0 {
            f64::NEG_INFINITY
        } else {
            f64::INFINITY
        };
    }
    if u > 0.5 {
        return -normal_quantile(1.0 - u);
    }
    let t = (-2.0 * u.ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    (0..3).fold(above / below - t, |z, _| {
        let miss = (normal_cdf(z) - u) * (2.0 * PI).sqrt() * (0.5 * z * z).exp();
        z - miss / (1.0 + 0.5 * z * miss)
    })
}

/// The distribution of a germ, the variable of the polynomials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Germ {
    /// Uniform from -1 to 1.
    Uniform,
    /// Standard normal between these bounds, which may be infinite.
    Normal(f64, f64),
}

impl Germ {
    fn quantile(self, u: f64) -> f64 {
        match self {
            Self::Uniform => 2.0 * u - 1.0,
            // From the nearer tail, where digits are left.
            Self::Normal(low, high) if low > 0.0 => -Self::Normal(-high, -low).quantile(1.0 - u),
            Self::Normal(low, high) => {
                let [below, above] = [low, high].map(normal_cdf);
                normal_quantile(below + u * (above - below)).clamp(low, high)
            }
        }
    }

    fn cdf(self, t: f64) -> f64 {
        match self {
            Self::Uniform => 0.5 * (t + 1.0),
            Self::Normal(low, high) if low > 0.0 => 1.0 - Self::Normal(-high, -low).cdf(-t),
            Self::Normal(low, high) => {
                let [below, above] = [low, high].map(normal_cdf);
                (normal_cdf(t) - below) / (above - below)
            }
        }
    }
}

/// A distribution by its usual parameters. Bounds may be infinite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Equally likely between the bounds.
    Uniform([f64; 2]),
    /// Normal with mean and standard deviation before the bounds cut anything off.
    Normal([f64; 2], [f64; 2]),
    /// The logarithm is normal with this mean and standard deviation; the bounds are those of the value.
    Lognormal([f64; 2], [f64; 2]),
}

/// The distribution of an input: `location + scale t` of a germ `t`, or the exponential of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distribution {
    pub(super) germ: Germ,
    location: f64,
    scale: f64,
    is_log: bool,
}

impl Distribution {
    /// Equally likely between the bounds.
    pub fn uniform(low: f64, high: f64) -> Self {
        Self {
            germ: Germ::Uniform,
            location: 0.5 * (low + high),
            scale: 0.5 * (high - low),
            is_log: false,
        }
    }

    /// Normal with this mean and standard deviation, cut off at the bounds (infinite: nowhere).
    pub fn normal(mean: f64, deviation: f64, [low, high]: [f64; 2]) -> Self {
        let standard = |x: f64| (x - mean) / deviation;
        Self {
            germ: Germ::Normal(standard(low), standard(high)),
            location: mean,
            scale: deviation,
            is_log: false,
        }
    }

    /// Lognormal with this mean (above 0) and standard deviation, cut off at the bounds (0 and infinite: nowhere).
    pub fn lognormal(mean: f64, deviation: f64, bounds: [f64; 2]) -> Self {
        let variance = (deviation / mean).powi(2).ln_1p();
        let of_log = Self::normal(
            mean.ln() - 0.5 * variance,
            variance.sqrt(),
            bounds.map(f64::ln),
        );
        Self {
            is_log: true,
            ..of_log
        }
    }

    /// The value below which the share `u` lies.
    pub fn quantile(&self, u: f64) -> f64 {
        self.value(self.germ.quantile(u))
    }

    /// The share that lies below a value.
    pub fn share_below(&self, value: f64) -> f64 {
        self.germ.cdf(self.germ_of(value))
    }

    /// The share of what is not cut off by the bounds.
    pub fn kept(&self) -> f64 {
        match self.germ {
            Germ::Uniform => 1.0,
            Germ::Normal(low, high) if low > 0.0 => normal_cdf(-low) - normal_cdf(-high),
            Germ::Normal(low, high) => normal_cdf(high) - normal_cdf(low),
        }
    }

    /// By its usual parameters.
    pub fn law(&self) -> Law {
        let parameters = [self.location, self.scale];
        match self.germ {
            Germ::Uniform => Law::Uniform([-1.0, 1.0].map(|t| self.value(t))),
            Germ::Normal(low, high) => {
                let bounds = [low, high].map(|t| self.value(t));
                match self.is_log {
                    true => Law::Lognormal(parameters, bounds),
                    false => Law::Normal(parameters, bounds),
                }
            }
        }
    }

    fn value(&self, germ: f64) -> f64 {
        let x = self.location + self.scale * germ;
        if self.is_log { x.exp() } else { x }
    }

    fn germ_of(&self, value: f64) -> f64 {
        let x = if self.is_log { value.ln() } else { value };
        (x - self.location) / self.scale
    }
}

/// All inputs of a study.
#[derive(Debug, Clone)]
pub struct Inputs {
    distributions: Vec<Distribution>,
    /// Of the correlations of the normal variables behind dependent inputs.
    cholesky: Option<Cholesky<f64, Dyn>>,
    is_dependent: Vec<bool>,
}

impl Inputs {
    /// Inputs with these correlations of the normal variables behind them (a Gaussian copula), each of two different
    /// inputs; `None` if the matrix of the correlations is not positive definite.
    pub fn new(
        distributions: Vec<Distribution>,
        correlations: &[(usize, usize, f64)],
    ) -> Option<Self> {
        let n = distributions.len();
        let mut matrix = DMatrix::identity(n, n);
        let mut is_dependent = vec![false; n];
        for &(i, j, correlation) in correlations {
            (matrix[(i, j)], matrix[(j, i)]) = (correlation, correlation);
            (is_dependent[i], is_dependent[j]) = (true, true);
        }
        Some(Self {
            distributions,
            cholesky: match correlations {
                [] => None,
                _ => Some(Cholesky::new(matrix)?),
            },
            is_dependent,
        })
    }

    /// Number of inputs.
    pub fn count(&self) -> usize {
        self.distributions.len()
    }

    /// The distribution of an input by itself.
    pub fn marginal(&self, input: usize) -> &Distribution {
        &self.distributions[input]
    }

    /// Distributions of the germs: standard normal where an input depends on others.
    pub(super) fn germs(&self) -> Vec<Germ> {
        let dependent = self.is_dependent.iter().zip(&self.distributions);
        let germ = |(dependent, distribution): (&bool, &Distribution)| match dependent {
            true => Germ::Normal(f64::NEG_INFINITY, f64::INFINITY),
            false => distribution.germ,
        };
        dependent.map(germ).collect()
    }

    /// The germs at a point of the unit cube.
    pub fn germs_at(&self, point: &[f64]) -> Vec<f64> {
        let germs = self.germs().into_iter().zip(point);
        germs.map(|(germ, &u)| germ.quantile(u)).collect()
    }

    /// The values of the inputs at a point of the unit cube.
    pub fn values_at(&self, point: &[f64]) -> Vec<f64> {
        let independent = |(distribution, &u): (&Distribution, &f64)| distribution.quantile(u);
        let Some(cholesky) = &self.cholesky else {
            let all = self.distributions.iter().zip(point);
            return all.map(independent).collect();
        };
        let normal = point.iter().map(|&u| normal_quantile(u));
        let normal = cholesky.l() * DVector::from_iterator(point.len(), normal);
        let all = self.distributions.iter().enumerate();
        all.map(|(i, distribution)| match self.is_dependent[i] {
            true => distribution.quantile(normal_cdf(normal[i])),
            false => independent((distribution, &point[i])),
        })
        .collect()
    }

    /// The germs of inputs with these values.
    pub fn germs_of(&self, values: &[f64]) -> Vec<f64> {
        let all = self.distributions.iter().zip(values);
        let germs: Vec<f64> = all.map(|(d, &x)| d.germ_of(x)).collect();
        let Some(cholesky) = &self.cholesky else {
            return germs;
        };
        let normal = |i: usize| match self.is_dependent[i] {
            true => normal_quantile(self.distributions[i].germ.cdf(germs[i])),
            false => 0.0,
        };
        let dependent = DVector::from_iterator(germs.len(), (0..germs.len()).map(normal));
        let dependent = cholesky
            .l()
            .solve_lower_triangular(&dependent)
            .expect("a factor of a positive definite matrix has an inverse");
        (0..germs.len())
            .map(|i| match self.is_dependent[i] {
                true => dependent[i],
                false => germs[i],
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::sobol_point;
    use super::*;
    use approx::assert_relative_eq;

    const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// Quantiles of tables, and moments that were asked for.
    #[test]
    fn quantiles_are_those_of_tables() {
        let standard = Distribution::normal(0.0, 1.0, EVERYWHERE);
        for (u, z) in [
            (0.975, 1.959_963_984_540_054),
            (0.5, 0.0),
            (0.001, -3.090_232_306_167_813_5),
            (1e-6, -4.753_424_308_822_899),
        ] {
            assert_relative_eq!(standard.quantile(u), z, epsilon = 1e-12);
        }
        let uniform = Distribution::uniform(2.0, 4.0);
        assert_relative_eq!(uniform.quantile(0.25), 2.5, epsilon = 1e-15);
        // (φ(1) - φ(2)) / (Φ(2) - Φ(1)) above one deviation: the mean of a normal variable cut off there.
        let tail = Distribution::normal(0.0, 1.0, [1.0, 2.0]);
        let lognormal = Distribution::lognormal(3.0, 0.6, [0.0, f64::INFINITY]);
        let count = 1 << 14;
        let mean = |distribution: Distribution, power: i32| {
            let values = (0..count).map(|i| (i as f64 + 0.5) / f64::from(count));
            let sum: f64 = values.map(|u| distribution.quantile(u).powi(power)).sum();
            sum / f64::from(count)
        };
        assert_relative_eq!(mean(tail, 1), 1.383_168, epsilon = 1e-5);
        assert_relative_eq!(mean(lognormal, 1), 3.0, epsilon = 1e-3);
        let deviation = (mean(lognormal, 2) - mean(lognormal, 1).powi(2)).sqrt();
        assert_relative_eq!(deviation, 0.6, epsilon = 1e-3);
        assert_relative_eq!(tail.kept(), 0.135_905_121_98, epsilon = 1e-9);
    }

    /// Inputs keep their own distributions, have the correlation of the copula, and lead back to their germs.
    #[test]
    fn correlated_inputs_have_their_correlation() {
        let distributions = vec![
            Distribution::normal(10.0, 2.0, EVERYWHERE),
            Distribution::uniform(0.0, 1.0),
            Distribution::normal(-1.0, 0.5, EVERYWHERE),
        ];
        let inputs = Inputs::new(distributions, &[(0, 2, -0.6)]).unwrap();
        let count = 4096;
        let points: Vec<Vec<f64>> = (0..count).map(|i| sobol_point(i, 3)).collect();
        let values: Vec<Vec<f64>> = points.iter().map(|p| inputs.values_at(p)).collect();
        let mean = |f: &dyn Fn(&[f64]) -> f64| {
            values.iter().map(|x| f(x)).sum::<f64>() / values.len() as f64
        };
        assert_relative_eq!(mean(&|x| x[0]), 10.0, epsilon = 1e-2);
        let covariance = mean(&|x| (x[0] - 10.0) * (x[2] + 1.0));
        assert_relative_eq!(covariance / (2.0 * 0.5), -0.6, epsilon = 1e-2);
        for (point, values) in points.iter().zip(&values).take(50) {
            let germs = inputs.germs_at(point);
            for (a, b) in germs.iter().zip(inputs.germs_of(values)) {
                assert_relative_eq!(*a, b, epsilon = 1e-8);
            }
        }
        let three = vec![Distribution::uniform(0.0, 1.0); 3];
        let impossible = [(0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9)];
        assert!(Inputs::new(three, &impossible).is_none());
    }
}
