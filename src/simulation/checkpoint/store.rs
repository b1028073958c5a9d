//! The folder of the checkpoints: the last two are kept, each is whole or absent.

use super::{Checkpoint, DecodeError};
use crate::files::{FileFingerprint, FingerprintError, sync_folder, write_atomically};
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
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// There is none.
    #[error("{} holds no checkpoint", .0.display())]
    None(PathBuf),
    /// Nobody has asked for any.
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
    #[error("it stands on a file that is not what it was: {0}")]
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

    fn folder(&self) -> PathBuf {
        self.run.join("checkpoints")
    }

    /// The file of the checkpoint after `step` steps.
    pub fn path(&self, step: usize) -> PathBuf {
        self.folder().join(format!("{step:08}.{ENDING}"))
    }

    /// Steps of all checkpoints, newest first.
    pub fn steps(&self) -> io::Result<Vec<usize>> {
        let mut steps = Vec::new();
        match fs::read_dir(self.folder()) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
            Ok(entries) => {
                for entry in entries {
                    let path = entry?.path();
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

    /// Writes a checkpoint and removes those before the last two; returns the steps of those that are there now,
    /// newest first. A newer one, of a future that is done again, is removed too.
    pub fn write<S: Serialize, O: Serialize>(
        &self,
        checkpoint: &Checkpoint<S, O>,
    ) -> Result<Vec<usize>, StoreError> {
        let path = self.path(checkpoint.step());
        let error = |source| StoreError::Io {
            path: path.clone(),
            source,
        };
        fs::create_dir_all(self.folder()).map_err(error)?;
        write_atomically(&path, &checkpoint.encode()).map_err(error)?;
        sync_folder(&self.folder()).map_err(error)?;
        let (newer, mut kept): (Vec<_>, Vec<_>) = self
            .steps()
            .map_err(error)?
            .into_iter()
            .partition(|step| *step > checkpoint.step());
        let older = kept.split_off(kept.len().min(KEPT));
        for step in newer.into_iter().chain(older) {
            fs::remove_file(self.path(step)).map_err(error)?;
        }
        Ok(kept)
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
        let steps = self.steps().map_err(|source| StoreError::Io {
            path: self.folder(),
            source,
        })?;
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
