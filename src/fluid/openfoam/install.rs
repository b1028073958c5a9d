//! Finds OpenFOAM and the adapter's library, and sees to it that they belong together.

use std::path::{Path, PathBuf};
use std::process::Command;

/// The command that mends every error of this module.
const REMEDY: &str = "run of-adapter/setup.sh";
const LIBRARY: &str = "libfsiAdapter.so";

/// What Debian's OpenFOAM needs to know of itself at run time.
pub const PROJECT_FOLDER: &str = "/usr/share/openfoam";

/// Why the fluid cannot be started at all.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InstallError {
    /// A program is missing.
    #[error("OpenFOAM's `{0}` is not installed here: {REMEDY}")]
    Program(String),
    /// The library is missing.
    #[error("the OpenFOAM adapter is not built: {REMEDY} (looked for {LIBRARY} in {})", list(.0))]
    Library(Vec<PathBuf>),
    /// The library named by the environment is missing.
    #[error("FSI_ADAPTER_LIBRARY names {}, which is no file: unset it and {REMEDY}", .0.display())]
    NamedLibrary(PathBuf),
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
    check_version(&library)?;
    Ok(library)
}

fn on_path(program: &str) -> bool {
    std::env::var_os("PATH").is_some_and(|folders| {
        std::env::split_paths(&folders).any(|folder| folder.join(program).is_file())
    })
}

/// `FSI_ADAPTER_LIBRARY`, or `of-adapter/build/` beside the program or one of the folders above it, beside the sources
/// it was compiled from, or in the working directory.
fn find_library() -> Result<PathBuf, InstallError> {
    if let Some(named) = std::env::var_os("FSI_ADAPTER_LIBRARY").filter(|name| !name.is_empty()) {
        let path = PathBuf::from(named);
        return match path.canonicalize() {
            Ok(path) if path.is_file() => Ok(path),
            _ => Err(InstallError::NamedLibrary(path)),
        };
    }
    let program = std::env::current_exe().unwrap_or_default();
    let mut folders: Vec<PathBuf> = program.ancestors().skip(1).map(Path::to_owned).collect();
    folders.push(PathBuf::from(env!("CARGO_MANIFEST_DIR")));
    folders.extend(std::env::current_dir());
    let places: Vec<_> = folders
        .iter()
        .map(|folder| folder.join("of-adapter/build"))
        .collect();
    match places
        .iter()
        .map(|place| place.join(LIBRARY))
        .find(|path| path.is_file())
    {
        Some(path) => Ok(path),
        None => Err(InstallError::Library(
            places.into_iter().rev().take(2).collect(),
        )),
    }
}

/// Compares the stamp that setup.sh left beside the library with the installed package.
fn check_version(library: &Path) -> Result<(), InstallError> {
    let Ok(stamp) = std::fs::read_to_string(library.with_file_name("stamp")) else {
        return Ok(()); // a library of the user's own; it compares versions itself when it is loaded
    };
    let built = stamp
        .lines()
        .find_map(|line| line.strip_prefix("openfoam "))
        .unwrap_or("unknown")
        .to_owned();
    let query = Command::new("dpkg-query")
        .args(["-W", "-f", "${Version}", "openfoam"])
        .output();
    let installed = match query {
        Ok(output) if output.status.success() => {
            String::from_utf8_lossy(&output.stdout).into_owned()
        }
        _ => "not known to dpkg".to_owned(),
    };
    if built == installed {
        Ok(())
    } else {
        Err(InstallError::Version { built, installed })
    }
}
