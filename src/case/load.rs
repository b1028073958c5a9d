//! From files, preset and command line to a checked [`Case`]: layers of values, the last one wins.

use super::error::{CaseError, CaseErrors, Place};
use super::schema::{self, Kind};
use super::source::{self, Entry, Source};
use super::stack::Stack;
use super::{Case, check, spelling};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::Deref;
use std::path::Path;
use toml::Value;

/// Resolution and length of a run, with everything else unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// About 5000 fluid cells, 0.1 s: to see that everything runs.
    Demo,
    /// About 10,000 fluid cells, three beats.
    Coarse,
    /// 30,000 fluid cells, the structure at the order and mesh of the paper's study, three beats.
    #[default]
    Paper,
}

impl Preset {
    /// All of them.
    pub const ALL: [Preset; 3] = [Preset::Demo, Preset::Coarse, Preset::Paper];

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Demo => "demo",
            Preset::Coarse => "coarse",
            Preset::Paper => "paper",
        }
    }
}

impl std::fmt::Display for Preset {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// A checked case that remembers where each value came from. Use it like a [`Case`].
#[derive(Debug, Clone, PartialEq)]
pub struct ResolvedCase {
    /// The values.
    pub case: Case,
    /// Where each value was written, by dotted path.
    pub origins: BTreeMap<String, Place>,
}

impl Deref for ResolvedCase {
    type Target = Case;

