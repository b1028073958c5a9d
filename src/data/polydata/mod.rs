//! Points, lines and triangles from files that other programs write.

mod legacy;
mod obj;
mod ply;
mod search;
mod stl;
mod surface;
mod vtp;

/// A surface may end, or be closed, so many radii before a centre-line within it does.
pub const OVERLAP: f64 = 1.5;

pub use search::{RayHit, SurfaceSearch};
pub use surface::{Crossing, OpenEdge, Surface};
pub use vtp::Grid;

use crate::files;
use crate::files::{Fault, fault};
use std::collections::BTreeMap;
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
    /// Arrays with one number a point, by name; components of `CenterlineId` as `CenterlineId:0`, ….
    pub of_points: BTreeMap<String, Vec<f64>>,
    /// Arrays with one number a line, by name.
    pub of_lines: BTreeMap<String, Vec<f64>>,
}

impl PolyData {
    /// Reads a file by its ending: `.vtp` (VTK's polydata in XML: ASCII, base64 or raw, compressed by zlib or not),
    /// `.vtk` (the same in VTK's old format), `.stl` (ASCII or binary), `.ply` or `.obj`.
    ///
    /// # Errors
    /// What is wrong with the file, in a sentence.
    pub fn read(path: &Path) -> Result<Self, Fault> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let reader: fn(&[u8]) -> Result<Self, Fault> = match ending.as_deref() {
            Some("vtp") => vtp::read,
            Some("vtk") => legacy::read,
            Some("stl") => stl::read,
            Some("ply") => ply::read,
            Some("obj") => obj::read,
            _ => {
                return Err(
                    "expected a file that ends with .vtp or .stl (or .vtk, .ply, .obj)".into(),
                );
            }
        };
        let bytes = files::read_regular(path, MOST_BYTES).map_err(|error| error.to_string())?;
        if bytes.is_empty() {
            return Err("the file is empty".into());
        }
        let data = reader(&bytes)?;
        match data
            .points
            .iter()
            .position(|p| p.iter().any(|x| !x.is_finite()))
        {
            Some(i) => Err(fault!(
                "point {} of {} has a coordinate that is not a finite number",
                i + 1,
                data.points.len()
            )),
            None => Ok(data),
        }
    }

    /// Adds a polygon as triangles.
    ///
    /// # Errors
    /// If it has a point that there is not.
    fn add_polygon(&mut self, corners: &[usize]) -> Result<(), Fault> {
        let count = self.points.len();
        if let Some(corner) = corners.iter().find(|corner| **corner >= count) {
            return Err(fault!(
                "a polygon has the point {corner}, counted from 0, and there are {count}"
            ));
        }
        let others = 1..corners.len().saturating_sub(1);
        self.triangles
            .extend(others.map(|i| [corners[0], corners[i], corners[i + 1]]));
        Ok(())
    }
}
