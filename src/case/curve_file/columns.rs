//! Which columns of a table are times and values.

use super::CurveQuantity;
use crate::tabular::units::Unit;
use crate::tabular::{Fault, Sheet};

/// Beginnings of the names of times, in small letters.
const TIMES: [&str; 6] = ["time", "zeit", "temps", "tiempo", "tempo", "sec"];
/// Parts of the names of what grows as times do, in small letters.
const NO_TIMES: [&str; 5] = ["%", "percent", "phase", "frame", "t/t"];
/// Parts of the names of what accompanies values.
const SPREAD: [&str; 9] = [
    "sd", "std", "sem", "err", "dev", "var", "lower", "upper", "conf",
];

/// The columns of times and values.
pub fn columns(sheet: &Sheet, quantity: &CurveQuantity) -> Result<[usize; 2], Fault> {
    let names: Vec<&str> = sheet
        .columns
        .iter()
        .map(|column| column.name.as_str())
        .collect();
    let count = names.len();
    let named = names.iter().position(|name| is_time(name));
    if sheet.header.is_none() {
        return Ok(match count > 2 && is_numbered(sheet) {
            true => [1, 2],
            false => [0, 1],
        });
    }
    let time = named.unwrap_or(0);
    let small = names[time].to_lowercase();
    if NO_TIMES.iter().any(|word| small.contains(word)) {
        return Err(Fault {
            line: sheet.header.as_ref().map(|(line, _)| *line),
            message: format!(
                "{} has no times: write seconds in a column called t (s)",
                sheet.listed([time])
            ),
        });
    }
    let others: Vec<usize> = (0..count).filter(|i| *i != time).collect();
    if let [value] = others[..] {
        return Ok([time, value]);
    }
    let called: Vec<usize> = (others.iter().copied())
        .filter(|i| quantity.is_called(names[*i]))
        .collect();
    let with_unit = |i: &usize| matches!(sheet.unit(*i, quantity.dimension), Ok(Some(_)));
    let sure: Vec<usize> = called.iter().copied().filter(with_unit).collect();
    match (&called[..], &sure[..]) {
        ([value], _) | (_, [value]) => Ok([time, *value]),
        ([], _) => Ok([
            time,
            others
                .iter()
                .copied()
                .find(|i| *i > time)
                .unwrap_or(others[0]),
        ]),
        _ => Err(Fault {
            line: sheet.header.as_ref().map(|(line, _)| *line),
            message: format!(
                "several columns may be the {}: {}; leave only the times and one of them in the file",
                quantity.name,
                sheet.listed(called)
            ),
        }),
    }
}

/// Whether the first column numbers the rows, and the second increases.
fn is_numbered(sheet: &Sheet) -> bool {
    let column = |i: usize| -> Vec<f64> {
        let numbers = sheet
            .rows
            .iter()
            .map(|row| sheet.number(row, i).unwrap_or(f64::NAN));
        numbers.collect()
    };
    let steps =
        |values: &[f64]| -> Vec<f64> { values.windows(2).map(|pair| pair[1] - pair[0]).collect() };
    let (first, second) = (column(0), column(1));
    steps(&first).iter().all(|step| *step == 1.0) && steps(&second).iter().all(|step| *step > 0.0)
}

pub fn is_time(name: &str) -> bool {
    let name = name.to_lowercase();
    let stem = name.trim_start_matches(['"', ' ']);
    let is_letter = stem
        .strip_prefix('t')
        .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric));
    is_letter || TIMES.iter().any(|word| stem.starts_with(word)) || stem == "s" || stem == "ms"
}

impl CurveQuantity {
    /// Whether a column of this name has such values.
    pub fn is_called(&self, name: &str) -> bool {
        let small = name.to_lowercase();
        let is_letter = small
            .strip_prefix(self.letter)
            .is_some_and(|rest| !rest.starts_with(char::is_alphabetic));
        let is_word = self.words.iter().any(|word| small.contains(word));
        let has_unit = matches!(Unit::of_name(name, self.dimension), Ok(Some(_)));
        let parts = small.split(|c: char| !c.is_alphanumeric());
        let is_spread = parts.into_iter().any(|part| SPREAD.contains(&part));
        !is_spread && (is_letter || is_word || has_unit)
    }
}
