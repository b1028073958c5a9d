//! Layers of values on top of each other: the last one wins.

use super::error::{CaseError, ValuePlace};
use super::schema::{self, Choice, Key, Schema, ValueKind};
use super::source::CaseValue;
use super::value::{self, shorten};
use super::{ProblemKind, spelling};
use serde::de::DeserializeOwned;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use toml::Value;

/// From so many missing keys on, the advice is to stand on the defaults.
const MANY: usize = 10;

/// The values that count, with the rank of the layer that each stands in.
#[derive(Debug)]
pub struct Stack {
    schema: &'static Schema,
    /// The tables at the root that are mentioned anywhere, and all keys.
    tables: BTreeSet<String>,
    layers: usize,
    /// The kind of case that the tables make it.
    kind: ProblemKind,
    /// The rank from which on it is of that kind.
    kind_since: usize,
    top: BTreeMap<String, (usize, CaseValue)>,
    /// Keys whose last value was refused, so that a lower layer's stands in its place.
    wrong: BTreeSet<String>,
    /// Tables that were written without any key.
    empty: BTreeSet<String>,
    /// The rank from which on a table makes its present choice, by the path of the tag.
    chosen_since: BTreeMap<String, usize>,
}

impl Stack {
    /// No values yet for the keys of this schema; there will be some in these `tables` at the root.
    pub fn new(schema: &'static Schema, tables: BTreeSet<String>) -> Self {
        let kind = ProblemKind::of(&tables);
        Self {
            schema,
            tables,
            layers: 0,
            kind,
            kind_since: usize::MAX,
            top: BTreeMap::new(),
            wrong: BTreeSet::new(),
            empty: BTreeSet::new(),
            chosen_since: BTreeMap::new(),
        }
    }

    /// The entry with its value in the form that its key asks for, or an error.
    pub fn check(&self, entry: CaseValue, errors: &mut Vec<CaseError>) -> Option<CaseValue> {
        match self.schema.find(&entry.key) {
            Some(key) => value::check(entry, key, errors),
            None => {
                spelling::unknown_key(entry, |path| self.alternatives(path), errors);
                None
            }
        }
    }

    /// Whether a key is one of another kind of case.
    fn is_foreign(&self, key: &Key) -> bool {
        key.is_foreign_to(self.kind)
    }

    /// The paths that may stand where `path` stands, without those of other kinds of cases and those in optional tables
    /// that nobody mentions.
    pub(super) fn alternatives(&self, path: &str) -> Vec<String> {
        let mut paths = self.schema.alternatives(path);
        paths.retain(|path| {
            if self
                .schema
                .find(path)
                .is_some_and(|key| self.is_foreign(key))
            {
                return false;
            }
            let mut optional = self.schema.optional_tables(path);
            optional.all(|table| self.tables.iter().any(|t| schema::is_within(table, t)))
        });
        paths
    }

    /// Checks the values of a layer and lays them on top.
    pub fn lay(&mut self, layer: Vec<CaseValue>, errors: &mut Vec<CaseError>) {
        for entry in layer {
            let key = entry.key.clone();
            if entry.value.as_table().is_some_and(|table| table.is_empty())
                && self.schema.has_table(&key)
            {
                self.empty.insert(key);
                continue;
            }
            match self.check(entry, errors) {
                Some(entry) => self.put(entry),
                None => drop(self.wrong.insert(key)),
            }
        }
        self.layers += 1;
    }

    /// Drops the keys of other kinds of cases that stand in layers below the one that says which kind it is, such as
    /// those of the vessel in the defaults; above, nobody can want them.
    pub fn sort_out_kinds(&mut self, errors: &mut Vec<CaseError>) {
        let top = std::mem::take(&mut self.top).into_iter();
        let (others, top): (BTreeMap<_, _>, _) = top.partition(|(path, _)| {
            let key = self.schema.find(path);
            key.is_some_and(|key| self.is_foreign(key))
        });
        for (key, (rank, entry)) in others {
            if rank >= self.kind_since {
                errors.push(CaseError::Nonsense {
                    place: entry.place,
                    key,
                    found: shorten(&entry.value),
                    message: format!(
                        "a case with {} has no such key: leave out one of the two",
                        self.kind.shown()
                    ),
                });
            }
        }
        self.top = top;
    }

