//! Formulas for one point or for several side by side, which a processor computes with the same instructions.
//!
//! The loops over points that call them are compiled for several kinds of processor ([`multiversion`]). Only what is
//! inlined into such a function is compiled with it: all that is called for each point has to be an `#[inline(always)]`
//! function with loops. A closure that is given to `map` is none.

use crate::Mat3;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Points side by side.
pub const LANES: usize = 4;

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

    /// `x^(-2/3)`.
    fn power_minus_two_thirds(self) -> Self;

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

    fn power_minus_two_thirds(self) -> Self {
        self.cbrt().powi(-2)
    }

    fn positive_part(self) -> Self {
        self.max(0.0)
    }
}

/// A number for each of [`LANES`] points.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Lanes([f64; LANES]);

impl Lanes {
    /// Of these numbers.
    #[inline(always)]
    pub fn new(values: [f64; LANES]) -> Self {
        Self(values)
    }

    /// The first [`LANES`] numbers of a slice.
    #[inline(always)]
    pub fn load(values: &[f64]) -> Self {
        let mut lanes = [0.0; LANES];
        lanes.copy_from_slice(&values[..LANES]);
        Self(lanes)
    }

    /// One after the other.
    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        self.0
    }

    /// Their sum.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        // As a tree: halves of a register are added to each other.
        (self.0[0] + self.0[2]) + (self.0[1] + self.0[3])
    }

    /// Whether all are at most `bound` in size; no NaN is.
    #[inline(always)]
    fn all_within(self, bound: f64) -> bool {
        let mut within = true;
        for value in self.0 {
            within &= value.abs() <= bound;
        }
        within
    }

    /// `f` of each: not vectorized.
    #[inline(always)]
    fn each(self, f: impl Fn(f64) -> f64) -> Self {
        let mut result = self.0;
        for value in &mut result {
            *value = f(*value);
        }
        Self(result)
    }
}

macro_rules! lanewise {
    ($($operator:ident $method:ident),*) => {$(
        impl $operator for Lanes {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let mut result = self.0;
                for lane in 0..LANES {
                    result[lane] = result[lane].$method(other.0[lane]);
                }
                Self(result)
            }
        }
    )*};
}

lanewise!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Lanes {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.each(|x| -x)
    }
}

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Real for Lanes {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Self([value; LANES])
    }

    #[inline(always)]
    fn inverse(self) -> Self {
        Self::of(1.0) / self
    }

    /// `2^k e^r` with a whole number `k` and `|r| <= ln(2)/2`, by the series of `e^r`, whose first term left out is
    /// below 1e-17.
    #[inline(always)]
    fn exponential(self) -> Self {
        /// Added to a number it leaves the nearest whole one in the last bits.
        const ROUNDING: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
        /// `ln 2` in two parts, of which the first has zeros at its end.
        const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
        if !self.all_within(700.0) {
            return self.each(f64::exp);
        }
        let shifted = self * Self::of(std::f64::consts::LOG2_E) + Self::of(ROUNDING);
        let whole = shifted - Self::of(ROUNDING);
        let rest = self - whole * Self::of(LN_2[0]) - whole * Self::of(LN_2[1]);
        // Taylor's series by Horner's scheme: 1 + r (1 + r/2 (1 + r/3 (…))).
        let mut series = Self::of(1.0);
        let mut divisor = 14.0;
        while divisor > 0.5 {
            series = Self::of(1.0) + rest * Self::of(1.0 / divisor) * series;
            divisor -= 1.0;
        }
        let mut result = series.0;
        for lane in 0..LANES {
            let exponent = shifted.0[lane].to_bits() << 52;
            result[lane] *= f64::from_bits(exponent.wrapping_add(1.0_f64.to_bits()));
        }
        Self(result)
    }

    /// Near one: `y²` with `y = x^(-1/3)` by Newton's method for `1 - x y³`, whose error becomes twice its square, from
    /// a series that errs by less than 1e-4.
    #[inline(always)]
    fn power_minus_two_thirds(self) -> Self {
        let change = self - Self::of(1.0);
        if !change.all_within(0.15) {
            return self.each(|x| x.power_minus_two_thirds());
        }
        let [first, second, third] = [-1.0 / 3.0, 2.0 / 9.0, -14.0 / 81.0].map(Self::of);
        let mut y = Self::of(1.0) + change * (first + change * (second + change * third));
        for _ in 0..2 {
            y += y * (Self::of(1.0) - self * y * y * y) * Self::of(1.0 / 3.0);
        }
        y * y
    }

    #[inline(always)]
    fn positive_part(self) -> Self {
        self.each(|x| if x > 0.0 { x } else { 0.0 })
    }
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
    let mut C = *A;
    for (row, A) in C.iter_mut().zip(A) {
        for j in 0..3 {
            row[j] = A[0] * B[0][j] + A[1] * B[1][j] + A[2] * B[2][j];
        }
    }
    C
}

