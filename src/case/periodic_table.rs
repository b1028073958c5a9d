//! Measured curves over one period, and what is between their points.

use super::curve_file::{self, CurveFile, FLOW, PRESSURE, TableError};
use super::{FlowUnit, PressureUnit};
use std::path::Path;

/// Values over a period, and between them a monotone cubic.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodicTable {
    /// Times within a period (s), increasing.
    times: Vec<f64>,
    /// Values at these times.
    values: Vec<f64>,
    /// Slopes (1/s) at these times.
    slopes: Vec<f64>,
    /// Duration of a period, s.
    period: f64,
    /// What was understood of the file.
    understood: String,
    /// Size of the unit of its values.
    unit: f64,
    is_unit_assumed: bool,
}

/// A period is sampled at so many times at least.
const SAMPLES: usize = 10_000;
/// Below this share of the mean magnitude a mean is none.
const EVEN: f64 = 0.01;
/// Longer than any period, s.
const LONGEST: f64 = 1e9;

impl PeriodicTable {
    /// A curve of the flow (m³/s). Those of SimVascular (`.flow`) are in cm³/s by default, and either
    /// sign may be that of what enters: on average it is what enters.
    ///
    /// # Errors
    /// What is wrong with the file, with the line.
    pub fn of_flow(
        path: &Path,
        unit: Option<FlowUnit>,
        file_period: Option<f64>,
        period: f64,
    ) -> Result<Self, TableError> {
        let is_simvascular = (path.extension())
            .is_some_and(|end| end.eq_ignore_ascii_case("flow") || end.eq_ignore_ascii_case("flw"));
        let assumed = is_simvascular.then_some(FlowUnit::CubicCentimetreSecond);
        let mut curve = curve_file::read(
            path,
            &FLOW,
            unit.map(FlowUnit::si),
            assumed.map(FlowUnit::si),
            file_period,
            period,
        )?;
        if is_simvascular {
            let [mean, magnitude] = curve.means(file_period.unwrap_or(period));
            // Its 3-D solver counts against the outward normal of the inlet, its 0-D and 1-D solvers along the vessel.
            let is_outward = mean < EVEN * magnitude;
            if is_outward {
                curve.values.iter_mut().for_each(|value| *value = -*value);
            }
            curve.understood += match mean.abs() < EVEN * magnitude {
                true => {
                    "; its mean is zero, and the sign is taken for that of SimVascular's 3-D solver, negative into the vessel"
                }
                false if is_outward => {
                    "; negative values enter, as in SimVascular's 3-D solver: their sign is changed"
                }
                false => "; positive values enter, as in SimVascular's 0-D and 1-D solvers",
            };
        }
        Ok(Self::new(curve, file_period.unwrap_or(period), period))
    }

    /// The period (s) that a curve of the flow shows, if it shows one, and its last time.
    ///
    /// # Errors
    /// What is wrong with the file, with the line.
    pub fn period_of_flow(
        path: &Path,
        unit: Option<FlowUnit>,
    ) -> Result<(Option<f64>, f64), TableError> {
        let all = Self::of_flow(path, unit, None, LONGEST)?;
        Ok((all.shown_period(), all.times[all.times.len() - 1]))
    }

    /// A curve of the pressure (Pa).
    ///
    /// # Errors
    /// What is wrong with the file, with the line.
    pub fn of_pressure(
        path: &Path,
        unit: Option<PressureUnit>,
        file_period: Option<f64>,
        period: f64,
    ) -> Result<Self, TableError> {
        let unit = unit.map(PressureUnit::si);
        let curve = curve_file::read(path, &PRESSURE, unit, None, file_period, period)?;
        Ok(Self::new(curve, file_period.unwrap_or(period), period))
    }

    fn new(curve: CurveFile, own: f64, period: f64) -> Self {
        let CurveFile {
            mut times,
            values,
            understood,
            unit,
            is_unit_assumed,
        } = curve;
        if own != period {
            times.iter_mut().for_each(|time| *time *= period / own);
        }
        let slopes = monotone_slopes(&times, &values, period);
        Self {
            times,
            values,
            slopes,
            period,
            understood,
            unit,
            is_unit_assumed,
        }
    }

    /// The curve times a factor.
    pub fn times(&self, factor: f64) -> Self {
        let scaled = |values: &[f64]| values.iter().map(|value| factor * value).collect();
        Self {
            values: scaled(&self.values),
            slopes: scaled(&self.slopes),
            ..self.clone()
        }
    }

    /// What was understood of the file: rows, columns, units and sign, in words.
    pub fn understood(&self) -> &str {
        &self.understood
    }

    /// Size of the unit of the file's values, in the SI unit.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Whether neither the file nor the case says the unit of its values.
    pub fn is_unit_assumed(&self) -> bool {
        self.is_unit_assumed
    }

