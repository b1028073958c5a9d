//! Measured curves in files: which columns are times and values, and in which units.

mod columns;

use crate::tabular::units::{self, Dimension, ForeignUnit, Unit};
use crate::tabular::{Fault, Sheet};
use columns::{columns, is_time};
use std::path::{Path, PathBuf};

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

impl TableError {
    fn new(path: &Path, Fault { line, message }: Fault) -> Self {
        let path = path.to_owned();
        match line {
            Some(line) => Self::Line {
                path,
                line,
                message,
            },
            None => Self::Unreadable {
                path,
                reason: message,
            },
        }
    }
}

/// What the values of a curve are.
pub struct CurveQuantity {
    /// Its name.
    name: &'static str,
    /// Header of a file in SI units.
    header: &'static str,
    /// Name of the key for its unit.
    key: &'static str,
    dimension: Dimension,
    /// Parts of the names of its column, in small letters.
    words: &'static [&'static str],
    /// The whole name of its column, in small letters.
    letter: char,
    /// The SI unit in messages.
    si: &'static str,
    /// Values in SI units that are likely as the largest of a curve.
    likely: [f64; 2],
}

pub const FLOW: CurveQuantity = CurveQuantity {
    name: "flow",
    header: "time_s,flow_m3_s",
    key: "inflow.unit",
    dimension: units::FLOW,
    words: &[
        "flow", "flux", "fluss", "strom", "debit", "débit", "caudal", "portata", "flujo", "rate",
    ],
    letter: 'q',
    si: "m³/s",
    likely: [1e-7, 1.5e-3],
};

pub const PRESSURE: CurveQuantity = CurveQuantity {
    name: "pressure",
    header: "time_s,pressure_Pa",
    key: "`unit` next to it",
    dimension: units::PRESSURE,
    words: &["press", "druck", "presión", "presion"],
    letter: 'p',
    si: "Pa",
    likely: [1e3, 4e4],
};

/// A curve as it stands in a file, in SI units.
#[derive(Debug)]
pub struct CurveFile {
    /// Times (s), increasing, from the period's beginning up to its end.
    pub times: Vec<f64>,
    pub values: Vec<f64>,
    /// What was understood: rows, columns and units, in words.
    pub understood: String,
    /// Size of the unit of the file's values.
    pub unit: f64,
    /// Whether neither file nor case says it.
    pub is_unit_assumed: bool,
}

impl CurveFile {
    /// Means of the values and of their magnitudes, linear between the points, over a period of so many seconds.
    pub fn means(&self, period: f64) -> [f64; 2] {
        let n = self.times.len();
        let mut sums = [0.0; 2];
        for i in 0..n {
            let j = (i + 1) % n;
            let step = if j == 0 {
                self.times[0] + period
            } else {
                self.times[j]
            } - self.times[i];
            let (a, b) = (self.values[i], self.values[j]);
            sums[0] += 0.5 * step * (a + b);
            sums[1] += 0.5 * step * (a.abs() + b.abs());
        }
        sums.map(|sum| sum / period)
    }
}

/// Reads a curve. Times increase and lie within one period, `file_period` or else `period` (s); if both its ends are
/// among them, their values must be the same. The size of the unit is that of the case, of the header or of a comment,
/// or else `assumed`.
pub fn read(
    path: &Path,
    quantity: &CurveQuantity,
    unit: Option<f64>,
    assumed: Option<f64>,
    file_period: Option<f64>,
    period: f64,
) -> Result<CurveFile, TableError> {
    let failed = |fault: Fault| TableError::new(path, fault);
    let is_header = |names: &[String]| {
        names.iter().any(|name| is_time(name)) && names.iter().any(|name| quantity.is_called(name))
    };
    let sheet = Sheet::read(path, 2, is_header).map_err(failed)?;
    if sheet.columns.len() < 2 {
        return Err(failed(quantity.no_unit(&sheet, None)));
    }
    let [time, value] = columns(&sheet, quantity).map_err(failed)?;
    let seconds = time_unit(&sheet, time).map_err(failed)?;
    let found = value_unit(&sheet, value, quantity, unit).map_err(failed)?;
    let Some(size) = found.or(assumed) else {
        return Err(failed(quantity.no_unit(&sheet, Some(value))));
    };
    let own = file_period.unwrap_or(period);
    let (times, values) = rows(&sheet, [time, value], [seconds, size], own).map_err(failed)?;
    let (times, values) = once(times, values, own, quantity.si).map_err(failed)?;
    let others: Vec<usize> = (0..sheet.columns.len())
        .filter(|i| ![time, value].contains(i))
        .collect();
    let left_out = match others.is_empty() {
        true => String::new(),
        false => format!("; {} left out", sheet.listed(others)),
    };
    Ok(CurveFile {
        times,
        values,
        understood: format!(
            "{}; times in {} ({}), {} in {} ({}{}){left_out}",
            sheet.shape(),
            sheet.listed([time]),
            word(units::TIME, seconds),
            quantity.name,
            sheet.listed([value]),
            word(quantity.dimension, size),
            match found {
                Some(_) => "",
                None => ", as SimVascular: the file says none",
            }
        ),
        unit: size,
        is_unit_assumed: found.is_none(),
    })
}

