//! `wall.bin`: wall shear stress and displacement of the wet surface at every step, in a compact binary file.
//!
//! Little-endian, without padding but for the end of the head. The head, with P points, F faces and V vertices of all
//! faces together:
//!
//! | byte | type | meaning |
//! | --- | --- | --- |
//! | 0 | 8 bytes | `FSIWALL` and the version, 2 |
//! | 8 | 4 u32 | P, F, V, and H: where the first record begins |
//! | 24 | 3 P f64 | positions of the points of the unloaded wall, m |
//! | | F u32 | number of vertices of each face |
//! | | V u32 | vertices of the faces, one face after the other, as numbers of points from 0 |
//! | | | zeros, so that H is a multiple of 8 |
//! | H - 4 | u32 | CRC-32 (as of zip and PNG) of all bytes before it |
//!
//! Then a record for each step; `numpy` reads all of them:
//!
//! ```python
//! P, F, V, H = numpy.fromfile("wall.bin", "<u4", 4, offset=8)
//! step = [("time_s", "<f8"), ("number", "<u4"), ("wall_shear_Pa", "<f4", (F, 3)), ("displacement_m", "<f4", (P, 3)),
//!         ("checksum", "<u4")]
//! steps = numpy.fromfile("wall.bin", step, offset=H)
//! ```
//!
//! Records are numbered from 0, and each ends with the CRC-32 of its bytes before. Wall shear stress is that of each
//! face, displacement that of each point. `src/python/fsi_driver/results.py` reads the file and checks it.

use crate::Vec3;
use crate::files::named;
use crate::hemodynamics::{WallState, WetSurface};
use std::fs::File;
use std::io::{self, BufReader, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 7] = b"FSIWALL";
const VERSION: u8 = 2;
/// Magic, version and counts.
const BEGIN: usize = 24;
/// Bytes of a record in addition to its fields: time, number, checksum.
const BESIDE_FIELDS: usize = 8 + 4 + 4;

/// Why a file is not a history of the wall.
#[derive(Debug, thiserror::Error)]
pub enum WallHistoryError {
    /// The system refused.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Another file, or one of another version.
    #[error("{} cannot be used: {what}", path.display())]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is, and what to do.
        what: String,
    },
    /// Bytes are missing or have changed.
    #[error(
        "{} is damaged: {what}; restore it from a copy, or compute the run again",
        path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        what: String,
    },
}

impl From<WallHistoryError> for io::Error {
    fn from(error: WallHistoryError) -> Self {
        Self::other(error)
    }
}

/// Writes the file.
pub struct WallHistory {
    path: PathBuf,
    file: File,
    /// Number of the next record.
    number: u32,
}

impl WallHistory {
    /// Creates the file with its head.
    pub fn create(path: &Path, wall: &WetSurface) -> io::Result<Self> {
        let mut file = File::create(path).map_err(named(path))?;
        file.write_all(&head(wall)).map_err(named(path))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            number: 0,
        })
    }

    /// Opens the file of an earlier run to continue after its first `length` bytes; what follows them is cut off.
    /// Nothing is left to continue if `length` is 0: then the file starts again.
    pub fn resume(path: &Path, wall: &WetSurface, length: u64) -> io::Result<Self> {
        if length == 0 {
            return Self::create(path, wall);
        }
        let steps = length.saturating_sub(head(wall).len() as u64) / record_length(wall);
        let file = File::options().append(true).open(path);
        let file = file.map_err(named(path))?;
        file.set_len(length).map_err(named(path))?;
        let number = u32::try_from(steps).map_err(io::Error::other)?;
        Ok(Self {
            path: path.to_owned(),
            file,
            number,
        })
    }

    /// Adds the end of a step.
    pub fn append(&mut self, state: &WallState) -> io::Result<()> {
        let record = record(state, self.number);
        self.file.write_all(&record).map_err(named(&self.path))?;
        self.number += 1;
        Ok(())
    }

    /// Sees to it that all steps are on the disk; returns the length of the file.
    pub fn sync(&self) -> io::Result<u64> {
        let length = || self.file.sync_data().and_then(|()| self.file.metadata());
        length().map(|it| it.len()).map_err(named(&self.path))
    }
}

