//! Folders of results that are written in one go: never silently overwritten.

use super::Failure;
use std::fs;
use std::path::Path;

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
