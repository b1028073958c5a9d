//! The wall's measures over the window: `wall-shear.csv` and `wall-shear.pvd`.

use super::vtu::{Cells, Grid, Series, Values};
use super::write_atomically;
use crate::hemodynamics::WetSurface;
use crate::hemodynamics::summary::WallFields;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::Path;

/// A row of `wall-shear.csv`: a face. Field names are the headers: they carry the unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct FaceRow {
    /// Centre of the unloaded face along the axis.
    pub x_m: f64,
    /// Around the axis, from +y towards +z.
    pub phi_deg: f64,
    /// Distance of the mean position from the centre of its cross-section.
    pub mean_radius_m: f64,
    /// Area at the mean position.
    pub area_m2: f64,
    /// Time-averaged wall shear stress.
    pub TAWSS_Pa: f64,
    /// Oscillating shear index.
    pub OSI: f64,
    /// Relative residence time.
    pub RRT_1_Pa: f64,
    /// Mean wall shear stress along x.
    pub mean_shear_x_Pa: f64,
    /// Mean wall shear stress along y.
    pub mean_shear_y_Pa: f64,
    /// Mean wall shear stress along z.
    pub mean_shear_z_Pa: f64,
}

/// A row for each face.
pub fn rows(wall: &WetSurface, fields: &WallFields) -> Vec<FaceRow> {
    let row = |(face, radius): (usize, f64)| {
        let shear = fields.mean_shear[face];
        FaceRow {
            x_m: fields.places[face].x_m,
            phi_deg: fields.places[face].phi_deg,
            mean_radius_m: radius,
            area_m2: fields.areas[face],
            TAWSS_Pa: fields.time_averaged[face],
            OSI: fields.oscillating[face],
            RRT_1_Pa: fields.residence[face],
            mean_shear_x_Pa: shear.x,
            mean_shear_y_Pa: shear.y,
            mean_shear_z_Pa: shear.z,
        }
    };
    let radii = wall.radii(&fields.positions).into_iter();
    radii.enumerate().map(row).collect()
}

/// Writes the table as a whole.
pub fn write_table(path: &Path, rows: &[FaceRow]) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(io::Error::other)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|e| io::Error::other(e.to_string()))?;
    write_atomically(path, &bytes)
}

/// Writes the wall at its mean position with the fields, as the one time `time` (s) of a series at `path`.
pub fn write_series(
    path: &Path,
    time: f64,
    wall: &WetSurface,
    fields: &WallFields,
) -> io::Result<()> {
    let place = |of: fn(&crate::hemodynamics::Place) -> f64| -> Vec<f64> {
        fields.places.iter().map(of).collect()
    };
    let (x, phi) = (place(|p| p.x_m), place(|p| p.phi_deg));
    let pairs = fields.positions.iter().zip(&wall.points);
    let moved: Vec<_> = pairs.map(|(now, rest)| now - rest).collect();
    let grid = Grid {
        points: &fields.positions,
        cells: Cells::Polygons(&wall.faces),
        point_data: vec![("mean_displacement_m", Values::Vectors(&moved))],
        cell_data: vec![
            ("TAWSS_Pa", Values::Scalars(&fields.time_averaged)),
            ("OSI", Values::Scalars(&fields.oscillating)),
            ("RRT_1_Pa", Values::Scalars(&fields.residence)),
            ("mean_wall_shear_Pa", Values::Vectors(&fields.mean_shear)),
            ("x_m", Values::Scalars(&x)),
            ("phi_deg", Values::Scalars(&phi)),
        ],
    };
    Series::resume(path.to_owned(), Vec::new())?.add(time, &grid)
}
