//! Interpolation by cubics, and the nearest of many points: pure mathematics, no units.

mod nearest;
mod smoothing;

use nalgebra::DMatrix;
pub use nearest::Nearest;
pub use smoothing::{SmoothingSpline, smooth_periodic};

/// How a spline continues at the ends of its interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SplineEnds {
    /// The slope is zero at both ends; the support points include both ends.
    Flat,
    /// The second derivative is zero at both ends; the support points include both ends.
    Natural,
    /// The spline repeats itself; the end, which equals the beginning, is no support point of its own.
    Periodic,
}

/// Matrix that turns values at `n` support points of unit distance into the second derivatives of their cubic spline.
fn second_derivatives(n: usize, ends: SplineEnds) -> DMatrix<f64> {
    // M_{i-1} + 4 M_i + M_{i+1} = 6 (v_{i-1} - 2 v_i + v_{i+1}); with a flat end 2 M_0 + M_1 = 6 (v_1 - v_0), with a
    // natural one M_0 = 0.
    let (mut left, mut right) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
    for i in 0..n {
        if ends == SplineEnds::Natural && (i == 0 || i == n - 1) {
            left[(i, i)] = 1.0;
            continue;
        }
        let (before, after) = match ends {
            SplineEnds::Periodic => (Some((i + n - 1) % n), Some((i + 1) % n)),
            SplineEnds::Flat | SplineEnds::Natural => {
                (i.checked_sub(1), (i + 1 < n).then_some(i + 1))
            }
        };
        for neighbour in [before, after].into_iter().flatten() {
            left[(i, i)] += 2.0;
            left[(i, neighbour)] += 1.0;
            right[(i, i)] -= 6.0;
            right[(i, neighbour)] += 6.0;
        }
    }
    left.lu()
        .solve(&right)
        .expect("the spline's matrix is strictly diagonally dominant")
}

/// Position `t` in units of the support distance: index of the interval's ends and the weights of
/// value and second derivative there.
struct Interval {
    ends: [usize; 2],
    value: [f64; 2],
    curvature: [f64; 2],
}

impl Interval {
    fn find(t: f64, n: usize, ends: SplineEnds) -> Self {
        let (first, b, second) = match ends {
            SplineEnds::Flat | SplineEnds::Natural => {
                let t = t.clamp(0.0, (n - 1) as f64);
                let first = (t as usize).min(n - 2);
                (first, t - first as f64, first + 1)
            }
            SplineEnds::Periodic => {
                let t = t.rem_euclid(n as f64);
                let first = (t as usize).min(n - 1);
                (first, t - first as f64, (first + 1) % n)
            }
        };
        let a = 1.0 - b;
        let curvature = |w: f64| (w * w * w - w) / 6.0;
        Self {
            ends: [first, second],
            value: [a, b],
            curvature: [curvature(a), curvature(b)],
        }
    }
}

/// A function through values at ascending places, without overshooting: cubic Hermite polynomials with the slopes of
/// Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984), straight between two places, constant beyond the ends.
#[derive(Debug, Clone, PartialEq)]
pub struct MonotoneCubic {
    places: Vec<f64>,
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl MonotoneCubic {
    /// The same everywhere.
    pub fn constant(value: f64) -> Self {
        Self::new(vec![0.0], vec![value])
    }

    /// Through values at ascending places, without overshooting: cubic Hermite polynomials with the slopes of Fritsch
    /// and Butland (SIAM J. Sci. Stat. Comput. 5, 1984), straight with two places; beyond the ends constant.
    pub fn new(places: Vec<f64>, values: Vec<f64>) -> Self {
        let n = places.len();
        let secant = |i: usize| (values[i + 1] - values[i]) / (places[i + 1] - places[i]);
        let slope = |i: usize| match (i, n) {
            (_, 1) => 0.0,
            (0, _) => secant(0),
            (i, _) if i == n - 1 => secant(n - 2),
            (i, _) => {
                let (before, after) = (secant(i - 1), secant(i));
                if before * after <= 0.0 {
                    return 0.0;
                }
                let (h, k) = (places[i] - places[i - 1], places[i + 1] - places[i]);
                let (u, v) = (h + 2.0 * k, 2.0 * h + k);
                (u + v) / (u / before + v / after)
            }
        };
        Self {
            slopes: (0..n).map(slope).collect(),
            places,
            values,
        }
    }

    /// With places counted from elsewhere.
    pub fn shifted(mut self, by: f64) -> Self {
        self.places.iter_mut().for_each(|place| *place += by);
        self
    }

    /// Mean value between two places.
    pub fn mean(&self, from: f64, to: f64) -> f64 {
        const SAMPLES: usize = 200;
        let at = |i: usize| self.at(from + (to - from) * (i as f64 + 0.5) / SAMPLES as f64);
        (0..SAMPLES).map(at).sum::<f64>() / SAMPLES as f64
    }

    /// Value at `s`.
    pub fn at(&self, s: f64) -> f64 {
        let next = self.places.partition_point(|place| *place <= s);
        if next == 0 || next == self.places.len() {
            return self.values[next.saturating_sub(1).min(self.values.len() - 1)];
        }
        let i = next - 1;
        let h = self.places[next] - self.places[i];
        let t = (s - self.places[i]) / h;
        let (r, q) = (1.0 - t, t * t * (3.0 - 2.0 * t));
        self.values[i] * (1.0 - q)
            + self.values[next] * q
            + h * t * r * (r * self.slopes[i] - t * self.slopes[next])
    }
}

/// Bicubic spline surface on `[0, 1] × [0, 1)`: flat or natural ends in the first direction, periodic in the second.
#[derive(Debug, Clone, PartialEq)]
pub struct BicubicSurface {
    /// Values, their second derivatives in the first direction, in the second, and in both.
    tables: [DMatrix<f64>; 4],
}

impl BicubicSurface {
    /// Interpolates `values`: rows at `i/(rows-1)`, columns at `j/columns`; flat ends.
    ///
    /// # Panics
    /// If there are fewer than two rows or three columns, or the rows differ in length.
    pub fn new(values: &[Vec<f64>]) -> Self {
        Self::with_ends(values, SplineEnds::Flat)
    }

