//! One value against its key: the right type and range, in the form that the types ask for.

use super::error::CaseError;
use super::schema::{Key, ValueKind};
use super::source::{self, CaseValue};
use super::{spelling, templates};
use std::ops::RangeInclusive;
use toml::Value;

/// The entry with its value in the form that `key` asks for, or an error.
pub fn check(mut entry: CaseValue, key: &Key, errors: &mut Vec<CaseError>) -> Option<CaseValue> {
    let value = match (key.kind, &entry.value) {
        (ValueKind::PathOr(words), Value::String(word)) if is_among(word, words) => {
            match templates::folder(word) {
                Ok(folder) => folder.to_str().map(Value::from),
                Err(error) => {
                    errors.push(CaseError::Nonsense {
                        found: shorten(&entry.value),
                        key: entry.key,
                        place: entry.place,
                        message: format!(
                            "cannot unpack it into the cache (XDG_CACHE_HOME or HOME) nor for the time being (TMPDIR): \
                             {error}"
                        ),
                    });
                    return None;
                }
            }
        }
        (kind, _) => read(kind, &entry),
    };
    if let Some(value) = value {
        entry.value = value;
        return Some(entry);
    }
    let suggestion = match (key.kind, &entry.value) {
        (ValueKind::Word(words), Value::String(word)) => {
            spelling::closest(word, words.iter().map(|(known, _)| *known))
        }
        (ValueKind::WholeOr(_, _, word), Value::String(found)) => spelling::closest(found, [word]),
        _ => None,
    };
    errors.push(CaseError::Value {
        suggestion: suggestion.map(str::to_owned),
        found: shorten(&entry.value),
        key: entry.key,
        place: entry.place,
        allowed: key.kind.to_string(),
        about: key.about.to_owned(),
    });
    None
}

fn is_among(word: &str, words: &[(&str, &str)]) -> bool {
    words.iter().any(|(known, _)| *known == word)
}

/// The value in the form of its kind; none if it is of another.
fn read(kind: ValueKind, entry: &CaseValue) -> Option<Value> {
    match (kind, &entry.value) {
        (ValueKind::Real(range), number) => {
            let x = self::number(number).filter(|x| range.contains(*x))?;
            Some(Value::Float(x))
        }
        (ValueKind::Path, Value::String(path)) if !path.is_empty() => absolute(path, entry),
        (ValueKind::PathOr(_), Value::String(path)) if !path.is_empty() => absolute(path, entry),
        (ValueKind::Command(most), Value::Array(words)) if (1..=most).contains(&words.len()) => {
            read_command(words, entry)
        }
        (ValueKind::Rows(most), Value::Array(rows)) => read_rows(rows, most),
        (ValueKind::Radii(most, columns), Value::Array(rows))
            if (2..=most).contains(&rows.len()) =>
        {
            read_radii(rows, columns)
        }
        (ValueKind::Points(most), Value::Array(points)) if points.len() <= most => {
            read_points(points)
        }
        (ValueKind::Triples(most), Value::Array(all)) if all.len() <= most => {
            let is_number = |value: &Value| value.as_integer().is_some_and(|i| i >= 0);
            let is_triple = |value: &Value| {
                (value.as_array())
                    .is_some_and(|three| three.len() == 3 && three.iter().all(is_number))
            };
            all.iter().all(is_triple).then(|| entry.value.clone())
        }
        (ValueKind::Degrees(low, high), degrees) => read_degrees(degrees, low..=high),
        (ValueKind::Numbers(most), Value::Array(all)) if (2..=most).contains(&all.len()) => {
            numbers(all, |x| x.is_finite())
        }
        (ValueKind::Amplitudes(most), Value::Array(all)) if (1..=most).contains(&all.len()) => {
            numbers(all, |x| x.is_finite())
        }
        (ValueKind::Sizes(most), Value::Array(all)) if (1..=most).contains(&all.len()) => {
            numbers(all, |x| x.is_finite() && x > 0.0)
        }
        (kind, value) => is_as_it_should_be(kind, value).then(|| value.clone()),
    }
}

/// Whether a value of a kind that needs no other form is right.
fn is_as_it_should_be(kind: ValueKind, value: &Value) -> bool {
    match (kind, value) {
        (ValueKind::Whole(low, high) | ValueKind::WholeOr(low, high, _), Value::Integer(i)) => {
            (low..=high).contains(i)
        }
        (ValueKind::WholeOr(_, _, word), Value::String(found)) => found == word,
        (ValueKind::Word(words), Value::String(word)) => is_among(word, words),
        (ValueKind::Flag, Value::Boolean(_)) => true,
        (ValueKind::Text(most), Value::String(text)) => {
            !text.trim().is_empty()
                && text.chars().count() <= most
                && !text.chars().any(char::is_control)
        }
        (ValueKind::Names(most), Value::Array(names)) => {
            let is_name = |name: &Value| name.as_str().is_some_and(|name| !name.is_empty());
            (1..=most).contains(&names.len()) && names.iter().all(is_name)
        }
        _ => false,
    }
}

