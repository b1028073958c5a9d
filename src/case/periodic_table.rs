//! Measured curves over one period, as the files come that people have.

use super::{FlowUnit, PressureUnit, text_file};
use std::path::{Path, PathBuf};

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
}

/// Why a curve cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
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
        line: usize,
        /// What was found and what is expected.
        message: String,
    },
}

/// A period is sampled at so many times at least.
const SAMPLES: usize = 10_000;
/// More rows than any measured curve has.
const MOST_ROWS: usize = 1_000_000;

/// What the second column of a file is.
struct Quantity {
    /// Header of a file in SI units.
    header: &'static str,
    /// Name of the key for its unit.
    key: &'static str,
    /// Words for units as they stand in headers, without what is neither letter nor digit, and their size in SI units.
    units: &'static [(&'static str, f64)],
    /// The SI unit in messages.
    si: &'static str,
}

const FLOW: Quantity = Quantity {
    header: "time_s,flow_m3_s",
    key: "inflow.unit",
    units: &[
        ("cm3s", 1e-6),
        ("mm3s", 1e-9),
        ("m3s", 1.0),
        ("mlmin", 1e-6 / 60.0),
        ("mls", 1e-6),
        ("ccs", 1e-6),
        ("lmin", 1e-3 / 60.0),
        ("ls", 1e-3),
    ],
    si: "m³/s",
};

const PRESSURE: Quantity = Quantity {
    header: "time_s,pressure_Pa",
    key: "`unit` beside it",
    units: &[
        ("mmhg", 133.322),
        ("kpa", 1e3),
        ("pa", 1.0),
        ("dyncm2", 0.1),
    ],
    si: "Pa",
};

/// Units of time in headers; seconds if there is none.
const TIMES: [(&str, f64); 4] = [("ms", 1e-3), ("min", 60.0), ("sec", 1.0), ("s", 1.0)];

