//! Reads a mesh from the files of a `polyMesh` folder, in OpenFOAM's ascii or binary format.

use super::is_a_place;
use super::poly_mesh::{Patch, PolyMesh};
use crate::Vec3;
use crate::files::{Fault, FileError, fault};
use std::fs;
use std::ops::Range;
use std::path::Path;

impl PolyMesh {
    /// Reads the mesh of the OpenFOAM case `case`, `constant/polyMesh`. Lengths are metres.
    ///
    /// # Errors
    /// The file that is missing or damaged, or in a format that is not read: compressed, or of other sizes of numbers
    /// than OpenFOAM's default on 64 bits.
    pub fn read(case: &Path) -> Result<Self, FileError> {
        let folder = case.join("constant/polyMesh");
        let numbers = |name: &str| -> Result<Vec<usize>, FileError> {
            let (mut file, path) = File::open(&folder, name)?;
            file.labels().map_err(|e| FileError::new(&path, e))
        };
        let (mut file, path) = File::open(&folder, "points")?;
        let points = file.points().map_err(|e| FileError::new(&path, e))?;
        let (mut file, path) = File::open(&folder, "faces")?;
        let faces = file.faces().map_err(|e| FileError::new(&path, e))?;
        check_faces(&faces, points.len()).map_err(|e| FileError::new(&path, e))?;
        let (owner, neighbour) = (numbers("owner")?, numbers("neighbour")?);
        if owner.len() != faces.len() || neighbour.len() > faces.len() {
            let reason = format!(
                "{} faces have {} owners and {} neighbours",
                faces.len(),
                owner.len(),
                neighbour.len()
            );
            return Err(FileError::new(&folder, reason));
        }
        check_cells(&owner, &neighbour).map_err(|e| FileError::new(&folder, e))?;
        let (mut file, path) = File::open(&folder, "boundary")?;
        let patches = file.patches().map_err(|e| FileError::new(&path, e))?;
        check_patches(&patches, neighbour.len()..faces.len())
            .map_err(|e| FileError::new(&path, e))?;
        Ok(Self {
            points,
            faces,
            owner,
            neighbour,
            patches,
        })
    }
}

fn check_faces(faces: &[Vec<usize>], points: usize) -> Result<(), Fault> {
    if let Some(point) = faces.iter().flatten().find(|point| **point >= points) {
        return Err(fault!(
            "a face has the point {point}, but there are {points}"
        ));
    }
    match faces.iter().position(|face| face.len() < 3) {
        Some(face) => {
            let corners = faces[face].len();
            Err(fault!(
                "face {face} has {corners} points: expected three or more"
            ))
        }
        None => Ok(()),
    }
}

/// Each cell has at least four faces, between it and another one.
fn check_cells(owner: &[usize], neighbour: &[usize]) -> Result<(), Fault> {
    let sides = || owner.iter().chain(neighbour).copied();
    let cells = sides().max().map_or(0, |last| last.saturating_add(1));
    let few = |cell: &dyn std::fmt::Display, count: usize| {
        Err(fault!(
            "cell {cell} has {count} faces: expected four or more"
        ))
    };
    if cells > owner.len() {
        return few(
            &(cells - 1),
            sides().filter(|cell| *cell == cells - 1).count(),
        );
    }
    let mut counts = vec![0; cells];
    sides().for_each(|cell| counts[cell] += 1);
    if let Some(cell) = counts.iter().position(|count| *count < 4) {
        return few(&cell, counts[cell]);
    }
    match owner.iter().zip(neighbour).position(|(a, b)| a == b) {
        Some(face) => Err(fault!(
            "face {face} lies between cell {} and itself",
            owner[face]
        )),
        None => Ok(()),
    }
}

/// The patches are the faces of the boundary.
fn check_patches(patches: &[Patch], boundary: Range<usize>) -> Result<(), Fault> {
    let mut sum = 0_usize;
    for patch in patches.iter().filter(|patch| patch.size > 0) {
        let end = patch.start.saturating_add(patch.size);
        if patch.start < boundary.start || end > boundary.end {
            return Err(fault!(
                "the patch {} has the faces {} to {}: those of the boundary are {} to {}",
                patch.name,
                patch.start,
                end - 1,
                boundary.start,
                boundary.end - 1
            ));
        }
        sum = sum.saturating_add(patch.size);
    }
    match sum == boundary.len() {
        true => Ok(()),
        false => Err(fault!(
            "its patches have {sum} faces, and the boundary {}",
            boundary.len()
        )),
    }
}