fn head(wall: &WetSurface) -> Vec<u8> {
    let sizes = wall.faces.iter().map(|face| face.len() as u32);
    let (points, faces, vertices) = (wall.points.len(), wall.faces.len(), sizes.clone().sum());
    let length = head_length([points as u64, faces as u64, u64::from(vertices)]) as usize;
    let mut bytes = MAGIC.to_vec();
    bytes.push(VERSION);
    let counts = [points as u32, faces as u32, vertices, length as u32];
    bytes.extend(counts.into_iter().flat_map(u32::to_le_bytes));
    let positions = wall.points.iter().flat_map(|x| [x.x, x.y, x.z]);
    bytes.extend(positions.flat_map(f64::to_le_bytes));
    let vertices = wall.faces.iter().flatten().copied();
    bytes.extend(sizes.chain(vertices).flat_map(u32::to_le_bytes));
    bytes.resize(length - 4, 0);
    with_checksum(bytes)
}

fn head_length([points, faces, vertices]: [u64; 3]) -> u64 {
    (BEGIN as u64 + 24 * points + 4 * faces + 4 * vertices + 4).next_multiple_of(8)
}

fn record_length(wall: &WetSurface) -> u64 {
    BESIDE_FIELDS as u64 + 12 * (wall.faces.len() + wall.points.len()) as u64
}

fn record(state: &WallState, number: u32) -> Vec<u8> {
    let values = state.shear.iter().chain(&state.displacement).flatten();
    let mut bytes = state.time.to_le_bytes().to_vec();
    bytes.extend(number.to_le_bytes());
    bytes.extend(values.flat_map(|value| value.to_le_bytes()));
    with_checksum(bytes)
}

fn with_checksum(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    bytes
}

/// The bytes before the checksum, if that is right.
fn checked(bytes: &[u8]) -> Option<&[u8]> {
    let (contents, checksum) = bytes.split_last_chunk()?;
    (crc32fast::hash(contents) == u32::from_le_bytes(*checksum)).then_some(contents)
}

/// Reads the file, step by step.
pub struct WallHistoryReader {
    /// The unloaded wall.
    pub wall: WetSurface,
    path: PathBuf,
    file: BufReader<File>,
    /// Bytes of the file, of its head, and of a record.
    length: u64,
    head: u64,
    record: u64,
    /// Records that were read.
    number: u64,
    /// Time of the last one, s.
    time: f64,
}

