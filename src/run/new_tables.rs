//! Tables of a run that are lost: set aside, so that the run can go on with new ones.

use super::{Failure, RunCheckpoint, RunFolder};
use crate::files::below;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Sets tables that are missing, or not what they were at the `checkpoint`, aside and says what is wrong with each; the
/// checkpoint then knows none of their rows.
pub fn set_aside(
    folder: &RunFolder,
    mut checkpoint: RunCheckpoint,
) -> Result<(RunCheckpoint, Vec<String>), Failure> {
    let root = folder.root();
    let (mut lost, record) = (Vec::new(), &mut checkpoint.observer.0);
    for (path, length) in [
        (folder.history(), &mut record.history),
        (folder.iterations(), &mut record.iterations),
        (folder.probes(), &mut record.probes),
        (folder.fluid_probes(), &mut record.fluid_probes),
        (folder.openings(), &mut record.openings),
        (folder.sections(), &mut record.sections.0),
        (folder.regions(), &mut record.wall.regions),
        (folder.wall_history(), &mut record.wall.history),
    ] {
        let name = below(root, &path).display().to_string();
        let mut files = checkpoint.files.iter().filter(|file| file.path == name);
        let Some(flaw) = files.find_map(|file| file.check(root).err()) else {
            continue;
        };
        rename(&path).map_err(|e| Failure::Input(format!("cannot rename {name}: {e}")))?;
        lost.push(flaw.to_string());
        *length = 0;
    }
    Ok((checkpoint, lost))
}

/// Renames a file, if it is there, to a name that is free.
fn rename(path: &Path) -> io::Result<()> {
    let name = |n: usize| PathBuf::from(format!("{}.damaged-{n}", path.display()));
    let free = (1..).map(name).find(|name| !name.exists());
    match fs::rename(path, free.expect("some number is free")) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        renamed => renamed,
    }
}

/// The files of a run that grow by rows: results, without which a state is whole.
pub fn names(folder: &RunFolder) -> Vec<String> {
    let tables = [
        folder.history(),
        folder.iterations(),
        folder.probes(),
        folder.fluid_probes(),
        folder.openings(),
        folder.sections(),
        folder.regions(),
        folder.wall_history(),
    ];
    let names = tables.iter().map(|path| below(folder.root(), path));
    names.map(|name| name.display().to_string()).collect()
}
