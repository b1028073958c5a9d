//! Files that are whole or absent, and what tells whether one has changed.

mod fault;
mod fingerprint;
pub mod text;

pub use crate::fault;
pub use fault::{Fault, FileError};
pub use fingerprint::{FileFingerprint, FingerprintError};

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

/// How the names of files and folders begin whose contents are to take the place of others once they are whole.
pub const UNFINISHED: &str = ".tmp";

/// The error of a file or folder with its name, which the system does not say: `RUN/history.csv: No space left on
/// device`.
pub fn named(path: &Path) -> impl Fn(io::Error) -> io::Error {
    move |error| io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

/// The bytes of a file. A device, a pipe or a socket is refused before it is opened: reading it might never end.
///
/// # Errors
/// If it cannot be read, is no regular file, or is larger than `most_bytes`, in words.
pub fn read_regular(path: &Path, most_bytes: u64) -> io::Result<Vec<u8>> {
    let invalid = |reason: String| io::Error::new(io::ErrorKind::InvalidData, reason);
    let kind = std::fs::metadata(path)?.file_type();
    if kind.is_dir() {
        return Err(invalid("this is a folder, not a file".into()));
    }
    if !kind.is_file() {
        return Err(invalid(
            "this is a device, a pipe or a socket, not a file".into(),
        ));
    }
    let mut bytes = Vec::new();
    (File::open(path)?.take(most_bytes + 1)).read_to_end(&mut bytes)?;
    match bytes.len() as u64 > most_bytes {
        true => Err(invalid(format!(
            "larger than {} MiB: this cannot be the right file",
            most_bytes >> 20
        ))),
        false => Ok(bytes),
    }
}

/// Writes `contents` under a temporary name in the same folder and renames it, so that a reader, or a run that is
/// killed meanwhile, never meets half a file.
///
/// # Errors
/// They name the file.
pub fn write_atomically(path: &Path, contents: &[u8]) -> io::Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let write = || {
        // Temporary files are private; results are not.
        let create = |path: &Path| File::create_new(path);
        let mut file = (tempfile::Builder::new().prefix(UNFINISHED)).make_in(folder, create)?;
        file.as_file_mut().write_all(contents)?;
        file.as_file().sync_data()?;
        file.persist(path).map_err(|refused| refused.error)
    };
    write().map(drop).map_err(named(path))
}

/// Removes what a process has left in `folder` that was ended, or hindered by the system, amid [`write_atomically`] or
/// in a temporary folder.
///
/// # Errors
/// They name the file.
pub fn clear_unfinished(folder: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(folder).map_err(named(folder))? {
        let entry = entry.map_err(named(folder))?;
        let path = entry.path();
        if !entry.file_name().to_string_lossy().starts_with(UNFINISHED) {
            continue;
        }
        let is_folder = entry.file_type().map(|kind| kind.is_dir());
        let removed = is_folder.and_then(|is_folder| match is_folder {
            true => std::fs::remove_dir_all(&path),
            false => std::fs::remove_file(&path),
        });
        removed.map_err(named(&path))?;
    }
    Ok(())
}

/// Sees to it that the names of the files in `folder` are on the disk.
///
/// # Errors
/// They name the folder.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    (File::open(folder).and_then(|opened| opened.sync_all())).map_err(named(folder))
}

/// A path as it is named from the folder `root`, if it lies below it.
pub fn below<'a>(root: &Path, path: &'a Path) -> &'a Path {
    path.strip_prefix(root).unwrap_or(path)
}
