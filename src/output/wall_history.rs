//! `wall.bin`: wall shear stress and displacement of the wet surface at every step, in a compact binary file.
//!
//! Little-endian. The head: `FSIWALL` and the version (one byte); number of points, number of faces, sum of the faces'
//! numbers of vertices (u32 each); positions of the points of the unloaded wall, m (3 f64 each); number of vertices of
//! each face (u32); vertices of the faces, one face after the other (u32). Then for each step: time, s (f64); wall
//! shear stress of each face, Pa (3 f32); displacement of each point, m (3 f32).

use crate::Vec3;
use crate::hemodynamics::{Wall, WallState};
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

const MAGIC: &[u8; 8] = b"FSIWALL\x01";
/// Bytes of one step beside its fields.
const STEP_HEAD: usize = 8;

/// Writes the file.
pub struct WallHistory {
    file: File,
}

impl WallHistory {
    /// Creates the file with its head.
    pub fn create(path: &Path, wall: &Wall) -> io::Result<Self> {
        let mut file = File::create(path)?;
        file.write_all(&head(wall))?;
        Ok(Self { file })
    }

    /// Opens the file of an earlier run to continue after its first `length` bytes; what follows them is cut off.
    pub fn resume(path: &Path, length: u64) -> io::Result<Self> {
        let file = File::options().append(true).open(path)?;
        file.set_len(length)?;
        Ok(Self { file })
    }

    /// Adds the end of a step.
    pub fn append(&mut self, state: &WallState) -> io::Result<()> {
        let values = state.shear.iter().chain(&state.displacement).flatten();
        let mut bytes = state.time.to_le_bytes().to_vec();
        bytes.extend(values.flat_map(|value| value.to_le_bytes()));
        self.file.write_all(&bytes)
    }

    /// Sees to it that all steps are on the disk.
    pub fn sync(&self) -> io::Result<()> {
        self.file.sync_data()
    }
}

fn head(wall: &Wall) -> Vec<u8> {
    let sizes = wall.faces.iter().map(|face| face.len() as u32);
    let counts = [wall.points.len() as u32, wall.faces.len() as u32];
    let whole = counts.into_iter().chain([sizes.clone().sum()]);
    let mut bytes = MAGIC.to_vec();
    bytes.extend(whole.flat_map(u32::to_le_bytes));
    let positions = wall.points.iter().flat_map(|x| [x.x, x.y, x.z]);
    bytes.extend(positions.flat_map(f64::to_le_bytes));
    let vertices = wall.faces.iter().flatten().copied();
    bytes.extend(sizes.chain(vertices).flat_map(u32::to_le_bytes));
    bytes
}

/// Reads the file, step by step.
pub struct WallHistoryReader {
    /// The unloaded wall.
    pub wall: Wall,
    file: BufReader<File>,
    steps: u64,
}

impl WallHistoryReader {
    /// Opens the file and reads its head.
    ///
    /// # Errors
    /// If it is not such a file.
    pub fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        let mut file = BufReader::with_capacity(1 << 18, file);
        let bad = |what: &str| {
            io::Error::new(
                io::ErrorKind::InvalidData,
                format!("{}: {what}", path.display()),
            )
        };
        if read::<8>(&mut file)? != *MAGIC {
            return Err(bad("not a history of the wall of this version"));
        }
        let mut counts = [0; 3];
        for count in &mut counts {
            *count = u64::from(u32::from_le_bytes(read(&mut file)?));
        }
        let [points, faces, vertices] = counts;
        let head = 20 + 24 * points + 4 * faces + 4 * vertices;
        if length < head {
            return Err(bad("its head is cut off"));
        }
        let number = |file: &mut BufReader<File>| io::Result::Ok(u32::from_le_bytes(read(file)?));
        let mut wall = Wall {
            points: Vec::new(),
            faces: Vec::new(),
        };
        for _ in 0..points {
            let mut x = Vec3::zeros();
            for c in x.iter_mut() {
                *c = f64::from_le_bytes(read(&mut file)?);
            }
            wall.points.push(x);
        }
        let sizes = (0..faces).map(|_| number(&mut file));
        let sizes = sizes.collect::<io::Result<Vec<u32>>>()?;
        if sizes.iter().map(|size| u64::from(*size)).sum::<u64>() != vertices {
            return Err(bad("its faces do not have the vertices that it announces"));
        }
        for size in sizes {
            let face = (0..size).map(|_| number(&mut file));
            let face = face.collect::<io::Result<Vec<u32>>>()?;
            if face.is_empty() || face.iter().any(|p| u64::from(*p) >= points) {
                return Err(bad("a face of it has points that do not exist"));
            }
            wall.faces.push(face);
        }
        let step = STEP_HEAD as u64 + 12 * (faces + points);
        Ok(Self {
            wall,
            file,
            steps: (length - head) / step,
        })
    }
}