impl WallHistoryReader {
    /// Opens the file and reads its head.
    ///
    /// # Errors
    /// If it is not such a file, or its head is not what was written.
    pub fn open(path: &Path) -> Result<Self, WallHistoryError> {
        let io = |source| WallHistoryError::Io {
            path: path.to_owned(),
            source,
        };
        let file = File::open(path).map_err(io)?;
        let length = file.metadata().map_err(io)?.len();
        let mut file = BufReader::with_capacity(1 << 18, file);
        let damaged = |what: String| WallHistoryError::Damaged {
            path: path.to_owned(),
            what,
        };
        let mut begin = [0; BEGIN];
        match file.read_exact(&mut begin) {
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
                return Err(damaged(format!(
                    "it has {length} bytes, too few for its head"
                )));
            }
            read => read.map_err(io)?,
        }
        check_kind(path, &begin)?;
        let [points, faces, vertices, stated] = words(&begin[8..]).map(u64::from);
        let head = head_length([points, faces, vertices]);
        if stated != head || length < head {
            return Err(damaged(format!(
                "its head (bytes 0 to {}) has changed, or is cut off: {length} bytes in all",
                stated.max(BEGIN as u64)
            )));
        }
        let mut bytes = begin.to_vec();
        (&mut file)
            .take(head - BEGIN as u64)
            .read_to_end(&mut bytes)
            .map_err(io)?;
        let wall = checked(&bytes).and_then(|contents| {
            let counts = [points as usize, faces as usize];
            decode_wall(&contents[BEGIN..], counts)
        });
        let wall =
            wall.ok_or_else(|| damaged(format!("its head (bytes 0 to {head}) has changed")))?;
        Ok(Self {
            record: record_length(&wall),
            wall,
            path: path.to_owned(),
            file,
            length,
            head,
            number: 0,
            time: 0.0,
        })
    }

    /// Bytes that were read.
    fn offset(&self) -> u64 {
        self.head + self.number * self.record
    }

    /// The error that the file ends before the step at `time` (s).
    pub fn ends_before(&self, time: f64) -> WallHistoryError {
        let (number, reached, offset) = (self.number, self.time, self.offset());
        self.damaged(format!(
            "its {number} whole records end at byte {offset} (t = {reached} s), but history.csv has a step at t = {time} s"
        ))
    }

    fn damaged(&self, what: String) -> WallHistoryError {
        WallHistoryError::Damaged {
            path: self.path.clone(),
            what,
        }
    }

    /// A flaw of the record that is being read.
    fn flaw(&self, what: &str) -> WallHistoryError {
        let (from, to) = (self.offset(), self.offset() + self.record);
        self.damaged(format!(
            "record {} (bytes {from} to {to}), after t = {} s: {what}",
            self.number, self.time
        ))
    }

    fn read(&mut self) -> Result<WallState, WallHistoryError> {
        let mut bytes = vec![0; self.record as usize];
        if let Err(source) = self.file.read_exact(&mut bytes) {
            let path = self.path.clone();
            return Err(WallHistoryError::Io { path, source });
        }
        let Some(contents) = checked(&bytes) else {
            return Err(self.flaw("its checksum is wrong"));
        };
        let time = f64::from_le_bytes(*contents.first_chunk().expect("a record has a time"));
        let [number] = words(&contents[8..]);
        let values: Vec<[f32; 3]> = contents[12..].chunks_exact(12).map(vector).collect();
        if u64::from(number) != self.number {
            return Err(self.flaw(&format!("it is number {number}")));
        }
        let is_next = time.is_finite() && (self.number == 0 || time > self.time);
        if !is_next || !values.as_flattened().iter().all(|c| c.is_finite()) {
            return Err(self.flaw("it holds non-finite numbers, or a time that is not the next"));
        }
        let (shear, displacement) = values.split_at(self.wall.faces.len());
        (self.number, self.time) = (self.number + 1, time);
        Ok(WallState {
            time,
            shear: shear.to_vec(),
            displacement: displacement.to_vec(),
        })
    }
}

impl Iterator for WallHistoryReader {
    type Item = Result<WallState, WallHistoryError>;

    /// The next step; one at the end that is cut off does not count.
    fn next(&mut self) -> Option<Self::Item> {
        (self.offset() + self.record <= self.length).then(|| self.read())
    }
}

fn check_kind(path: &Path, begin: &[u8; BEGIN]) -> Result<(), WallHistoryError> {
    let foreign = |what: String| {
        let path = path.to_owned();
        Err(WallHistoryError::Foreign { path, what })
    };
    if &begin[..7] != MAGIC {
        return foreign("it is not a history of the wall".into());
    }
    match begin[7] {
        VERSION => Ok(()),
        version => foreign(format!(
            "its format is version {version}, this program reads version {VERSION}; evaluate it with the version of the program that wrote it"
        )),
    }
}

/// Points and faces from the bytes after the counts.
fn decode_wall(bytes: &[u8], [points, faces]: [usize; 2]) -> Option<WetSurface> {
    let (positions, rest) = bytes.split_at_checked(24 * points)?;
    let (sizes, mut rest) = rest.split_at_checked(4 * faces)?;
    let component = |chunk: &[u8]| f64::from_le_bytes(chunk.try_into().expect("eight bytes"));
    let components: Vec<f64> = positions.chunks_exact(8).map(component).collect();
    let points_of = components.chunks_exact(3);
    let points_of = points_of.map(|x| Vec3::new(x[0], x[1], x[2])).collect();
    let mut faces_of = Vec::with_capacity(faces);
    for size in sizes.chunks_exact(4) {
        let [size] = words(size);
        let (face, others) = rest.split_at_checked(4 * size as usize)?;
        let face: Vec<u32> = face.chunks_exact(4).map(|w| words::<1>(w)[0]).collect();
        if face.is_empty() || face.iter().any(|p| *p as usize >= points) {
            return None;
        }
        faces_of.push(face);
        rest = others;
    }
    Some(WetSurface::new(points_of, faces_of))
}

/// The first N numbers.
fn words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    std::array::from_fn(|i| {
        let word = &bytes[4 * i..4 * i + 4];
        u32::from_le_bytes(word.try_into().expect("four bytes"))
    })
}