    fn deref(&self) -> &Case {
        &self.case
    }
}

/// Files that stand on each other, at most.
const MAX_DEPTH: usize = 10;

impl Case {
    /// Reads and checks the case in the folder `dir` (or a file of any name): the file that its `extends` names, the
    /// preset, its own values, then `overrides` (pairs of a dotted key and a value in TOML; a bare word is a string).
    ///
    /// # Errors
    /// All mistakes at once, each with file, line, key, what was found and what is allowed.
    pub fn load(
        dir: &Path,
        preset: Preset,
        overrides: &[(String, String)],
    ) -> Result<ResolvedCase, CaseErrors> {
        let file = if dir.is_file() {
            dir.to_owned()
        } else {
            dir.join("case.toml")
        };
        let mut errors = Vec::new();
        let mut layers = Vec::new();
        for source in chain(&file, &mut errors) {
            layers.push(source.plain);
            let (chosen, others) = presets(source.presets, preset, &mut errors);
            layers.push(chosen);
            // Mistakes in presets that are not asked for are mistakes too.
            others
                .into_iter()
                .for_each(|entry| drop(check_entry(entry, &mut errors)));
        }
        let set = overrides
            .iter()
            .map(|(key, value)| source::read_set(key, value));
        layers.push(set.flat_map(source::split_tables).collect());
        let readable = errors.is_empty();

        let mut stack = Stack::default();
        for (rank, layer) in layers.into_iter().enumerate() {
            for entry in layer {
                let key = entry.key.clone();
                match check_entry(entry, &mut errors) {
                    Some(entry) => stack.put(rank, entry),
                    None => stack.refuse(key),
                }
            }
        }
        stack.sort_out_materials(&mut errors);
        if readable {
            stack.require_all(&file, &mut errors);
        }
        if let Some(case) = stack.build(&file, &mut errors) {
            check::check(&case, &stack, &mut errors);
            if errors.is_empty() {
                let origins = stack.places();
                return Ok(ResolvedCase { case, origins });
            }
        }
        Err(CaseErrors(errors))
    }
}

/// The file and those it stands on, the lowest first.
fn chain(file: &Path, errors: &mut Vec<CaseError>) -> Vec<Source> {
    let mut sources: Vec<Source> = Vec::new();
    let mut next = Some((file.to_owned(), None));
    while let Some((path, named_by)) = next {
        let source = source::read(&path, named_by.as_ref(), errors);
        next = source
            .extends
            .as_ref()
            .map(|(base, place)| (base.clone(), Some(place.clone())));
        if sources.len() == MAX_DEPTH {
            let reason = format!(
                "more than {MAX_DEPTH} files stand on each other by `extends`: do they form a circle?"
            );
            errors.push(CaseError::Unreadable { path, reason });
            break;
        }
        sources.push(source);
    }
    sources.reverse();
    sources
}

/// Values of the chosen preset, and of the others.
fn presets(
    found: Vec<(String, Entry)>,
    chosen: Preset,
    errors: &mut Vec<CaseError>,
) -> (Vec<Entry>, Vec<Entry>) {
    let names = Preset::ALL.map(Preset::name);
    let mut values = (Vec::new(), Vec::new());
    for (name, entry) in found {
        if !names.contains(&name.as_str()) {
            errors.push(CaseError::UnknownKey {
                place: entry.place,
                suggestion: spelling::closest(&name, names).map(|near| format!("preset.{near}")),
                key: format!("preset.{name}"),
            });
        } else if name == chosen.name() {
            values.0.push(entry);
        } else {
            values.1.push(entry);
        }
    }
    values
}

/// The entry with its value in the form that the key asks for, or an error.
fn check_entry(mut entry: Entry, errors: &mut Vec<CaseError>) -> Option<Entry> {
    let Some(key) = schema::find(&entry.key) else {
        let suggestion = spelling::suggest(&entry.key);
        errors.push(CaseError::UnknownKey {
            place: entry.place,
            key: entry.key,
            suggestion,
        });
        return None;
    };
    let value = match (key.kind, &entry.value) {
        (Kind::Real(range), Value::Float(x)) if range.contains(*x) => Some(Value::Float(*x)),
        (Kind::Real(range), Value::Integer(i)) if range.contains(*i as f64) => {
            Some(Value::Float(*i as f64))
        }
        (Kind::Whole(low, high), Value::Integer(i)) if (low..=high).contains(i) => {
            Some(Value::Integer(*i))
        }
        (Kind::Word(words), Value::String(word)) if words.contains(&word.as_str()) => {
            Some(entry.value.clone())
        }
        (Kind::Flag, Value::Boolean(_)) => Some(entry.value.clone()),
        (Kind::Path, Value::String(path)) if !path.is_empty() => {
            let absolute = source::tidy(&entry.folder.join(path));
            absolute.to_str().map(|path| Value::String(path.to_owned()))
        }
        (Kind::Rows, Value::Array(rows)) => read_rows(rows),
        (Kind::Points, Value::Array(points)) => read_points(points),
        _ => None,
    };
    match value {
        Some(value) => {
            entry.value = value;
            Some(entry)
        }
        None => {
            let suggestion = match (key.kind, &entry.value) {
                (Kind::Word(words), Value::String(word)) => {
                    spelling::closest(word, words.iter().copied())
                }
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
    }
}

/// Lists of numbers, as floating-point numbers.
fn read_lists(lists: &[Value]) -> Option<Vec<Vec<f64>>> {
    let number = |value: &Value| match value {
        Value::Float(x) => Some(*x),
        Value::Integer(i) => Some(*i as f64),
        _ => None,
    };
    lists
        .iter()
        .map(|list| list.as_array()?.iter().map(number).collect())
        .collect()
}

/// Points as [`Kind::Points`] asks for them.
fn read_points(points: &[Value]) -> Option<Value> {
    let points = read_lists(points)?;
    let fine = points
        .iter()
        .all(|point| point.len() == 3 && point.iter().all(|x| x.is_finite()));
    fine.then(|| Value::from(points))
}

/// Rows as [`Kind::Rows`] asks for them.
fn read_rows(rows: &[Value]) -> Option<Value> {
    let rows = read_lists(rows)?;
    let columns = rows.first()?.len();
    let zero = |row: Option<&Vec<f64>>| row.is_some_and(|row| row.iter().all(|x| *x == 0.0));
    let fine = rows.len() >= 3
        && columns >= 3
        && rows
            .iter()
            .all(|row| row.len() == columns && row.iter().all(|x| (0.0..=1.0).contains(x)))
        && zero(rows.first())
        && zero(rows.last());
    fine.then(|| Value::from(rows))
}

/// A value in few letters for a message.
pub(super) fn shorten(value: &Value) -> String {
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
