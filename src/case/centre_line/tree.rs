//! The lines of a tree: each from its beginning to one of its ends, whether a file has them so or in branches.

use super::{CentreLine, LineFile, file, swc, vtp};
use crate::LengthUnit;
use crate::files::{Fault, fault};
use std::path::Path;

/// No coordinate of a vessel is as large, in any unit.
const FAR: f64 = 1e8;

/// Points and radii of a line, in the unit of its file.
pub type LineOfTree = (Vec<[f64; 3]>, Vec<f64>);

/// The lines of a file, each from the beginning of the tree to one of its ends.
///
/// # Errors
/// What is wrong with the file, in a sentence.
pub fn lines_of_tree(path: &Path) -> Result<Vec<LineOfTree>, Fault> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let lines = match ending.as_deref() {
        Some("swc") => swc::all(path),
        Some("vtp" | "vtk") => vtp::all(path),
        _ => Err("expected a file that ends with .vtp, .vtk or .swc".into()),
    }?;
    let lines = lines.into_iter().map(CentreLine::without_repeated);
    let lines: Vec<CentreLine> = lines.filter(|line| line.points.len() > 1).collect();
    let mut points = lines
        .iter()
        .flat_map(|line| line.points.iter().zip(&line.radii));
    let is_odd = |radius: &f64| !(radius.is_finite() && *radius > 0.0);
    if let Some(([x, y, z], radius)) = points.find(|(_, radius)| is_odd(radius)) {
        let mut odd: Vec<&[f64; 3]> = points.filter(|(_, r)| is_odd(r)).map(|(x, _)| x).collect();
        odd.dedup();
        let more = match odd.len() {
            0 => String::new(),
            more => format!(", and {more} more are not either"),
        };
        return Err(fault!(
            "the radius at ({x}, {y}, {z}) is {radius:?}: expected one above 0{more}"
        ));
    }
    let mut lines: Vec<LineOfTree> = (lines.into_iter())
        .map(|line| (line.points, line.radii))
        .collect();
    let far = lines.iter().flat_map(|(points, _)| points);
    if let Some([x, y, z]) = { far }.find(|x| !x.iter().all(|c| c.abs() < FAR)) {
        return Err(fault!(
            "a point lies at ({x:?}, {y:?}, {z:?}): expected coordinates of less than {FAR:e}; correct it, or delete it"
        ));
    }
    downstream(&mut lines);
    let whole = from_the_beginning(&lines, &vec![None; lines.len()]).map_err(|apart| {
        let [x, y, z] = lines[apart.line].0[0];
        fault!(
            "line {} of {} begins at ({x}, {y}, {z}), on none of the others: a file is one tree, whose first line begins at its \
             inlet; delete what belongs to others",
            apart.line + 1,
            lines.len()
        )
    })?;
    Ok(whole.into_iter().map(|(_, line)| line).collect())
}

/// The line of one branch, from a table of points and radii in this unit, m.
///
/// # Errors
/// What is wrong with the file, in a sentence.
pub fn line_of_branch(path: &Path, unit: LengthUnit) -> Result<LineOfTree, Fault> {
    if !file::is_table(path) {
        return Err(
            "expected a table of points that ends with .csv (or .txt, .dat); files with lines of several branches are \
             for tree.lines"
                .into(),
        );
    }
    let file = LineFile::read(path, None)?;
    let metres = file.metres(unit, "tree.unit")?;
    let (understood, line) = (file.understood, file.line.without_repeated());
    let found = line.points.len();
    if found < 2 {
        return Err(fault!("expected two points at least, found {found}"));
    }
    if line.radii.len() != found {
        return Err(fault!(
            "expected the columns x,y,z,r with the radius, found {understood}"
        ));
    }
    let points = line.points.into_iter().map(|x| x.map(|c| c * metres));
    let radii = line.radii.into_iter().map(|r| r * metres);
    Ok((points.collect(), radii.collect()))
}

