//! Smoothing splines: curves that scatter less than the points they come from.

/// The cubic spline `g` through scattering values that makes `Σ w_i |y_i - g_i|²/λ_i + ∫ |g''|²` smallest, where `w_i`
/// is the distance for which a value stands (Reinsch, *Smoothing by spline functions*, Numer. Math. 10, 1967). With
/// `λ_i = (L/2π)⁴` a wave of the length `L` keeps half of its height, one of three times that 99 %, one of a third 1 %;
/// a straight line stays what it is. `L` may differ from place to place.
#[derive(Debug, Clone, PartialEq)]
pub struct SmoothingSpline<const N: usize> {
    places: Vec<f64>,
    values: Vec<[f64; N]>,
    /// Second derivatives.
    bends: Vec<[f64; N]>,
}

impl<const N: usize> SmoothingSpline<N> {
    /// Smooths `values` at ascending `places`; waves of the length `halved` keep half of their height.
    ///
    /// # Panics
    /// If there are not as many places as values, or fewer than two.
    pub fn new(places: &[f64], values: &[[f64; N]], halved: f64) -> Self {
        Self::with_lengths(places, values, &vec![halved; places.len()])
    }

    /// As [`SmoothingSpline::new`], with a length of its own for each place.
    ///
    /// # Panics
    /// If there are not as many places as values and lengths, or fewer than two.
    pub fn with_lengths(places: &[f64], values: &[[f64; N]], halved: &[f64]) -> Self {
        let n = places.len();
        assert!(n >= 2 && n == values.len(), "a spline needs two values");
        assert_eq!(n, halved.len(), "each value has its length");
        let lambda = |i: usize| (halved[i] / std::f64::consts::TAU).powi(4);
        let h: Vec<f64> = places.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let weight = |i: usize| {
            let previous = if i > 0 { h[i - 1] } else { 0.0 };
            0.5 * (previous + h.get(i).copied().unwrap_or(0.0))
        };
        let weights: Vec<f64> = (0..n).map(weight).collect();
        // Column j of Q has the second difference at the inner place j + 1.
        let inner = n - 2;
        let column = |j: usize| {
            let (previous, after) = (1.0 / h[j], 1.0 / h[j + 1]);
            [previous, -previous - after, after]
        };
        let columns: Vec<[f64; 3]> = (0..inner).map(column).collect();
        // (R + Qᵀ Λ W⁻¹ Q) γ = Qᵀ y, with two diagonals next to the main one.
        let product = |j: usize, off: usize| {
            let shared = (off..3).map(|row| {
                let share = lambda(j + row) / weights[j + row];
                columns[j][row] * columns[j + off][row - off] * share
            });
            shared.sum::<f64>()
        };
        let mut diagonals = vec![[0.0; 3]; inner];
        for j in 0..inner {
            diagonals[j][0] = (h[j] + h[j + 1]) / 3.0 + product(j, 0);
            if j + 1 < inner {
                diagonals[j][1] = h[j + 1] / 6.0 + product(j, 1);
            }
            if j + 2 < inner {
                diagonals[j][2] = product(j, 2);
            }
        }
        let second_difference = |j: usize| -> [f64; N] {
            std::array::from_fn(|c| (0..3).map(|k| columns[j][k] * values[j + k][c]).sum())
        };
        let mut curvature: Vec<[f64; N]> = (0..inner).map(second_difference).collect();
        solve_banded(&mut diagonals, &mut curvature);
        let mut bends = vec![[0.0; N]; n];
        let mut smooth = values.to_vec();
        for j in 0..inner {
            bends[j + 1] = curvature[j];
            for k in 0..3 {
                let share = lambda(j + k) * columns[j][k] / weights[j + k];
                for c in 0..N {
                    smooth[j + k][c] -= share * curvature[j][c];
                }
            }
        }
        Self {
            places: places.to_vec(),
            values: smooth,
            bends,
        }
    }

