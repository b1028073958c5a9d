//! The folder of a run: never silently overwritten.

use super::Failure;
use std::fs;
use std::path::{Path, PathBuf};

/// Its presence marks a folder as one that this program made.
const MARK: &str = "case.resolved.toml";

/// The files of a run.
#[derive(Debug, Clone)]
pub struct RunFolder {
    root: PathBuf,
}

impl RunFolder {
    /// Creates the folder.
    ///
    /// # Errors
    /// If it exists and is not empty, unless `force` is given and it is the folder of an earlier run.
    pub fn create(root: &Path, force: bool) -> Result<Self, Failure> {
        claim(root, MARK, force)?;
        Ok(Self {
            root: root.to_owned(),
        })
    }

    /// The folder itself.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Every value of the case.
    pub fn resolved_case(&self) -> PathBuf {
        self.root.join(MARK)
    }

    /// A row a time step.
    pub fn history(&self) -> PathBuf {
        self.root.join("history.csv")
    }

    /// A row a coupling iteration.
    pub fn iterations(&self) -> PathBuf {
        self.root.join("iterations.csv")
    }

    /// A row a time step and probe.
    pub fn probes(&self) -> PathBuf {
        self.root.join("probes.csv")
    }

    /// The run in figures.
    pub fn summary(&self) -> PathBuf {
        self.root.join("summary.json")
    }

    /// The wall over time, for ParaView.
    pub fn structure(&self) -> PathBuf {
        self.root.join("structure.pvd")
    }

    /// The case that OpenFOAM runs in.
    pub fn openfoam(&self) -> PathBuf {
        self.root.join("openfoam")
    }

    /// OpenFOAM's own output.
    pub fn openfoam_log(&self) -> PathBuf {
        self.root.join("openfoam.log")
    }
}

/// Creates an empty folder for results.
///
/// # Errors
/// If it exists and is not empty, unless `force` is given and it holds the file `mark` of earlier results, which are
/// then removed.
pub fn claim(root: &Path, mark: &str, force: bool) -> Result<(), Failure> {
    let shown = root.display();
    let occupied = root.exists()
        && (!root.is_dir() || root.read_dir().map_or(true, |mut d| d.next().is_some()));
    if occupied && !force {
        return Err(Failure::Input(format!(
            "{shown} exists already; choose another folder with --out, or replace the earlier run with --force"
        )));
    }
    if occupied {
        if !root.join(mark).is_file() {
            return Err(Failure::Input(format!(
                "{shown} is not the folder of a run (it holds no {mark}), so --force does not remove it; remove it yourself or choose another folder with --out"
            )));
        }
        fs::remove_dir_all(root)
            .map_err(|e| Failure::Input(format!("cannot remove {shown}: {e}")))?;
    }
    fs::create_dir_all(root).map_err(|e| Failure::Input(format!("cannot create {shown}: {e}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_earlier_run_is_replaced_only_by_force_and_other_folders_never() {
        let parent = tempfile::tempdir().unwrap();
        let root = parent.path().join("run");
        let folder = RunFolder::create(&root, false).unwrap();
        fs::write(folder.resolved_case(), "").unwrap();
        let refused = RunFolder::create(&root, false).unwrap_err();
        assert!(refused.to_string().contains("--force"));
        RunFolder::create(&root, true).unwrap();
        assert!(!folder.resolved_case().exists());

        fs::write(root.join("thesis.tex"), "").unwrap();
        assert!(
            RunFolder::create(&root, true)
                .unwrap_err()
                .to_string()
                .contains("not the folder of a run")
        );
        assert!(root.join("thesis.tex").exists());
    }
}
