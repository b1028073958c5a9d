//! TOML text, flattened: every value under its dotted path, with the line it stands in.

use super::defaults;
use super::error::{CaseError, ValuePlace};
use super::text_file;
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Value;
use toml::de::{DeTable, DeValue};

/// A value where it was written.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseValue {
    /// Dotted path of the key.
    pub key: String,
    /// The value.
    pub value: Value,
    /// Where.
    pub place: ValuePlace,
    /// Folder that relative paths start from.
    pub folder: PathBuf,
}

/// A case file: what it stands on, its values, and its presets' values.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Source {
    /// What `extends` names, with the place of that line.
    pub extends: Option<(Base, ValuePlace)>,
    /// Values outside presets.
    pub plain: Vec<CaseValue>,
    /// Values of presets, with the preset's name.
    pub presets: Vec<(String, CaseValue)>,
}

/// What a file stands on.
#[derive(Debug, Clone, PartialEq)]
pub enum Base {
    /// Another file.
    File(PathBuf),
    /// The defaults that are built into the program.
    Defaults,
}

impl Base {
    /// The word for the defaults; a file of that name is `./defaults`.
    const DEFAULTS: &str = "defaults";
}

/// The defaults that are built into the program.
pub fn read_defaults(errors: &mut Vec<CaseError>) -> Source {
    let path = Path::new(defaults::SHOWN_AS);
    parse(defaults::TEXT, path, Path::new(""), errors)
}

/// Reads the file `path`, shown as such in messages; `advice` says what to do if it cannot be read.
pub fn read(path: &Path, advice: &str, errors: &mut Vec<CaseError>) -> Source {
    let unreadable = |reason: String| CaseError::Unreadable {
        path: path.to_owned(),
        reason,
    };
    let text = match text_file::read(path, text_file::OF_PARAMETERS) {
        Ok(text) => text,
        Err(error) => {
            errors.push(unreadable(format!("{error}; {advice}")));
            return Source::default();
        }
    };
    let folder = match std::fs::canonicalize(path.parent().unwrap_or(Path::new(""))) {
        Ok(folder) => folder,
        Err(_) => std::env::current_dir().unwrap_or_default(),
    };
    parse(&text, path, &folder, errors)
}

/// The values of a text of the file `path`; relative paths in it start from `folder`.
fn parse(text: &str, path: &Path, folder: &Path, errors: &mut Vec<CaseError>) -> Source {
    let lines: Vec<usize> = text.match_indices('\n').map(|(at, _)| at).collect();
    let line_of = |offset: usize| 1 + lines.partition_point(|end| *end < offset);
    let place = |span: Range<usize>| ValuePlace::File(path.to_owned(), line_of(span.start));
    let mut source = Source::default();
    for (mut keys, value, at) in flatten(text, &place, errors) {
        let entry = |key: String| CaseValue {
            key,
            value: value.clone(),
            place: at.clone(),
            folder: folder.to_owned(),
        };
        match keys[0].as_str() {
            "extends" if keys.len() == 1 => match value.as_str() {
                Some(Base::DEFAULTS) => source.extends = Some((Base::Defaults, at)),
                Some(base) => {
                    let base = Base::File(tidy(&path.with_file_name(base)));
                    source.extends = Some((base, at));
                }
                None => errors.push(CaseError::Value {
                    place: at.clone(),
                    key: "extends".into(),
                    found: value.to_string(),
                    allowed: "a path in quotes, or \"defaults\"".into(),
                    about: "the file that this one extends".into(),
                    suggestion: None,
                }),
            },
            "preset" if keys.len() > 2 => {
                let key = keys.split_off(2).join(".");
                source.presets.push((keys.swap_remove(1), entry(key)));
            }
            // An empty preset.
            "preset"
                if keys.len() == 2 && value.as_table().is_some_and(|table| table.is_empty()) => {}
            _ => source.plain.push(entry(keys.join("."))),
        }
    }
    source
}

/// Reads a value of the command line, such as that of `--set key=value`: it is TOML, or else a word. Relative paths
/// start from the current folder.
pub fn read_option(place: ValuePlace, key: &str, value: &str) -> CaseValue {
    let value = toml::from_str::<toml::Table>(&format!("value = {value}\n"))
        .ok()
        .and_then(|mut table| {
            if table.len() == 1 {
                table.remove("value")
            } else {
                None
            }
        })
        .unwrap_or_else(|| Value::String(value.to_owned()));
    CaseValue {
        key: key.trim().to_owned(),
        value,
        place,
        folder: std::env::current_dir().unwrap_or_default(),
    }
}

/// The tables at the root of the file that these entries stand in, and the entries' own keys.
pub fn tables<'a>(entries: impl IntoIterator<Item = &'a CaseValue>) -> BTreeSet<String> {
    let names = entries.into_iter().flat_map(|entry| {
        let root = entry.key.split('.').next().unwrap_or_default();
        [root.to_owned(), entry.key.clone()]
    });
    names.collect()
}

