//! What is done to the lines of a tree before it is meshed: thin vessels and ends are left out, and the lines smoothed.

use super::centre_line::smoothed;
use super::tree::{TreeKeys, TreeLine};
use crate::curve::{CentreLine, Partings};
use fsi_numerics::twelve_digits;
use std::ops::Range;

/// What is left of a line that is cut must be so long outside the lumen of others to be a branch, in radii.
const BRANCH: f64 = 3.0;
/// Points that are nearer to each other than this, in radii, are one where points are left out.
const LEAST_PIECE: f64 = 1e-3;

impl TreeKeys {
    /// Does what the case asks for.
    ///
    /// # Errors
    /// The key to blame, and what is wrong.
    pub(super) fn change_lines(&mut self) -> Result<(), (&'static str, String)> {
        self.cut_thin_lines()?;
        self.leave_out_lines()?;
        self.smooth_junctions();
        self.smooth_lines()
    }

    /// Ends each line where it is last as wide as the thinnest vessel that counts, and takes those away that are then
    /// nothing but the beginning of another one.
    fn cut_thin_lines(&mut self) -> Result<(), (&'static str, String)> {
        let Some(least) = self.least_radius else {
            return Ok(());
        };
        let mut lines = self.line.take().unwrap_or_default();
        if !lines.iter().all(|line| line.curve().is_some()) {
            // What is wrong with them is said when they are checked.
            self.line = Some(lines);
            return Ok(());
        }
        let widest = lines.iter().flat_map(|line| &line.radii);
        let widest = widest.fold(0.0f64, |most, radius| most.max(*radius));
        let mut is_cut = vec![false; lines.len()];
        for (line, is_cut) in lines.iter_mut().zip(&mut is_cut) {
            let last = line.radii.iter().rposition(|radius| *radius >= least);
            let kept = last.map_or(0, |last| last + 1);
            *is_cut = kept < line.points.len();
            line.points.truncate(kept);
            line.radii.truncate(kept);
        }
        let curves: Vec<Option<CentreLine>> = lines.iter().map(TreeLine::curve).collect();
        let length = |i: usize| curves[i].as_ref().map_or(0.0, CentreLine::length);
        let mut order: Vec<usize> = (0..lines.len()).collect();
        order.sort_by(|&a, &b| {
            let longer_first = length(b).total_cmp(&length(a));
            is_cut[a].cmp(&is_cut[b]).then(longer_first)
        });
        let mut kept: Vec<usize> = Vec::new();
        for i in order {
            let Some(line) = &curves[i] else { continue };
            let shortest = BRANCH * line.radius(line.length());
            let is_branch = |other: &usize| {
                let other = curves[*other].as_ref();
                let leaves = other.and_then(|other| line.leaves(other));
                leaves.is_some_and(|s| line.length() - s >= shortest)
            };
            if !is_cut[i] || kept.iter().all(is_branch) {
                kept.push(i);
            }
        }
        if kept.is_empty() {
            let reason = format!(
                "no line is as wide as {} mm: the widest place has {} mm",
                twelve_digits(1e3 * least),
                twelve_digits(1e3 * widest)
            );
            return Err(("tree.least_radius_m", reason));
        }
        kept.sort_unstable();
        let all = lines.into_iter().enumerate();
        let lines = all.filter(|(i, _)| kept.contains(i)).map(|(_, line)| line);
        self.line = Some(lines.collect());
        Ok(())
    }