impl PeriodicTable {
    /// A curve of the flow (m³/s). Those of SimVascular (`.flow`) have no header, are in cm³/s where `unit` says nothing
    /// else, and count what enters as negative.
    ///
    /// # Errors
    /// What is wrong with the file, with the line.
    pub fn of_flow(
        path: &Path,
        unit: Option<FlowUnit>,
        file_period: Option<f64>,
        period: f64,
    ) -> Result<Self, TableError> {
        let is_simvascular = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("flow"));
        let unit = unit.or(is_simvascular.then_some(FlowUnit::CubicCentimetreSecond));
        let mut table = Self::read(path, &FLOW, unit.map(FlowUnit::si), file_period, period)?;
        if is_simvascular {
            let negated = [&mut table.values, &mut table.slopes];
            negated.into_iter().flatten().for_each(|x| *x = -*x);
        }
        Ok(table)
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
        Self::read(
            path,
            &PRESSURE,
            unit.map(PressureUnit::si),
            file_period,
            period,
        )
    }

    /// Value at the time `t` (s).
    pub fn value(&self, t: f64) -> f64 {
        let Self {
            times,
            values,
            slopes,
            period,
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

    /// One period as pairs of time (s) and value to interpolate linearly, from 0 to the period's end: ten thousand or more, among
    /// them every multiple of the time `step` (s), of its half, its quarter, …, if it divides the period.
    pub fn samples(&self, step: f64) -> impl Iterator<Item = [f64; 2]> {
        samples(self.period, step, |t| self.value(t))
    }

    /// Duration of a period, s.
    pub fn period(&self) -> f64 {
        self.period
    }

    /// The times (s) between which there is no value, from the last to the first in the next period, if they are
    /// more than `times` as far apart as any two others that follow each other.
    pub fn gap(&self, times: f64) -> Option<[f64; 2]> {
        let known = &self.times;
        let widest = known.windows(2).map(|pair| pair[1] - pair[0]);
        let widest = widest.fold(0.0, f64::max);
        let gap = [known[known.len() - 1], known[0] + self.period];
        (gap[1] - gap[0] > times * widest).then_some(gap)
    }

    /// Reads two columns, with or without a header, separated by commas, semicolons or blanks; lines that begin with `#` or
    /// `%` are comments. Times increase and lie within one period; if both its ends are among them, their values must be the same.
    fn read(
        path: &Path,
        quantity: &Quantity,
        unit: Option<f64>,
        file_period: Option<f64>,
        period: f64,
    ) -> Result<Self, TableError> {
        let unreadable = |reason: String| TableError::Unreadable {
            path: path.to_owned(),
            reason,
        };
        let wrong = |line: usize, message: String| TableError::Line {
            path: path.to_owned(),
            line,
            message,
        };
        let text = text_file::read(path, text_file::OF_A_CURVE)
            .map_err(|error| unreadable(error.to_string()))?;
        let own = file_period.unwrap_or(period);
        let rows = text
            .lines()
            .map(|row| row.trim().trim_start_matches('\u{feff}'));
        let mut rows = (1..)
            .zip(rows)
            .filter(|(_, row)| !row.is_empty() && !row.starts_with(['#', '%']))
            .peekable();
        let (mut seconds, mut size) = (1.0, unit);
        let no_unit = |line: usize, found: &str| {
            let message = format!(
                "expected the header {}, or the unit of the column ({}), found {found:?}",
                quantity.header, quantity.key
            );
            wrong(line, message)
        };
        match rows.peek() {
            Some((line, row))
                if fields(row)
                    .iter()
                    .all(|field| field.parse::<f64>().is_err()) =>
            {
                let names = fields_of_header(row);
                let [time, value] = &names[..] else {
                    return Err(no_unit(*line, row));
                };
                seconds = unit_of(time, &TIMES).unwrap_or(1.0);
                let of_header = unit_of(value, quantity.units);
                if let (Some(a), Some(b)) = (unit, of_header)
                    && (a / b - 1.0).abs() > 1e-9
                {
                    let message = format!(
                        "the header {row:?} says another unit than {}: leave that out, or correct one of them",
                        quantity.key
                    );
                    return Err(wrong(*line, message));
                }
                size = unit.or(of_header);
                if size.is_none() {
                    return Err(no_unit(*line, row));
                }
                rows.next();
            }
            Some((line, row)) if size.is_none() => return Err(no_unit(*line, row)),
            Some(_) => (),
            None => return Err(no_unit(1, "")),
        }
        let size = size.expect("it is known by now");
        let (mut times, mut values) = (Vec::<f64>::new(), Vec::<f64>::new());
        for (line, row) in rows {
            let fields = fields(row);
            let [time, value] = fields[..] else {
                let message = format!("expected 2 numbers, found {} fields", fields.len());
                return Err(wrong(line, message));
            };
            let number = |field: &str| match field.parse::<f64>() {
                Ok(x) if x.is_finite() => Ok(x),
                _ => Err(wrong(line, format!("expected a number, found {field:?}"))),
            };
            let (time, value) = (seconds * number(time)?, size * number(value)?);
            if !(0.0..=own * (1.0 + 1e-9)).contains(&time) {
                return Err(wrong(
                    line,
                    format!(
                        "the time {time:?} s is outside the period from 0 to {own:?} s: write the curve's own into \
                         `file_period_s` beside the file, and it is stretched"
                    ),
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
            values.push(value);
        }
        if let (Some(first), Some(last)) = (times.first(), times.last())
            && last - first >= own * (1.0 - 1e-9)
        {
            times.pop();
            let (end, begin) = (values.pop().unwrap_or_default(), values[0]);
            let span = values
                .iter()
                .fold(0.0f64, |most, value| most.max(value.abs()));
            if (end - begin).abs() > 1e-3 * span {
                return Err(unreadable(format!(
                    "the curve must repeat itself: {begin:e} {} at the period's beginning, but {end:e} at its end",
                    quantity.si
                )));
            }
        }
        if times.len() < 3 {
            return Err(unreadable(format!(
                "a period needs at least 3 different times, found {}",
                times.len()
            )));
        }
        if own != period {
            times.iter_mut().for_each(|time| *time *= period / own);
        }
        let slopes = monotone_slopes(&times, &values, period);
        Ok(Self {
            times,
            values,
            slopes,
            period,
        })
    }
}

/// Fields of a row of numbers.
fn fields(row: &str) -> Vec<&str> {
    let fields = row.split([',', ';', ' ', '\t']);
    fields.filter(|field| !field.is_empty()).collect()
}

/// Fields of a header, in which a name and its unit may stand apart: "t (s), Q (ml/min)".
fn fields_of_header(row: &str) -> Vec<&str> {
    let separator = if row.contains([',', ';']) {
        &[',', ';'][..]
    } else {
        &['\t', ' '][..]
    };
    let fields = row.split(separator).map(str::trim);
    fields.filter(|field| !field.is_empty()).collect()
}

/// The unit with which a column's name ends, as `flow_ml_min`, `Q (ml/min)` or `pressure [mmHg]`.
fn unit_of(name: &str, units: &[(&str, f64)]) -> Option<f64> {
    let bracketed = name.split_once(['(', '[']).map(|(_, unit)| unit);
    let parts: Vec<&str> = match bracketed {
        Some(unit) => vec![unit],
        // Every way to cut off what stands before the unit
        None => (name.match_indices(['_', ' ']))
            .map(|(i, _)| &name[i + 1..])
            .collect(),
    };
    parts.into_iter().find_map(|part| {
        let letters = part.chars().filter(char::is_ascii_alphanumeric);
        let word: String = letters.collect::<String>().to_lowercase();
        let mut known = units.iter();
        known.find(|(unit, _)| *unit == word).map(|(_, size)| *size)
    })
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
