//! By what a case is recognized: all its values, and the content of the files that it names.

use super::{Case, Problem, WallMode};
use crate::files::{FileFingerprint, below, named};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Keys (or tables) that may change when a run is resumed: they have no influence on the steps that were done, or,
/// like the files, are compared by their content.
const MAY_CHANGE: &[&str] = &[
    "time.end_s",
    "time.until_periodic",
    "time.max_halvings",
    "output.title",
    "output.structure_interval_s",
    "output.fluid_interval_s",
    "output.checkpoint_interval_min",
    "output.window_start_s",
    "output.window_end_s",
    "output.measure",
    "fluid.answer_limit_s",
    "fluid.transport",
    "fluid.templates",
    "fluid.case",
    "wall.file.mesh",
    "wall.extrude.factors",
    "wall.motion.displacements",
    "wall.motion.factors",
    "inflow.file",
    "inlet.file",
    "outlet.file",
    "coupling.max_iterations",
    "structure.newton_max_iterations",
    "uncertain",
    "correlation",
];

/// A case as it was at some time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CaseIdentity {
    /// Every value, as TOML.
    pub values: String,
    /// The files that it names: templates of OpenFOAM's dictionaries, the curves of flow and pressure.
    pub files: Vec<FileFingerprint>,
}

impl CaseIdentity {
    /// Of a case as it is now.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn of(case: &Case) -> io::Result<Self> {
        Ok(Self {
            values: case.to_toml_string(),
            files: files(case)?,
        })
    }

    /// What of the case `now` is not as it was, except what may change when a run is resumed; a line each.
    pub fn changes(&self, now: &Self) -> Vec<String> {
        let mut changed = changed_keys(&self.values, &now.values, MAY_CHANGE);
        let paths = |files: &[FileFingerprint]| -> BTreeSet<String> {
            files.iter().map(|file| file.path.clone()).collect()
        };
        for path in paths(&self.files).union(&paths(&now.files)) {
            let find =
                |files: &[FileFingerprint]| files.iter().find(|file| file.path == *path).cloned();
            if find(&self.files) != find(&now.files) {
                changed.push(format!("the content of {path}"));
            }
        }
        changed
    }
}

/// Keys with different values, with both, except for those (or whole tables) that may change.
pub fn changed_keys(before: &str, now: &str, may_change: &[&str]) -> Vec<String> {
    let read = |text: &str| toml::from_str::<toml::Table>(text).unwrap_or_default();
    let mut changed = Vec::new();
    compare_tables(&read(before), &read(now), "", may_change, &mut changed);
    changed
}

fn compare_tables(
    before: &toml::Table,
    now: &toml::Table,
    above: &str,
    may_change: &[&str],
    changed: &mut Vec<String>,
) {
    let names: BTreeSet<&String> = before.keys().chain(now.keys()).collect();
    for name in names {
        let key = format!("{above}{name}");
        if may_change.contains(&key.as_str()) {
            continue;
        }
        match (before.get(name), now.get(name)) {
            (Some(toml::Value::Table(before)), Some(toml::Value::Table(now))) => {
                compare_tables(before, now, &format!("{key}."), may_change, changed);
            }
            (before, now) if before != now => {
                let shown = |value: Option<&toml::Value>| {
                    value.map_or("absent".into(), ToString::to_string)
                };
                changed.push(format!(
                    "{key}: {} in the run, {} now",
                    shown(before),
                    shown(now)
                ));
            }
            _ => {}
        }
    }
}

/// The files that a case names.
fn files(case: &Case) -> io::Result<Vec<FileFingerprint>> {
    let mut found = Vec::new();
    let mut single: Vec<(String, PathBuf)> = Vec::new();
    match &case.problem {
        Problem::UserCase(own) => {
            // What else lies there are results, perhaps those of this run.
            for part in ["0", "0.orig", "constant", "system"] {
                let folder = own.fluid.case.as_ref().map(|case| case.join(part));
                if let Some(folder) = folder.filter(|folder| folder.is_dir()) {
                    add_folder(&folder, &format!("fluid.case/{part}"), &mut found)?;
                }
            }
            if let Some(tree) = own.meshed_tree() {
                add_folder(&case.fluid.templates, "fluid.templates", &mut found)?;
                for (i, keys) in tree.opening.iter().flatten().enumerate() {
                    let file = keys.condition.file();
                    let named = |(name, path): (&str, &PathBuf)| {
                        (format!("tree.opening[{i}].{name}"), path.clone())
                    };
                    single.extend(file.map(named));
                }
            }
            let mesh = own.wall.file.as_ref().map(|file| &file.mesh);
            single.extend(mesh.map(|file| ("wall.file.mesh".into(), file.clone())));
            let factors = own.wall.extrude.as_ref().and_then(|e| e.factors.as_ref());
            single.extend(factors.map(|file| ("wall.extrude.factors".into(), file.clone())));
            for motion in own
                .wall
                .motion
                .iter()
                .filter(|_| own.wall.mode() == WallMode::Prescribed)
            {
                single.push((
                    "wall.motion.displacements".into(),
                    motion.displacements.clone(),
                ));
                single.push(("wall.motion.factors".into(), motion.factors.clone()));
            }
        }
        Problem::Vessel(_) | Problem::Flag(_) => {
            add_folder(&case.fluid.templates, "fluid.templates", &mut found)?;
        }
    }
    if let Problem::Vessel(vessel) = &case.problem {
        for opening in vessel.opening_keys() {
            if let Some((name, path)) = opening.condition.file() {
                single.push((vessel.opening_key(opening.end, name), path.clone()));
            }
        }
    }
    for (key, path) in single {
        let mut file = FileFingerprint::of(Path::new(""), &path, None)?;
        file.path = key;
        found.push(file);
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(found)
}

/// The files in a folder, with what the folder is `called`.
fn add_folder(root: &Path, called: &str, found: &mut Vec<FileFingerprint>) -> io::Result<()> {
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).map_err(named(&folder))? {
            let path = entry.map_err(named(&folder))?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let mut file = FileFingerprint::of(root, below(root, &path), None)?;
                file.path = format!("{called}/{}", file.path);
                found.push(file);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{MAY_CHANGE, changed_keys};

    /// Keys that may change when a run is resumed are not named.
    #[test]
    fn changed_keys_are_named_with_both_values() {
        let before = "[time]\nstep_s = 0.002\nend_s = 1.0\n[output]\nfluid_interval_s = 1\n[wall.media]\nk2 = 3.5\n";
        let now = "[time]\nstep_s = 0.001\nend_s = 2.0\n[output]\nfluid_interval_s = 2\n[wall.media]\nk1 = 2.0\n";
        assert_eq!(
            changed_keys(before, now, MAY_CHANGE),
            [
                "time.step_s: 0.002 in the run, 0.001 now",
                "wall.media.k1: absent in the run, 2.0 now",
                "wall.media.k2: 3.5 in the run, absent now",
            ]
        );
        assert_eq!(changed_keys(before, before, &[]), Vec::<String>::new());
    }
}
