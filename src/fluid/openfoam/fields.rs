//! The fields of the blood that OpenFOAM has written.

use super::times::{self, WrittenTime};
use crate::Vec3;
use std::io;
use std::path::Path;

/// The times (s) whose velocity was written, with its file, by time. None of a run with several ranks, whose fields lie
/// in one folder a rank.
pub fn velocities(case: &Path) -> io::Result<Vec<(f64, std::path::PathBuf)>> {
    let of_the_case = |written: &WrittenTime| written.folder.parent() == Some(case);
    let times = times::written(case)?.into_iter().filter(of_the_case);
    let files = times.map(|written| (written.time, written.folder.join("U")));
    let mut found: Vec<_> = files.filter(|(_, file)| file.is_file()).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(found)
}

/// The vectors of a field in the cells, from a binary file of OpenFOAM.
pub fn vectors(path: &Path) -> io::Result<Vec<Vec3>> {
    let bytes = std::fs::read(path)?;
    let bad = || {
        let text = format!("{}: not a binary field of vectors", path.display());
        io::Error::new(io::ErrorKind::InvalidData, text)
    };
    let after = |from: usize, what: &[u8]| {
        let found = bytes[from..].windows(what.len()).position(|w| w == what);
        found.map(|at| from + at + what.len())
    };
    let header = after(0, b"internalField").ok_or_else(bad)?;
    let list = after(header, b"List<vector>").ok_or_else(bad)?;
    let open = after(list, b"(").ok_or_else(bad)?;
    let count = std::str::from_utf8(&bytes[list..open - 1]).map_err(|_| bad())?;
    let count: usize = count.trim().parse().map_err(|_| bad())?;
    let end = count.checked_mul(24).and_then(|n| n.checked_add(open));
    let numbers = end.and_then(|end| bytes.get(open..end)).ok_or_else(bad)?;
    let vector = |chunk: &[u8]| {
        let mut v = Vec3::zeros();
        for (c, bytes) in v.iter_mut().zip(chunk.chunks_exact(8)) {
            let mut number = [0; 8];
            number.copy_from_slice(bytes);
            *c = f64::from_le_bytes(number);
        }
        v
    };
    Ok(numbers.chunks_exact(24).map(vector).collect())
}