    /// Value at the time `t` (s).
    pub fn value(&self, t: f64) -> f64 {
        let Self {
            times,
            values,
            slopes,
            period,
            ..
        } = self;
        let n = times.len();
        // The interval that holds t; the last one reaches over the period's end.
        let first = times[0];
        let t = first + (t - first).rem_euclid(*period);
        let i = times.partition_point(|time| *time <= t).saturating_sub(1);
        let j = (i + 1) % n;
        let h = if j == 0 {
            times[0] + period - times[i]
        } else {
            times[j] - times[i]
        };
        let s = (t - times[i]) / h;
        // Cubic Hermite polynomial.
        let (r, q) = (1.0 - s, s * s * (3.0 - 2.0 * s));
        values[i] * (1.0 - q) + values[j] * q + h * s * r * (r * slopes[i] - s * slopes[j])
    }

    /// One period as pairs of time (s) and value to interpolate linearly, from 0 to the period's end: ten thousand or
    /// more, among them every multiple of the time `step` (s), of its half, its quarter, …, if it divides the period.
    pub fn samples(&self, step: f64) -> impl Iterator<Item = [f64; 2]> {
        samples(self.period, step, |t| self.value(t))
    }

    /// Duration of a period, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The period (s) that the curve itself shows: up to its last time if that has the value of the first one, or else
    /// one more of its equal steps; `None` if it ends anywhere and its steps differ. Where the last value is that of
    /// the first because blood rests, the period is the one that takes fewer digits to write.
    fn shown_period(&self) -> Option<f64> {
        let (n, times, values) = (self.times.len(), &self.times, &self.values);
        let span = times[n - 1] - times[0];
        let step = span / (n - 1) as f64;
        let is_even = times
            .windows(2)
            .all(|pair| ((pair[1] - pair[0]) / step - 1.0).abs() < 0.02);
        // What sums of rounded times leave after the sixth digit is not of the period.
        let extended = format!("{:.5e}", span + step).parse().unwrap_or(span);
        let most = values.iter().fold(0.0f64, |most, q| most.max(q.abs()));
        let closes = (values[n - 1] - values[0]).abs() <= 1e-3 * most;
        match (closes, is_even) {
            (true, true) if digits(extended) < digits(span) => Some(extended),
            (true, _) => Some(span),
            (false, true) => Some(extended),
            (false, false) => None,
        }
    }

    /// The times (s) between which there is no value, from the last to the first in the next period, if they are
    /// more than `times` as far apart as any two others that follow each other.
    pub fn gap(&self, times: f64) -> Option<[f64; 2]> {
        let known = &self.times;
        if known.len() == 1 {
            return None; // a steady flow
        }
        let widest = known.windows(2).map(|pair| pair[1] - pair[0]);
        let widest = widest.fold(0.0, f64::max);
        let gap = [known[known.len() - 1], known[0] + self.period];
        (gap[1] - gap[0] > times * widest).then_some(gap)
    }
}

/// A periodic function as pairs of time (s) and value to interpolate linearly, from 0 to the period's end: ten thousand
/// or more, among them every multiple of the time `step` (s), of its half, its quarter, …, if it divides the period.
pub(super) fn samples(
    period: f64,
    step: f64,
    value: impl Fn(f64) -> f64,
) -> impl Iterator<Item = [f64; 2]> {
    let per_period = (period / step).round().max(1.0) as usize;
    let n = per_period * SAMPLES.div_ceil(per_period).next_power_of_two();
    (0..=n).map(move |i| {
        let time = period * i as f64 / n as f64;
        [time, value(time)]
    })
}

/// Slopes of a periodic curve that overshoots nowhere (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984): the
/// weighted harmonic mean of the slopes to either side, zero at an extremum.
fn monotone_slopes(times: &[f64], values: &[f64], period: f64) -> Vec<f64> {
    let n = times.len();
    let step = |i: usize| {
        if i + 1 == n {
            times[0] + period - times[i]
        } else {
            times[i + 1] - times[i]
        }
    };
    let secant = |i: usize| (values[(i + 1) % n] - values[i]) / step(i);
    (0..n)
        .map(|i| {
            let before = (i + n - 1) % n;
            let (h0, h1, d0, d1) = (step(before), step(i), secant(before), secant(i));
            if d0 * d1 <= 0.0 {
                return 0.0;
            }
            let (w0, w1) = (h0 + 2.0 * h1, 2.0 * h0 + h1);
            (w0 + w1) / (w0 / d1 + w1 / d0)
        })
        .collect()
}

/// Digits of a number as it is written, without zeros before and after.
fn digits(x: f64) -> usize {
    let text = format!("{x:.8e}");
    let (mantissa, _) = text.split_once('e').unwrap_or((&text, ""));
    mantissa.trim_end_matches('0').len()
}