    /// The smooth values at the places.
    pub fn values(&self) -> &[[f64; N]] {
        &self.values
    }

    /// First and second derivative at the place of this number.
    pub fn derivatives(&self, i: usize) -> [[f64; N]; 2] {
        let last = self.places.len() - 1;
        let (a, b) = if i < last { (i, i + 1) } else { (i - 1, i) };
        let h = self.places[b] - self.places[a];
        let [near, far] = if i < last { [2.0, 1.0] } else { [-1.0, -2.0] };
        let slope = std::array::from_fn(|c| {
            let bends = near * self.bends[a][c] + far * self.bends[b][c];
            (self.values[b][c] - self.values[a][c]) / h - h / 6.0 * bends
        });
        [slope, self.bends[i]]
    }

    /// The value at `x`, between the first place and the last.
    pub fn at(&self, x: f64) -> [f64; N] {
        let next = self.places.partition_point(|place| *place <= x);
        let i = next.clamp(1, self.places.len() - 1) - 1;
        let h = self.places[i + 1] - self.places[i];
        let b = ((x - self.places[i]) / h).clamp(0.0, 1.0);
        let a = 1.0 - b;
        let cubic = |w: f64| (w * w * w - w) * h * h / 6.0;
        std::array::from_fn(|c| {
            a * self.values[i][c]
                + b * self.values[i + 1][c]
                + cubic(a) * self.bends[i][c]
                + cubic(b) * self.bends[i + 1][c]
        })
    }
}

/// Solves a symmetric positive definite system with the main diagonal and two next to it, by `L D Lᵀ`; the right-hand
/// side becomes the solution.
fn solve_banded<const N: usize>(diagonals: &mut [[f64; 3]], right: &mut [[f64; N]]) {
    let n = diagonals.len();
    for j in 0..n {
        let [pivot, first, second] = diagonals[j];
        let factors = [first / pivot, second / pivot];
        for (k, factor) in factors.into_iter().enumerate() {
            let row = j + 1 + k;
            if row < n {
                diagonals[row][0] -= factor * diagonals[j][1 + k];
                for c in 0..N {
                    right[row][c] -= factor * right[j][c];
                }
            }
        }
        if j + 2 < n {
            diagonals[j + 1][1] -= factors[0] * second;
        }
    }
    for j in (0..n).rev() {
        let [pivot, first, second] = diagonals[j];
        for c in 0..N {
            let mut value = right[j][c];
            if j + 1 < n {
                value -= first * right[j + 1][c];
            }
            if j + 2 < n {
                value -= second * right[j + 2][c];
            }
            right[j][c] = value / pivot;
        }
    }
}

