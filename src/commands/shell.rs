//! `fsi-driver completions SHELL`, `fsi-driver man` and `--version`: what makes an installed program feel at home.

use super::{CommandLine, Failure};
use crate::fluid::openfoam::install::{self, InstallError, Installation};
use crate::output::terminal::print;
use clap::CommandFactory;
use clap_complete::Shell;
use std::fs;
use std::path::PathBuf;

/// For which shell.
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// Its name.
    #[arg(value_enum)]
    shell: Shell,
}

/// Where the manual goes.
#[derive(Debug, clap::Args)]
pub struct Manual {
    /// Folder for the pages of all commands, such as ~/.local/share/man/man1 [default: the main page is printed].
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// Prints the script by which a shell completes commands and options.
pub fn completions(arguments: &Completions) -> Result<(), Failure> {
    let mut script = Vec::new();
    let mut command = CommandLine::command();
    clap_complete::generate(arguments.shell, &mut command, "fsi-driver", &mut script);
    Ok(print(String::from_utf8_lossy(&script))?)
}

/// Prints the manual page, or writes one for each command.
pub fn manual(arguments: &Manual) -> Result<(), Failure> {
    let command = CommandLine::command();
    match &arguments.folder {
        Some(folder) => fs::create_dir_all(folder)
            .and_then(|()| clap_mangen::generate_to(command, folder))
            .map_err(|error| Failure::Input(format!("{}: {error}", folder.display()))),
        None => {
            let mut page = Vec::new();
            let rendered = clap_mangen::Man::new(command).render(&mut page);
            rendered.map_err(|error| Failure::Run(error.to_string()))?;
            Ok(print(String::from_utf8_lossy(&page))?)
        }
    }
}

/// Prints the version, and each OpenFOAM with its adapter, first the one that a run would use.
pub fn version() -> Result<(), Failure> {
    let mut text = format!("fsi-driver {}\n", env!("CARGO_PKG_VERSION"));
    let of = |openfoam: &Installation, adapter: Result<PathBuf, InstallError>| {
        let adapter = match adapter {
            Ok(library) => library.display().to_string(),
            Err(error) => error.to_string(),
        };
        format!(
            "OpenFOAM {} ({})\nadapter {adapter}\n",
            openfoam.version, openfoam.origin
        )
    };
    match install::chosen() {
        Ok(chosen) => text += &of(chosen, install::check(1)),
        Err(error) => text += &format!("OpenFOAM not installed\nadapter {error}\n"),
    }
    for other in install::installations().unwrap_or_default() {
        if install::chosen() != Ok(&other) {
            let library = install::find_library(&other);
            let fits =
                |library: PathBuf| install::check_version(&library, &other).map(|()| library);
            text += &of(&other, library.and_then(fits));
        }
    }
    Ok(print(text)?)
}
