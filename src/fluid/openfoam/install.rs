//! Finds OpenFOAM and the adapter's library, and sees to it that they belong together.
//!
//! Which OpenFOAM: the one that `FSI_DRIVER_OPENFOAM` names; or the one that is loaded (`WM_PROJECT_DIR`); or of those
//! in `/usr/lib/openfoam` (the newest first) and Debian's the first that has an adapter. `of-adapter/setup.sh` chooses
//! in the same order.

use crate::processes::on_path;
use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// What needs no OpenFOAM.
const INSTEAD: &str = "or compute vessels with --fluid native, which needs none";
/// The environment variable that names the adapter's library, or the folder or prefix that it is installed in.
const VARIABLE: &str = "FSI_DRIVER_ADAPTER";
/// The environment variable that names the folder of an OpenFOAM, or one with several `openfoamNNNN`.
const OPENFOAM: &str = "FSI_DRIVER_OPENFOAM";
/// What OpenFOAM's own `etc/bashrc` sets.
const LOADED: &str = "WM_PROJECT_DIR";
/// Where packages of openfoam.com install.
const INSTALLED: &str = "/usr/lib/openfoam";
/// Where Debian's package does.
const DEBIAN: &str = "/usr/share/openfoam";
/// Where `setup.sh --prefix` puts the library, below the prefix, in a folder for each version.
const BELOW_PREFIX: &str = "lib/fsi-driver";
const LIBRARY: &str = "libfsiAdapter.so";
/// What `setup.sh` puts next to it for an OpenFOAM that needs it preloaded.
const MENDING: &str = "libfsiStream.so";

/// An OpenFOAM of this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Installation {
    /// Its folder, `WM_PROJECT_DIR`.
    pub folder: PathBuf,
    /// Its number, such as 2506.
    pub api: u32,
    /// Which build of it, as `setup.sh` says it.
    pub version: String,
    /// How it was found.
    pub origin: &'static str,
}

impl Installation {
    fn of_debian() -> Option<Self> {
        let query = Command::new("dpkg-query")
            .args(["-W", "-f", "${Version}", "openfoam"])
            .output();
        let output = query.ok().filter(|output| output.status.success())?;
        let version = String::from_utf8_lossy(&output.stdout).into_owned();
        Some(Self {
            folder: DEBIAN.into(),
            api: version.split('.').next()?.parse().ok()?,
            version,
            origin: "Debian's",
        })
    }

    fn in_folder(folder: &Path, origin: &'static str) -> Option<Self> {
        if folder == Path::new(DEBIAN) {
            return Self::of_debian();
        }
        let text = std::fs::read_to_string(folder.join("META-INFO/api-info")).ok()?;
        let value = |key: &str| {
            text.lines()
                .find_map(|line| line.strip_prefix(key))
                .map(str::trim)
        };
        let api = value("api=")?.parse().ok()?;
        let patch = value("patch=").unwrap_or_default();
        Some(Self {
            folder: folder.to_owned(),
            api,
            version: format!("{api}.{patch} in {}", folder.display()),
            origin,
        })
    }

    /// What its programs need in their environment.
    pub fn environment(&self) -> Vec<(OsString, OsString)> {
        let mut variables = self.own_environment();
        let library = find_library(self).ok();
        if let Some(mending) = library.map(|file| file.with_file_name(MENDING))
            && mending.is_file()
        {
            // By its name: a path in LD_PRELOAD must not have a blank.
            let folder = mending.parent().unwrap_or(Path::new("")).to_owned();
            let before = |name: &str| {
                let own = variables.iter().rev().find(|(own, _)| own == name);
                own.map(|(_, value)| value.clone())
                    .or(std::env::var_os(name))
            };
            let with = |first: OsString, name: &str| {
                let more = before(name).filter(|value| !value.is_empty());
                more.map_or(first.clone(), |more| [first, more].join(OsStr::new(":")))
            };
            let both = [
                ("LD_PRELOAD", with(MENDING.into(), "LD_PRELOAD")),
                (
                    "LD_LIBRARY_PATH",
                    with(folder.into_os_string(), "LD_LIBRARY_PATH"),
                ),
            ];
            variables.extend(both.map(|(name, value)| (name.into(), value)));
        }
        variables
    }

    /// An OpenFOAM that is not loaded says by its `etc/bashrc` what it sets.
    fn own_environment(&self) -> Vec<(OsString, OsString)> {
        let own = (LOADED.into(), self.folder.clone().into_os_string());
        let loaded = std::env::var_os(LOADED).is_some_and(|folder| folder == self.folder);
        if self.folder == Path::new(DEBIAN) {
            return vec![own];
        }
        if loaded {
            // Named, since ranks on other nodes get no other variables.
            let passed = ["PATH", "LD_LIBRARY_PATH"].into_iter();
            let passed = passed.filter_map(|name| Some((name.into(), std::env::var_os(name)?)));
            return [own].into_iter().chain(passed).collect();
        }
        let said = Command::new("bash")
            .args(["-c", ". \"$0/etc/bashrc\" >/dev/null 2>&1; env -0"])
            .arg(&self.folder)
            .output();
        let said = said.map(|output| output.stdout).unwrap_or_default();
        let variables = said.split(|byte| *byte == 0).filter_map(|entry| {
            let equals = entry.iter().position(|byte| *byte == b'=')?;
            let name = OsString::from_vec(entry[..equals].to_vec());
            let value = OsString::from_vec(entry[equals + 1..].to_vec());
            let shells = ["_", "SHLVL", "PWD", "OLDPWD"]
                .iter()
                .any(|shell| name == *shell);
            (!shells && std::env::var_os(&name).as_ref() != Some(&value)).then_some((name, value))
        });
        [own].into_iter().chain(variables).collect()
    }

