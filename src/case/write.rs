//! The case as a file again: every value used, loadable by itself.

use super::schema::{self, Key, ValueKind};
use super::{Case, ResolvedCase, templates};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use toml::Value;

impl Case {
    /// All values by paths in which tables of lists have their names: `vessel.material[media].mu_Pa`.
    pub fn values_by_name(&self) -> BTreeMap<String, Value> {
        let values = self.values();
        let name_of = |list: &str| {
            let key = format!("{list}.name");
            let found = values.iter().find(|(path, ..)| *path == key);
            found.and_then(|(.., name)| name.as_str())
        };
        let named = |path: &String| {
            let (list, rest) = path.split_once(']')?;
            let name = name_of(&format!("{list}]"))?;
            Some(format!("{}[{name}]{rest}", list.split_once('[')?.0))
        };
        let all = values.iter();
        all.map(|(path, _, value)| (named(path).unwrap_or_else(|| path.clone()), value.clone()))
            .collect()
    }

    /// The keys that this case has, in the order of a file, with their paths and values; those of lists of tables have
    /// indices in their paths.
    pub fn values(&self) -> Vec<(String, &'static Key, Value)> {
        let root =
            Value::try_from(self).expect("a case holds nothing but numbers, words and lists");
        let value = |place: &str| {
            let mut names = place.split(['.', '[']);
            let value = names.try_fold(&root, |value, name| match name.strip_suffix(']') {
                Some(index) => value.get(index.parse::<usize>().ok()?),
                None => value.get(name),
            });
            value.cloned()
        };
        let keys = Case::schema().keys();
        let mut values = Vec::new();
        // Keys of a table stand together.
        for keys in keys.chunk_by(|a, b| a.table() == b.table()) {
            let table = keys[0].table();
            let list = table.split_once("[]").map(|(list, _)| list);
            let items = list.map_or(1, |list| {
                let place = Case::schema().place(list);
                let items = value(&place);
                items
                    .and_then(|items| Some(items.as_array()?.len()))
                    .unwrap_or(0)
            });
            for item in 0..items {
                let all = keys.iter().filter_map(|key| {
                    let path = key.path.replace("[]", &format!("[{item}]"));
                    let value = value(&key.place(&path))?;
                    Some((path, key, value))
                });
                values.extend(all);
            }
        }
        values
    }

    /// TOML text with every value of this case and the program's version at the top; it stands on no other file, and
    /// reading it gives the same case whatever the preset.
    pub fn to_toml_string(&self) -> String {
        write(self, |_| None)
    }
}

impl ResolvedCase {
    /// As [`Case::to_toml_string`], with the place that each value came from.
    pub fn to_toml_string(&self) -> String {
        write(&self.case, |key| {
            self.origins.get(key).map(ToString::to_string)
        })
    }
}

fn write(case: &Case, origin: impl Fn(&str) -> Option<String>) -> String {
    let mut text = format!(
        "# Every value of a run of fsi-driver {}. The names carry the units.\n",
        env!("CARGO_PKG_VERSION")
    );
    let mut section = String::new();
    for (path, key, value) in case.values() {
        // What is built in is so on another machine, too.
        let built_in = value
            .as_str()
            .filter(|_| matches!(key.kind, ValueKind::PathOr(_)));
        let built_in = built_in.and_then(|path| templates::word(Path::new(path)));
        let value = built_in.map_or(value.clone(), Value::from);
        if section != schema::parent(&path) {
            schema::parent(&path).clone_into(&mut section);
            let _ = match section.split_once('[') {
                Some((list, _)) => write!(text, "\n[[{list}]]\n"),
                None => write!(text, "\n[{section}]\n"),
            };
        }
        let origin = origin(&path).map_or(String::new(), |place| format!("; {place}"));
        let _ = writeln!(text, "{} = {value} # {}{origin}", key.name(), key.about);
    }
    text
}
