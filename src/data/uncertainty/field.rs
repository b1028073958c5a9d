//! A Gaussian random field on a tube, by the modes that carry most of its variance (Karhunen-Loève).

use fsi_numerics::quadrature::Rule;
use nalgebra::{DMatrix, SymmetricEigen};
use std::f64::consts::{PI, SQRT_2, TAU};

/// Gauss points of a fade, and of a part as long as the correlation, at least.
const POINTS: usize = 6;
/// Points along a field, at most.
const MOST_POINTS: usize = 400;
/// Points around, for the Fourier coefficients of the correlation: exact to rounding for angles of a few degrees.
const AROUND: usize = 720;
/// What carries a smaller share of the variance is not a mode: rounding errors of the covariance are as large.
const LEAST_SHARE: f64 = 1e-8;

/// How a field varies. Its mean is zero, and its covariance is
/// `σ² w(s) w(s') exp(-((s - s')/l)²) exp(-(sin((φ - φ')/2) / sin(α/2))²)`: each correlation falls to 1/e over its
/// length. Both are Gaussian in the distance of two points of a circular tube across and along it, so that the product
/// is positive definite. `w` fades from 1 to 0 at the ends, by half a cosine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covariance {
    /// Standard deviation `σ` where nothing fades.
    pub deviation: f64,
    /// Arc lengths of the ends.
    pub range: [f64; 2],
    /// Length of a fade; two of them are not longer than the range.
    pub fade: f64,
    /// Correlation length `l` along the tube.
    pub along: f64,
    /// Correlation angle `α` (rad), at most π; none if the field does not depend on the angle.
    pub around: Option<f64>,
}

impl Covariance {
    /// The weight `w` at `s`: 0 at the ends and beyond.
    pub fn weight(&self, s: f64) -> f64 {
        let [from, to] = self.range;
        let inside = (s - from).min(to - s);
        match inside {
            _ if inside <= 0.0 => 0.0,
            _ if inside >= self.fade => 1.0,
            _ => 0.5 * (1.0 - (PI * inside / self.fade).cos()),
        }
    }

    /// Of the values at two points `(s, φ)`.
    pub fn between(&self, [s, phi]: [f64; 2], [t, psi]: [f64; 2]) -> f64 {
        let along = self.weight(s) * self.weight(t) * self.gaussian(s - t);
        self.deviation.powi(2) * along * self.correlation_around(phi - psi)
    }

    fn gaussian(&self, distance: f64) -> f64 {
        (-(distance / self.along).powi(2)).exp()
    }

    fn correlation_around(&self, angle: f64) -> f64 {
        let chord = |angle: f64| (0.5 * angle).sin().powi(2);
        self.around
            .map_or(1.0, |around| (-chord(angle) / chord(around)).exp())
    }

    /// Shares of the waves `m = 0, 1, …` around in the variance at a point: `v_0 + 2 v_1 + 2 v_2 + … = 1`.
    fn waves(&self) -> Vec<f64> {
        let share = |m: usize| {
            let terms = (0..AROUND).map(|i| {
                let angle = TAU * i as f64 / AROUND as f64;
                self.correlation_around(angle) * (m as f64 * angle).cos()
            });
            terms.sum::<f64>() / AROUND as f64
        };
        match self.around {
            None => vec![1.0],
            Some(_) => (0..AROUND / 2)
                .map(share)
                .take_while(|share| *share > LEAST_SHARE)
                .collect(),
        }
    }

    /// Points and weights of Gauss' rule in both fades and between, which have enough for the correlation length.
    /// `None` if that is too short for [`RandomField`].
    fn points(&self) -> Option<(Vec<f64>, Vec<f64>)> {
        let [from, to] = self.range;
        let inner = [from + self.fade, to - self.fade];
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for [a, b] in [[from, inner[0]], inner, [inner[1], to]] {
            if b - a <= 1e-12 * (to - from) {
                continue;
            }
            let lengths = (b - a) / self.along;
            let count = POINTS + (POINTS as f64 * lengths).min(MOST_POINTS as f64) as usize;
            let rule = Rule::gauss_legendre(count);
            points.extend(rule.points.iter().map(|x| a + 0.5 * (b - a) * (1.0 + x)));
            weights.extend(rule.weights.iter().map(|w| 0.5 * (b - a) * w));
        }
        (points.len() <= MOST_POINTS).then_some((points, weights))
    }
}

