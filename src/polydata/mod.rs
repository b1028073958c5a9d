//! Points, lines and triangles from files that other programs write.

mod stl;
mod surface;
mod vtp;

pub use surface::{Crossing, Surface};

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

/// Far larger than what is segmented of a vessel.
const MOST_BYTES: u64 = 1 << 30;

/// Points with lines, triangles and numbers, in the unit of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PolyData {
    /// Positions.
    pub points: Vec<[f64; 3]>,
    /// Numbers of the points of each line.
    pub lines: Vec<Vec<usize>>,
    /// Numbers of the points of each triangle; polygons with more corners are cut into triangles.
    pub triangles: Vec<[usize; 3]>,
    /// Arrays with one number a point, by name.
    pub of_points: BTreeMap<String, Vec<f64>>,
    /// Arrays with one number a line, by name.
    pub of_lines: BTreeMap<String, Vec<f64>>,
}

impl PolyData {
    /// Reads a file by its ending: `.vtp` (VTK's polydata in XML: ASCII, base64 or raw, compressed by zlib or not) or `.stl`
    /// (ASCII or binary).
    ///
    /// # Errors
    /// What is wrong with the file, in a sentence.
    pub fn read(path: &Path) -> Result<Self, String> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let reader: fn(&[u8]) -> Result<Self, String> = match ending.as_deref() {
            Some("vtp") => vtp::read,
            Some("stl") => stl::read,
            _ => return Err("expected a file that ends with .vtp or .stl".into()),
        };
        let data = reader(&bytes(path)?)?;
        match data
            .points
            .iter()
            .position(|p| p.iter().any(|x| !x.is_finite()))
        {
            Some(i) => Err(format!(
                "point {} of {} has a coordinate that is not a finite number",
                i + 1,
                data.points.len()
            )),
            None => Ok(data),
        }
    }
}

/// The whole file, if it is a regular one.
fn bytes(path: &Path) -> Result<Vec<u8>, String> {
    let kind = fs::metadata(path)
        .map_err(|error| error.to_string())?
        .file_type();
    if !kind.is_file() {
        return Err("this is a folder, a device or a pipe, not a file".into());
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|error| error.to_string())?;
    file.take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| error.to_string())?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(format!(
            "larger than {} MiB: this cannot be the right file",
            MOST_BYTES >> 20
        ));
    }
    Ok(bytes)
}
