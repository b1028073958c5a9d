//! The folder of a run: never silently overwritten.

use super::Failure;
use super::lock::Lock;
use crate::files::clear_unfinished;
use crate::output::run_files::{FLUID, MARK, RunFiles};
use crate::simulation::assembly::surroundings::{LOGS, OWN_FLUID};
use std::fs;
use std::path::Path;

/// Who works in the folder.
const LOCK: &str = "run.lock";

/// What a run leaves whose fluid could not be started.
const OF_A_START: [&str; 7] = [LOCK, MARK, FLUID, OWN_FLUID, LOGS[0], LOGS[1], LOGS[2]];

/// What to do with an earlier run in the same folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Earlier {
    /// Leave it alone, and refuse to work here.
    Keep,
    /// Remove it.
    Replace,
    /// Go on with it.
    Resume,
    /// Go on with it although tables of it are missing or damaged.
    ResumeWithoutTables,
}

/// The files of a run, and the right to work with them.
#[derive(Debug)]
pub struct RunFolder {
    files: RunFiles,
    _lock: Lock,
}

impl std::ops::Deref for RunFolder {
    type Target = RunFiles;

    fn deref(&self) -> &RunFiles {
        &self.files
    }
}

impl RunFolder {
    /// Whether a run has been in the folder that never began, for a look before the work of a start.
    ///
    /// # Errors
    /// If there is something that `earlier` does not allow to touch, or nothing where there should be an earlier run.
    pub fn look(root: &Path, earlier: Earlier) -> Result<bool, Failure> {
        let shown = root.display();
        let input = |text: String| Err(Failure::Input(text));
        let entries = contents(root)
            .map_err(|e| Failure::Input(format!("cannot use {shown} as a folder: {e}")))?;
        let ours = entries.iter().any(|name| name == MARK || name == LOCK);
        // Without the first row of a history nothing is lost: OpenFOAM did not start.
        let never_begun = ours
            && entries
                .iter()
                .all(|name| OF_A_START.iter().any(|n| name == n));
        let occupied = !never_begun && entries.iter().any(|name| name != LOCK);
        match earlier {
            Earlier::Resume | Earlier::ResumeWithoutTables if !ours => input(format!(
                "{shown} holds no run to resume; start it without --resume"
            )),
            Earlier::Keep if occupied => input(format!(
                "{shown} exists already; continue the run in it with --resume, replace it with --force, or choose another folder with --out"
            )),
            Earlier::Replace if occupied && !ours => input(format!(
                "{shown} is not the folder of a run (it holds no {MARK}), so --force does not remove it; remove it yourself or choose another folder with --out"
            )),
            _ => Ok(never_begun),
        }
    }

    /// Locks the folder and prepares it.
    ///
    /// # Errors
    /// As [`Self::look`], or if another process works there.
    pub fn open(root: &Path, earlier: Earlier) -> Result<Self, Failure> {
        let never_begun = Self::look(root, earlier)?;
        let shown = root.display();
        fs::create_dir_all(root)
            .map_err(|e| Failure::Input(format!("cannot create {shown}: {e}")))?;
        let folder = Self {
            _lock: Lock::take(&root.join(LOCK))?,
            files: RunFiles::new(root),
        };
        if matches!(earlier, Earlier::Resume | Earlier::ResumeWithoutTables) {
            folder
                .clear_unfinished()
                .map_err(|e| Failure::Input(format!("cannot tidy up: {e}")))?;
        }
        if earlier == Earlier::Replace || earlier == Earlier::Keep && never_begun {
            folder
                .clear()
                .map_err(|e| Failure::Input(format!("cannot empty {shown}: {e}")))?;
        }
        Ok(folder)
    }

    /// Locks a folder into which the files of a run have just been copied.
    pub fn adopt(root: &Path) -> Result<Self, Failure> {
        Ok(Self {
            _lock: Lock::take(&root.join(LOCK))?,
            files: RunFiles::new(root),
        })
    }

    /// Removes half-written files of an earlier process.
    fn clear_unfinished(&self) -> std::io::Result<()> {
        let checkpoints = self.checkpoints().folder();
        clear_unfinished(self.root())?;
        match checkpoints.is_dir() {
            true => clear_unfinished(&checkpoints),
            false => Ok(()),
        }
    }