/// A mode: `√(variance) φ(s) ψ(φ)` with `∫φ² ds = 1`, and ψ = 1, √2 cos mφ or √2 sin mφ.
#[derive(Debug, Clone, PartialEq)]
struct Mode {
    /// Eigenvalue of the covariance: its part of `∫∫ Var ds dφ/(2π)`.
    variance: f64,
    /// Eigenvalue along the tube alone, of a standard deviation of 1.
    along: f64,
    /// φ at the points.
    shape: Vec<f64>,
    wave: Wave,
}

/// A function around.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Wave {
    number: usize,
    is_sine: bool,
}

impl Wave {
    fn at(self, phi: f64) -> f64 {
        let angle = self.number as f64 * phi;
        match (self.number, self.is_sine) {
            (0, _) => 1.0,
            (_, false) => SQRT_2 * angle.cos(),
            (_, true) => SQRT_2 * angle.sin(),
        }
    }
}

/// The modes of a Gaussian field that carry most of its variance, the largest first. A mode of waves around comes as
/// cosine and sine, in this order; along the tube each begins with positive values.
///
/// The eigenfunctions along are those of Nyström's method: exact at Gauss points, and in between the integral of the
/// covariance with them.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomField {
    covariance: Covariance,
    points: Vec<f64>,
    weights: Vec<f64>,
    modes: Vec<Mode>,
    /// `∫∫ Var ds dφ/(2π)` of the whole field.
    variance: f64,
    /// Modes that the whole field has.
    all: usize,
}

impl RandomField {
    /// The first `count` modes, fewer if the field has no more. `None` if the correlation length along is too short for
    /// its range: more than about 60 of them.
    pub fn new(covariance: Covariance, count: usize) -> Option<Self> {
        let (points, weights) = covariance.points()?;
        let n = points.len();
        let w: Vec<f64> = points.iter().map(|s| covariance.weight(*s)).collect();
        let matrix = DMatrix::from_fn(n, n, |i, j| {
            let roots = (weights[i] * weights[j]).sqrt();
            roots * w[i] * w[j] * covariance.gaussian(points[i] - points[j])
        });
        let total = matrix.trace();
        let eigen = SymmetricEigen::new(matrix);
        let waves = covariance.waves();
        let mut modes = Vec::new();
        for (k, along) in eigen.eigenvalues.iter().copied().enumerate() {
            let vector = eigen.eigenvectors.column(k);
            let shape: Vec<f64> = (vector.iter().zip(&weights))
                .map(|(q, weight)| q / weight.sqrt())
                .collect();
            let shape = begins_positive(shape);
            for (number, share) in waves.iter().enumerate() {
                if along * share < LEAST_SHARE * total {
                    continue;
                }
                let both: &[bool] = if number == 0 {
                    &[false]
                } else {
                    &[false, true]
                };
                modes.extend(both.iter().map(|&is_sine| Mode {
                    variance: covariance.deviation.powi(2) * along * share,
                    along,
                    shape: shape.clone(),
                    wave: Wave { number, is_sine },
                }));
            }
        }
        modes.sort_by(|a, b| b.variance.total_cmp(&a.variance));
        let all = modes.len();
        modes.truncate(count);
        Some(Self {
            variance: covariance.deviation.powi(2) * total,
            covariance,
            points,
            weights,
            modes,
            all,
        })
    }

    /// Modes that the whole field has, but for those that rounding hides.
    pub fn all(&self) -> usize {
        self.all
    }

    /// The share of each mode in the variance of the whole field.
    pub fn shares(&self) -> Vec<f64> {
        let shares = self.modes.iter().map(|mode| mode.variance / self.variance);
        shares.collect()
    }