impl CurveQuantity {
    /// The unit of the column `value` is missing.
    fn no_unit(&self, sheet: &Sheet, value: Option<usize>) -> Fault {
        let (line, found) = match (&sheet.header, sheet.rows.first()) {
            (Some((line, text)), _) => (*line, text.clone()),
            (None, Some(row)) => (row.line, row.cells.join(" ")),
            (None, None) => (1, String::new()),
        };
        let largest = value.map(|value| {
            let values = sheet
                .rows
                .iter()
                .filter_map(|row| sheet.number(row, value).ok());
            values.fold(0.0f64, |most, x| most.max(x.abs()))
        });
        let likely = largest.map_or(Vec::new(), |largest| self.likely_units(largest));
        let hint = match likely.is_empty() {
            true => String::new(),
            false => format!(
                "; with values up to {}, {} would fit a vessel",
                largest.unwrap_or(0.0),
                likely.join(" or ")
            ),
        };
        Fault::at(
            line,
            format!(
                "expected the header {}, or the unit of the column ({}: {}), found {found:?}{hint}",
                self.header,
                self.key,
                units::offered(self.dimension)
            ),
        )
    }

    /// Units in which this is likely as the largest value.
    fn likely_units(&self, largest: f64) -> Vec<&'static str> {
        let known = units::offered(self.dimension).split(", ");
        let is_likely = |word: &&str| {
            let size = Unit::parse(word).map_or(0.0, |unit| unit.size);
            (self.likely[0]..=self.likely[1]).contains(&(size * largest))
        };
        known.filter(is_likely).collect()
    }
}

fn time_unit(sheet: &Sheet, column: usize) -> Result<f64, Fault> {
    match sheet.unit(column, units::TIME) {
        Ok(Some(unit)) => Ok(unit.size),
        // "0.8 s" in a comment may be anything, milliseconds are units of a column.
        Ok(None) => Ok((sheet.noted_unit(units::TIME))
            .filter(|unit| unit.size < 1.0)
            .map_or(1.0, |unit| unit.size)),
        Err(foreign) => Err(Fault {
            line: sheet.header.as_ref().map(|(line, _)| *line),
            message: foreign.to_string(),
        }),
    }
}

/// The unit that the file says, in the column's name, below it or in a comment; another one than that of the quantity
/// is an error, and so is an unknown unit if the case gives none.
fn unit_of_file(
    sheet: &Sheet,
    column: usize,
    quantity: &CurveQuantity,
    is_given: bool,
) -> Result<Option<Unit>, Fault> {
    let at = |message: String| Fault {
        line: sheet.header.as_ref().map(|(line, _)| *line),
        message,
    };
    match sheet.unit(column, quantity.dimension) {
        Ok(Some(unit)) => Ok(Some(unit)),
        Ok(None) => {
            // A name with the unit of something else: `pressure_mmHg` for a flow.
            let name = &sheet.columns[column].name;
            let others = [units::FLOW, units::PRESSURE, units::VELOCITY].into_iter();
            let mut others = others.filter(|other| *other != quantity.dimension);
            let other = others.find(|other| matches!(Unit::of_name(name, *other), Ok(Some(_))));
            if let Some(other) = other.filter(|_| !is_given) {
                return Err(at(format!(
                    "{} is a {}, and a {} is expected",
                    sheet.listed([column]),
                    units::called(other),
                    quantity.name
                )));
            }
            Ok(sheet.noted_unit(quantity.dimension))
        }
        Err(ForeignUnit { text: found, .. }) => {
            let other = Unit::parse(&found).map(|unit| units::called(unit.dimension));
            if let Some(other) = other {
                let advice = match other {
                    "velocity" => ": multiply it by the area of the lumen",
                    _ => "",
                };
                return Err(at(format!(
                    "{} is a {other} ({found}), and a {} is expected{advice}",
                    sheet.listed([column]),
                    quantity.name
                )));
            }
            if !is_given {
                return Err(at(format!(
                    "{found:?} is not a known unit of {}: expected {}, or another spelling of these",
                    quantity.name,
                    units::offered(quantity.dimension)
                )));
            }
            Ok(None)
        }
    }
}

