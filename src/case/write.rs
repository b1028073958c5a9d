//! The case as a file again: every value used, loadable by itself.

use super::schema::{self, Key};
use super::{Case, ResolvedCase};
use std::fmt::Write as _;
use toml::Value;

impl Case {
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
    let values = Value::try_from(case).expect("a case holds nothing but numbers, words and lists");
    let mut text = format!(
        "# Every value of a run of fsi-driver {}. Units stand in the names.\n",
        env!("CARGO_PKG_VERSION")
    );
    let mut section = String::new();
    let mut line = |path: &str, key: &Key| {
        let (table, name) = path.rsplit_once('.').expect("every key stands in a table");
        let Some(value) = path
            .split('.')
            .try_fold(&values, |value, name| value.get(name))
        else {
            return;
        };
        if section != table {
            let _ = write!(text, "\n[{table}]\n");
            section = table.to_owned();
        }
        let origin = origin(path).map_or(String::new(), |place| format!("; {place}"));
        let _ = writeln!(text, "{name} = {value} # {}{origin}", key.about);
    };
    for (i, key) in schema::KEYS.iter().enumerate() {
        line(key.path, key);
        // Materials follow the other keys of their table.
        let root = schema::root(key.path);
        let next = schema::KEYS.get(i + 1);
        if next.is_none_or(|next| schema::root(next.path) != root) {
            let tables = schema::MATERIAL_TABLES.iter();
            for table in tables.filter(|table| schema::root(table) == root) {
                let parameters = schema::MATERIALS.iter().flat_map(|(_, keys)| *keys);
                let mut seen = Vec::new();
                for key in [&schema::MATERIAL].into_iter().chain(parameters) {
                    if !seen.contains(&key.path) {
                        seen.push(key.path);
                        line(&format!("{table}.{}", key.path), key);
                    }
                }
            }
        }
    }
    text
}