    /// The field with these amplitudes of its first modes.
    pub fn realization(&self, amplitudes: &[f64]) -> Realization {
        let mut waves: Vec<(Wave, Vec<f64>)> = Vec::new();
        for (mode, amplitude) in self.modes.iter().zip(amplitudes) {
            if *amplitude == 0.0 {
                continue;
            }
            let place = waves.iter().position(|(wave, _)| *wave == mode.wave);
            let place = place.unwrap_or_else(|| {
                waves.push((mode.wave, vec![0.0; self.points.len()]));
                waves.len() - 1
            });
            // √λ φ(s) = √λ/μ ∫ w(s) w(t) exp(-((s - t)/l)²) φ(t) dt with the eigenvalue μ along.
            let factor = amplitude * mode.variance.sqrt() / mode.along;
            for (j, sum) in waves[place].1.iter_mut().enumerate() {
                let weight = self.weights[j] * self.covariance.weight(self.points[j]);
                *sum += factor * weight * mode.shape[j];
            }
        }
        Realization {
            covariance: self.covariance,
            points: self.points.clone(),
            waves,
        }
    }
}

/// With the sign that makes it begin with positive values.
fn begins_positive(mut shape: Vec<f64>) -> Vec<f64> {
    let largest = shape.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let first = shape.iter().find(|x| x.abs() > 0.1 * largest);
    if first.is_some_and(|x| *x < 0.0) {
        shape.iter_mut().for_each(|x| *x = -*x);
    }
    shape
}

/// A field with given amplitudes of its modes.
#[derive(Debug, Clone, PartialEq)]
pub struct Realization {
    covariance: Covariance,
    points: Vec<f64>,
    /// For each wave around the factors of the Gaussians about the points.
    waves: Vec<(Wave, Vec<f64>)>,
}