fn vector(bytes: &[u8]) -> [f32; 3] {
    words(bytes).map(f32::from_bits)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall() -> WetSurface {
        let points = (0..4).map(|k| Vec3::new(0.1, k as f64, 1.0)).collect();
        WetSurface::new(points, vec![vec![0, 1, 2], vec![0, 1, 2, 3]])
    }

    fn state(n: usize) -> WallState {
        let v = |k: usize| Vec3::new(n as f64, k as f64, 0.1);
        WallState::new(0.002 * n as f64, &[v(0), v(1)], &[v(2), v(3), v(4), v(5)])
    }

    /// The file with the steps 1, 2, …
    fn written(path: &Path, steps: usize) -> WallHistory {
        let mut history = WallHistory::create(path, &wall()).unwrap();
        (1..=steps).for_each(|n| history.append(&state(n)).unwrap());
        history
    }

    fn read(path: &Path) -> Result<Vec<WallState>, WallHistoryError> {
        WallHistoryReader::open(path)?.collect()
    }

    #[test]
    fn what_was_written_is_read_and_what_was_cut_off_is_continued() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wall.bin");
        let mut history = written(&path, 3);
        let length = std::fs::metadata(&path).unwrap().len();
        history.append(&state(9)).unwrap();
        let mut history = WallHistory::resume(&path, &wall(), length).unwrap();
        history.append(&state(4)).unwrap();

        // A step that a dying driver left half written does not count.
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, [&bytes[..], &[7; 20]].concat()).unwrap();
        assert_eq!(WallHistoryReader::open(&path).unwrap().wall, wall());
        assert_eq!(read(&path).unwrap(), [1, 2, 3, 4].map(state));

        WallHistory::resume(&path, &wall(), 0).unwrap();
        assert_eq!(read(&path).unwrap(), []);
    }

    /// Every bit of the file is flipped in turn: each is noticed, and its place is named.
    #[test]
    fn a_flipped_bit_is_found_wherever_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wall.bin");
        written(&path, 3);
        let good = std::fs::read(&path).unwrap();
        let (head, record) = (head(&wall()).len(), record(&state(1), 0).len());
        assert_eq!(good.len(), head + 3 * record);
        for bit in 0..8 * good.len() {
            let mut bytes = good.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            std::fs::write(&path, &bytes).unwrap();
            let error = read(&path).unwrap_err().to_string();
            if let Some(after) = (bit / 8).checked_sub(head) {
                let n = after / record;
                let (from, to) = (head + n * record, head + (n + 1) * record);
                let place = format!(
                    "record {n} (bytes {from} to {to}), after t = {} s",
                    0.002 * n as f64
                );
                assert!(error.contains(&place), "{error}");
            }
        }
    }

    #[test]
    fn missing_doubled_and_non_finite_records_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wall.bin");
        written(&path, 3);
        let good = std::fs::read(&path).unwrap();
        let (head, record) = (head(&wall()).len(), record(&state(1), 0).len());
        let at = |n: usize| &good[head + n * record..head + (n + 1) * record];
        let mut infinite = state(3);
        infinite.shear[1][2] = f32::INFINITY;
        let infinite = super::record(&infinite, 2);
        for records in [
            vec![at(0), at(2)],
            vec![at(0), at(0)],
            vec![at(0), at(1), &infinite],
        ] {
            std::fs::write(&path, [&good[..head], &records.concat()].concat()).unwrap();
            assert!(read(&path).is_err());
        }
    }

    #[test]
    fn foreign_and_cut_off_heads_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wall.bin");
        let good = head(&wall());
        let mut huge = good.clone();
        huge[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
        let cases: [(&[u8], &str); 6] = [
            (b"", "0 bytes"),
            (b"no", "2 bytes"),
            (&[b'a'; 100], "not a history of the wall"),
            (b"FSIWALL\x01................", "version 1"),
            (&good[..40], "cut off"),
            (&huge, "cut off"),
        ];
        for (bytes, expected) in cases {
            std::fs::write(&path, bytes).unwrap();
            let error = read(&path).unwrap_err().to_string();
            assert!(
                error.contains(expected) && error.contains("wall.bin"),
                "{error}"
            );
        }
    }
}