/// The bytes of a file after its header, and how far they have been read.
struct File {
    bytes: Vec<u8>,
    at: usize,
    is_binary: bool,
}

impl File {
    fn open(folder: &Path, name: &str) -> Result<(Self, std::path::PathBuf), FileError> {
        let path = folder.join(name);
        let wrong = |reason: &dyn std::fmt::Display| FileError::new(&path, reason);
        if !path.exists() && folder.join(format!("{name}.gz")).exists() {
            return Err(wrong(&"it is compressed: unpack it with gunzip"));
        }
        let bytes = fs::read(&path).map_err(|e| wrong(&e))?;
        let mut file = Self {
            bytes,
            at: 0,
            is_binary: false,
        };
        file.header().map_err(|e| wrong(&e))?;
        Ok((file, path))
    }

    /// `FoamFile { … }`.
    fn header(&mut self) -> Result<(), Fault> {
        if self.word()? != "FoamFile" || self.word()? != "{" {
            return Err("it has no header: expected FoamFile { … } at the top".into());
        }
        loop {
            let key = self.word()?;
            if key == "}" {
                return Ok(());
            }
            let mut values = Vec::new();
            loop {
                match self.word()? {
                    end if end == ";" => break,
                    value => values.push(value),
                }
            }
            let value = values.join(" ");
            match key.as_str() {
                "format" => self.is_binary = value == "binary",
                "arch" if !value.contains("label=32") || !value.contains("scalar=64") => {
                    return Err(fault!(
                        "its numbers are {value}: expected label=32 and scalar=64, or the format ascii (foamFormatConvert)"
                    ));
                }
                _ => {}
            }
        }
    }

    /// Skips blanks and comments.
    fn skip(&mut self) {
        loop {
            let rest = &self.bytes[self.at..];
            let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
            let rest = &rest[blanks..];
            self.at += blanks;
            let end: &[u8] = match rest {
                [b'/', b'/', ..] => b"\n",
                [b'/', b'*', ..] => b"*/",
                _ => return,
            };
            let found = rest.windows(end.len()).skip(2).position(|w| w == end);
            self.at += found.map_or(rest.len(), |place| place + 2 + end.len());
        }
    }

    /// The next word, a text in quotes, or one of `{ } ( ) ;`.
    fn word(&mut self) -> Result<String, Fault> {
        self.skip();
        let rest = &self.bytes[self.at..];
        let is_single = |b: &u8| b"{}();".contains(b);
        let length = match rest.first() {
            None => return Err("it ends before it is complete".into()),
            Some(b'"') => {
                let end = rest[1..].iter().position(|b| *b == b'"');
                end.map_or(rest.len(), |end| end + 2)
            }
            Some(first) if is_single(first) => 1,
            Some(_) => rest
                .iter()
                .take_while(|b| !b.is_ascii_whitespace() && !is_single(b))
                .count(),
        };
        let word = String::from_utf8_lossy(&rest[..length]).into_owned();
        self.at += length;
        Ok(word)
    }

    fn number<T: std::str::FromStr>(&mut self) -> Result<T, Fault> {
        let word = self.word()?;
        let number = word.parse();
        number.map_err(|_| Fault::unexpected("a number", word))
    }

    fn expect(&mut self, expected: &str) -> Result<(), Fault> {
        match self.word()? {
            found if found == expected => Ok(()),
            found => Err(fault!("expected {expected:?}, found {found:?}")),
        }
    }

    /// `size` numbers of `N` bytes each in brackets, in a binary file.
    fn raw<const N: usize>(&mut self, size: usize) -> Result<Vec<[u8; N]>, Fault> {
        if size == 0 {
            // An empty list is written with its brackets, or without.
            self.skip();
            if self.bytes[self.at..].starts_with(b"(") {
                self.expect("(")?;
                self.expect(")")?;
            }
            return Ok(Vec::new());
        }
        self.expect("(")?;
        let rest = &self.bytes[self.at..];
        let bytes = size.checked_mul(N).and_then(|length| rest.get(..length));
        let bytes = bytes.ok_or("it ends before it is complete")?;
        let values = bytes.chunks_exact(N);
        let values = values.map(|chunk| chunk.try_into().expect("chunks have N bytes"));
        let values = values.collect();
        self.at += N * size;
        self.expect(")")?;
        Ok(values)
    }

