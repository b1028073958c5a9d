//! Flow at the inlet over time, and the smooth start.

use super::{Inflow, Ramp, text_file};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

/// A periodic flow curve.
#[derive(Debug, Clone, PartialEq)]
pub enum FlowCurve {
    /// `base + amplitude sin²(π (t/systole)^exponent)` for t < systole within a period, then `base`.
    Pulse {
        /// The parameters.
        inflow: Inflow,
        /// Duration of a period, s.
        period: f64,
    },
    /// Values of a file.
    Table {
        /// Times within a period (s), increasing.
        times: Vec<f64>,
        /// Flow (m³/s) at these times.
        flows: Vec<f64>,
        /// Slope (m³/s²) at these times.
        slopes: Vec<f64>,
        /// Duration of a period, s.
        period: f64,
    },
}

/// Why a flow curve cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum FlowCurveError {
    /// The file cannot be read.
    #[error("{}: {reason}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why not.
        reason: String,
    },
    /// A line is wrong.
    #[error("{}:{line}: {message}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// What was found and what is expected.
        message: String,
    },
}

/// A period is sampled at so many times at least.
const SAMPLES: usize = 10_000;
/// More rows than any measured curve has.
const MOST_ROWS: usize = 1_000_000;

impl FlowCurve {
    /// The curve of a case; reads its file if there is one.
    ///
    /// # Errors
    /// What is wrong with the file, with the line.
    pub fn new(inflow: &Inflow, period: f64) -> Result<Self, FlowCurveError> {
        match &inflow.file {
            None => Ok(Self::Pulse {
                inflow: inflow.clone(),
                period,
            }),
            Some(path) => Self::read(path, period),
        }
    }

    /// Flow (m³/s) at the time `t` (s), before the ramp.
    pub fn flow(&self, t: f64) -> f64 {
        match self {
            Self::Pulse { inflow, period } => {
                let t = t.rem_euclid(*period);
                if t >= inflow.systole {
                    return inflow.base;
                }
                inflow.base
                    + inflow.amplitude
                        * (PI * (t / inflow.systole).powf(inflow.exponent))
                            .sin()
                            .powi(2)
            }
            Self::Table {
                times,
                flows,
                slopes,
                period,
            } => {
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
                flows[i] * (1.0 - q) + flows[j] * q + h * s * r * (r * slopes[i] - s * slopes[j])
            }
        }
    }

    /// One period as pairs of time (s) and flow (m³/s) to interpolate linearly, from 0 to the period's end: ten thousand
    /// or more, among them every multiple of the time `step` (s), of its half, its quarter, …, if it divides the period.
    pub fn samples(&self, step: f64) -> impl Iterator<Item = [f64; 2]> {
        let period = self.period();
        let per_period = (period / step).round().max(1.0) as usize;
        let n = per_period * SAMPLES.div_ceil(per_period).next_power_of_two();
        (0..=n).map(move |i| {
            let time = period * i as f64 / n as f64;
            [time, self.flow(time)]
        })
    }

    /// Duration of a period, s.
    pub fn period(&self) -> f64 {
        match self {
            Self::Pulse { period, .. } | Self::Table { period, .. } => *period,
        }
    }

    /// The times (s) between which a table has no value, from its last to its first in the next period, if they are
    /// more than `times` as far apart as any two others that follow each other.
    pub fn gap(&self, times: f64) -> Option<[f64; 2]> {
        let Self::Table {
            times: known,
            period,
            ..
        } = self
        else {
            return None;
        };
        let widest = known.windows(2).map(|pair| pair[1] - pair[0]);
        let widest = widest.fold(0.0, f64::max);
        let gap = [known[known.len() - 1], known[0] + period];
        (gap[1] - gap[0] > times * widest).then_some(gap)
    }

