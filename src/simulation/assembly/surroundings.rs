//! What the fluid of a case needs around it and what it leaves in its folder: asked here, answered by the fluid's own
//! room.

use crate::Vec3;
use crate::case::{Case, Solver};
use crate::fluid::openfoam::{fields, install, times};
use crate::processes::on_path;
use std::io;
use std::path::{Path, PathBuf};

/// What a fluid leaves next to its folder that could not be started.
pub const LOGS: [&str; 3] = ["openfoam.log", "log.decomposePar", EXTERNAL_LOG];
/// Folder of a user-supplied fluid, next to that which OpenFOAM would have.
pub const OWN_FLUID: &str = "fluid";
/// Messages of a user-supplied fluid.
pub(super) const EXTERNAL_LOG: &str = "fluid.log";

/// What a fluid needs and is not there.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Missing(String);

/// Whether the solver is OpenFOAM, or stands on it.
pub fn needs_openfoam(solver: Solver) -> bool {
    solver == Solver::OpenFoam
}

/// What the blood of a case is computed on, in `cells` cells or elements.
pub fn described(case: &Case, cells: usize) -> String {
    match (case.fluid.solver, case.native_degree()) {
        (Solver::External, _) if case.fluid.is_awaited => "a solver that is waited for".into(),
        (Solver::External, _) => format!("by {}", case.fluid.command.join(" ")),
        (Solver::Native, Some(degree)) => format!("{cells} elements of degree {degree}"),
        _ => format!("{cells} cells, {} MPI rank(s)", case.fluid.ranks),
    }
}

/// Whether what the fluid of a case needs is installed.
///
/// # Errors
/// What is missing, and how to get it.
pub fn check_installed(case: &Case) -> Result<(), Missing> {
    match case.fluid.solver {
        Solver::OpenFoam => match install::check(case.fluid.ranks) {
            Ok(_) => Ok(()),
            Err(error) => Err(Missing(error.to_string())),
        },
        Solver::Native => Ok(()),
        Solver::External => match case.fluid.command.first() {
            Some(program) if !on_path(program) => Err(Missing(format!(
                "fluid.command: there is no program `{program}`: install it, or write where it is, from the folder of \
                 the case with a slash (\"./{program}\") or as an absolute path"
            ))),
            _ => Ok(()),
        },
    }
}

/// Which OpenFOAM computes the blood, if one does: its number and build.
pub fn openfoam(solver: Solver) -> Option<String> {
    let chosen = matches!(solver, Solver::OpenFoam).then(install::chosen)?;
    chosen.ok().map(|openfoam| openfoam.version.clone())
}

/// Whether the fluid of a case can work below a folder, which need not exist yet.
///
/// # Errors
/// Why not.
pub fn check_folder(case: &Case, folder: &Path) -> Result<(), Missing> {
    match case.fluid.solver {
        Solver::OpenFoam => install::check_path(folder).map_err(|e| Missing(e.to_string())),
        Solver::Native | Solver::External => Ok(()),
    }
}

/// Folders within a fluid's own that never change, and that no memory names.
pub fn unchanging(solver: Solver, folder: &Path) -> Vec<PathBuf> {
    match solver {
        Solver::OpenFoam => times::unchanging(folder),
        Solver::Native | Solver::External => Vec::new(),
    }
}

/// The file by which ParaView opens all fields of a fluid that leaves them in its folder; none of one that hands them
/// over ([`Fluid::field`](crate::fluid::Fluid::field)).
pub fn fields_to_open(solver: Solver, folder: &Path) -> Option<PathBuf> {
    match solver {
        Solver::OpenFoam => Some(folder.join("fluid.foam")),
        Solver::Native | Solver::External => None,
    }
}

/// The velocity of the blood at a time, in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityField {
    /// Time, s.
    pub time: f64,
    file: PathBuf,
}

impl VelocityField {
    /// Velocity in each cell, m/s.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn read(&self) -> io::Result<Vec<Vec3>> {
        fields::vectors(&self.file)
    }
}

/// The velocities that a fluid has left in its folder, by time; none where it leaves none.
///
/// # Errors
/// If the folder cannot be read.
pub fn velocity_fields(solver: Solver, folder: &Path) -> io::Result<Vec<VelocityField>> {
    let found = match solver {
        Solver::OpenFoam if folder.is_dir() => fields::velocities(folder)?,
        _ => Vec::new(),
    };
    let fields = found.into_iter();
    Ok(fields
        .map(|(time, file)| VelocityField { time, file })
        .collect())
}
