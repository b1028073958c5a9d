//! What may stand in a file: its keys with their ranges and meanings, collected from the types that it is read into.

mod kind;

pub use kind::{Range, ValueKind, above, from, whole};

use super::{Case, ProblemKind};
use std::collections::HashMap;

/// One key of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Key {
    /// Dotted path, such as `time.step_s`; the unit is part of the name, and `[]` stands for any index.
    pub path: String,
    /// Which values are allowed.
    pub kind: ValueKind,
    /// What counts where the key is absent; without it the key is needed.
    pub absent: Option<&'static str>,
    /// What the value is, in a few words.
    pub about: &'static str,
    /// The only choices of its table that have this key; any if empty.
    pub choices: Vec<Choice>,
    /// The only kinds of cases that have this key; all if empty.
    pub problems: &'static [ProblemKind],
    /// The conditions under which it is read; always if empty.
    pub only: Vec<&'static Only>,
}

/// The condition under which a key, or a table, is read.
#[derive(Debug)]
pub struct Only {
    /// For "is read only …".
    pub when: &'static str,
    /// Whether a case reads the key at this path, which has the indices of its tables.
    pub(super) holds: fn(&Case, &str) -> bool,
}

// A condition is its words; two pointers to one function may differ.
impl PartialEq for Only {
    fn eq(&self, other: &Self) -> bool {
        self.when == other.when
    }
}

/// A table whose key `tag` has the value `word`, such as `material = "neo_hooke"`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Choice {
    /// Name of the key that chooses.
    pub tag: &'static str,
    /// Its value.
    pub word: &'static str,
}

impl Key {
    /// Where the value lies within the type that the file is read into, as a dotted path.
    pub(super) fn place(&self, path: &str) -> String {
        ProblemKind::place(self.problems, path)
    }

    /// Whether nothing but a case of this kind has it; such a key has no default.
    pub(super) fn is_special_to(&self, kind: ProblemKind) -> bool {
        let is_of_default = self.problems.contains(&ProblemKind::Anastomosis);
        self.problems.contains(&kind) && (self.problems.len() == 1 || !is_of_default)
    }

    /// Whether only cases of other kinds have it.
    pub(super) fn is_foreign_to(&self, kind: ProblemKind) -> bool {
        !self.problems.is_empty() && !self.problems.contains(&kind)
    }

    /// The path of the table that the key stands in.
    pub fn table(&self) -> &str {
        parent(&self.path)
    }

    /// The last name of the path.
    pub fn name(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or(&self.path)
    }

    /// The unit that the name ends with, if it has one.
    pub fn unit(&self) -> Option<&'static str> {
        const UNITS: [(&str, &str); 15] = [
            ("_Pa_sn", "Pa sⁿ"),
            ("_Pa_s_m3", "Pa s/m³"),
            ("_Pa_s_m", "Pa s/m"),
            ("_Pa_m", "Pa/m"),
            ("_kg_m3", "kg/m³"),
            ("_m3_Pa", "m³/Pa"),
            ("_m3_s", "m³/s"),
            ("_Pa_s", "Pa s"),
            ("_m_s", "m/s"),
            ("_1_s", "1/s"),
            ("_Pa", "Pa"),
            ("_deg", "°"),
            ("_min", "min"),
            ("_m", "m"),
            ("_s", "s"),
        ];
        let ends = |(suffix, _): &&(&str, &str)| self.name().ends_with(suffix);
        UNITS.iter().find(ends).map(|(_, unit)| *unit)
    }
}

/// A table of a file, which the macros `table!` and `choice!` make.
pub trait KeyTable {
    /// Adds what may stand in this table at `path` (empty: the file itself).
    fn describe(path: &str, schema: &mut Schema);
}

/// A table that a file may do without; where it has any key it needs all.
impl<T: KeyTable> KeyTable for Option<T> {
    fn describe(path: &str, schema: &mut Schema) {
        schema.optional_tables.push(path.to_owned());
        T::describe(path, schema);
    }
}

/// One or more tables, `[[path]]`.
impl<T: KeyTable> KeyTable for Vec<T> {
    fn describe(path: &str, schema: &mut Schema) {
        T::describe(&format!("{path}[]"), schema);
    }
}

/// All keys of a kind of file.
#[derive(Debug, Default)]
pub struct Schema {
    keys: Vec<Key>,
    by_path: HashMap<String, usize>,
    optional_tables: Vec<String>,
    has_defaults: bool,
}

impl Schema {
    /// The keys of files that are read into a `T`.
    pub fn of<T: KeyTable>() -> Self {
        let mut schema = Self::default();
        T::describe("", &mut schema);
        schema
    }

    /// The same for files that can stand on others by `extends`.
    pub fn with_defaults(self) -> Self {
        Self {
            has_defaults: true,
            ..self
        }
    }

