//! The case as a file again: every value used, loadable by itself.

use super::schema::{Key, Kind};
use super::{Case, ResolvedCase, templates};
use std::fmt::Write as _;
use std::path::Path;
use toml::Value;

impl Case {
    /// The keys that this case has, in the order of a file, with their values.
    pub fn values(&self) -> Vec<(&'static Key, Value)> {
        let root =
            Value::try_from(self).expect("a case holds nothing but numbers, words and lists");
        let value = |key: &Key| {
            let place = key.place(&key.path);
            let mut names = place.split('.');
            let value = names.try_fold(&root, |value, name| value.get(name));
            value.cloned()
        };
        let keys = Case::schema().keys().iter();
        keys.filter_map(|key| Some((key, value(key)?))).collect()
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
        "# Every value of a run of fsi-driver {}. Units stand in the names.\n",
        env!("CARGO_PKG_VERSION")
    );
    let mut section = "";
    for (key, value) in case.values() {
        // What is built in is so on another machine, too.
        let built_in = value
            .as_str()
            .filter(|_| matches!(key.kind, Kind::PathOr(_)));
        let built_in = built_in.and_then(|path| templates::word(Path::new(path)));
        let value = built_in.map_or(value.clone(), Value::from);
        if section != key.table() {
            section = key.table();
            let _ = write!(text, "\n[{section}]\n");
        }
        let origin = origin(&key.path).map_or(String::new(), |place| format!("; {place}"));
        let _ = writeln!(text, "{} = {value} # {}{origin}", key.name(), key.about);
    }
    text
}