/// `A : A`.
#[inline(always)]
pub fn norm_squared<T: Real>(A: &Tensor<T>) -> T {
    dot(&A[0], &A[0]) + dot(&A[1], &A[1]) + dot(&A[2], &A[2])
}

/// `a × b`.
#[inline(always)]
fn cross<T: Real>(a: &Vector<T>, b: &Vector<T>) -> Vector<T> {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// The cofactors `det A A⁻ᵀ`.
#[inline(always)]
pub fn cofactors<T: Real>(A: &Tensor<T>) -> Tensor<T> {
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

/// `ln(1 + x)` with all digits of a small `x`: `2 artanh s` with `s = x/(2 + x)`, by its series where seven terms are
/// enough.
#[inline(always)]
pub fn ln_1p(x: Lanes) -> Lanes {
    if !x.all_within(0.15) {
        return x.each(f64::ln_1p);
    }
    let s = x / (Lanes::of(2.0) + x);
    let square = s * s;
    // 1 + z/3 + z²/5 + …; the first term left out is below 1e-17.
    let mut series = Lanes::of(0.0);
    for odd in [15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0, 1.0] {
        series = series * square + Lanes::of(1.0 / odd);
    }
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
    fn functions_side_by_side_are_those_one_by_one() {
        #[multiversion::multiversion(targets = "simd")]
        fn exponential(x: Lanes) -> Lanes {
            x.exponential()
        }
        #[multiversion::multiversion(targets = "simd")]
        fn power(x: Lanes) -> Lanes {
            x.power_minus_two_thirds()
        }
        let exponents = [
            0.0, 1e-9, -0.3, 0.346, 0.347, 5.0, -40.0, 699.0, 701.0, 800.0, -800.0,
        ];
        let ratios = [1.0, 1.0 + 1e-9, 0.86, 1.14, 0.84, 1.16, 30.0, 1e-3];
        let same =
            |found: f64, expected: f64| found == expected || (found / expected - 1.0).abs() < 5e-16;
        for x in exponents {
            let found = exponential(Lanes::new([x, 0.0, 0.5, 1.0])).to_array();
            assert!(same(found[0], x.exp()), "{x}: {} {}", found[0], x.exp());
            assert!(same(found[2], 0.5_f64.exp()) && found[1] == 1.0);
        }
        for x in ratios {
            let found = power(Lanes::of(x)).to_array();
            assert!(same(found[3], x.cbrt().powi(-2)), "{x}: {}", found[3]);
        }
        assert!(Lanes::of(f64::NAN).exponential().sum().is_nan());
        let signs = Lanes::new([-1.0, 0.0, 2.0, -0.5]);
        assert_eq!(signs.positive_part().to_array(), [0.0, 0.0, 2.0, 0.0]);
    }

    #[test]
    fn cofactors_are_the_determinant_times_the_inverse_transpose() {
        let A = Mat3::new(1.1, -0.2, 0.3, 0.4, 0.7, 0.1, -0.1, 0.2, 1.25);
        let expected = A.try_inverse().expect("regular").transpose() * A.determinant();
        assert!((matrix(&cofactors(&rows(&A))) - expected).norm() < 1e-15);
    }
}
