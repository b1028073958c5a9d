//! Finds OpenFOAM and the adapter's library, and sees to it that they belong together.

use crate::processes::on_path;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The command that mends every error of this module.
const REMEDY: &str = "run of-adapter/setup.sh";
/// What needs no OpenFOAM.
const INSTEAD: &str = "or compute vessels with --fluid native, which needs none";
/// The environment variable that names the adapter's library, or the folder or prefix that it is installed in.
const VARIABLE: &str = "FSI_DRIVER_ADAPTER";
/// Where `setup.sh --prefix` puts the library, below the prefix.
const BELOW_PREFIX: &str = "lib/fsi-driver";
const LIBRARY: &str = "libfsiAdapter.so";

/// What Debian's OpenFOAM needs to know of itself at run time.
pub const PROJECT_FOLDER: &str = "/usr/share/openfoam";

/// Why the fluid cannot be started at all.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InstallError {
    /// A program is missing.
    #[error("OpenFOAM's `{0}` is not installed here: {REMEDY}, {INSTEAD}")]
    Program(String),
    /// The library is missing.
    #[error("the OpenFOAM adapter is not built: {REMEDY}, {INSTEAD} (looked for {LIBRARY} in {})", list(.0))]
    Library(Vec<PathBuf>),
    /// The library named by the environment is missing.
    #[error("{VARIABLE} names {}, where there is no {LIBRARY}: unset it or {REMEDY}", .0.display())]
    NamedLibrary(PathBuf),
    /// OpenFOAM cannot work there.
    #[error(
        "{}: OpenFOAM takes no path with quotes, tabs or line breaks: choose another folder", .0.display()
    )]
    Path(PathBuf),
    /// The library was built for another OpenFOAM.
    #[error(
        "the OpenFOAM adapter was built for version {built}, installed is {installed}: {REMEDY}"
    )]
    Version {
        /// Version of the package that it was built for.
        built: String,
        /// Version of the package that is here.
        installed: String,
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
    if let Some(missing) = programs.iter().find(|program| !on_path(program)) {
        return Err(InstallError::Program((*missing).to_owned()));
    }
    let library = find_library()?;
    check_path(&library)?;
    check_version(&library)?;
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
    let file = Path::new(PROJECT_FOLDER).join("etc/controlDict");
    let switches = std::fs::read_to_string(file).ok()?;
    Some(format!(
        "{switches}\nInfoSwitches {{ allowSpaceInFileName 1; }}\n"
    ))
}

/// What `FSI_DRIVER_ADAPTER` names; or else the first of these: `of-adapter/build/` next to the program or one of the
/// folders above it (a build in the source tree), `lib/fsi-driver/` below the prefix of the program, `~/.local` or
/// `/usr/local` (`setup.sh --prefix`), `of-adapter/build/` next to the sources it was compiled from, or in the working
/// directory.
fn find_library() -> Result<PathBuf, InstallError> {
    if let Some(named) = std::env::var_os(VARIABLE).filter(|name| !name.is_empty()) {
        let path = PathBuf::from(named);
        let below = [
            PathBuf::new(),
            LIBRARY.into(),
            Path::new(BELOW_PREFIX).join(LIBRARY),
        ];
        let mut files = below
            .iter()
            .map(|below| match below.as_os_str().is_empty() {
                true => path.clone(),
                false => path.join(below),
            });
        let found = files.find(|file| file.is_file());
        return found
            .and_then(|file| file.canonicalize().ok())
            .ok_or(InstallError::NamedLibrary(path));
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
    let mut files = places.iter().map(|place| place.join(LIBRARY));
    match files.find(|path| path.is_file()) {
        Some(path) => Ok(path),
        None => Err(InstallError::Library(
            places.split_off(places.len().saturating_sub(5)),
        )),
    }
}

/// The version of the installed package of OpenFOAM.
pub fn version() -> Option<String> {
    let query = Command::new("dpkg-query")
        .args(["-W", "-f", "${Version}", "openfoam"])
        .output();
    let output = query.ok().filter(|output| output.status.success())?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Compares the stamp that setup.sh left next to the library with the installed package.
fn check_version(library: &Path) -> Result<(), InstallError> {
    let Ok(stamp) = std::fs::read_to_string(library.with_file_name("stamp")) else {
        return Ok(()); // a user-supplied library; it compares versions itself when it is loaded
    };
    let built = stamp
        .lines()
        .find_map(|line| line.strip_prefix("openfoam "))
        .unwrap_or("unknown")
        .to_owned();
    let installed = version().unwrap_or_else(|| "not known to dpkg".to_owned());
    if built == installed {
        Ok(())
    } else {
        Err(InstallError::Version { built, installed })
    }
}
