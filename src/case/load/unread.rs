//! What a user has written and the case does not read has no effect, and is reported.

use super::ResolvedCase;
use crate::Case;
use crate::conditions;
use crate::error::ValuePlace;
use crate::schema::is_within;
use std::collections::BTreeMap;
use std::path::Path;

/// Keys that the user has written and the case does not read, for one reason.
#[derive(Debug, Clone, PartialEq)]
pub struct Unread {
    /// The keys, with where each stands.
    pub keys: Vec<(String, ValuePlace)>,
    /// When they would be read: for "is read only …".
    pub when: &'static str,
}

impl std::fmt::Display for Unread {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let keys: Vec<String> = (self.keys.iter())
            .map(|(key, place)| format!("`{key}` ({place})"))
            .collect();
        let verb = if keys.len() == 1 {
            "does nothing here: it is"
        } else {
            "do nothing here: they are"
        };
        write!(f, "{} {verb} read only {}", keys.join(", "), self.when)
    }
}

impl ResolvedCase {
    /// What stands in the case's own `file` (not in one that it stands on) or on the command line, and is not read.
    pub(super) fn find_unread(&mut self, file: &Path, extends: bool) {
        let mut found: BTreeMap<&'static str, Unread> = BTreeMap::new();
        for (path, place) in &self.origins {
            let is_own = match place {
                // A file that stands on no other has to have all keys.
                ValuePlace::File(origin, _) => extends && origin == file,
                ValuePlace::Set | ValuePlace::Sweep | ValuePlace::Option(_) => true,
                _ => false,
            };
            let Some(key) = Case::schema().find(path).filter(|_| is_own) else {
                continue;
            };
            if let Some(only) = key.only.iter().find(|only| !(only.holds)(&self.case, path)) {
                let unread = found.entry(only.when).or_insert(Unread {
                    keys: Vec::new(),
                    when: only.when,
                });
                unread.keys.push((path.clone(), place.clone()));
            }
        }
        self.unread = found.into_values().collect();
        self.pardon_other_solver(file);
    }

    /// A file with keys of several solvers is written for each of them, and one whose solver was chosen on the command
    /// line as well.
    fn pardon_other_solver(&mut self, file: &Path) {
        let of_file =
            |place: &ValuePlace| matches!(place, ValuePlace::File(origin, _) if origin == file);
        let has = |table: &str| {
            let mut origins = self.origins.iter();
            origins.any(|(path, place)| is_within(path, table) && of_file(place))
        };
        let both = has("fluid.mesh") && has("fluid.native");
        let chosen = self
            .origins
            .get("fluid.solver")
            .is_some_and(|place| !of_file(place));
        if both || chosen {
            let of_solver = [
                conditions::OPENFOAM,
                conditions::NATIVE,
                conditions::NATIVE_ELEMENTS,
                conditions::NOT_NATIVE,
                conditions::TEMPLATES,
                conditions::COUPLED_MESH,
            ];
            for unread in self
                .unread
                .iter_mut()
                .filter(|unread| of_solver.iter().any(|only| only.when == unread.when))
            {
                unread.keys.retain(|(_, place)| !of_file(place));
            }
            self.unread.retain(|unread| !unread.keys.is_empty());
        }
    }
}