/// Smooths values in equal angles around a circle of the circumference `around`, as a periodic [`SmoothingSpline`] of
/// many values does: the wave with `k` turns keeps the share `1/(1 + (k halved/around)⁴)`.
pub fn smooth_periodic(values: &[f64], around: f64, halved: f64) -> Vec<f64> {
    let n = values.len();
    let angle = |i: usize, k: usize| std::f64::consts::TAU * ((i * k) % n) as f64 / n as f64;
    let mut smooth = vec![values.iter().sum::<f64>() / n as f64; n];
    for k in 1..=n / 2 {
        let sum = |wave: fn(f64) -> f64| -> f64 {
            (values.iter().enumerate())
                .map(|(i, value)| value * wave(angle(i, k)))
                .sum()
        };
        // The highest wave of an even number of values has no counterpart.
        let norm = if 2 * k == n { 1.0 } else { 2.0 } / n as f64;
        let share = norm / (1.0 + (k as f64 * halved / around).powi(4));
        let (cosine, sine) = (share * sum(f64::cos), share * sum(f64::sin));
        for (i, value) in smooth.iter_mut().enumerate() {
            *value += cosine * angle(i, k).cos() + sine * angle(i, k).sin();
        }
    }
    smooth
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn places() -> Vec<f64> {
        // Unequal distances.
        let place = |i: i32| 0.1 * f64::from(i) + 0.02 * f64::from(i % 3);
        (0..600).map(place).collect()
    }

    #[test]
    fn a_straight_line_stays_and_without_smoothing_everything_does() {
        let places = places();
        let line: Vec<[f64; 2]> = places.iter().map(|x| [3.0 - 0.7 * x, 1.0]).collect();
        let smooth = SmoothingSpline::new(&places, &line, 5.0);
        for (a, b) in smooth.values().iter().zip(&line) {
            assert!((a[0] - b[0]).abs() < 1e-9 && (a[1] - b[1]).abs() < 1e-9);
        }
        let wave: Vec<[f64; 1]> = places.iter().map(|x| [x.sin()]).collect();
        let same = SmoothingSpline::new(&places, &wave, 0.0);
        assert_eq!(same.values(), &wave[..]);
        let middle = 0.5 * (places[300] + places[301]);
        assert!((same.at(middle)[0] - middle.sin()).abs() < 2e-5);
    }

    #[test]
    fn only_a_part_may_be_smoothed() {
        let places = places();
        let wave: Vec<[f64; 1]> = places.iter().map(|x| [(TAU * x / 3.0).sin()]).collect();
        let halved: Vec<f64> = (0..600).map(|i| if i < 300 { 0.0 } else { 3.0 }).collect();
        let smooth = SmoothingSpline::with_lengths(&places, &wave, &halved);
        let height = |part: std::ops::Range<usize>| {
            let heights = smooth.values()[part].iter().map(|v| v[0].abs());
            heights.fold(0.0, f64::max)
        };
        assert_eq!(smooth.values()[..300], wave[..300]);
        assert!(
            (height(400..500) - 0.5).abs() < 0.01,
            "{}",
            height(400..500)
        );
        // Derivatives of the wave, at both ends of an interval.
        for i in [100, 200] {
            let [slope, bend] = smooth.derivatives(i);
            let x = TAU * places[i] / 3.0;
            assert!(
                (slope[0] - TAU / 3.0 * x.cos()).abs() < 0.01,
                "{i}: {slope:?}"
            );
            assert!(
                (bend[0] + (TAU / 3.0).powi(2) * x.sin()).abs() < 0.15,
                "{i}: {bend:?}"
            );
        }
        let [slope, bend] = SmoothingSpline::new(&places[..3], &wave[..3], 0.0).derivatives(2);
        let h = places[2] - places[1];
        let chord = (wave[2][0] - wave[1][0]) / h;
        assert!(bend[0] == 0.0 && slope[0] != chord);
    }

    #[test]
    fn a_wave_of_the_length_keeps_half_of_its_height() {
        let places = places();
        for (ratio, share) in [(1.0, 0.5), (3.0, 81.0 / 82.0), (1.0 / 3.0, 1.0 / 82.0)] {
            let length = 3.0 * ratio;
            let wave: Vec<[f64; 1]> = places.iter().map(|x| [(TAU * x / length).sin()]).collect();
            let smooth = SmoothingSpline::new(&places, &wave, 3.0);
            // By projection on the wave, far from the ends.
            let middle = 150..450;
            let (mut sum, mut norm) = (0.0, 0.0);
            for i in middle {
                sum += smooth.values()[i][0] * wave[i][0];
                norm += wave[i][0].powi(2);
            }
            let found = sum / norm;
            assert!((found - share).abs() < 0.004, "{ratio}: {found} {share}");
        }
        let around: Vec<f64> = (0..48)
            .map(|i| 2.0 + (TAU * f64::from(i * 4) / 48.0).cos())
            .collect();
        let smooth = smooth_periodic(&around, 12.0, 3.0);
        for (a, b) in smooth.iter().zip(&around) {
            assert!((a - (2.0 + 0.5 * (b - 2.0))).abs() < 1e-12);
        }
    }
}