/// Numbers of which each is right.
fn numbers(values: &[Value], is_right: impl Fn(f64) -> bool) -> Option<Value> {
    let right = |value| number(value).filter(|x| is_right(*x)).map(Value::Float);
    values
        .iter()
        .map(right)
        .collect::<Option<_>>()
        .map(Value::Array)
}

/// A path as one that does not depend on the current folder.
fn absolute(path: &str, entry: &CaseValue) -> Option<Value> {
    let absolute = source::tidy(&entry.folder.join(path));
    absolute.to_str().map(Value::from)
}

/// A program and its arguments. What is the name of a file next to the one that the words stand in becomes its path; so
/// does a program with a slash in its name, the others are looked for in `PATH`.
fn read_command(words: &[Value], entry: &CaseValue) -> Option<Value> {
    let word = |(i, word): (usize, &Value)| {
        let word = word.as_str().filter(|word| !word.contains('\0'))?;
        let is_path = match i {
            0 if word.is_empty() => return None,
            0 => word.contains('/'),
            _ => !word.is_empty() && entry.folder.join(word).is_file(),
        };
        if is_path {
            absolute(word, entry)
        } else {
            Some(word.into())
        }
    };
    let words = words.iter().enumerate().map(word);
    words.collect::<Option<_>>().map(Value::Array)
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Float(x) => Some(*x),
        Value::Integer(i) => Some(*i as f64),
        _ => None,
    }
}

/// Three degrees from three, or from one.
fn read_degrees(found: &Value, range: RangeInclusive<i64>) -> Option<Value> {
    let degree = |value: &Value| value.as_integer().filter(|p| range.contains(p));
    let three = match found {
        Value::Array(degrees) if degrees.len() == 3 => {
            degrees.iter().map(degree).collect::<Option<Vec<_>>>()
        }
        single => degree(single).map(|p| vec![p; 3]),
    };
    three.map(Value::from)
}

/// Lists of numbers.
fn read_lists(lists: &[Value]) -> Option<Vec<Vec<f64>>> {
    lists
        .iter()
        .map(|list| list.as_array()?.iter().map(number).collect())
        .collect()
}

/// Points as [`ValueKind::Points`] asks for them.
fn read_points(points: &[Value]) -> Option<Value> {
    let points = read_lists(points)?;
    let fine = points
        .iter()
        .all(|point| point.len() == 3 && point.iter().all(|x| x.is_finite()));
    fine.then(|| Value::from(points))
}

/// Rows as [`ValueKind::Rows`] asks for them.
fn read_rows(rows: &[Value], most: usize) -> Option<Value> {
    let rows = read_lists(rows)?;
    let columns = rows.first()?.len();
    let zero = |row: Option<&Vec<f64>>| row.is_some_and(|row| row.iter().all(|x| *x == 0.0));
    let fine = (3..=most).contains(&rows.len())
        && (3..=most).contains(&columns)
        && rows
            .iter()
            .all(|row| row.len() == columns && row.iter().all(|x| (0.0..=1.0).contains(x)))
        && zero(rows.first())
        && zero(rows.last());
    fine.then(|| Value::from(rows))
}

/// Rows as [`ValueKind::Radii`] asks for them.
fn read_radii(rows: &[Value], most: usize) -> Option<Value> {
    let rows = read_lists(rows)?;
    let columns = rows.first()?.len();
    let positive = |r: &f64| r.is_finite() && *r > 0.0;
    let fine = (4..=most).contains(&columns)
        && (rows.iter()).all(|row| row.len() == columns && row.iter().all(positive));
    fine.then(|| Value::from(rows))
}

/// `list` and 3 of `list[3]`.
pub(super) fn split_index(path: &str) -> Option<(&str, usize)> {
    let (list, index) = path.strip_suffix(']')?.rsplit_once('[')?;
    Some((list, index.parse().ok()?))
}

/// A value in few letters for a message.
pub fn shorten(value: &Value) -> String {
    let text: String = value
        .to_string()
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ");
    if text.chars().count() > 60 {
        text.chars().take(57).chain("...".chars()).collect()
    } else {
        text
    }
}