    fn put(&mut self, entry: CaseValue) {
        let key = entry.key.clone();
        self.wrong.remove(&key);
        let same = (self.top.get(&key)).is_some_and(|(_, below)| below.value == entry.value);
        if !same {
            self.chosen_since.insert(key.clone(), self.layers);
        }
        let own = self.schema.find(&key);
        if own.is_some_and(|key| key.is_special_to(self.kind)) {
            self.kind_since = self.kind_since.min(self.layers);
        }
        self.top.insert(key, (self.layers, entry));
    }

    /// Where each value was written.
    pub(super) fn places(self) -> BTreeMap<String, ValuePlace> {
        let entries = self.top.into_iter();
        entries
            .map(|(key, (_, entry))| (key, entry.place))
            .collect()
    }

    /// The value of `key` that counts.
    pub fn entry(&self, key: &str) -> Option<&CaseValue> {
        self.top.get(key).map(|(_, entry)| entry)
    }

    /// The same, or the first of the values in the table of this name.
    pub(super) fn entry_within(&self, key: &str) -> Option<&CaseValue> {
        let within = || {
            self.top
                .iter()
                .find(|(path, _)| schema::is_within(path, key))
        };
        let first = || within().map(|(_, (_, entry))| entry);
        self.entry(key).or_else(first)
    }

    /// Which values the key at `path` may have, if there is one.
    pub(super) fn kind_of(&self, path: &str) -> Option<ValueKind> {
        self.schema.find(path).map(|key| key.kind)
    }

    /// The one of these keys whose value stands in the highest layer; the first of several.
    pub(super) fn last_written(&self, keys: &[&str]) -> Option<&CaseValue> {
        let found = keys.iter().rev().filter_map(|key| self.top.get(*key));
        found.max_by_key(|(rank, _)| *rank).map(|(_, entry)| entry)
    }

    /// Whether the value of `key` was refused.
    pub(super) fn is_wrong(&self, key: &str) -> bool {
        self.wrong.contains(key)
    }

    /// The choice that `table` makes among those of its `key`, and the rank since when.
    fn choice(&self, table: &str, key: &Key) -> Option<(Choice, usize)> {
        let tag = key.choices.first()?.tag;
        let path = schema::join(table, tag);
        let word = self.entry(&path)?.value.as_str()?;
        let keys = self.schema.keys().iter();
        let mut known = keys.flat_map(|key| &key.choices);
        let choice = known.find(|choice| choice.tag == tag && choice.word == word)?;
        Some((*choice, self.chosen_since[&path]))
    }

    /// Drops the keys of a choice, such as the parameters of a material, that was replaced in a higher layer; others
    /// must fit the choice.
    pub fn sort_out_choices(&mut self, errors: &mut Vec<CaseError>) {
        let mut dropped = Vec::new();
        for (path, (rank, entry)) in &self.top {
            let Some(key) = self.schema.find(path) else {
                continue;
            };
            let table = schema::parent(path);
            let Some((choice, since)) = self.choice(table, key) else {
                continue;
            };
            let belongs = key.choices.contains(&choice);
            if !belongs && *rank >= since {
                let names: Vec<_> = (self.schema.chosen(table, choice))
                    .map(|key| key.name())
                    .collect();
                errors.push(CaseError::Nonsense {
                    place: entry.place.clone(),
                    key: path.clone(),
                    found: shorten(&entry.value),
                    message: format!(
                        "{} has no such parameter; it has {}",
                        choice.word,
                        names.join(", ")
                    ),
                });
            }
            if !belongs || *rank < since {
                dropped.push(path.clone());
            }
        }
        for path in dropped {
            self.top.remove(&path);
        }
    }

    /// Whether anything was said of this table.
    pub fn is_there(&self, table: &str) -> bool {
        let mut given = self.top.keys().chain(&self.wrong).chain(&self.empty);
        given.any(|path| schema::is_within(path, table))
    }

    /// The paths of a key: one for each table of a list, and one if there is none.
    fn paths(&self, key: &Key) -> Vec<String> {
        let Some((list, name)) = key.path.split_once("[]") else {
            return vec![key.path.clone()];
        };
        let given = self.top.keys().chain(&self.wrong).chain(&self.empty);
        let prefix = format!("{list}[");
        let indices = given.filter_map(|path| {
            let (index, _) = path.strip_prefix(&prefix)?.split_once(']')?;
            index.parse::<usize>().ok()
        });
        let last = indices.max().unwrap_or(0);
        (0..=last).map(|i| format!("{list}[{i}]{name}")).collect()
    }

    /// The first value that only a case of this kind has.
    fn first_of_kind(&self) -> Option<&CaseValue> {
        let is_own =
            |path: &str| (self.schema.find(path)).is_some_and(|key| key.is_special_to(self.kind));
        let mut entries = self.top.iter();
        let found = entries.find(|(path, _)| is_own(path));
        found.map(|(_, (_, entry))| entry)
    }

