//! Centre-lines from files that people have.

mod file;
mod pth;
mod smooth;
mod survey;
mod swc;
mod table;
mod tree;
mod vtp;

use super::vessel::MOST_POINTS;
use super::{LengthUnit, VesselDescription};
use crate::files::{Fault, fault};
pub use file::LineReading;
use std::path::Path;
pub use survey::LineSurvey;
pub use tree::{Apart, from_the_beginning, line_of_branch, lines_of_tree, smoothed};

/// Most branches that a message names.
const MOST_NAMED: usize = 8;

/// Points of a centre-line, and the radius of the lumen at each if the file knows it, in its own unit.
#[derive(Debug, Clone, Default, PartialEq)]
struct CentreLine {
    points: Vec<[f64; 3]>,
    radii: Vec<f64>,
}

/// A centre-line as it stands in a file.
#[derive(Debug, Default)]
struct LineFile {
    line: CentreLine,
    /// The unit that the file says (m), if it does.
    unit: Option<f64>,
    /// What was understood of the file, in words.
    understood: String,
}

impl CentreLine {
    /// As [`LineFile::read`], without what else the file says.
    fn read(path: &Path, branch: Option<&str>) -> Result<Self, Fault> {
        LineFile::read(path, branch).map(|file| file.line)
    }

    /// Without points that lie where the one before does.
    fn without_repeated(self) -> Self {
        let size = self
            .points
            .iter()
            .flatten()
            .fold(0.0f64, |most, x| most.max(x.abs()));
        let distance =
            |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max);
        let mut line = Self::default();
        for (i, point) in self.points.iter().enumerate() {
            if line
                .points
                .last()
                .is_none_or(|last| distance(*last, *point) > 1e-7 * size)
            {
                line.points.push(*point);
                line.radii.extend(self.radii.get(i));
            }
        }
        line
    }
}

/// The first of many, for a message.
pub fn listed(names: &[String], most: usize) -> String {
    let more = match names.len().saturating_sub(most) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    names[..names.len().min(most)].join(", ") + &more
}

impl VesselDescription {
    fn is_smoothed(&self) -> bool {
        self.smoothing.is_some() || self.least_bend.is_some()
    }

    /// Length of the waves that are halved; so short a one changes nothing.
    fn halved(&self) -> f64 {
        self.smoothing.unwrap_or(1e-9)
    }

    /// Smooths the points of the case itself, if they are to be.
    fn smooth_points(&mut self) {
        let fits = self.radii.is_empty() || self.radii.len() == self.points.len();
        if self.is_smoothed() && self.points.len() > 2 && fits {
            let line = CentreLine {
                points: std::mem::take(&mut self.points),
                radii: std::mem::take(&mut self.radii),
            };
            let line = (line.without_repeated()).smooth(self.halved(), self.least_bend);
            (self.points, self.radii) = (line.points, line.radii);
        }
    }

    /// Reads the file of the centre-line, if the case names one, and smooths the line, if it is to be: points and radii
    /// then stand in it.
    ///
    /// # Errors
    /// The key to blame, and what is wrong.
    pub(super) fn read_file(&mut self) -> Result<(), (&'static str, String)> {
        let key = "vessel.centre_line";
        let Some(path) = self.centre_line.clone() else {
            self.smooth_points();
            return Ok(());
        };
        let Some(unit) = self.unit else {
            let words: Vec<_> = LengthUnit::WORDS.iter().map(|(word, _)| *word).collect();
            let words = words.join("\", \"");
            let what = "expected its unit of length next to it";
            return Err((key, format!("{what}: vessel.unit = one of \"{words}\"")));
        };
        if !self.points.is_empty() {
            let reason = "the case has vessel.points_m as well: leave out one of the two";
            return Err((key, reason.into()));
        }
        let named = |fault: Fault| (key, format!("{}: {fault}", path.display()));
        let file = LineFile::read(&path, self.branch.as_deref()).map_err(named)?;
        let metres = file.metres(unit, "vessel.unit").map_err(named)?;
        let mut line = file.line;
        let count = line.points.len();
        if count < 2 || !self.is_smoothed() && count > MOST_POINTS {
            let advice = match count {
                0 | 1 => "",
                _ => "; with vessel.smoothing_m there may be more",
            };
            let reason = fault!("expected 2 to {MOST_POINTS} points, found {count}{advice}");
            return Err(named(reason));
        }
        line.points.iter_mut().flatten().for_each(|x| *x *= metres);
        line.radii.iter_mut().for_each(|r| *r *= metres);
        let ending = path.extension();
        if !ending.is_some_and(|e| e.eq_ignore_ascii_case("csv")) {
            line = line.without_repeated(); // tracts of VMTK's repeat the point where they meet
        }
        if self.is_reversed.unwrap_or(false) {
            line.points.reverse();
            line.radii.reverse();
        }
        if self.is_smoothed() && line.points.len() > 2 {
            line = line
                .without_repeated()
                .smooth(self.halved(), self.least_bend);
            if line.points.len() > MOST_POINTS {
                let message = format!(
                    "leaves {} points, and {MOST_POINTS} are allowed: smooth more",
                    line.points.len()
                );
                return Err(("vessel.smoothing_m", message));
            }
        }
        self.points = line.points;
        // A radius of the case, or a surface, counts more than those of the file.
        if self.radius.is_none() && self.lumen.is_none() {
            self.radii = line.radii;
        }
        Ok(())
    }
}