impl Iterator for WallHistoryReader {
    type Item = io::Result<WallState>;

    /// The next step that is whole.
    fn next(&mut self) -> Option<Self::Item> {
        self.steps = self.steps.checked_sub(1)?;
        let (faces, points) = (self.wall.faces.len(), self.wall.points.len());
        let mut bytes = vec![0; STEP_HEAD + 12 * (faces + points)];
        if let Err(error) = self.file.read_exact(&mut bytes) {
            return Some(Err(error));
        }
        let (time, fields) = bytes.split_at(STEP_HEAD);
        let mut time_bytes = [0; 8];
        time_bytes.copy_from_slice(time);
        let vector = |chunk: &[u8]| {
            let part =
                |i: usize| f32::from_le_bytes([chunk[i], chunk[i + 1], chunk[i + 2], chunk[i + 3]]);
            [part(0), part(4), part(8)]
        };
        let (shear, displacement) = fields.split_at(12 * faces);
        Some(Ok(WallState {
            time: f64::from_le_bytes(time_bytes),
            shear: shear.chunks_exact(12).map(vector).collect(),
            displacement: displacement.chunks_exact(12).map(vector).collect(),
        }))
    }
}

fn read<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    file.read_exact(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(n: usize) -> WallState {
        let v = |k: usize| Vec3::new(n as f64, k as f64, 0.1);
        WallState::new(0.002 * n as f64, &[v(0), v(1)], &[v(2), v(3), v(4), v(5)])
    }

    #[test]
    fn what_was_written_is_read_and_what_was_cut_off_is_continued() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wall.bin");
        let wall = Wall {
            points: (0..4).map(|k| Vec3::new(0.1, k as f64, 1.0)).collect(),
            faces: vec![vec![0, 1, 2], vec![0, 1, 2, 3]],
        };
        let mut history = WallHistory::create(&path, &wall).unwrap();
        (1..4).for_each(|n| history.append(&state(n)).unwrap());
        let length = std::fs::metadata(&path).unwrap().len();
        history.append(&state(9)).unwrap();
        let mut history = WallHistory::resume(&path, length).unwrap();
        history.append(&state(4)).unwrap();

        // A step that a dying driver left half written does not count.
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, [&bytes[..], &[7; 20]].concat()).unwrap();
        let reader = WallHistoryReader::open(&path).unwrap();
        assert_eq!(reader.wall, wall);
        let steps: Vec<WallState> = reader.map(Result::unwrap).collect();
        assert_eq!(steps, [1, 2, 3, 4].map(state));
    }

    #[test]
    fn foreign_and_damaged_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wall.bin");
        let wall = Wall {
            points: vec![Vec3::zeros(); 3],
            faces: vec![vec![0, 1, 2]],
        };
        let good = head(&wall);
        let mut wild = good.clone();
        let last = wild.len() - 1;
        wild[last] = 1;
        let mut huge = good.clone();
        huge[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        for bytes in [&b"FSIWALL\x02"[..], &good[..30], &wild, &huge, b"", b"no"] {
            std::fs::write(&path, bytes).unwrap();
            assert!(WallHistoryReader::open(&path).is_err());
        }
    }
}