    /// The command that builds the adapter for it.
    fn remedy(&self) -> String {
        match self.folder == Path::new(DEBIAN) {
            true => "run of-adapter/setup.sh".into(),
            false => format!(
                "run of-adapter/setup.sh --openfoam {}",
                self.folder.display()
            ),
        }
    }
}

/// All that a run could use, in the order of preference.
///
/// # Errors
/// If what is named or loaded is no OpenFOAM that the adapter is for.
pub fn installations() -> Result<Vec<Installation>, InstallError> {
    let variable = |name| std::env::var_os(name).filter(|value| !value.is_empty());
    let mut below = PathBuf::from(INSTALLED);
    for (name, origin) in [(OPENFOAM, "named"), (LOADED, "loaded")] {
        let Some(folder) = variable(name).map(PathBuf::from) else {
            continue;
        };
        if name == OPENFOAM && !installed_below(&folder).is_empty() {
            below = folder;
            break;
        }
        let found = Installation::in_folder(&folder, origin);
        let variable = name;
        return (found.map(|one| vec![one])).ok_or(InstallError::Foreign { variable, folder });
    }
    Ok(installed_below(&below)
        .into_iter()
        .chain(Installation::of_debian())
        .collect())
}

/// Those in the folders `openfoamNNNN` of one, the newest first.
fn installed_below(folder: &Path) -> Vec<Installation> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<Installation> = entries
        .filter(|entry| entry.file_name().to_string_lossy().starts_with("openfoam"))
        .filter_map(|entry| Installation::in_folder(&entry.path(), "installed"))
        .collect();
    found.sort_by_key(|installation| std::cmp::Reverse(installation.api));
    found
}

/// The one that runs of this process use.
///
/// # Errors
/// If there is none.
pub fn chosen() -> Result<&'static Installation, InstallError> {
    static CHOSEN: OnceLock<Result<Installation, InstallError>> = OnceLock::new();
    let choose = || {
        let all = installations()?;
        let ready = all.iter().find(|one| find_library(one).is_ok());
        let one = ready.or(all.first()).cloned();
        one.ok_or_else(|| InstallError::Program("pimpleFoam".into()))
    };
    CHOSEN.get_or_init(choose).as_ref().map_err(Clone::clone)
}

/// Why the fluid cannot be started at all.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InstallError {
    /// A program is missing.
    #[error("OpenFOAM's `{0}` is not installed here: run of-adapter/setup.sh, {INSTEAD}")]
    Program(String),
    /// What an environment variable names is no OpenFOAM, or another one.
    #[error(
        "{variable} names {}, which is no OpenFOAM of openfoam.com, 1912 or newer, which the adapter is for (that of \
         openfoam.org is another program): unset it, load another, {INSTEAD}", .folder.display()
    )]
    Foreign {
        /// The variable.
        variable: &'static str,
        /// The folder.
        folder: PathBuf,
    },
    /// The library is missing.
    #[error(
        "the OpenFOAM adapter is not built for {}: {}, {INSTEAD} (looked for {LIBRARY} in {})",
        .0.version, .0.remedy(), list(.1)
    )]
    Library(Box<Installation>, Vec<PathBuf>),
    /// The library named by the environment is missing.
    #[error(
        "{VARIABLE} names {}, where there is no {LIBRARY} for OpenFOAM {}: unset it or {}",
        .0.display(), .1.api, .1.remedy()
    )]
    NamedLibrary(PathBuf, Box<Installation>),
    /// OpenFOAM cannot work there.
    #[error(
        "{}: OpenFOAM takes no path with quotes, tabs or line breaks: choose another folder", .0.display()
    )]
    Path(PathBuf),
    /// The library was built for another OpenFOAM.
    #[error("the OpenFOAM adapter was built for {built}, but {} would run: {}", .running.version, .running.remedy())]
    Version {
        /// What it was built for.
        built: String,
        /// What is here.
        running: Box<Installation>,
    },
}

fn list(paths: &[PathBuf]) -> String {
    paths
        .iter()
        .map(|path| path.display().to_string())
        .collect::<Vec<_>>()
        .join(", ")
}

