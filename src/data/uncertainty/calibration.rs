//! The likeliest inputs with which measures have the values that they should have.

use super::distribution::{normal_cdf, normal_quantile};
use super::{Chaos, Inputs, sobol_point};
use nalgebra::{DMatrix, DVector};

/// Points of the unit cube among which the search begins, and the best of them from which it goes on.
const POINTS: usize = 512;
const STARTS: usize = 8;
/// Steps of a search, at most.
const MOST_STEPS: usize = 100;
/// Standard deviations from the median beyond which no input goes: the polynomials know nothing there.
const FARTHEST: f64 = 3.0;
/// Difference of the variables by which slopes are found.
const SMALL: f64 = 1e-5;

/// What a measure should be.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// The measure over the inputs.
    pub chaos: &'a Chaos,
    /// The value that it should have.
    pub value: f64,
    /// The standard deviation with which this is known.
    pub tolerance: f64,
}

/// The point of the unit cube that is likeliest by the distributions of the inputs and by the targets (the maximum of
/// the posterior density in standard normal variables): the least sum of squares of what each target is missed by over
/// its tolerance, and of the standard normal variable behind each input. By Levenberg's and Marquardt's method.
pub fn calibrated(inputs: &Inputs, targets: &[Target]) -> Vec<f64> {
    let misses = |z: &DVector<f64>| misses(inputs, targets, z);
    let mut starts: Vec<DVector<f64>> = (0..POINTS)
        .map(|i| sobol_point(i, inputs.count()))
        .map(|point| DVector::from_iterator(point.len(), point.into_iter().map(normal_of)))
        .collect();
    let far = |z: &DVector<f64>| misses(z).norm_squared();
    starts.sort_by(|a, b| far(a).total_cmp(&far(b)));
    let ends = starts.into_iter().take(STARTS).map(|z| search(z, &misses));
    let best = ends.min_by(|a, b| far(a).total_cmp(&far(b)));
    let best = best.expect("there are starts");
    best.iter().map(|z| normal_cdf(*z)).collect()
}

fn misses(inputs: &Inputs, targets: &[Target], z: &DVector<f64>) -> DVector<f64> {
    let point: Vec<f64> = z.iter().map(|z| normal_cdf(*z)).collect();
    let germs = inputs.germs_at(&point);
    let of_targets = targets
        .iter()
        .map(|target| (target.chaos.value(&germs) - target.value) / target.tolerance);
    DVector::from_iterator(targets.len() + z.len(), of_targets.chain(z.iter().copied()))
}

fn normal_of(u: f64) -> f64 {
    normal_quantile(u).clamp(-FARTHEST, FARTHEST)
}

fn search(mut z: DVector<f64>, misses: &dyn Fn(&DVector<f64>) -> DVector<f64>) -> DVector<f64> {
    let mut damping = 1e-3;
    let mut missed = misses(&z);
    for _ in 0..MOST_STEPS {
        let mut slopes = DMatrix::zeros(missed.len(), z.len());
        for i in 0..z.len() {
            let mut beside = z.clone();
            beside[i] += SMALL;
            slopes.set_column(i, &((misses(&beside) - &missed) / SMALL));
        }
        let normal = slopes.tr_mul(&slopes);
        let downhill = -slopes.tr_mul(&missed);
        let damped = &normal + DMatrix::from_diagonal(&(normal.diagonal() * damping));
        let Some(factor) = damped.cholesky() else {
            return z;
        };
        let step = factor.solve(&downhill);
        let next = (&z + &step).map(|z| z.clamp(-FARTHEST, FARTHEST));
        let missed_next = misses(&next);
        if missed_next.norm_squared() < missed.norm_squared() {
            let moved = (&next - &z).amax();
            (z, missed) = (next, missed_next);
            damping *= 0.2;
            if moved < 1e-9 {
                return z;
            }
        } else {
            damping *= 10.0;
            if damping > 1e12 {
                return z;
            }
        }
    }
    z
}

#[cfg(test)]
mod tests {
    use super::super::{Design, Distribution};
    use super::*;

    fn inputs() -> Inputs {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        let inputs = vec![
            Distribution::normal(3.0, 1.0, everywhere),
            Distribution::normal(10.0, 2.0, everywhere),
        ];
        Inputs::new(inputs, &[]).unwrap()
    }

    fn chaos(inputs: &Inputs, f: impl Fn(&[f64]) -> f64) -> Chaos {
        let points = "sobol:40".parse::<Design>().unwrap().points(2).unwrap();
        let germs: Vec<_> = points.iter().map(|p| inputs.germs_at(p)).collect();
        let values: Vec<_> = points.iter().map(|p| f(&inputs.values_at(p))).collect();
        Chaos::fit(inputs, &germs, &values).unwrap()
    }

    /// Two measures, x² and x y, tell both inputs.
    #[test]
    fn as_many_targets_as_inputs_find_the_inputs() {
        let inputs = inputs();
        let (square, product) = (
            chaos(&inputs, |x| x[0] * x[0]),
            chaos(&inputs, |x| x[0] * x[1]),
        );
        let target = |chaos, value| Target {
            chaos,
            value,
            tolerance: 1e-6,
        };
        let found = calibrated(&inputs, &[target(&square, 12.25), target(&product, 31.5)]);
        let x = inputs.values_at(&found);
        assert!(
            (x[0] - 3.5).abs() < 1e-6 && (x[1] - 9.0).abs() < 1e-6,
            "{x:?}"
        );
    }

    /// One target for a sum of two: the miss is shared by the variances. With x = 3 + a and y = 10 + 2 b, a sum that is
    /// 16 +- 1 asks for the least (a + 2 b - 3)² + a² + b²: a = 0.5, b = 1.
    #[test]
    fn fewer_targets_leave_the_likeliest_inputs() {
        let inputs = inputs();
        let sum = chaos(&inputs, |x| x[0] + x[1]);
        let target = Target {
            chaos: &sum,
            value: 16.0,
            tolerance: 1.0,
        };
        let x = inputs.values_at(&calibrated(&inputs, &[target]));
        assert!(
            (x[0] - 3.5).abs() < 1e-5 && (x[1] - 12.0).abs() < 1e-5,
            "{x:?}"
        );
    }
}
