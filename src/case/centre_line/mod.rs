//! Centre-lines from files that people have.

mod csv;

use super::vessel::MOST_POINTS;
use super::{LengthUnit, VesselDescription};
use std::path::Path;

/// Points of a centre-line, and the radius of the lumen at each if the file knows it, in its own unit.
#[derive(Debug, Clone, Default, PartialEq)]
struct CentreLine {
    points: Vec<[f64; 3]>,
    radii: Vec<f64>,
}

/// Reads the centre-line in `path` into the points and radii (m) of a vessel.
///
/// # Errors
/// What is wrong with the file, in a sentence.
fn read_into(vessel: &mut VesselDescription, path: &Path, unit: LengthUnit) -> Result<(), String> {
    let ending = path
        .extension()
        .map(|ending| ending.to_string_lossy().to_lowercase());
    let line = match ending.as_deref() {
        Some("csv" | "txt" | "dat") => csv::read(path),
        _ => Err("expected a file that ends with .csv".to_owned()),
    };
    let line = line.map_err(|reason| format!("{}: {reason}", path.display()))?;
    let count = line.points.len();
    if !(2..=MOST_POINTS).contains(&count) {
        return Err(format!(
            "{}: expected 2 to {MOST_POINTS} points, found {count}",
            path.display()
        ));
    }
    let metres = unit.metres();
    vessel.points = (line.points.iter())
        .map(|point| point.map(|x| metres * x))
        .collect();
    // A radius of the case counts more than those of the file.
    if vessel.radius.is_none() {
        vessel.radii = line.radii.iter().map(|radius| metres * radius).collect();
    }
    Ok(())
}

impl VesselDescription {
    /// Reads the file that it names, if it does: points and radii then stand in it.
    pub(super) fn read_file(&mut self) -> Result<(), (&'static str, String)> {
        let Some(path) = self.centre_line.clone() else {
            return Ok(());
        };
        let Some(unit) = self.unit else {
            let words: Vec<_> = LengthUnit::WORDS.iter().map(|(word, _)| *word).collect();
            return Err((
                "vessel.centre_line",
                format!(
                    "expected its unit of length beside it: vessel.unit = one of \"{}\"",
                    words.join("\", \"")
                ),
            ));
        };
        if !self.points.is_empty() {
            return Err((
                "vessel.centre_line",
                "the case has vessel.points_m as well: leave out one of the two".into(),
            ));
        }
        read_into(self, &path, unit).map_err(|reason| ("vessel.centre_line", reason))
    }
}
