//! The OpenFOAM dictionaries that are built into the program, so that a case needs no other files.
//!
//! OpenFOAM, and users who look at a case, reads files: they are unpacked into the user's cache, in a folder that is
//! named by their content and so belongs to no program version.

use super::FluidSettings;
use std::io;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// The sets by their words, with their meanings.
pub(super) const WORDS: &[(&str, &str)] = &[
    (
        "built-in/vessel",
        "A flow at the inlet, a windkessel at the outlet.",
    ),
    (
        "built-in/channel",
        "A parabolic inflow into the channel around a flag.",
    ),
];

macro_rules! files {
    ($folder:literal: $($file:literal)+) => {
        &[$(($file, include_str!(concat!("openfoam-case/", $folder, "/", $file)))),+]
    };
}

type TemplateFiles = &'static [(&'static str, &'static str)];

const VESSEL: TemplateFiles = files!("base":
    "0/U" "0/p" "0/pointDisplacement"
    "constant/dynamicMeshDict" "constant/transportProperties" "constant/turbulenceProperties"
    "system/controlDict" "system/decomposeParDict" "system/fvSchemes" "system/fvSolution");

const CHANNEL: TemplateFiles = files!("turek-hron/fluid":
    "0/U" "0/p" "0/pointDisplacement"
    "constant/dynamicMeshDict" "constant/transportProperties" "constant/turbulenceProperties"
    "system/baseControlDict" "system/controlDict" "system/decomposeParDict" "system/fvSchemes" "system/fvSolution");

fn files(word: &str) -> Option<TemplateFiles> {
    let sets = [VESSEL, CHANNEL];
    let mut all = WORDS.iter().zip(sets);
    all.find(|((known, _), _)| *known == word)
        .map(|(_, files)| files)
}

/// Whether the dictionaries in a folder prescribe at the boundaries what those that are built in do.
fn has_built_in_conditions(folder: &Path) -> bool {
    let is_there = |(name, text): &(&str, &str)| {
        !name.starts_with("0/") || fs::read_to_string(folder.join(name)).is_ok_and(|it| it == *text)
    };
    [VESSEL, CHANNEL]
        .iter()
        .any(|files| files.iter().all(is_there))
}

impl FluidSettings {
    /// Whether OpenFOAM's boundary conditions are those of the case: user-supplied templates may prescribe others.
    pub fn has_conditions_of_the_case(&self) -> bool {
        has_built_in_conditions(&self.templates)
    }
}

/// The folder with the dictionaries that `word` stands for.
///
/// # Errors
/// If they can be written neither into the user's cache nor into the folder for temporary files.
pub(super) fn folder(word: &str) -> io::Result<PathBuf> {
    let files = files(word).ok_or(io::ErrorKind::NotFound)?;
    let name = name(word, files);
    let mut refused = None;
    for parent in parents() {
        match unpack(files, &parent, &name) {
            Ok(folder) => return Ok(folder),
            Err(error) => refused = Some(error),
        }
    }
    Err(refused.unwrap_or_else(|| io::ErrorKind::NotFound.into()))
}

/// The word for a folder that [`folder`] has made.
pub(super) fn word(folder: &Path) -> Option<&'static str> {
    let words = WORDS.iter().map(|(word, _)| *word);
    let mut known = words.filter_map(|word| Some((word, name(word, files(word)?))));
    let found = known.find(|(_, name)| {
        let mut parents = parents().into_iter();
        parents.any(|parent| folder == parent.join(name))
    });
    found.map(|(word, _)| word)
}

fn name(word: &str, files: TemplateFiles) -> String {
    let mut hasher = crc32fast::Hasher::new();
    for (name, text) in files {
        hasher.update(name.as_bytes());
        hasher.update(text.as_bytes());
    }
    let kind = word.rsplit('/').next().unwrap_or(word);
    format!("{kind}-{:08x}", hasher.finalize())
}

/// Folders that may hold the unpacked files, the best first.
fn parents() -> Vec<PathBuf> {
    let named = |name: &str| {
        let folder = PathBuf::from(env::var_os(name)?);
        folder.is_absolute().then_some(folder)
    };
    let cache = named("XDG_CACHE_HOME").or(named("HOME").map(|home| home.join(".cache")));
    let user = rustix::process::getuid().as_raw();
    let temporary = env::temp_dir().join(format!("fsi-driver-{user}"));
    let cache = cache.map(|cache| cache.join("fsi-driver"));
    cache.into_iter().chain([temporary]).collect()
}

/// Writes the files as a whole, unless they are there.
fn unpack(files: TemplateFiles, parent: &Path, name: &str) -> io::Result<PathBuf> {
    let folder = parent.join(name);
    if is_whole(files, &folder) {
        return Ok(folder);
    }
    fs::create_dir_all(parent)?;
    let partial = tempfile::tempdir_in(parent)?;
    let inner = partial.path().join(name);
    for (file, text) in files {
        let file = inner.join(file);
        fs::create_dir_all(file.parent().unwrap_or(&inner))?;
        fs::write(file, text)?;
    }
    // What was changed by hand makes room; another process may have been faster.
    if folder.exists() && !is_whole(files, &folder) {
        fs::rename(&folder, partial.path().join("changed"))?;
    }
    match fs::rename(&inner, &folder) {
        Err(_) if is_whole(files, &folder) => Ok(folder),
        Err(error) => Err(error),
        Ok(()) => Ok(folder),
    }
}

/// Whether the folder holds these files and no others.
fn is_whole(files: TemplateFiles, folder: &Path) -> bool {
    let same = |(file, text): &(&str, &str)| {
        fs::read_to_string(folder.join(file)).is_ok_and(|found| found == *text)
    };
    files.iter().all(same) && count(folder) == Some(files.len())
}

fn count(folder: &Path) -> Option<usize> {
    let mut files = 0;
    for entry in fs::read_dir(folder).ok()? {
        let path = entry.ok()?.path();
        files += if path.is_dir() { count(&path)? } else { 1 };
    }
    Some(files)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file that is added to the templates is built in as well.
    #[test]
    fn built_in_templates_are_those_of_the_project() {
        let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case");
        for (files, folder) in [(VESSEL, "base"), (CHANNEL, "turek-hron/fluid")] {
            assert!(is_whole(files, &project.join(folder)), "{folder}");
        }
    }

    #[test]
    fn changed_files_are_written_again() {
        let parent = tempfile::tempdir().unwrap();
        let folder = unpack(VESSEL, parent.path(), "vessel-1").unwrap();
        assert!(is_whole(VESSEL, &folder));
        for change in ["0/U", "system/more"] {
            fs::write(folder.join(change), "changed").unwrap();
            assert!(!is_whole(VESSEL, &folder));
            assert_eq!(unpack(VESSEL, parent.path(), "vessel-1").unwrap(), folder);
            assert!(is_whole(VESSEL, &folder));
        }
        // Nothing is left next to them.
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 1);
    }
}