    /// A list of whole numbers, none of them negative.
    fn labels(&mut self) -> Result<Vec<usize>, Fault> {
        let size: usize = self.number()?;
        if self.is_binary {
            let raw = self.raw::<4>(size)?.into_iter();
            let whole = |bytes| {
                usize::try_from(i32::from_le_bytes(bytes))
                    .map_err(|_| Fault::whole("a number is negative"))
            };
            return raw.map(whole).collect();
        }
        self.expect("(")?;
        let labels = (0..size).map(|_| self.number()).collect::<Result<_, _>>()?;
        self.expect(")")?;
        Ok(labels)
    }

    fn points(&mut self) -> Result<Vec<Vec3>, Fault> {
        let points = self.unchecked_points()?;
        match points.iter().position(|x| !is_a_place(x)) {
            Some(point) => {
                let x = points[point];
                Err(fault!(
                    "point {point} is at ({:e} {:e} {:e})",
                    x.x,
                    x.y,
                    x.z
                ))
            }
            None => Ok(points),
        }
    }

    fn unchecked_points(&mut self) -> Result<Vec<Vec3>, Fault> {
        let size: usize = self.number()?;
        if self.is_binary {
            let raw = self.raw::<24>(size)?.into_iter();
            let part = |bytes: &[u8; 24], i: usize| {
                f64::from_le_bytes(bytes[8 * i..8 * i + 8].try_into().expect("eight bytes"))
            };
            return Ok(raw
                .map(|bytes| Vec3::from_fn(|i, _| part(&bytes, i)))
                .collect());
        }
        self.expect("(")?;
        let mut points = Vec::with_capacity(size.min(self.bytes.len()));
        for _ in 0..size {
            self.expect("(")?;
            points.push(Vec3::new(self.number()?, self.number()?, self.number()?));
            self.expect(")")?;
        }
        self.expect(")")?;
        Ok(points)
    }

    /// In a binary file, where each face begins in one list of all their points, and that list.
    fn faces(&mut self) -> Result<Vec<Vec<usize>>, Fault> {
        if self.is_binary {
            let (starts, points) = (self.labels()?, self.labels()?);
            let face = |pair: &[usize]| points.get(pair[0]..pair[1]).map(<[usize]>::to_vec);
            let faces: Option<Vec<_>> = starts.windows(2).map(face).collect();
            return faces.ok_or("its faces do not fit their list of points".into());
        }
        let size: usize = self.number()?;
        self.expect("(")?;
        let mut faces = Vec::with_capacity(size.min(self.bytes.len()));
        for _ in 0..size {
            faces.push(self.labels()?);
        }
        self.expect(")")?;
        Ok(faces)
    }

    /// `N ( name { type …; nFaces …; startFace …; … } … )`, always ascii.
    fn patches(&mut self) -> Result<Vec<Patch>, Fault> {
        let size: usize = self.number()?;
        self.expect("(")?;
        let mut patches = Vec::new();
        for _ in 0..size {
            let mut patch = Patch {
                name: self.word()?,
                kind: String::new(),
                start: 0,
                size: 0,
            };
            self.expect("{")?;
            loop {
                match self.word()?.as_str() {
                    "}" => break,
                    "type" => patch.kind = self.word()?,
                    "nFaces" => patch.size = self.number()?,
                    "startFace" => patch.start = self.number()?,
                    _ => while self.word()? != ";" {},
                }
                self.skip();
                if self.bytes[self.at..].starts_with(b";") {
                    self.at += 1;
                }
            }
            patches.push(patch);
        }
        Ok(patches)
    }
}

#[cfg(test)]
mod tests {
    use crate::geometry::PolyMesh;

    /// A mesh that was written is read as it was.
    #[test]
    fn a_written_mesh_is_read_back_to_the_bit() {
        let case = crate::case::Case::load(
            concat!(env!("CARGO_MANIFEST_DIR"), "/openfoam-case/turek-hron").as_ref(),
            crate::case::Preset::Paper,
            &[],
        );
        let case = case.unwrap();
        let mesh = crate::geometry::flag::fluid_mesh(case.flag().unwrap());
        let folder = tempfile::tempdir().unwrap();
        mesh.write(folder.path()).unwrap();
        assert_eq!(PolyMesh::read(folder.path()).unwrap(), mesh);
        let path = folder.path().join("constant/polyMesh/faces");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        let error = PolyMesh::read(folder.path()).unwrap_err().to_string();
        assert!(error.contains("polyMesh/faces: it ends before"), "{error}");
    }
}