    /// As [`BicubicSurface::new`], with flat or natural ends.
    ///
    /// # Panics
    /// As there.
    pub fn with_ends(values: &[Vec<f64>], ends: SplineEnds) -> Self {
        let (rows, columns) = (values.len(), values.first().map_or(0, Vec::len));
        assert!(
            rows >= 2 && columns >= 3,
            "a surface needs at least 2 by 3 support values"
        );
        assert!(
            values.iter().all(|row| row.len() == columns),
            "rows of support values differ in length"
        );
        let v = DMatrix::from_fn(rows, columns, |i, j| values[i][j]);
        let along = second_derivatives(rows, ends);
        let around = second_derivatives(columns, SplineEnds::Periodic).transpose();
        let (v_along, v_around) = (&along * &v, &v * &around);
        let v_both = &v_along * &around;
        Self {
            tables: [v, v_along, v_around, v_both],
        }
    }

    /// Value at `u` in [0, 1] (clamped) and `v` (taken modulo 1).
    pub fn value(&self, u: f64, v: f64) -> f64 {
        let (rows, columns) = self.tables[0].shape();
        let along = Interval::find(u * (rows - 1) as f64, rows, SplineEnds::Flat);
        let around = Interval::find(v * columns as f64, columns, SplineEnds::Periodic);
        let mut sum = 0.0;
        for (a, &i) in along.ends.iter().enumerate() {
            for (b, &j) in around.ends.iter().enumerate() {
                // The `map` of an array, which this crate's level of optimization leaves as calls, takes twice as long.
                let of = |table: usize| self.tables[table][(i, j)];
                sum += along.value[a] * (around.value[b] * of(0) + around.curvature[b] * of(2))
                    + along.curvature[a] * (around.value[b] * of(1) + around.curvature[b] * of(3));
            }
        }
        sum
    }

    /// The largest value and its place `(value, u, v)`.
    pub fn maximum(&self) -> (f64, f64, f64) {
        self.extreme(1.0)
    }

    /// The smallest value and its place `(value, u, v)`.
    pub fn minimum(&self) -> (f64, f64, f64) {
        let (value, u, v) = self.extreme(-1.0);
        (-value, u, v)
    }

    /// Maximum of `sign` times the surface: samples, then a search on ever finer grids around each high sample.
    fn extreme(&self, sign: f64) -> (f64, f64, f64) {
        const SAMPLES: usize = 12;
        let (rows, columns) = self.tables[0].shape();
        let (nu, nv) = ((rows - 1) * SAMPLES, columns * SAMPLES);
        let at = |i: usize, j: usize| sign * self.value(i as f64 / nu as f64, j as f64 / nv as f64);
        let samples = DMatrix::from_fn(nu + 1, nv, at);
        let mut best = (f64::NEG_INFINITY, 0.0, 0.0);
        for i in 0..=nu {
            for j in 0..nv {
                // Of equal samples side by side, such as those of a flat part, the first one counts.
                let lower = |k: usize| {
                    let near = ((i + k / 3).clamp(1, nu + 1) - 1, (j + nv + k % 3 - 1) % nv);
                    samples[near] < samples[(i, j)]
                        || samples[near] == samples[(i, j)] && near >= (i, j)
                };
                let peak = (0..9).all(lower);
                if peak {
                    let refined = self.climb(
                        sign,
                        i as f64 / nu as f64,
                        j as f64 / nv as f64,
                        1.0 / nu as f64,
                    );
                    if refined.0 > best.0 {
                        best = refined;
                    }
                }
            }
        }
        best
    }

    fn climb(&self, sign: f64, u: f64, v: f64, mut step: f64) -> (f64, f64, f64) {
        let mut best = (sign * self.value(u, v), u, v);
        while step > 1e-10 {
            let centre = best;
            for k in 0..9 {
                let (u, v) = (
                    centre.1 + step * (k / 3 - 1) as f64,
                    centre.2 + step * (k % 3 - 1) as f64,
                );
                let u = u.clamp(0.0, 1.0);
                let value = sign * self.value(u, v);
                if value > best.0 {
                    best = (value, u, v);
                }
            }
            if best.0 <= centre.0 {
                step *= 0.5;
            }
        }
        (best.0, best.1, best.2.rem_euclid(1.0))
    }
}