    /// The same in the order in which `text`, a file with all the tables, has its tables at the root. Keys of a table
    /// stand together, those that only one kind of case has last.
    pub(super) fn in_the_order_of(mut self, text: &str) -> Self {
        let root = |key: &Key| {
            let name = key.path.split('.').next().unwrap_or_default();
            let headers = ["[", "# [", "# [["].map(|open| format!("\n{open}{name}"));
            headers.iter().find_map(|header| text.find(header))
        };
        let tables: Vec<String> = (self.keys.iter())
            .map(|key| key.table().to_owned())
            .collect();
        let depth = |table: &str| table.split('.').count();
        self.keys.sort_by_cached_key(|key| {
            let table = tables.iter().position(|table| table == key.table());
            (
                root(key),
                depth(key.table()),
                table,
                !key.problems.is_empty(),
            )
        });
        let paths = self.keys.iter().enumerate();
        self.by_path = paths.map(|(i, key)| (key.path.clone(), i)).collect();
        self
    }

    /// Adds what `describe` does, as keys that only these kinds of cases have, or fewer if it says so itself.
    pub(super) fn of_problems(
        &mut self,
        kinds: &'static [ProblemKind],
        describe: impl FnOnce(&mut Self),
    ) {
        let before = self.keys.len();
        describe(self);
        for key in &mut self.keys[before..] {
            if key.problems.is_empty() {
                key.problems = kinds;
            }
        }
    }

    /// Adds what `describe` does, as keys that are read under these conditions only.
    pub fn only(&mut self, conditions: &[&'static Only], describe: impl FnOnce(&mut Self)) {
        let before = self.keys.len();
        describe(self);
        for key in &mut self.keys[before..] {
            key.only.extend(conditions);
        }
    }

    /// Whether a file can stand on others by `extends`.
    pub fn has_defaults(&self) -> bool {
        self.has_defaults
    }

    /// The keys in the order of the file.
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// Adds a key; one that several choices of a table have becomes one.
    pub fn add(&mut self, key: Key) {
        match self.by_path.get(&key.path) {
            Some(&i) => {
                let same = &mut self.keys[i];
                assert_eq!(same.kind, key.kind, "{} has two ranges", key.path);
                same.choices.extend(key.choices);
            }
            None => {
                self.by_path.insert(key.path.clone(), self.keys.len());
                self.keys.push(key);
            }
        }
    }

    /// What is known of the key at `path`, which may have indices.
    pub fn find(&self, path: &str) -> Option<&Key> {
        let index = self.by_path.get(&without_indices(path))?;
        Some(&self.keys[*index])
    }

    /// Where the value of the key, or the table, at `path` lies within the type that the file is read into.
    pub(super) fn place(&self, path: &str) -> String {
        let bare = without_indices(path);
        let mut within = self.keys.iter().filter(|key| is_within(&key.path, &bare));
        match within.next() {
            Some(key) => key.place(path),
            None => path.to_owned(),
        }
    }

    /// Whether there is a table at `path`, which may have indices.
    pub fn has_table(&self, path: &str) -> bool {
        let prefix = without_indices(path) + ".";
        self.keys.iter().any(|key| key.path.starts_with(&prefix))
    }

    /// The optional tables that the key at `path` stands in, from the outside in.
    pub fn optional_tables(&self, path: &str) -> impl Iterator<Item = &str> {
        let tables = self.optional_tables.iter();
        tables
            .filter(move |table| is_within(path, table))
            .map(String::as_str)
    }

    /// The keys that a table has where it makes this choice.
    pub fn chosen(&self, table: &str, choice: Choice) -> impl Iterator<Item = &Key> {
        let table = without_indices(table);
        let keys = self.keys.iter();
        keys.filter(move |key| key.table() == table && key.choices.contains(&choice))
    }

    /// The paths that may stand where `path` stands: in lists, those with its indices.
    pub fn alternatives(&self, path: &str) -> Vec<String> {
        let keys = self.keys.iter();
        keys.map(|key| with_indices_of(path, &key.path)).collect()
    }
}

/// The path of the table that a path stands in.
pub fn parent(path: &str) -> &str {
    path.rsplit_once('.').map_or("", |(table, _)| table)
}

/// Whether a path lies in this table (or list of tables), or is the table itself.
pub fn is_within(path: &str, table: &str) -> bool {
    let rest = path.strip_prefix(table);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

/// The path of `name` in the table at `path`.
pub fn join(path: &str, name: &str) -> String {
    if path.is_empty() {
        name.to_owned()
    } else {
        format!("{path}.{name}")
    }
}

/// `tube.layer[3].k2` as `tube.layer[].k2`.
fn without_indices(path: &str) -> String {
    let mut bare = String::with_capacity(path.len());
    for part in path.split_inclusive('[') {
        bare.push_str(part.trim_start_matches(|c: char| c.is_ascii_digit() && part.contains(']')));
    }
    bare
}

/// The `pattern` with the indices of `path` in place of its `[]`, or with 0 where `path` has none.
fn with_indices_of(path: &str, pattern: &str) -> String {
    let mut indices = path.split('[').skip(1).map(|rest| {
        let digits = rest.split(']').next().unwrap_or_default();
        digits.parse().unwrap_or(0)
    });
    let mut parts = pattern.split("[]");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| {
        let index: usize = indices.next().unwrap_or(0);
        format!("{text}[{index}]{part}")
    })
}
