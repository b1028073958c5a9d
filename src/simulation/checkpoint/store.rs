//! The folder of the checkpoints: the last two are kept, each is whole or absent.

use super::{Checkpoint, DecodeError};
use crate::files::{FileFingerprint, FingerprintError, named, sync_folder, write_atomically};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

const KEPT: usize = 2;
const ENDING: &str = "checkpoint";

/// A folder of checkpoints in the folder of a run.
#[derive(Debug, Clone)]
pub struct Store {
    run: PathBuf,
}

/// What was found.
#[derive(Debug)]
pub struct Found<S, O> {
    /// The newest checkpoint that is whole.
    pub checkpoint: Checkpoint<S, O>,
    /// Its file.
    pub path: PathBuf,
    /// What is wrong with newer ones.
    pub damaged: Vec<String>,
}

/// Why there is no checkpoint to resume from.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The system refused; the error names the file or folder.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// There is none.
    #[error("{} holds no checkpoint", .0.display())]
    None(PathBuf),
    /// None was asked for.
    #[error("no checkpoints are kept")]
    Unwanted,
    /// There is none that could be used.
    #[error("no checkpoint is whole:\n  {}", .0.join("\n  "))]
    Damaged(Vec<String>),
}

/// Why one checkpoint cannot be used.
#[derive(Debug, thiserror::Error)]
enum Flaw {
    #[error(transparent)]
    Io(#[from] io::Error),
    #[error(transparent)]
    Decode(#[from] DecodeError),
    #[error("it depends on a file that has changed: {0}")]
    Changed(#[from] FingerprintError),
}

impl Store {
    /// The checkpoints of the run in the folder `run`.
    pub fn new(run: &Path) -> Self {
        Self {
            run: run.to_owned(),
        }
    }

    /// The folder of the run.
    pub fn root(&self) -> &Path {
        &self.run
    }

    /// The folder in it where they lie.
    pub fn folder(&self) -> PathBuf {
        self.run.join("checkpoints")
    }

    /// The file of the checkpoint after `step` steps.
    pub fn path(&self, step: usize) -> PathBuf {
        self.folder().join(format!("{step:08}.{ENDING}"))
    }

    /// Steps of all checkpoints, newest first.
    pub fn steps(&self) -> io::Result<Vec<usize>> {
        let (mut steps, folder) = (Vec::new(), self.folder());
        match fs::read_dir(&folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(named(&folder)(error)),
            Ok(entries) => {
                for entry in entries {
                    let path = entry.map_err(named(&folder))?.path();
                    let is_checkpoint = path.extension().is_some_and(|e| e == ENDING);
                    let stem = path.file_stem().and_then(|s| s.to_str());
                    steps.extend(
                        stem.filter(|_| is_checkpoint)
                            .and_then(|s| s.parse::<usize>().ok()),
                    );
                }
            }
        }
        steps.sort_unstable_by(|a, b| b.cmp(a));
        Ok(steps)
    }

    /// Writes a checkpoint next to those that are there.
    pub fn write<S: Serialize, O: Serialize>(
        &self,
        checkpoint: &Checkpoint<S, O>,
    ) -> Result<(), StoreError> {
        let folder = self.folder();
        fs::create_dir_all(&folder).map_err(named(&folder))?;
        write_atomically(&self.path(checkpoint.step()), &checkpoint.encode())?;
        Ok(sync_folder(&folder)?)
    }

    /// Steps of the checkpoints that stay when the one after `step` steps is there, which may be still to be written:
    /// the last two until then, newest first.
    pub fn kept(&self, step: usize) -> io::Result<Vec<usize>> {
        let older = self.steps()?.into_iter().filter(|other| *other < step);
        Ok(std::iter::once(step).chain(older).take(KEPT).collect())
    }

    /// Removes the checkpoints but those that are [kept](Self::kept) with the one after `step` steps.
    pub fn tidy(&self, step: usize) -> Result<(), StoreError> {
        let kept = self.kept(step)?;
        for step in self.steps()?.into_iter().filter(|it| !kept.contains(it)) {
            let path = self.path(step);
            fs::remove_file(&path).map_err(named(&path))?;
        }
        Ok(())
    }

    /// The newest checkpoint that is whole, with all files that it stands on.
    pub fn newest<S: DeserializeOwned, O: DeserializeOwned>(
        &self,
    ) -> Result<Found<S, O>, StoreError> {
        self.newest_without(&[])
    }

    /// The newest checkpoint that is whole, with all files that it stands on but those at the paths `waived`.
    pub fn newest_without<S: DeserializeOwned, O: DeserializeOwned>(
        &self,
        waived: &[String],
    ) -> Result<Found<S, O>, StoreError> {
        let steps = self.steps()?;
        if steps.is_empty() {
            return Err(StoreError::None(self.run.clone()));
        }
        let mut damaged = Vec::new();
        for step in steps {
            let path = self.path(step);
            match self.read(&path, waived) {
                Ok(checkpoint) => {
                    return Ok(Found {
                        checkpoint,
                        path,
                        damaged,
                    });
                }
                Err(flaw) => damaged.push(format!("{}: {flaw}", path.display())),
            }
        }
        Err(StoreError::Damaged(damaged))
    }

    fn read<S: DeserializeOwned, O: DeserializeOwned>(
        &self,
        path: &Path,
        waived: &[String],
    ) -> Result<Checkpoint<S, O>, Flaw> {
        let checkpoint = Checkpoint::decode(&fs::read(path)?)?;
        let needed = |file: &&FileFingerprint| !waived.contains(&file.path);
        for file in checkpoint.files.iter().filter(needed) {
            file.check(&self.run)?;
        }
        Ok(checkpoint)
    }
}