impl Realization {
    /// The value at the arc length `s` and the angle `phi`; zero where the field has ended.
    pub fn value(&self, s: f64, phi: f64) -> f64 {
        let fade = self.covariance.weight(s);
        if fade == 0.0 || self.waves.is_empty() {
            return 0.0;
        }
        let near = self.points.iter().map(|t| self.covariance.gaussian(s - t));
        let near: Vec<f64> = near.collect();
        let of_wave = |(wave, factors): &(Wave, Vec<f64>)| {
            let along: f64 = factors.iter().zip(&near).map(|(b, e)| b * e).sum();
            along * wave.at(phi)
        };
        fade * self.waves.iter().map(of_wave).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// A third of an artery of the paper as correlation length.
    const FIELD: Covariance = Covariance {
        deviation: 0.25e-3,
        range: [0.03, 0.06],
        fade: 0.006,
        along: 0.01,
        around: Some(0.5 * PI),
    };

    fn field(count: usize) -> RandomField {
        RandomField::new(FIELD, count).unwrap()
    }

    /// The covariance of the kept modes at two points.
    fn kept(field: &RandomField, a: [f64; 2], b: [f64; 2]) -> f64 {
        let modes = 0..field.modes.len();
        let product = |k: usize| {
            let mut amplitudes = vec![0.0; k + 1];
            amplitudes[k] = 1.0;
            let mode = field.realization(&amplitudes);
            mode.value(a[0], a[1]) * mode.value(b[0], b[1])
        };
        modes.map(product).sum()
    }

    /// ∫w² ds of a half cosine of the length L is 3/8 L.
    #[test]
    fn eigenvalues_sum_to_the_variance() {
        let all = field(usize::MAX);
        let exact = FIELD.deviation.powi(2) * (0.03 - 2.0 * 0.006 + 2.0 * 0.375 * 0.006);
        assert_relative_eq!(all.variance, exact, max_relative = 1e-12);
        let sum: f64 = all.shares().iter().sum();
        assert!(sum > 1.0 - 1e-6 && sum < 1.0 + 1e-12, "{sum}");
        let shares = all.shares();
        assert!(shares.windows(2).all(|pair| pair[0] >= pair[1]));
        // Two of circles, then a pair of waves once around.
        let waves = all
            .modes
            .iter()
            .map(|mode| (mode.wave.number, mode.wave.is_sine));
        let waves: Vec<_> = waves.take(4).collect();
        assert_eq!(waves, [(0, false), (0, false), (1, false), (1, true)]);
    }

    #[test]
    fn the_covariance_of_all_modes_is_the_formula() {
        let all = field(usize::MAX);
        let points = [
            [0.045, 0.0],
            [0.045, 1.0],
            [0.0413, 2.9],
            [0.0322, -0.4],
            [0.0587, 0.3],
        ];
        for a in points {
            for b in points {
                let (found, exact) = (kept(&all, a, b), FIELD.between(a, b));
                let error = (found - exact) / FIELD.deviation.powi(2);
                assert!(error.abs() < 1e-5, "{a:?} {b:?}: {error:.1e}");
            }
        }
        // 1/e after each length, in the middle.
        let e = FIELD.between([0.04, 0.3], [0.05, 0.3]) / FIELD.deviation.powi(2);
        assert_relative_eq!(e, (-1.0_f64).exp(), max_relative = 1e-12);
        let e = FIELD.between([0.045, 0.3], [0.045, 0.3 + 0.5 * PI]) / FIELD.deviation.powi(2);
        assert_relative_eq!(e, (-1.0_f64).exp(), max_relative = 1e-12);
    }

    /// Twelve modes leave a small part of the variance out, and nowhere add to it.
    #[test]
    fn few_modes_carry_most_of_the_variance() {
        let twelve = field(12);
        let share: f64 = twelve.shares().iter().sum();
        assert!((0.92..0.95).contains(&share), "{share}");
        for s in [0.036, 0.045, 0.054] {
            let here = kept(&twelve, [s, 0.7], [s, 0.7]) / FIELD.deviation.powi(2);
            assert!((0.7..1.0).contains(&here), "{s}: {here}");
        }
    }

    /// The modes are orthogonal, and of the length that their variance says.
    #[test]
    fn modes_are_orthogonal() {
        let field = field(8);
        let rule = Rule::gauss_legendre(80);
        let single = |k: usize| {
            let mut amplitudes = [0.0; 8];
            amplitudes[k] = 1.0;
            field.realization(&amplitudes)
        };
        let product = |a: &Realization, b: &Realization| {
            let along = rule.points.iter().zip(&rule.weights);
            let along = along.map(|(x, w)| {
                let s = 0.045 + 0.015 * x;
                let around = (0..24).map(|i| TAU * f64::from(i) / 24.0);
                let around = around.map(|phi| a.value(s, phi) * b.value(s, phi) / 24.0);
                0.015 * w * around.sum::<f64>()
            });
            along.sum::<f64>()
        };
        for i in 0..8 {
            for j in 0..8 {
                let expected = if i == j { field.modes[i].variance } else { 0.0 };
                let error = product(&single(i), &single(j)) - expected;
                assert!(error.abs() < 1e-5 * field.variance, "{i} {j}: {error:.1e}");
            }
        }
    }

    #[test]
    fn nothing_is_left_where_the_field_ends() {
        let realization = field(12).realization(&[1.0; 12]);
        for s in [-0.01, 0.03, 0.06, 0.08] {
            assert_eq!(realization.value(s, 0.4), 0.0);
        }
        // Without a kink: quadratically.
        let near = realization.value(0.03 + 6e-6, 0.4) / realization.value(0.03 + 3e-6, 0.4);
        assert!((3.9..4.1).contains(&near), "{near}");
        assert_eq!(field(12).realization(&[0.0; 12]).value(0.045, 0.4), 0.0);
    }

    #[test]
    fn circles_stay_circles_without_an_angle() {
        let round = Covariance {
            around: None,
            ..FIELD
        };
        let field = RandomField::new(round, 4).unwrap();
        let realization = field.realization(&[1.0, -0.5, 0.3, 2.0]);
        let value = realization.value(0.041, 0.0);
        assert!(value.abs() > 1e-5);
        assert_eq!(realization.value(0.041, 2.0), value);
        let short = Covariance {
            along: 1e-4,
            ..FIELD
        };
        assert_eq!(RandomField::new(short, 4), None);
    }
}