/// A line whose waves of this length are halved; the radii change by their own scatter at most, and it begins where it
/// did, so that lines still begin at one place.
pub fn smoothed((points, radii): LineOfTree, halved: f64) -> LineOfTree {
    let begin = points[0];
    let line = CentreLine { points, radii };
    let mut line = line.without_repeated().smooth(halved, None);
    line.points[0] = begin;
    (line.points, line.radii)
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let squares = (0..3).map(|c| (a[c] - b[c]).powi(2));
    squares.sum::<f64>().sqrt()
}

/// Turns lines around that lead from the ends to a common place where they end, as they may if the outlets were taken
/// for the sources.
fn downstream(lines: &mut [LineOfTree]) {
    let together = |place: fn(&LineOfTree) -> usize| {
        let (points, radii) = &lines[0];
        let i = place(&lines[0]);
        let mut others = lines[1..].iter().map(|line| line.0[place(line)]);
        others.all(|x| distance(&x, &points[i]) < radii[i])
    };
    let last = |line: &LineOfTree| line.0.len() - 1;
    if lines.len() > 1 && together(last) && !together(|_| 0) {
        for (points, radii) in lines {
            points.reverse();
            radii.reverse();
        }
    }
}

/// A line that does not begin where it should.
#[derive(Debug)]
pub struct Apart {
    /// Its number.
    pub line: usize,
    /// The line that is nearest to its beginning, or that was given; how far away it is, and its radius there.
    pub nearest: usize,
    pub distance: f64,
    pub radius: f64,
}

/// A place on a line where another one begins.
struct Joint {
    parent: usize,
    /// Its last point up to there, and the share of the way to the next one.
    after: usize,
    share: f64,
    distance: f64,
    radius: f64,
}

impl Joint {
    /// The nearest point of these lines; where none is within its radius, the nearest place between two.
    fn nearest(
        lines: &[LineOfTree],
        parents: impl Iterator<Item = usize> + Clone,
        start: &[f64; 3],
    ) -> Option<Self> {
        let joint = |parent: usize, after: usize, share: f64| {
            let (x, radius) = place(&lines[parent], after, share);
            let distance = distance(&x, start);
            Self {
                parent,
                after,
                share,
                distance,
                radius,
            }
        };
        let in_radii = |a: &Self, b: &Self| {
            let [a, b] = [a, b].map(|joint| joint.distance / joint.radius);
            a.total_cmp(&b)
        };
        let points = parents.clone().flat_map(|parent| {
            let count = lines[parent].0.len();
            (0..count).map(move |i| joint(parent, i, 0.0))
        });
        let nearest = points.min_by(in_radii)?;
        if nearest.distance <= nearest.radius {
            return Some(nearest);
        }
        let between = parents.flat_map(|parent| {
            let pairs = lines[parent].0.windows(2).enumerate();
            pairs.map(move |(i, pair)| joint(parent, i, share_between(pair, start)))
        });
        between.min_by(in_radii)
    }

    /// The parent's line up to there; a place between two points is led to along the straight line between them.
    fn way(&self, parent: &LineOfTree) -> LineOfTree {
        let (points, radii) = parent;
        let mut way = (
            points[..=self.after].to_vec(),
            radii[..=self.after].to_vec(),
        );
        if self.share > 0.0 {
            let length = distance(&points[self.after], &points[self.after + 1]);
            let upstream = self.share - STRAIGHT * self.radius / length;
            for share in [upstream, self.share]
                .into_iter()
                .filter(|share| *share > 0.0)
            {
                let (x, radius) = place(parent, self.after, share);
                way.0.push(x);
                way.1.push(radius);
            }
        }
        way
    }
}

/// So far, in radii, the way to a place between two points is kept straight.
const STRAIGHT: f64 = 0.25;

/// Position and radius at this share of the way from a point of a line to the next one.
fn place((points, radii): &LineOfTree, after: usize, share: f64) -> ([f64; 3], f64) {
    let next = (after + 1).min(points.len() - 1);
    let between = |a: f64, b: f64| a + share * (b - a);
    let x = |c: usize| between(points[after][c], points[next][c]);
    ([x(0), x(1), x(2)], between(radii[after], radii[next]))
}