    /// Reads a CSV file with the header `time_s,flow_m3_s`; lines that begin with `#` are skipped. Times increase and
    /// lie in one period; if the period's end is among them its flow must equal the beginning's.
    fn read(path: &Path, period: f64) -> Result<Self, FlowCurveError> {
        let unreadable = |reason: String| FlowCurveError::Unreadable {
            path: path.to_owned(),
            reason,
        };
        let wrong = |line: u64, message: String| FlowCurveError::Line {
            path: path.to_owned(),
            line,
            message,
        };
        let text = text_file::read(path, text_file::OF_A_CURVE)
            .map_err(|error| unreadable(error.to_string()))?;
        let mut reader = csv::ReaderBuilder::new()
            .comment(Some(b'#'))
            .trim(csv::Trim::All)
            .flexible(true)
            .from_reader(text.as_bytes());
        let header = reader
            .headers()
            .map_err(|error| unreadable(error.to_string()))?;
        if header != ["time_s", "flow_m3_s"].as_slice() {
            let found = header.iter().collect::<Vec<_>>().join(",");
            return Err(wrong(
                header.position().map_or(1, |at| at.line()),
                format!("expected the header time_s,flow_m3_s, found {found:?}"),
            ));
        }
        let (mut times, mut flows) = (Vec::<f64>::new(), Vec::<f64>::new());
        for record in reader.records() {
            let record = record.map_err(|error| unreadable(error.to_string()))?;
            let line = record.position().map_or(0, |at| at.line());
            if record.len() != 2 {
                return Err(wrong(
                    line,
                    format!("expected 2 numbers, found {} fields", record.len()),
                ));
            }
            let number = |field: &str| match field.parse::<f64>() {
                Ok(x) if x.is_finite() => Ok(x),
                _ => Err(wrong(line, format!("expected a number, found {field:?}"))),
            };
            let (time, flow) = (number(&record[0])?, number(&record[1])?);
            if !(0.0..=period * (1.0 + 1e-9)).contains(&time) {
                return Err(wrong(
                    line,
                    format!("the time {time:?} s is outside the period from 0 to {period:?} s"),
                ));
            }
            if let Some(last) = times.last().filter(|last| time <= **last) {
                return Err(wrong(
                    line,
                    format!("times must increase, but {time:?} s follows {last:?} s"),
                ));
            }
            if times.len() == MOST_ROWS {
                return Err(wrong(
                    line,
                    format!("more than {MOST_ROWS} rows; a period needs a few hundred at most"),
                ));
            }
            times.push(time);
            flows.push(flow);
        }
        if let (Some(first), Some(last)) = (times.first(), times.last())
            && last - first >= period * (1.0 - 1e-9)
        {
            times.pop();
            let (end, begin) = (flows.pop().unwrap_or_default(), flows[0]);
            let span = flows.iter().fold(0.0f64, |most, flow| most.max(flow.abs()));
            if (end - begin).abs() > 1e-3 * span {
                return Err(unreadable(format!(
                    "the curve must repeat itself: {begin:e} m³/s at the period's beginning, but {end:e} at its end"
                )));
            }
        }
        if times.len() < 3 {
            return Err(unreadable(format!(
                "a period needs at least 3 different times, found {}",
                times.len()
            )));
        }
        let slopes = monotone_slopes(&times, &flows, period);
        Ok(Self::Table {
            times,
            flows,
            slopes,
            period,
        })
    }
}

/// Slopes of a periodic curve that overshoots nowhere (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984): the
/// weighted harmonic mean of the slopes to either side, zero at an extremum.
fn monotone_slopes(times: &[f64], flows: &[f64], period: f64) -> Vec<f64> {
    let n = times.len();
    let step = |i: usize| {
        if i + 1 == n {
            times[0] + period - times[i]
        } else {
            times[i + 1] - times[i]
        }
    };
    let secant = |i: usize| (flows[(i + 1) % n] - flows[i]) / step(i);
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

impl Ramp {
    /// Factor on inflow and outlet pressure at the time `t` (s): half a cosine from 0 to 1, then 1; once continuously
    /// differentiable.
    pub fn factor(&self, t: f64) -> f64 {
        if t >= self.duration {
            1.0
        } else {
            0.5 * (1.0 - (PI * t.max(0.0) / self.duration).cos())
        }
    }
}
