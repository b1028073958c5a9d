//! Formulas for one point or for several side by side, which a processor computes with the same instructions.

use crate::Mat3;
use std::ops::{Add, Mul, Neg, Sub};
use wide::f64x4;

/// Points side by side.
pub const LANES: usize = 4;

/// A number for each of [`LANES`] points.
pub type Lanes = f64x4;

/// A number, or one for each of several points.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Neg<Output = Self>
{
    /// The same number everywhere.
    fn of(value: f64) -> Self;

    /// `1/x`.
    fn inverse(self) -> Self;

    /// `e^x`.
    fn exponential(self) -> Self;

    /// `ln x`.
    fn logarithm(self) -> Self;

    /// `x`, or zero if that is negative.
    fn positive_part(self) -> Self;
}

impl Real for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn inverse(self) -> Self {
        1.0 / self
    }

    fn exponential(self) -> Self {
        self.exp()
    }

    fn logarithm(self) -> Self {
        self.ln()
    }

    fn positive_part(self) -> Self {
        self.max(0.0)
    }
}

impl Real for Lanes {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Self::splat(value)
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        Self::splat(1.0) / self
    }

    #[inline(always)]
    fn exponential(self) -> Self {
        self.exp()
    }

    #[inline(always)]
    fn logarithm(self) -> Self {
        self.ln()
    }

    #[inline(always)]
    fn positive_part(self) -> Self {
        self.fast_max(Self::splat(0.0))
    }
}

/// The first [`LANES`] numbers of a slice.
#[inline(always)]
pub fn load(values: &[f64]) -> Lanes {
    Lanes::new([values[0], values[1], values[2], values[3]])
}

/// A vector of space.
pub type Vector<T> = [T; 3];
/// A second-order tensor, `tensor[i][j]`.
pub type Tensor<T> = [[T; 3]; 3];

/// `a · b`.
#[inline(always)]
pub fn dot<T: Real>(a: &Vector<T>, b: &Vector<T>) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `A a`.
#[inline(always)]
pub fn apply<T: Real>(A: &Tensor<T>, a: &Vector<T>) -> Vector<T> {
    [dot(&A[0], a), dot(&A[1], a), dot(&A[2], a)]
}

/// `A B`.
#[inline(always)]
pub fn product<T: Real>(A: &Tensor<T>, B: &Tensor<T>) -> Tensor<T> {
    A.map(|row| [0, 1, 2].map(|j| row[0] * B[0][j] + row[1] * B[1][j] + row[2] * B[2][j]))
}

/// `A : A`.
#[inline(always)]
pub fn norm_squared<T: Real>(A: &Tensor<T>) -> T {
    dot(&A[0], &A[0]) + dot(&A[1], &A[1]) + dot(&A[2], &A[2])
}

/// The cofactors `det A A⁻ᵀ`.
#[inline(always)]
pub fn cofactors<T: Real>(A: &Tensor<T>) -> Tensor<T> {
    let cross = |a: &Vector<T>, b: &Vector<T>| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    [
        cross(&A[1], &A[2]),
        cross(&A[2], &A[0]),
        cross(&A[0], &A[1]),
    ]
}

/// `det(1 + H) - 1` without the rounding of a one: the sum of the invariants of `H`.
#[inline(always)]
pub fn volume_change<T: Real>(H: &Tensor<T>) -> T {
    let C = cofactors(H);
    let third = dot(&H[0], &C[0]);
    (H[0][0] + H[1][1] + H[2][2]) + (C[0][0] + C[1][1] + C[2][2]) + third
}

/// `ln(1 + x)` with all digits of a small `x`: `2 artanh s` with `s = x/(2 + x)`, by its series where seven terms are enough.
#[inline(always)]
pub fn ln_1p(x: Lanes) -> Lanes {
    const SMALL: f64 = 0.15;
    let all = x.to_array();
    if all.iter().any(|x| x.is_nan() || x.abs() > SMALL) {
        return Lanes::new(all.map(f64::ln_1p));
    }
    let s = x * (Lanes::of(2.0) + x).inverse();
    let square = s * s;
    // 1 + z/3 + z²/5 + …; the first term left out is below 1e-17.
    let series = [15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0, 1.0]
        .into_iter()
        .fold(Lanes::of(0.0), |sum, odd| {
            sum * square + Lanes::of(1.0 / odd)
        });
    (s + s) * series
}

/// As rows.
pub fn rows(A: &Mat3) -> Tensor<f64> {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| A[(i, j)]))
}

/// From rows.
pub fn matrix(A: &Tensor<f64>) -> Mat3 {
    Mat3::from_fn(|i, j| A[i][j])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_changes_of_volume_have_all_their_digits() {
        // det(1 + H) - 1 = 3 h + 3 h² + h³; 1 + 1e-12 has four digits of the change.
        let h = 1e-12;
        let diagonal = Mat3::identity() * h;
        let expected = 3.0 * h + 3.0 * h * h + h * h * h;
        assert!((volume_change(&rows(&diagonal)) / expected - 1.0).abs() < 1e-15);
        let full = Mat3::new(0.1, -0.2, 0.3, 0.4, -0.3, 0.1, -0.1, 0.2, 0.25);
        let expected = (Mat3::identity() + full).determinant() - 1.0;
        assert!((volume_change(&rows(&full)) - expected).abs() < 1e-15);
    }

    #[test]
    fn cofactors_are_the_determinant_times_the_inverse_transpose() {
        let A = Mat3::new(1.1, -0.2, 0.3, 0.4, 0.7, 0.1, -0.1, 0.2, 1.25);
        let expected = A.try_inverse().expect("regular").transpose() * A.determinant();
        assert!((matrix(&cofactors(&rows(&A))) - expected).norm() < 1e-15);
    }
}
