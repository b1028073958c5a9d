//! What OpenFOAM's function objects write, as tables over time.

use crate::files::{Fault, fault};
use std::fs;
use std::path::{Path, PathBuf};

/// Times (s), and the total force (N) at each.
pub type Forces = Vec<(f64, [f64; 3])>;

/// Total force over time of a function object of the type `forces`, from its folder in `postProcessing`, which
/// has a folder for each start of the solver, named by its time. What a repeated step or a later start writes replaces
/// what there was from its time on.
///
/// # Errors
/// What cannot be read, in words.
pub fn forces(folder: &Path) -> Result<Forces, Fault> {
    let mut rows = Forces::new();
    for start in starts(folder)? {
        let file = start.join("force.dat");
        let text =
            fs::read_to_string(&file).map_err(|e| fault!("cannot read {}: {e}", file.display()))?;
        let lines = text.lines().enumerate();
        for (number, line) in lines.filter(|(_, line)| !line.starts_with('#')) {
            let row = row(line).ok_or_else(|| {
                fault!(
                    "{}:{}: found {line:?}, expected the time and the components of a force",
                    file.display(),
                    number + 1
                )
            })?;
            while rows.last().is_some_and(|last| last.0 >= row.0) {
                rows.pop();
            }
            rows.push(row);
        }
    }
    Ok(rows)
}

/// The folders of the solver's starts, in the order of their times.
fn starts(folder: &Path) -> Result<Vec<PathBuf>, Fault> {
    let unreadable = |e| fault!("cannot read {}: {e}", folder.display());
    let mut starts = Vec::new();
    for entry in fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let time = path
            .file_name()
            .and_then(|name| name.to_str()?.parse().ok());
        starts.extend(time.map(|time: f64| (time, path)));
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(starts.into_iter().map(|(_, path)| path).collect())
}

/// Time and total force: the first numbers of a line, vectors in brackets up to v2112 and without them later.
fn row(line: &str) -> Option<(f64, [f64; 3])> {
    let mut numbers = line
        .split(|c: char| c.is_whitespace() || "()".contains(c))
        .filter(|word| !word.is_empty())
        .map_while(|word| word.parse().ok());
    let mut next = || numbers.next();
    Some((next()?, [next()?, next()?, next()?]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_starts_and_repeated_steps_replace_what_there_was() {
        let folder = tempfile::tempdir().unwrap();
        let write = |start: &str, text: &str| {
            let start = folder.path().join(start);
            fs::create_dir(&start).unwrap();
            fs::write(start.join("force.dat"), text).unwrap();
        };
        write("10", "# Time\ttotal_x\n10.1\t7 8 9\t1 1 1\t0 0 0\n");
        write(
            "0",
            "# Force\n1 \t(1 2 3)\t(1 1 1)\n2\t(4 5 6)\n2\t(4.5 5 -6e-1)\n11\t(0 0 0)\n",
        );
        assert_eq!(
            forces(folder.path()).unwrap(),
            [
                (1.0, [1.0, 2.0, 3.0]),
                (2.0, [4.5, 5.0, -0.6]),
                (10.1, [7.0, 8.0, 9.0])
            ]
        );
        write("20", "20.1 1 x 2\n");
        let fault = forces(folder.path()).unwrap_err().to_string();
        assert!(
            fault.contains("20/force.dat:1: found \"20.1 1 x 2\""),
            "{fault}"
        );
        assert!(forces(Path::new("/nowhere")).is_err());
    }
}