    /// Takes the lines away that are left out; the others keep their names.
    fn leave_out_lines(&mut self) -> Result<(), (&'static str, String)> {
        if self.leave_out.is_empty() {
            return Ok(());
        }
        let names = self.names();
        let outlets = &names[1..];
        if let Some(unknown) = self.leave_out.iter().find(|name| !outlets.contains(name)) {
            let reason = format!(
                "no line ends at {unknown:?}; they end at \"{}\"",
                outlets.join("\", \"")
            );
            return Err(("tree.leave_out", reason));
        }
        let is_kept = |name: &String| !self.leave_out.contains(name);
        let lines = self.line.take().unwrap_or_default().into_iter();
        let kept = lines.zip(outlets).filter(|(_, name)| is_kept(name));
        let named = kept.map(|(line, name)| TreeLine {
            name: Some(name.clone()),
            ..line
        });
        self.line = Some(named.collect());
        self.outlets.retain(is_kept);
        self.closed.retain(is_kept);
        Ok(())
    }

    /// Halves the waves of the lines, if they are to be smoothed.
    fn smooth_lines(&mut self) -> Result<(), (&'static str, String)> {
        let Some(halved) = self.smoothing.filter(|halved| *halved > 0.0) else {
            return Ok(());
        };
        let curves = self.line.iter().flatten().filter_map(TreeLine::curve);
        let longest = curves.map(|curve| curve.length()).fold(0.0, f64::max);
        if longest > 0.0 && halved > longest {
            let reason = format!(
                "expected at most {longest:.1e}, the length of the longest line: of longer waves there are none"
            );
            return Err(("tree.smoothing_m", reason));
        }
        for line in self.line.iter_mut().flatten() {
            if line.points.len() > 2 && line.points.len() == line.radii.len() {
                let given = (
                    std::mem::take(&mut line.points),
                    std::mem::take(&mut line.radii),
                );
                (line.points, line.radii) = smoothed(given, halved);
            }
        }
        Ok(())
    }

    /// Leaves out what lies next to where branches part, if that is asked for: traced lines have hooks there, from the
    /// middle of the parent's lumen to where the daughter leaves it.
    fn smooth_junctions(&mut self) {
        let Some(reach) = self.junction_smoothing.filter(|reach| *reach > 0.0) else {
            return;
        };
        let lines = self.line.iter().flatten();
        let Some(curves) = lines.map(TreeLine::curve).collect::<Option<Vec<_>>>() else {
            // What is wrong with them is said when they are checked.
            return;
        };
        let mut gaps = vec![Vec::new(); curves.len()];
        for fork in Partings::new(&curves).forks(&curves) {
            for (class, last) in &fork.daughters {
                for line in class {
                    let radii = |s: f64| reach * curves[*line].radius(s);
                    gaps[*line].push(fork.first - radii(fork.first)..last + radii(*last));
                }
            }
        }
        let lines = self.line.iter_mut().flatten();
        for ((line, curve), gaps) in lines.zip(&curves).zip(&gaps) {
            line.bridge(curve, gaps);
        }
    }
}

impl TreeLine {
    /// Leaves out its points within ranges of the arc length (m) of its curve, which goes on where these end.
    fn bridge(&mut self, curve: &CentreLine, gaps: &[Range<f64>]) {
        let end = curve.length();
        let is_outside = |s: f64| gaps.iter().all(|gap| s <= gap.start || s >= gap.end);
        // Its points are among the samples of the curve.
        let mut samples = curve.places().zip(&curve.points);
        let given = self.points.iter().filter_map(|x| {
            let sample = samples.find(|(_, sample)| sample.as_slice() == x.as_slice());
            sample.map(|(s, _)| s)
        });
        let ends = gaps.iter().flat_map(|gap| [gap.start, gap.end]);
        let mut places: Vec<f64> = given
            .chain(ends)
            .filter(|s| is_outside(*s) && (0.0..=end).contains(s))
            .chain([0.0, end])
            .collect();
        places.sort_by(f64::total_cmp);
        places.dedup_by(|b, a| *b - *a < LEAST_PIECE * curve.radius(*a));
        // The last point stays where it is.
        places.pop();
        places.push(end);
        self.points = places.iter().map(|s| curve.at(*s).into()).collect();
        self.radii = places.iter().map(|s| curve.radius(*s)).collect();
    }
}
