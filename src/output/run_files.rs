//! The names of the files in the folder of a run.

use crate::files::{UNFINISHED, named};
use crate::simulation::assembly::{Workplace, surroundings};
use crate::simulation::checkpoint::Store;
use std::io;
use std::path::{Path, PathBuf};

/// Its presence marks a folder as one that this program made.
pub const MARK: &str = "case.resolved.toml";

/// The fluid's own folder.
pub const FLUID: &str = "openfoam";

/// The files of a run.
#[derive(Debug, Clone)]
pub struct RunFiles {
    root: PathBuf,
}

impl RunFiles {
    /// The files of the run in the folder `root`.
    pub fn new(root: &Path) -> Self {
        Self {
            root: root.to_owned(),
        }
    }

    /// The checkpoints.
    pub fn checkpoints(&self) -> Store {
        Store::new(&self.root)
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Every value of the case.
    pub fn resolved_case(&self) -> PathBuf {
        self.root.join(MARK)
    }

    /// One row per time step.
    pub fn history(&self) -> PathBuf {
        self.root.join("history.csv")
    }

    /// One row per coupling iteration.
    pub fn iterations(&self) -> PathBuf {
        self.root.join("iterations.csv")
    }

    /// One row per time step and probe.
    pub fn probes(&self) -> PathBuf {
        self.root.join("probes.csv")
    }

    /// One row per time step and probe in the blood.
    pub fn fluid_probes(&self) -> PathBuf {
        self.root.join("fluid-probes.csv")
    }

    /// One row per time step and opening.
    pub fn openings(&self) -> PathBuf {
        self.root.join("openings.csv")
    }

    /// One row per time step and watched cross-section.
    pub fn sections(&self) -> PathBuf {
        self.root.join("sections.csv")
    }

    /// One row per phase of the period.
    pub fn phases(&self) -> PathBuf {
        self.root.join("phases.csv")
    }

    /// The wall at each phase of the period, for ParaView.
    pub fn wall_phases(&self) -> PathBuf {
        self.root.join("phases.pvd")
    }

    /// One row per time step and region of the vessel.
    pub fn regions(&self) -> PathBuf {
        self.root.join("regions.csv")
    }

    /// Wall shear stress and displacement of the wet surface at each step.
    pub fn wall_history(&self) -> PathBuf {
        self.root.join("wall.bin")
    }

    /// The run in figures.
    pub fn summary(&self) -> PathBuf {
        self.root.join("summary.json")
    }

    /// The wall over time, for ParaView.
    pub fn structure(&self) -> PathBuf {
        self.root.join("structure.pvd")
    }

    /// The hemodynamics in figures.
    pub fn hemodynamics(&self) -> PathBuf {
        self.root.join("hemodynamics.json")
    }

    /// One row per face of the wall.
    pub fn wall_shear_table(&self) -> PathBuf {
        self.root.join("wall-shear.csv")
    }

    /// How well the flow is resolved at each face of the wall.
    pub fn resolution(&self) -> PathBuf {
        self.root.join("resolution.csv")
    }

    /// Wall shear measures on the wall, for ParaView.
    pub fn wall_shear(&self) -> PathBuf {
        self.root.join("wall-shear.pvd")
    }

    /// Wall shear stress and displacement over time, for ParaView.
    pub fn wall_shear_over_time(&self) -> PathBuf {
        self.root.join("wall-shear-over-time.pvd")
    }

    /// Opens everything in ParaView.
    pub fn view(&self) -> PathBuf {
        self.root.join("view.py")
    }

    /// The blood over time, for ParaView, from a fluid that does not leave its fields in its folder.
    pub fn fluid_fields(&self) -> PathBuf {
        self.root.join("fluid.pvd")
    }

    /// The fluid's own folder.
    pub fn fluid(&self) -> PathBuf {
        self.root.join(FLUID)
    }

    /// What a function object of OpenFOAM writes.
    pub fn function_object(&self, name: &str) -> PathBuf {
        self.root.join(FLUID).join("postProcessing").join(name)
    }

    /// Where the fluid works.
    pub fn workplace(&self) -> Workplace {
        Workplace {
            folder: self.fluid(),
            log: self.fluid_log(),
            case_file: self.resolved_case(),
            ..Workplace::default()
        }
    }

    /// What the fluid itself says.
    pub fn fluid_log(&self) -> PathBuf {
        self.root.join(surroundings::LOGS[0])
    }
}

/// A folder next to the results, for those that are to take their place.
pub(super) fn draft(files: &RunFiles) -> io::Result<tempfile::TempDir> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED).tempdir_in(files.root())
}

/// Moves all files of a folder, and of the folders in it, to the same places in another.
pub(super) fn replace(from: &Path, to: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(from).map_err(named(from))? {
        let entry = entry.map_err(named(from))?;
        let target = to.join(entry.file_name());
        if entry.file_type().map_err(named(from))?.is_dir() {
            std::fs::create_dir_all(&target).map_err(named(&target))?;
            replace(&entry.path(), &target)?;
        } else {
            std::fs::rename(entry.path(), &target).map_err(named(&target))?;
        }
    }
    Ok(())
}