    /// Every key needs a value, but for the optional ones.
    pub fn require_all(&self, file: &Path, errors: &mut Vec<CaseError>) {
        let mut missing = Vec::new();
        for key in self.schema.keys() {
            let mut optional = self.schema.optional_tables(&key.path);
            let is_optional = self.schema.optional_tables(&key.path).next().is_some();
            if key.absent.is_some()
                || self.is_foreign(key)
                || optional.any(|table| !self.is_there(table))
            {
                continue;
            }
            for path in self.paths(key) {
                let chosen = (self.choice(schema::parent(&path), key))
                    .is_some_and(|(choice, _)| key.choices.contains(&choice));
                let needed = key.choices.is_empty() || chosen;
                if needed && !self.top.contains_key(&path) && !self.wrong.contains(&path) {
                    let shown_by_table = key.is_special_to(self.kind) && self.kind.mark().is_some();
                    missing.push((path, key, is_optional || shown_by_table));
                }
            }
        }
        // Nearly all keys of a kind: perhaps the case was never meant to be of that kind.
        let own = |(_, key, _): &(String, &Key, bool)| key.is_special_to(self.kind);
        let of_kind = missing.iter().filter(|missing| own(missing));
        let (first, count) = (of_kind.clone().next(), of_kind.count());
        if let (Some(_), Some((first, ..))) = (self.kind.mark(), first)
            && count >= MANY
            && let Some(entry) = self.first_of_kind()
        {
            errors.push(CaseError::Nonsense {
                place: entry.place.clone(),
                key: entry.key.clone(),
                found: shorten(&entry.value),
                message: format!(
                    "{} makes it another kind of case, which needs {count} keys more, `{first}` the first of them; give \
                     them all, or leave it out",
                    self.kind.shown()
                ),
            });
            missing.retain(|missing| !own(missing));
        }
        // The defaults have nothing to say about optional tables.
        let of_defaults = |(.., optional): &&(String, &Key, bool)| !optional;
        let count = missing.iter().filter(of_defaults).count();
        match missing.iter().find(of_defaults) {
            Some((first, ..)) if self.schema.has_defaults() && count >= MANY => {
                errors.push(CaseError::NoDefaults {
                    file: file.to_owned(),
                    count,
                    first: first.clone(),
                });
            }
            _ => errors.extend(
                missing
                    .into_iter()
                    .map(|(path, key, _)| CaseError::Missing {
                        file: file.to_owned(),
                        key: path,
                        allowed: key.kind.to_string(),
                        about: key.about.to_owned(),
                    }),
            ),
        }
    }

    /// The typed form, if there is a value for every key (be it a lower layer's for a refused one).
    pub fn build<T: DeserializeOwned>(
        &self,
        file: &Path,
        errors: &mut Vec<CaseError>,
    ) -> Option<T> {
        let mut root = toml::Table::new();
        let values = self.top.iter();
        let values = values.map(|(path, (_, entry))| (path, entry.value.clone()));
        let empty = self.empty.iter();
        let empty = empty.map(|path| (path, Value::Table(toml::Table::new())));
        for (path, value) in empty.chain(values) {
            insert(&mut root, &self.schema.place(path), value)?;
        }
        match root.try_into() {
            Ok(typed) => Some(typed),
            // A key without any value has been reported; what else is refused here is a mistake of the schema.
            Err(_) if !errors.is_empty() => None,
            Err(error) => {
                let reason = error.message().to_owned();
                errors.push(CaseError::Unreadable {
                    path: file.to_owned(),
                    reason,
                });
                None
            }
        }
    }
}

/// Puts a value at a dotted path, which may have indices of lists.
pub(super) fn insert(root: &mut toml::Table, path: &str, value: Value) -> Option<()> {
    let empty = || Value::Table(toml::Table::new());
    let mut table = root;
    let mut names = path.split('.').peekable();
    while let Some(name) = names.next() {
        let place = match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
            Some((list, index)) => {
                let index: usize = index.parse().ok()?;
                let list = table
                    .entry(list)
                    .or_insert_with(|| Value::Array(Vec::new()));
                let list = list.as_array_mut()?;
                list.resize_with(list.len().max(index + 1), empty);
                &mut list[index]
            }
            None => table.entry(name).or_insert_with(empty),
        };
        if names.peek().is_none() {
            *place = value;
            return Some(());
        }
        table = place.as_table_mut()?;
    }
    None
}
