//! The content of a file in three numbers.

use super::named;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// A file as it was: its first bytes, how many, and their checksum. It may have grown since.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileFingerprint {
    /// Path from a root.
    pub path: String,
    /// Number of bytes.
    pub length: u64,
    /// CRC-32 of these bytes.
    pub checksum: u32,
}

/// Why a file is not what it was.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {reason}")]
pub struct FingerprintError {
    /// The file.
    pub path: String,
    /// What is wrong with it.
    pub reason: String,
}

impl FileFingerprint {
    /// Of the first `length` bytes of `root/path`, or all.
    ///
    /// # Errors
    /// They name the file.
    pub fn of(root: &Path, path: &Path, length: Option<u64>) -> io::Result<Self> {
        Self::read(root, path, length).map_err(named(&root.join(path)))
    }

    fn read(root: &Path, path: &Path, length: Option<u64>) -> io::Result<Self> {
        let mut file = File::open(root.join(path))?.take(length.unwrap_or(u64::MAX));
        let (mut hasher, mut length) = (crc32fast::Hasher::new(), 0);
        let mut buffer = vec![0; 1 << 16];
        loop {
            match file.read(&mut buffer)? {
                0 => break,
                n => {
                    hasher.update(&buffer[..n]);
                    length += n as u64;
                }
            }
        }
        Ok(Self {
            path: path.to_string_lossy().into_owned(),
            length,
            checksum: hasher.finalize(),
        })
    }

    /// Whether the file below `root` still begins with these bytes.
    pub fn check(&self, root: &Path) -> Result<(), FingerprintError> {
        let wrong = |reason: String| FingerprintError {
            path: self.path.clone(),
            reason,
        };
        let now = Self::read(root, Path::new(&self.path), Some(self.length))
            .map_err(|error| wrong(error.to_string()))?;
        if now.length < self.length {
            return Err(wrong(format!(
                "it has {} bytes instead of {}",
                now.length, self.length
            )));
        }
        if now.checksum != self.checksum {
            return Err(wrong("it has changed".into()));
        }
        Ok(())
    }
}
