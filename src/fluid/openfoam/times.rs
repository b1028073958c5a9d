//! The times that OpenFOAM has written: a folder each, in the case or in the `processorN` of each rank.

use crate::files::{named, sync_folder};
use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// A time that was written.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenTime {
    /// The time, s.
    pub time: f64,
    /// Its folder.
    pub folder: PathBuf,
}

/// All times in a case, those of each rank included.
pub fn written(case: &Path) -> io::Result<Vec<WrittenTime>> {
    let mut found = Vec::new();
    for entry in folders(case)? {
        let name = entry
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if let Some(time) = time(&name) {
            found.push(WrittenTime {
                time,
                folder: entry,
            });
        } else if name.starts_with("processor") {
            for folder in folders(&entry)? {
                let name = folder
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned();
                found.extend(time(&name).map(|time| WrittenTime { time, folder }));
            }
        }
    }
    Ok(found)
}

/// What of a case its times stand on, and no checkpoint names because it never changes: the mesh of each rank.
pub fn unchanging(case: &Path) -> Vec<PathBuf> {
    let mesh = |rank: usize| case.join(format!("processor{rank}/constant"));
    (0..).map(mesh).take_while(|mesh| mesh.exists()).collect()
}

/// Removes the times that `keep` does not want.
pub fn prune(case: &Path, keep: impl Fn(f64) -> bool) -> io::Result<()> {
    let mut old = written(case)?.into_iter().filter(|t| !keep(t.time));
    old.try_for_each(|t| fs::remove_dir_all(&t.folder).map_err(named(&t.folder)))
}

/// State of OpenFOAM's function objects in the folder of a time. OpenFOAM writes it last, when the next step begins or
/// the solver ends; it reads it again at its start, and nothing here needs it.
const LATE: &str = "uniform/functionObjects/functionObjectProperties";

/// Removes what a solver that was ended amid its writing may have left behind, before another one starts at the time
/// `start` (s): all later times, and a late file that is not whole, at which OpenFOAM would give up.
pub fn clear_remains(case: &Path, start: f64) -> io::Result<()> {
    prune(case, |time| time <= start)?;
    for written in written(case)? {
        let late = written.folder.join(LATE);
        if written.time == start && late.exists() && !is_complete(&late)? {
            fs::remove_file(&late).map_err(named(&late))?;
        }
    }
    Ok(())
}

/// A time with all its files.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TimeFiles {
    /// The time as the names of the folders spell it, s: from here OpenFOAM continues to the bit.
    pub time: f64,
    /// The files in all folders of this time.
    pub files: Vec<PathBuf>,
}

/// The files of the time `at`, where a step is `time_step` (s) long.
pub fn files(case: &Path, at: f64, time_step: f64) -> io::Result<TimeFiles> {
    let (mut files, mut time) = (Vec::new(), None);
    for t in written(case)? {
        if (t.time - at).abs() < 0.5 * time_step {
            collect(&t.folder, &mut files)?;
            time = Some(t.time);
        }
    }
    files.sort();
    let nothing = || io::Error::other(format!("OpenFOAM has written nothing at t = {at} s"));
    let time = time.ok_or_else(nothing)?;
    Ok(TimeFiles { time, files })
}

/// Whether OpenFOAM has written a file up to its last line; it does not notice a full disk.
fn is_complete(path: &Path) -> io::Result<bool> {
    let last_letters = || {
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(64)))?;
        let mut end = Vec::new();
        file.read_to_end(&mut end).map(|_| end)
    };
    let end = last_letters().map_err(named(path))?;
    Ok(end.trim_ascii_end().ends_with(b"****** //"))
}

/// Sees to it that a file that OpenFOAM has written is on the disk.
///
/// # Errors
/// If it is not whole.
pub fn sync_whole(path: &Path) -> io::Result<()> {
    (File::open(path).and_then(|file| file.sync_all())).map_err(named(path))?;
    path.parent().map_or(Ok(()), sync_folder)?;
    if is_complete(path)? {
        return Ok(());
    }
    Err(io::Error::other(format!(
        "OpenFOAM has not written {} to its end; is the disk full?",
        path.display()
    )))
}

fn time(name: &str) -> Option<f64> {
    let number = name.starts_with(|c: char| c.is_ascii_digit());
    number.then(|| name.parse().ok()).flatten()
}

fn folders(of: &Path) -> io::Result<Vec<PathBuf>> {
    let mut folders = Vec::new();
    for entry in fs::read_dir(of).map_err(named(of))? {
        let entry = entry.map_err(named(of))?;
        if entry.file_type().map_err(named(of))?.is_dir() {
            folders.push(entry.path());
        }
    }
    Ok(folders)
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder).map_err(named(folder))? {
        let entry = entry.map_err(named(folder))?;
        if entry.file_type().map_err(named(folder))?.is_dir() {
            collect(&entry.path(), files)?;
        } else {
            files.push(entry.path());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_all_ranks_are_found_and_pruned_and_nothing_else() {
        let case = tempfile::tempdir().unwrap();
        let names = [
            "0",
            "0.002",
            "1e-05",
            "processor0/0.002",
            "processor1/0.004",
            "system",
            "constant",
        ];
        for name in names {
            fs::create_dir_all(case.path().join(name).join("uniform")).unwrap();
            fs::write(case.path().join(name).join("uniform/time"), "").unwrap();
        }
        assert_eq!(written(case.path()).unwrap().len(), 5);
        assert_eq!(
            files(case.path(), 0.002 + 1e-17, 0.002)
                .unwrap()
                .files
                .len(),
            2
        );
        let late = case.path().join("processor0/0.002").join(LATE);
        fs::create_dir_all(late.parent().unwrap()).unwrap();
        fs::write(&late, "FoamFile").unwrap();
        clear_remains(case.path(), 0.002).unwrap();
        assert!(!late.exists() && late.parent().unwrap().exists());
        assert_eq!(written(case.path()).unwrap().len(), 4);
        assert!(case.path().join("constant").is_dir());
    }

    #[test]
    fn a_file_without_its_last_line_is_not_complete() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let is_complete = |bytes: &[u8]| {
            fs::write(file.path(), bytes).unwrap();
            super::is_complete(file.path()).unwrap()
        };
        let whole = b"internalField uniform 0;\n\n\n// ************************************************************************* //\n";
        assert!(is_complete(whole));
        assert!(!is_complete(&whole[..60]));
        assert!(!is_complete(b""));
    }
}
