//! The wall's measures over the window, `wall-shear.csv` and `wall-shear.pvd`, and over time,
//! `wall-shear-over-time.pvd`.

use super::vtu::{Cells, Values, VtuGrid, VtuSeries};
use super::wall_history::WallHistoryReader;
use super::write_atomically;
use crate::Vec3;
use crate::hemodynamics::WetSurface;
use crate::hemodynamics::summary::WallFields;
use crate::hemodynamics::wall::widened;
use crate::simulation::is_due;
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
    /// Centre of the unloaded face in space; not a number in tables of earlier versions.
    #[serde(default = "unknown")]
    pub centre_x_m: f64,
    /// As before, along y.
    #[serde(default = "unknown")]
    pub centre_y_m: f64,
    /// As before, along z.
    #[serde(default = "unknown")]
    pub centre_z_m: f64,
}

fn unknown() -> f64 {
    f64::NAN
}

/// A row for each face.
pub fn rows(wall: &WetSurface, fields: &WallFields) -> Vec<FaceRow> {
    let centres: Vec<Vec3> = wall.middles().collect();
    let row = |(face, radius): (usize, f64)| {
        let shear = fields.mean_shear[face];
        let centre = centres[face];
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
            centre_x_m: centre.x,
            centre_y_m: centre.y,
            centre_z_m: centre.z,
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
    let grid = VtuGrid {
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
    VtuSeries::resume(path.to_owned(), Vec::new())?.add(time, &grid)
}

/// Writes the wall of the steps of `time_step` (s) that end about every `interval` (s), from the file `history`, as a
/// series at `path`: where it is then, its displacement, and the wall shear stress.
pub fn write_over_time(
    path: &Path,
    history: &Path,
    [time_step, interval]: [f64; 2],
) -> io::Result<()> {
    let reader = WallHistoryReader::open(history)?;
    let wall = reader.wall.clone();
    let mut series = VtuSeries::new(path.to_owned())?;
    for state in reader {
        let state = state?;
        let step = (state.time / time_step).round();
        let is_whole = (state.time - step * time_step).abs() < 1e-3 * time_step;
        if !is_whole || step < 1.0 || !is_due(step as usize, time_step, interval) {
            continue;
        }
        let of = |values: &[[f32; 3]]| -> Vec<Vec3> { values.iter().map(widened).collect() };
        let (shear, moved) = (of(&state.shear), of(&state.displacement));
        let grid = VtuGrid {
            points: &wall.displaced(&state.displacement),
            cells: Cells::Polygons(&wall.faces),
            point_data: vec![("displacement_m", Values::Vectors(&moved))],
            cell_data: vec![("wall_shear_Pa", Values::Vectors(&shear))],
        };
        series.add(state.time, &grid)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hemodynamics::WallState;
    use crate::output::vtu;
    use crate::output::wall_history::WallHistory;

    #[test]
    fn the_wall_over_time_is_what_the_history_holds() {
        let folder = tempfile::tempdir().unwrap();
        let history = folder.path().join("wall.bin");
        let points: Vec<Vec3> = (0..4).map(|k| Vec3::new(0.1, f64::from(k), 1.0)).collect();
        let wall = WetSurface::new(points.clone(), vec![vec![0, 1, 2], vec![1, 2, 3]]);
        let mut written = WallHistory::create(&history, &wall).unwrap();
        // Steps of 2 ms, the third one in halves.
        let times = [0.002, 0.004, 0.005, 0.006, 0.008, 0.01];
        let at = |time: f64, k: usize| Vec3::new(64.0 * time, k as f64, 0.5);
        for time in times {
            let all = |n: usize| -> Vec<Vec3> { (0..n).map(|k| at(time, k)).collect() };
            let state = WallState::new(time, &all(2), &all(4));
            written.append(&state).unwrap();
        }
        drop(written);
        let path = folder.path().join("wall-shear-over-time.pvd");
        write_over_time(&path, &history, [0.002, 0.004]).unwrap();
        let entries = VtuSeries::read(&path).unwrap();
        let found: Vec<f64> = entries.iter().map(|(time, _)| *time).collect();
        assert_eq!(found, [0.004, 0.008]);
        for (time, file) in entries {
            let file = folder.path().join(file);
            let moved = vtu::read_vectors(&file, "displacement_m").unwrap();
            for (k, (x, u)) in moved.iter().enumerate() {
                // Single precision.
                assert!((u - at(time, k)).norm() < 1e-6 && (x - points[k] - u).norm() < 1e-12);
            }
            let text = std::fs::read_to_string(&file).unwrap();
            assert!(text.contains("Name=\"wall_shear_Pa\" NumberOfComponents=\"3\""));
        }
    }
}
