//! Good files of every kind that is read, damaged at random: each is read, or refused in words. None ends in a panic.
//!
//! `MUTATIONS=5000 cargo test --release --test library damaged_files` looks longer than the tests do.

use crate::file_support::copy;
use fsi_driver::case::{Case, Preset};
use fsi_driver::geometry::{PolyMesh, WallFile};
use fsi_driver::polydata::PolyData;
use fsi_driver::simulation::assembly::preflight;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

/// Numbers that are out of every range, or none at all.
const ODD: [&str; 14] = [
    "-1",
    "0",
    "1",
    "2",
    "4294967296",
    "99999999999",
    "9223372036854775808",
    "18446744073709551615",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "",
];

/// Numbers that look random and are the same each time (Knuth's MMIX).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = (self.0.wrapping_mul(6364136223846793005)).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % limit.max(1)
    }

    fn range(&mut self, length: usize) -> std::ops::Range<usize> {
        let from = self.below(length);
        from..(from + 1 + self.below(40)).min(length)
    }

    /// Damages a file in one of the ways in which files are damaged.
    fn damage(&mut self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let length = bytes.len();
        match self.below(7) {
            0 => bytes.truncate(self.below(length)),
            1 => drop(bytes.drain(self.range(length))),
            2 => {
                let (part, at) = (bytes[self.range(length)].to_vec(), self.below(length));
                drop(bytes.splice(at..at, part));
            }
            3 => bytes[self.below(length)] = self.below(256) as u8,
            4 => bytes[self.below(length)] = b"0123456789-+.eE(){}[];\"#$/ \n,"[self.below(29)],
            _ => {
                // A number becomes another one.
                let from = self.below(length);
                let digit = |b: &u8| b.is_ascii_digit();
                let start = bytes[from..].iter().position(digit).map(|at| from + at);
                if let Some(start) = start {
                    let count = bytes[start..].iter().take_while(|b| digit(b)).count();
                    let odd = ODD[self.below(ODD.len())].bytes();
                    drop(bytes.splice(start..start + count, odd));
                }
            }
        }
    }
}

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// Reads a file with `read` after each of many ways to damage it. Both, files that are read and files that are refused,
/// occur.
fn survives(file: &Path, share: usize, read: impl Fn() -> Result<(), String>) {
    let good = fs::read(file).unwrap();
    read().unwrap_or_else(|reason| panic!("{} as it was: {reason}", file.display()));
    let count = std::env::var("MUTATIONS").map_or(40, |count| count.parse().unwrap());
    let mut refused = 0;
    for seed in 0..(count / share).max(5) {
        let mut random = Random(1 + seed as u64);
        let mut bytes = good.clone();
        (0..=random.below(3)).for_each(|_| random.damage(&mut bytes));
        fs::write(file, &bytes).unwrap();
        match catch_unwind(AssertUnwindSafe(&read)) {
            Ok(Ok(())) => {}
            Ok(Err(reason)) => {
                assert!(!reason.is_empty());
                refused += 1;
            }
            Err(_) => {
                let kept = std::env::temp_dir().join(format!(
                    "panic-{seed}-{}",
                    file.file_name().unwrap().display()
                ));
                fs::write(&kept, &bytes).unwrap();
                panic!("{} panics, seed {seed}: {}", file.display(), kept.display());
            }
        }
    }
    fs::write(file, good).unwrap();
    assert!(refused > 0, "{}: nothing was refused", file.display());
}

/// Everything that `check` and a run look at before a solver starts.
fn looked_at(case: &Path) -> Result<(), String> {
    let case = Case::load(case, Preset::Paper, &[]).map_err(|e| e.to_string())?;
    preflight::check(&case).map_err(|e| e.to_string())
}

/// A user-supplied case with 27 cells, rigid or with an elastic wall.
fn own_case(folder: &Path, wall: &str) -> PathBuf {
    let case = folder.join("case");
    copy(&project().join("tests/data/last-cell-inside"), &case);
    let file = case.join("case.toml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replace("mode = \"rigid\"\n", wall)).unwrap();
    case
}

#[test]
fn openfoam_meshes_and_dictionaries() {
    let folder = tempfile::tempdir().unwrap();
    let case = own_case(folder.path(), "mode = \"rigid\"\n");
    for name in ["points", "faces", "owner", "neighbour", "boundary"] {
        let file = case.join("fluid/constant/polyMesh").join(name);
        survives(&file, 1, || looked_at(&case));
    }
    for name in ["0/U", "0/p", "system/fvSolution", "system/controlDict"] {
        let file = case.join("fluid").join(name);
        let good = fs::read(&file).unwrap();
        for seed in 0..20 {
            let mut bytes = good.clone();
            Random(seed).damage(&mut bytes);
            fs::write(&file, bytes).unwrap();
            // What is damaged may be left for OpenFOAM to refuse.
            drop(looked_at(&case));
        }
        fs::write(&file, good).unwrap();
    }
}