/// Splits a table given to `--set` (such as `fluid.mesh={core=4}`) into its entries.
pub fn split_tables(entry: CaseValue) -> Vec<CaseValue> {
    match entry.value {
        Value::Table(table) if !table.is_empty() => table
            .into_iter()
            .flat_map(|(name, value)| {
                let key = format!("{}.{name}", entry.key);
                split_tables(CaseValue {
                    key,
                    value,
                    place: entry.place.clone(),
                    folder: entry.folder.clone(),
                })
            })
            .collect(),
        _ => vec![entry],
    }
}

/// The line of a text with the byte `at`.
fn line_at(text: &str, at: usize) -> &str {
    let bytes = text.as_bytes();
    let before = bytes[..at.min(bytes.len())]
        .iter()
        .filter(|byte| **byte == b'\n');
    text.split('\n').nth(before.count()).unwrap_or_default()
}

/// What else people write, and TOML does not know.
fn hint(line: &str) -> &'static str {
    let value = line.split_once('=').map_or("", |(_, value)| value.trim());
    let is_decimal = |(whole, fraction): (&str, &str)| {
        whole.trim_start_matches(['+', '-']).parse::<u64>().is_ok()
            && fraction.starts_with(|c: char| c.is_ascii_digit())
    };
    if line.contains(['“', '”', '„', '‘', '’', '«', '»']) {
        "; quotation marks must be straight: \""
    } else if value.split_once(',').is_some_and(is_decimal) {
        "; decimals have a point, not a comma"
    } else {
        ""
    }
}

type Flat = Vec<(Vec<String>, Value, ValuePlace)>;

fn flatten(
    text: &str,
    place: &dyn Fn(Range<usize>) -> ValuePlace,
    errors: &mut Vec<CaseError>,
) -> Flat {
    let (spanned, mistakes) = DeTable::parse_recoverable(text);
    for mistake in &mistakes {
        let message = mistake.message().replace('\n', ", ");
        let span = mistake.span().unwrap_or(0..0);
        let hint = hint(line_at(text, span.start));
        errors.push(CaseError::Syntax {
            place: place(span),
            message: message + hint,
        });
    }
    let mut flat = Flat::new();
    if mistakes.is_empty() {
        match toml::from_str::<toml::Table>(text) {
            Ok(values) => walk(
                spanned.get_ref(),
                &values,
                &mut Vec::new(),
                place,
                &mut flat,
            ),
            Err(error) => {
                let message = error.message().replace('\n', ", ");
                errors.push(CaseError::Syntax {
                    place: place(error.span().unwrap_or(0..0)),
                    message,
                });
            }
        }
    }
    flat
}

fn walk(
    spans: &DeTable<'_>,
    values: &toml::Table,
    keys: &mut Vec<String>,
    place: &dyn Fn(Range<usize>) -> ValuePlace,
    flat: &mut Flat,
) {
    for (key, spanned) in spans {
        let name = key.get_ref().to_string();
        let Some(value) = values.get(&name) else {
            continue;
        };
        // Brackets are for indices and dots for tables; a quoted key that has some must not pass for either.
        keys.push(match name.contains(['[', ']', '.']) {
            true => format!("{name:?}"),
            false => name.clone(),
        });
        match (spanned.get_ref(), value) {
            (DeValue::Table(inner), Value::Table(table)) if !table.is_empty() => {
                walk(inner, table, keys, place, flat)
            }
            // `[[name]]`: its tables count from zero, as `name[0]`.
            (DeValue::Array(inner), Value::Array(tables)) if tables.iter().any(Value::is_table) => {
                for (i, (spanned, value)) in inner.iter().zip(tables).enumerate() {
                    keys.pop();
                    keys.push(format!("{name}[{i}]"));
                    match (spanned.get_ref(), value) {
                        (DeValue::Table(inner), Value::Table(table)) if !table.is_empty() => {
                            walk(inner, table, keys, place, flat)
                        }
                        _ => flat.push((keys.clone(), value.clone(), place(spanned.span()))),
                    }
                }
            }
            _ => flat.push((keys.clone(), value.clone(), place(key.span()))),
        }
        keys.pop();
    }
}

/// Removes `name/..` from a path, so that messages show `openfoam-case/defaults.toml`.
pub fn tidy(path: &Path) -> PathBuf {
    use std::path::Component::{Normal, ParentDir};
    let mut tidy = PathBuf::new();
    for component in path.components() {
        match (component, tidy.components().next_back()) {
            (ParentDir, Some(Normal(_))) => drop(tidy.pop()),
            _ => tidy.push(component),
        }
    }
    tidy
}