    /// Removes everything but the lock.
    fn clear(&self) -> std::io::Result<()> {
        for name in contents(self.root())? {
            let path = self.root().join(&name);
            if path.is_dir() && !path.is_symlink() {
                fs::remove_dir_all(path)?;
            } else if name != LOCK {
                fs::remove_file(path)?;
            }
        }
        Ok(())
    }
}

/// The process that works in the folder of a run, if there is one.
pub fn at_work(root: &Path) -> Option<String> {
    Lock::holder(&root.join(LOCK))
}

/// Names in a folder; none if it does not exist.
fn contents(folder: &Path) -> std::io::Result<Vec<std::ffi::OsString>> {
    match fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error),
        Ok(entries) => entries.map(|entry| Ok(entry?.file_name())).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Not even `--force` replaces a folder that holds something else.
    #[test]
    fn only_force_replaces_an_earlier_run() {
        let parent = tempfile::tempdir().unwrap();
        let root = parent.path().join("run");
        let refused = RunFolder::open(&root, Earlier::Resume).unwrap_err();
        assert!(refused.to_string().contains("no run to resume") && !root.exists());
        let folder = RunFolder::open(&root, Earlier::Keep).unwrap();
        fs::write(folder.resolved_case(), "").unwrap();
        drop(folder);
        // A run that never began is in nobody's way.
        let folder = RunFolder::open(&root, Earlier::Keep).unwrap();
        assert!(!folder.resolved_case().exists());
        fs::write(folder.resolved_case(), "").unwrap();
        fs::write(folder.history(), "").unwrap();
        drop(folder);
        let refused = RunFolder::open(&root, Earlier::Keep).unwrap_err();
        assert!(refused.to_string().contains("--force"));
        let folder = RunFolder::open(&root, Earlier::Replace).unwrap();
        assert!(!folder.resolved_case().exists());

        let foreign = parent.path().join("thesis");
        fs::create_dir(&foreign).unwrap();
        fs::write(foreign.join("thesis.tex"), "").unwrap();
        for earlier in [Earlier::Keep, Earlier::Replace, Earlier::Resume] {
            RunFolder::open(&foreign, earlier).unwrap_err();
            assert_eq!(contents(&foreign).unwrap(), ["thesis.tex"]);
        }
    }

    #[test]
    fn what_a_hindered_write_has_left_goes_when_the_run_goes_on() {
        let parent = tempfile::tempdir().unwrap();
        let folder = RunFolder::open(parent.path(), Earlier::Keep).unwrap();
        fs::create_dir(folder.checkpoints().folder()).unwrap();
        fs::write(folder.checkpoints().folder().join(".tmpHalf"), "").unwrap();
        fs::create_dir_all(parent.path().join(".tmpEvaluation/wall-shear")).unwrap();
        fs::write(folder.history(), "").unwrap();
        drop(folder);
        let folder = RunFolder::open(parent.path(), Earlier::Resume).unwrap();
        let mut left = contents(parent.path()).unwrap();
        left.sort();
        assert_eq!(left, ["checkpoints", "history.csv", LOCK]);
        assert!(contents(&folder.checkpoints().folder()).unwrap().is_empty());
    }

    /// Nobody else may work in a folder and nobody is fooled by what is left of a lock.
    #[test]
    fn a_locked_folder_is_refused_a_stale_lock_is_not() {
        let parent = tempfile::tempdir().unwrap();
        let root = parent.path().join("run");
        let folder = RunFolder::open(&root, Earlier::Keep).unwrap();
        for earlier in [Earlier::Keep, Earlier::Replace, Earlier::Resume] {
            let refused = RunFolder::open(&root, earlier).unwrap_err().to_string();
            let name = format!("process {}", std::process::id());
            assert!(refused.contains(&name), "{refused}");
        }
        drop(folder);
        fs::write(root.join(LOCK), "process 1 on another-machine\n").unwrap();
        RunFolder::open(&root, Earlier::Resume).unwrap();
    }
}