#[test]
fn openfoam_meshes_with_an_elastic_wall() {
    let folder = tempfile::tempdir().unwrap();
    let wall = "extrude = { layers = [\"wall\"], thicknesses_m = [0.0005], axis = \"mesh\" }\n\
                material = [{ name = \"wall\", material = \"saint_venant_kirchhoff\", youngs_modulus_Pa = 1.0e6, poisson_ratio = 0.3 }]\n\
                support = [{ support = \"clamped\", surfaces = [\"inlet\"] }]\n";
    let case = own_case(folder.path(), wall);
    for name in ["points", "faces", "owner", "boundary"] {
        let file = case.join("fluid/constant/polyMesh").join(name);
        survives(&file, 4, || looked_at(&case));
    }
}

#[test]
fn binary_openfoam_meshes() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = PolyMesh::read(&project().join("tests/data/last-cell-inside/fluid")).unwrap();
    let case = folder.path().join("constant/polyMesh");
    mesh.write(folder.path()).unwrap();
    let head = |name: &str, class: &str| {
        format!(
            "FoamFile\n{{\nversion 2.0;\nformat binary;\narch \"LSB;label=32;scalar=64\";\nclass {class};\nobject {name};\n}}\n"
        )
    };
    let list = |numbers: &mut dyn Iterator<Item = usize>| {
        let numbers: Vec<usize> = numbers.collect();
        let bytes = numbers.iter().flat_map(|n| (*n as i32).to_le_bytes());
        let count = format!("{}\n(", numbers.len()).into_bytes();
        count
            .into_iter()
            .chain(bytes)
            .chain(*b")\n")
            .collect::<Vec<u8>>()
    };
    let starts = mesh.faces.iter().scan(0, |at, face| {
        *at += face.len();
        Some(*at)
    });
    let mut starts = [0].into_iter().chain(starts);
    let faces = [
        list(&mut starts),
        list(&mut mesh.faces.iter().flatten().copied()),
    ]
    .concat();
    let points = mesh.points.iter().flat_map(|x| [x.x, x.y, x.z]);
    let points = points.flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    let points = [
        format!("{}\n(", mesh.points.len()).as_bytes(),
        &points,
        b")\n",
    ]
    .concat();
    for (name, class, bytes) in [
        ("points", "vectorField", points),
        ("faces", "faceCompactList", faces),
        ("owner", "labelList", list(&mut mesh.owner.iter().copied())),
        (
            "neighbour",
            "labelList",
            list(&mut mesh.neighbour.iter().copied()),
        ),
    ] {
        fs::write(
            case.join(name),
            [head(name, class).as_bytes(), &bytes].concat(),
        )
        .unwrap();
        assert_eq!(PolyMesh::read(folder.path()).unwrap(), mesh);
    }
    for name in ["points", "faces", "owner", "neighbour"] {
        survives(&case.join(name), 1, || {
            let mesh = PolyMesh::read(folder.path()).map_err(|e| e.to_string())?;
            assert_eq!(mesh.cell_geometry().len(), mesh.cells());
            Ok(())
        });
    }
}

#[test]
fn meshes_of_walls() {
    let folder = tempfile::tempdir().unwrap();
    for name in [
        "block1.msh",
        "block2.msh",
        "block20.msh",
        "block8.inp",
        "block20.inp",
        "block1.vtu",
        "block2.vtu",
        "block20.vtu",
    ] {
        let file = folder.path().join(name);
        fs::copy(project().join("tests/data/walls").join(name), &file).unwrap();
        survives(&file, 1, || {
            let wall = WallFile::read(&file).map_err(|e| e.to_string())?;
            wall.mesh(1.0, &[], |_| Ok(0))
                .map(drop)
                .map_err(|e| e.to_string())
        });
    }
}

#[test]
fn lines_and_surfaces() {
    let folder = tempfile::tempdir().unwrap();
    let files = fs::read_dir(project().join("tests/library/vessel_files")).unwrap();
    let files = files.map(|entry| entry.unwrap().path());
    for from in files.filter(|file| file.extension().is_some_and(|end| end == "vtp")) {
        let file = folder.path().join(from.file_name().unwrap());
        fs::copy(from, &file).unwrap();
        survives(&file, 1, || {
            PolyData::read(&file).map(drop).map_err(|e| e.to_string())
        });
    }
    for name in ["curved", "surface"] {
        let case = folder.path().join(name);
        copy(&project().join("examples/vessels").join(name), &case);
        let read = || {
            Case::load(&case, Preset::Demo, &[])
                .map(drop)
                .map_err(|e| e.to_string())
        };
        survives(&case.join("centre-line.csv"), 4, read);
    }
}