/// The size of the unit that the case or the file says.
fn value_unit(
    sheet: &Sheet,
    column: usize,
    quantity: &CurveQuantity,
    given: Option<f64>,
) -> Result<Option<f64>, Fault> {
    let of_file = unit_of_file(sheet, column, quantity, given.is_some())?;
    match (given, of_file) {
        (Some(a), Some(b)) if (a / b.size - 1.0).abs() > 1e-9 => {
            let (line, text) = match &sheet.header {
                Some((line, text)) => (Some(*line), format!("the header {text:?}")),
                None => (None, "a comment of the file".to_owned()),
            };
            Err(Fault {
                line,
                message: format!(
                    "{text} says another unit than {}, {}: leave that out, or correct one of them",
                    quantity.key,
                    word(quantity.dimension, b.size)
                ),
            })
        }
        (given, of_file) => Ok(given.or(of_file.map(|unit| unit.size))),
    }
}

/// The usual word for a unit of this size.
fn word(dimension: Dimension, size: f64) -> String {
    let is =
        |word: &&str| Unit::parse(word).is_some_and(|unit| (unit.size / size - 1.0).abs() < 1e-9);
    let found = units::offered(dimension).split(", ").find(is);
    found.map_or_else(|| format!("{size:e} of the SI unit"), str::to_owned)
}

/// Times (s) and values of all rows.
fn rows(
    sheet: &Sheet,
    [time, value]: [usize; 2],
    [seconds, size]: [f64; 2],
    own: f64,
) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    let (mut times, mut values) = (Vec::<f64>::new(), Vec::<f64>::new());
    for row in &sheet.rows {
        let (time, value) = (
            seconds * sheet.number(row, time)?,
            size * sheet.number(row, value)?,
        );
        if let Some(last) = times.last().filter(|last| time <= **last) {
            return Err(Fault::at(
                row.line,
                format!("times must increase, but {time:?} s follows {last:?} s"),
            ));
        }
        times.push(time);
        values.push(value);
    }
    let is_outside = |time: &f64| !(0.0..=own * (1.0 + 1e-9)).contains(time);
    if let Some(place) = times.iter().position(is_outside) {
        let (first, last) = (times[0], times[times.len() - 1]);
        let outside = format!(
            "the time {:?} s is outside the period from 0 to {own:?} s",
            times[place]
        );
        let advice = if first != 0.0 && last - first <= own * (1.0 + 1e-9) {
            format!("the first time is {first:?} s, and a period begins at 0: subtract it from all")
        } else if (500.0..2000.0).contains(&(last / own)) && seconds == 1.0 {
            "if the times are in milliseconds, call their column \"t (ms)\"".to_owned()
        } else {
            "give its own period as `file_period_s` next to the file, and it is stretched"
                .to_owned()
        };
        return Err(Fault::at(
            sheet.rows[place].line,
            format!("{outside}: {advice}"),
        ));
    }
    Ok((times, values))
}

/// Without the period's end, if its beginning is there too.
fn once(
    mut times: Vec<f64>,
    mut values: Vec<f64>,
    own: f64,
    si: &str,
) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    // A steady flow needs no more than two times.
    let is_steady = times.len() > 1 && values.iter().all(|value| *value == values[0]);
    if let (Some(first), Some(last)) = (times.first(), times.last())
        && last - first >= own * (1.0 - 1e-9)
    {
        let (end, begin) = (values[values.len() - 1], values[0]);
        times.pop();
        values.pop();
        let span = values
            .iter()
            .fold(0.0f64, |most, value| most.max(value.abs()));
        if (end - begin).abs() > 1e-3 * span {
            return Err(Fault::whole(format!(
                "the curve must repeat itself: {begin:e} {si} at the period's beginning, but {end:e} at its end"
            )));
        }
    }
    if times.len() < 3 && !is_steady {
        return Err(Fault::whole(format!(
            "a period needs at least 3 different times, found {}",
            times.len()
        )));
    }
    Ok((times, values))
}
