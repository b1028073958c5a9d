//! Files that are whole or absent, and what tells whether one has changed.

mod fingerprint;

pub use fingerprint::{FileFingerprint, FingerprintError};

use std::io::Write;
use std::path::Path;

/// Writes `contents` under a temporary name in the same folder and renames it, so that a reader, or a run that is
/// killed meanwhile, never meets half a file.
pub fn write_atomically(path: &Path, contents: &[u8]) -> std::io::Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    file.write_all(contents)?;
    // Temporary files are private; results are not.
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o644);
    file.as_file().set_permissions(permissions)?;
    file.as_file().sync_data()?;
    file.persist(path)?;
    Ok(())
}

/// Sees to it that the names of the files in `folder` are on the disk.
pub fn sync_folder(folder: &Path) -> std::io::Result<()> {
    std::fs::File::open(folder)?.sync_all()
}

/// A path as it is named from the folder `root`, if it lies below it.
pub fn below<'a>(root: &Path, path: &'a Path) -> &'a Path {
    path.strip_prefix(root).unwrap_or(path)
}
