//! A centre-line as it stands in a file.

use super::{LineFile, pth, swc, table, vtp};
use crate::LengthUnit;
use crate::files::{Fault, fault};
use std::path::Path;

/// Endings of files with tables of points.
const TABLES: [&str; 6] = ["csv", "txt", "dat", "tsv", "asc", "xyz"];

/// Whether a file is a table of points.
pub fn is_table(path: &Path) -> bool {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| TABLES.contains(&ending.as_str()))
}

impl LineFile {
    /// Reads the centre-line in `path`; of several the one that is called `branch`.
    ///
    /// # Errors
    /// What is wrong with the file, in a sentence.
    pub fn read(path: &Path, branch: Option<&str>) -> Result<Self, Fault> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let file = match (ending.as_deref(), branch) {
            (Some(end), Some(_)) if TABLES.contains(&end) => {
                Err("a table of points is one line: leave out vessel.branch".into())
            }
            (Some(end), None) if TABLES.contains(&end) => table::read(path),
            (Some("vtp" | "vtk"), _) => vtp::read(path, branch),
            (Some("swc"), _) => swc::read(path, branch),
            (Some("pth"), _) => pth::read(path),
            (Some("yml" | "yaml"), _) => Err(
                "a network of a one-dimensional code (openBF) has lengths and radii, but no coordinates: give a vessel of it by its \
                 radius and length (vessel.radius_m, [[vessel.piece]]), or its centre-line as .csv, .vtp or .swc"
                    .into(),
            ),
            _ => Err(
                "expected a file that ends with .csv, .vtp or .swc (or .txt, .dat, .vtk, .pth)"
                    .into(),
            ),
        }?;
        let radii = &file.line.radii;
        match radii.iter().position(|r| !(r.is_finite() && *r > 0.0)) {
            Some(i) => Err(fault!(
                "the radius of point {} is {:?}: expected one above 0",
                i + 1,
                radii[i]
            )),
            None => Ok(file),
        }
    }

    /// The size of the unit of its lengths, m: that which is given as `key`, which must be that of the file if it says
    /// one.
    ///
    /// # Errors
    /// If they differ.
    pub fn metres(&self, given: LengthUnit, key: &str) -> Result<f64, Fault> {
        match self.length_unit().filter(|own| *own != given) {
            None => Ok(given.metres()),
            Some(own) => Err(fault!(
                "its header says {own}, and {given} was given ({key}): correct one of them"
            )),
        }
    }

    fn length_unit(&self) -> Option<LengthUnit> {
        let own = self.unit?;
        let mut known = LengthUnit::ALL.into_iter();
        known.find(|known| (known.metres() / own - 1.0).abs() < 1e-9)
    }
}

/// What a file with a centre-line says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct LineReading {
    /// The unit of its lengths, if it says one.
    pub unit: Option<LengthUnit>,
    /// What was understood: rows or points, columns, radii, in words.
    pub understood: String,
}

impl LineReading {
    /// Looks into the file `path`; of several lines into the one that is called `branch`.
    ///
    /// # Errors
    /// What is wrong with the file, in a sentence.
    pub fn of(path: &Path, branch: Option<&str>) -> Result<Self, Fault> {
        let file = LineFile::read(path, branch)?;
        Ok(Self {
            unit: file.length_unit(),
            understood: file.understood,
        })
    }
}
