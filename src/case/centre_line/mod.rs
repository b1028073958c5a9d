//! Centre-lines from files that people have.

mod file;
mod swc;
mod table;
mod vtp;

use super::vessel::MOST_POINTS;
use super::{LengthUnit, VesselDescription};
use crate::interpolation::SmoothingSpline;
use file::LineFile;
pub use file::LineReading;
use std::path::Path;

/// A smooth line has so many points along the length whose waves are halved.
const POINTS_OF_A_WAVE: f64 = 4.0;
/// Most branches that a message names.
const MOST_NAMED: usize = 8;

/// Points of a centre-line, and the radius of the lumen at each if the file knows it, in its own unit.
#[derive(Debug, Clone, Default, PartialEq)]
struct CentreLine {
    points: Vec<[f64; 3]>,
    radii: Vec<f64>,
}

impl CentreLine {
    /// As [`LineFile::read`], without what else the file says.
    fn read(path: &Path, branch: Option<&str>) -> Result<Self, String> {
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

    /// The smoothing spline in the length of the polygon: waves of the length `halved` keep half of their height. Where there
    /// are more points than it needs, it is given by fewer.
    fn smooth(&self, halved: f64) -> Self {
        let mut places = vec![0.0];
        for pair in self.points.windows(2) {
            let step: f64 = (0..3).map(|c| (pair[1][c] - pair[0][c]).powi(2)).sum();
            places.push(places[places.len() - 1] + step.sqrt());
        }
        let length = places[places.len() - 1];
        let radius = |i: usize| self.radii.get(i).copied().unwrap_or(0.0);
        let values = self
            .points
            .iter()
            .enumerate()
            .map(|(i, [x, y, z])| [*x, *y, *z, radius(i)]);
        let spline = SmoothingSpline::new(&places, &values.collect::<Vec<_>>(), halved);
        let needed = (length / halved * POINTS_OF_A_WAVE).ceil().max(8.0) as usize;
        let smooth: Vec<[f64; 4]> = match needed + 1 < places.len() {
            true => (0..=needed)
                .map(|i| spline.at(length * i as f64 / needed as f64))
                .collect(),
            false => spline.values().to_vec(),
        };
        let radii = smooth.iter().map(|[.., r]| *r);
        Self {
            points: smooth.iter().map(|[x, y, z, _]| [*x, *y, *z]).collect(),
            radii: radii
                .take(if self.radii.is_empty() {
                    0
                } else {
                    smooth.len()
                })
                .collect(),
        }
    }
}

/// What a file with a centre-line holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineSurvey {
    /// Number of points.
    pub points: usize,
    /// Length of the polygon through every tenth of them, m: that through all would be longer where they scatter.
    pub length: f64,
    /// Median radius of the lumen (m), if the file knows it.
    pub radius: Option<f64>,
}

impl LineSurvey {
    /// Looks into a file of lengths in `unit`; of several lines into the one that is called `branch`.
    ///
    /// # Errors
    /// What is wrong with the file, in a sentence.
    pub fn read(path: &Path, branch: Option<&str>, unit: LengthUnit) -> Result<Self, String> {
        let line = CentreLine::read(path, branch)?;
        let count = line.points.len();
        if count < 2 {
            return Err(format!("expected 2 points at least, found {count}"));
        }
        let every = count.div_ceil(20);
        let chosen = (0..count).step_by(every).chain([count - 1]);
        let points: Vec<crate::Vec3> = chosen.map(|i| line.points[i].into()).collect();
        let length = points.windows(2).map(|pair| (pair[1] - pair[0]).norm());
        let mut radii = line.radii;
        radii.sort_by(f64::total_cmp);
        Ok(Self {
            points: count,
            length: unit.metres() * length.sum::<f64>(),
            radius: radii.get(radii.len() / 2).map(|r| unit.metres() * r),
        })
    }
}

/// A few of many, for a message.
fn listed(names: &[String]) -> String {
    let more = match names.len().saturating_sub(MOST_NAMED) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    names[..names.len().min(MOST_NAMED)].join(", ") + &more
}

impl VesselDescription {
    /// Reads the file of the centre-line, if the case names one, and smooths the line, if it is to be: points and radii then
    /// stand in it.
    ///
    /// # Errors
    /// The key to blame, and what is wrong.
    pub(super) fn read_file(&mut self) -> Result<(), (&'static str, String)> {
        let key = "vessel.centre_line";
        let Some(path) = self.centre_line.clone() else {
            if let Some(halved) = self.smoothing
                && self.points.len() > 2
            {
                let line = CentreLine {
                    points: std::mem::take(&mut self.points),
                    radii: std::mem::take(&mut self.radii),
                };
                let fits = line.radii.is_empty() || line.radii.len() == line.points.len();
                let line = if fits {
                    line.without_repeated().smooth(halved)
                } else {
                    line
                };
                (self.points, self.radii) = (line.points, line.radii);
            }
            return Ok(());
        };
        let Some(unit) = self.unit else {
            let words: Vec<_> = LengthUnit::WORDS.iter().map(|(word, _)| *word).collect();
            let words = words.join("\", \"");
            return Err((
                key,
                format!("expected its unit of length beside it: vessel.unit = one of \"{words}\""),
            ));
        };
        if !self.points.is_empty() {
            return Err((
                key,
                "the case has vessel.points_m as well: leave out one of the two".into(),
            ));
        }
        let named = |reason: String| (key, format!("{}: {reason}", path.display()));
        let file = LineFile::read(&path, self.branch.as_deref()).map_err(named)?;
        let metres = file.metres(unit).map_err(named)?;
        let mut line = file.line;
        let count = line.points.len();
        if count < 2 || self.smoothing.is_none() && count > MOST_POINTS {
            return Err(named(format!(
                "expected 2 to {MOST_POINTS} points, found {count}{}",
                if count < 2 {
                    ""
                } else {
                    "; with vessel.smoothing_m there may be more"
                }
            )));
        }
        line.points.iter_mut().flatten().for_each(|x| *x *= metres);
        line.radii.iter_mut().for_each(|r| *r *= metres);
        if !path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("csv"))
        {
            line = line.without_repeated(); // tracts of VMTK's repeat the point where they meet
        }
        if self.is_reversed.unwrap_or(false) {
            line.points.reverse();
            line.radii.reverse();
        }
        if let Some(halved) = self.smoothing
            && line.points.len() > 2
        {
            line = line.without_repeated().smooth(halved);
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