/// Checks that the programs for so many MPI ranks are on the path and returns the adapter's library.
pub fn check(ranks: usize) -> Result<PathBuf, InstallError> {
    let programs: &[&str] = if ranks > 1 {
        &["pimpleFoam", "decomposePar", "mpirun"]
    } else {
        &["pimpleFoam"]
    };
    let openfoam = chosen()?;
    let environment = openfoam.environment();
    let path = environment.iter().find(|(name, _)| name == "PATH");
    let there = |program: &str| match path {
        Some((_, folders)) => {
            std::env::split_paths(folders).any(|folder| folder.join(program).is_file())
        }
        None => on_path(program),
    };
    if let Some(missing) = programs.iter().find(|program| !there(program)) {
        return Err(InstallError::Program((*missing).to_owned()));
    }
    let library = find_library(openfoam)?;
    check_path(&library)?;
    check_version(&library, openfoam)?;
    Ok(library)
}

/// Checks that OpenFOAM accepts the name of a file or folder, which need not exist yet.
pub fn check_path(path: &Path) -> Result<(), InstallError> {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    // What OpenFOAM sees is the folder behind all links.
    let existing = path
        .ancestors()
        .find_map(|folder| folder.canonicalize().ok());
    let refused = |c: u8| matches!(c, b'"' | b'\'' | b'\t' | b'\n' | b'\r' | 0x0b | 0x0c);
    let both = [Some(&path), existing.as_ref()];
    match (both.into_iter().flatten()).find(|path| {
        path.as_os_str()
            .as_encoded_bytes()
            .iter()
            .any(|c| refused(*c))
    }) {
        Some(path) => Err(InstallError::Path(path.clone())),
        None => Ok(()),
    }
}

/// What makes OpenFOAM accept blanks in `paths`, if there are any: the content of its own `etc/controlDict`, with a
/// switch, for the environment variable `FOAM_CONTROLDICT`. (It then ignores a `controlDict` in the user's
/// `~/.OpenFOAM`.)
pub fn with_blanks(paths: &[&Path]) -> Option<String> {
    let blank = |path: &&Path| path.as_os_str().as_encoded_bytes().contains(&b' ');
    paths.iter().any(blank).then_some(())?;
    let file = chosen().ok()?.folder.join("etc/controlDict");
    let switches = std::fs::read_to_string(file).ok()?;
    Some(format!(
        "{switches}\nInfoSwitches {{ allowSpaceInFileName 1; }}\n"
    ))
}

/// What `FSI_DRIVER_ADAPTER` names; or else the first of these: `of-adapter/build/` next to the program or one of the
/// folders above it (a build in the source tree), `lib/fsi-driver/` below the prefix of the program, `~/.local` or
/// `/usr/local` (`setup.sh --prefix`), `of-adapter/build/` next to the sources it was compiled from, or in the working
/// directory; each in the folder of this OpenFOAM's number.
pub fn find_library(openfoam: &Installation) -> Result<PathBuf, InstallError> {
    let version = format!("v{}", openfoam.api);
    if let Some(named) = std::env::var_os(VARIABLE).filter(|name| !name.is_empty()) {
        let path = PathBuf::from(named);
        let of_version = Path::new(&version).join(LIBRARY);
        let mut files = [
            path.clone(),
            path.join(&of_version),
            path.join(BELOW_PREFIX).join(of_version),
            path.join(LIBRARY),
        ]
        .into_iter();
        let found = files.find(|file| file.is_file());
        return found
            .and_then(|file| file.canonicalize().ok())
            .ok_or_else(|| InstallError::NamedLibrary(path, Box::new(openfoam.clone())));
    }
    let program = std::env::current_exe().unwrap_or_default();
    let built = |folder: &Path| folder.join("of-adapter/build");
    let mut places: Vec<PathBuf> = program.ancestors().skip(1).map(built).collect();
    let prefixes = [
        program.ancestors().nth(2).map(Path::to_owned),
        std::env::var_os("HOME").map(|home| Path::new(&home).join(".local")),
        Some(PathBuf::from("/usr/local")),
    ];
    let prefixes = prefixes.into_iter().flatten();
    places.extend(prefixes.map(|prefix| prefix.join(BELOW_PREFIX)));
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).to_owned();
    for folder in [Some(sources), std::env::current_dir().ok()] {
        let place = folder.map(|folder| built(&folder));
        places.extend(place.filter(|place| !places.contains(place)));
    }
    let mut files = places
        .iter()
        .map(|place| place.join(&version).join(LIBRARY));
    match files.find(|path| path.is_file()) {
        Some(path) => Ok(path),
        None => Err(InstallError::Library(
            Box::new(openfoam.clone()),
            places.split_off(places.len().saturating_sub(5)),
        )),
    }
}

/// Compares the stamp that setup.sh left next to the library with the OpenFOAM that would run.
pub fn check_version(library: &Path, openfoam: &Installation) -> Result<(), InstallError> {
    let Ok(stamp) = std::fs::read_to_string(library.with_file_name("stamp")) else {
        return Ok(()); // a user-supplied library; it compares versions itself when it is loaded
    };
    let built = stamp
        .lines()
        .find_map(|line| line.strip_prefix("openfoam "))
        .unwrap_or("unknown")
        .to_owned();
    match built == openfoam.version {
        true => Ok(()),
        false => Err(InstallError::Version {
            built,
            running: Box::new(openfoam.clone()),
        }),
    }
}