/// The share of the way between two points at which it is nearest to another one.
fn share_between(pair: &[[f64; 3]], x: &[f64; 3]) -> f64 {
    let dot = |to: &[f64; 3]| -> f64 {
        (0..3)
            .map(|c| (to[c] - pair[0][c]) * (pair[1][c] - pair[0][c]))
            .sum()
    };
    (dot(x) / dot(&pair[1])).clamp(0.0, 1.0)
}

/// Lines from the beginning of the tree to each end, with the number of the line that ends there. A line that begins on
/// another one, that which is `named` or else the nearest, is a branch of it; the first line of which none is named
/// begins at the beginning.
///
/// # Errors
/// The first line that begins further from the others, or from the one that is named, than the radius there.
pub fn from_the_beginning(
    lines: &[LineOfTree],
    named: &[Option<usize>],
) -> Result<Vec<(usize, LineOfTree)>, Apart> {
    if lines.is_empty() {
        return Ok(Vec::new());
    }
    let first = (0..lines.len()).fold(0, |first, _| named[first].unwrap_or(first));
    let (begin, first_radius) = (&lines[first].0[0], lines[first].1[0]);
    // None of one that begins where the tree does.
    let joint = |line: usize| {
        let start = &lines[line].0[0];
        if distance(start, begin) <= first_radius {
            return Ok(None);
        }
        let is_meant = |other: &usize| *other != line && named[line].is_none_or(|it| it == *other);
        let found = Joint::nearest(lines, (0..lines.len()).filter(is_meant), start);
        match found {
            Some(found) if found.distance > found.radius => Err(Apart {
                line,
                nearest: found.parent,
                distance: found.distance,
                radius: found.radius,
            }),
            found => Ok(found),
        }
    };
    let joints = (0..lines.len()).map(joint).collect::<Result<Vec<_>, _>>()?;
    let is_end = |line: &usize| {
        let (points, radii) = &lines[*line];
        let last = points.len() - 1;
        // Not where others go on.
        let is_here = |joint: &Joint| {
            let (x, _) = place(&lines[joint.parent], joint.after, joint.share);
            joint.parent == *line && distance(&x, &points[last]) <= radii[last]
        };
        !joints.iter().flatten().any(is_here)
    };
    let whole = |line: usize| {
        let (mut points, mut radii) = lines[line].clone();
        let mut at = line;
        for _ in 0..lines.len() {
            let Some(joint) = &joints[at] else { break };
            let way = joint.way(&lines[joint.parent]);
            // The point where it begins is on both.
            points.splice(0..1, way.0);
            radii.splice(0..1, way.1);
            at = joint.parent;
        }
        (line, (points, radii))
    };
    Ok((0..lines.len()).filter(is_end).map(whole).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_are_led_back_to_the_beginning() {
        let line = |points: &[[f64; 3]]| (points.to_vec(), vec![0.4; points.len()]);
        let trunk = line(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        let left = line(&[[2.0, 0.0, 0.0], [3.0, 1.0, 0.0]]);
        let side = line(&[[1.1, 0.0, 0.0], [1.1, -2.0, 0.0]]);
        let twig = line(&[[3.0, 1.0, 0.0], [3.0, 2.0, 0.0]]);
        let whole = from_the_beginning(&[trunk, left, side, twig], &[None; 4]).unwrap();
        let (numbers, lines): (Vec<usize>, Vec<LineOfTree>) = whole.into_iter().unzip();
        assert_eq!(numbers, [2, 3]);
        assert_eq!(
            lines[0].0,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.1, -2.0, 0.0]]
        );
        let twig = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [3.0, 1.0, 0.0],
            [3.0, 2.0, 0.0],
        ];
        assert_eq!(lines[1].0, twig);
        assert_eq!(lines[1].1, [0.4; 5]);
    }
}
