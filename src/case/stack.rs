//! Layers of values on top of each other: the last one wins.

use super::Case;
use super::error::{CaseError, Place};
use super::schema::{self, Key};
use super::source::Entry;
use super::value::shorten;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use toml::Value;

/// From so many missing keys on, the advice is to stand on the defaults.
const MANY: usize = 10;

/// The values that count, with the rank of the layer that each stands in.
#[derive(Debug, Default)]
pub(super) struct Stack {
    top: BTreeMap<String, (usize, Entry)>,
    /// Keys whose last value was refused, so that a lower layer's stands in its place.
    wrong: BTreeSet<String>,
    /// Materials: the rank from which on a part of the wall has its present one.
    material_since: BTreeMap<&'static str, usize>,
}

impl Stack {
    /// Lays a checked entry on top; ranks grow from call to call.
    pub(super) fn put(&mut self, rank: usize, entry: Entry) {
        self.wrong.remove(&entry.key);
        let same = self
            .top
            .get(&entry.key)
            .is_some_and(|(_, below)| below.value == entry.value);
        if let Some((table, "material")) = schema::split_material(&entry.key)
            && !same
        {
            self.material_since.insert(table, rank);
        }
        self.top.insert(entry.key.clone(), (rank, entry));
    }

    /// Remembers that the last value of `key` makes no sense.
    pub(super) fn refuse(&mut self, key: String) {
        self.wrong.insert(key);
    }

    /// Where each value was written.
    pub(super) fn places(self) -> BTreeMap<String, Place> {
        let entries = self.top.into_iter();
        entries
            .map(|(key, (_, entry))| (key, entry.place))
            .collect()
    }

    /// The value of `key` that counts.
    pub(super) fn entry(&self, key: &str) -> Option<&Entry> {
        self.top.get(key).map(|(_, entry)| entry)
    }

    /// The one of these keys whose value stands in the highest layer; the first of several.
    pub(super) fn last_written(&self, keys: &[&str]) -> Option<&Entry> {
        let found = keys.iter().rev().filter_map(|key| self.top.get(*key));
        found.max_by_key(|(rank, _)| *rank).map(|(_, entry)| entry)
    }

    /// Whether the value of `key` was refused.
    pub(super) fn is_wrong(&self, key: &str) -> bool {
        self.wrong.contains(key)
    }

    fn material(&self, table: &str) -> Option<&str> {
        self.top.get(&format!("{table}.material"))?.1.value.as_str()
    }

    /// Drops the parameters of a material that was replaced in a higher layer; others must fit their material.
    pub(super) fn sort_out_materials(&mut self, errors: &mut Vec<CaseError>) {
        for &table in schema::MATERIAL_TABLES {
            let Some(material) = self.material(table).map(str::to_owned) else {
                continue;
            };
            let since = self.material_since[table];
            let names: Vec<_> = schema::parameters(&material)
                .iter()
                .map(|key| key.path)
                .collect();
            self.top.retain(|key, (rank, entry)| {
                let parameter = match schema::split_material(key) {
                    Some((of, parameter)) if of == table && parameter != "material" => parameter,
                    _ => return true,
                };
                let belongs = names.contains(&parameter);
                if !belongs && *rank >= since {
                    errors.push(CaseError::Nonsense {
                        place: entry.place.clone(),
                        key: key.clone(),
                        found: shorten(&entry.value),
                        message: format!(
                            "{material} has no such parameter; it has {}",
                            names.join(", ")
                        ),
                    });
                }
                belongs && *rank >= since
            });
        }
    }

    /// Whether the case has this table at the root of the file.
    fn is_there(&self, table: &str) -> bool {
        let mut given = self.top.keys().chain(&self.wrong);
        !schema::OPTIONAL_TABLES.contains(&table) || given.any(|key| schema::root(key) == table)
    }

    /// Every key needs a value, but for the optional ones.
    pub(super) fn require_all(&self, file: &Path, errors: &mut Vec<CaseError>) {
        let mut missing = Vec::new();
        let mut require = |path: String, key: &Key| {
            let wanted = !key.optional && self.is_there(schema::root(&path));
            if wanted && !self.top.contains_key(&path) && !self.wrong.contains(&path) {
                missing.push((path, key.kind, key.about));
            }
        };
        schema::KEYS
            .iter()
            .for_each(|key| require(key.path.to_owned(), key));
        for &table in schema::MATERIAL_TABLES {
            let parameters = self.material(table).map_or(&[][..], schema::parameters);
            for key in [&schema::MATERIAL].into_iter().chain(parameters) {
                require(format!("{table}.{}", key.path), key);
            }
        }
        let file = file.to_owned();
        // The defaults have nothing to say about optional tables.
        let of_defaults =
            |(path, ..): &&(String, _, _)| !schema::OPTIONAL_TABLES.contains(&schema::root(path));
        let count = missing.iter().filter(of_defaults).count();
        match missing.iter().find(of_defaults) {
            Some((first, ..)) if count >= MANY => {
                errors.push(CaseError::NoDefaults {
                    file,
                    count,
                    first: first.clone(),
                });
            }
            _ => errors.extend(
                missing
                    .into_iter()
                    .map(|(key, kind, about)| CaseError::Missing {
                        file: file.clone(),
                        key,
                        allowed: kind.to_string(),
                        about: about.to_owned(),
                    }),
            ),
        }
    }

    /// The case, if there is a value for every key (be it a lower layer's for a refused one).
    pub(super) fn build(&self, file: &Path, errors: &mut Vec<CaseError>) -> Option<Case> {
        let mut root = toml::Table::new();
        for (path, (_, entry)) in &self.top {
            let mut table = &mut root;
            let mut names = path.split('.').peekable();
            while let Some(name) = names.next() {
                if names.peek().is_none() {
                    table.insert(name.to_owned(), entry.value.clone());
                    break;
                }
                let inner = table
                    .entry(name)
                    .or_insert_with(|| Value::Table(toml::Table::new()));
                table = inner.as_table_mut()?;
            }
        }
        match root.try_into() {
            Ok(case) => Some(case),
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
