//! The lines of a tree: each from its beginning to one of its ends, whether a file has them so or in branches.

use super::{CentreLine, swc, vtp};
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
    let apart = lines.iter().position(|line| !is_joined(line, &lines));
    if let Some(number) = apart {
        let [x, y, z] = lines[number].0[0];
        return Err(fault!(
            "line {} of {} begins at ({x}, {y}, {z}), on none of the others: a file is one tree, whose first line begins at its \
             inlet; delete what belongs to others",
            number + 1,
            lines.len()
        ));
    }
    Ok(from_the_beginning(&lines)
        .into_iter()
        .map(|(_, line)| line)
        .collect())
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

/// Whether a line begins where the first does, or on another one.
fn is_joined(line: &LineOfTree, lines: &[LineOfTree]) -> bool {
    let start = &line.0[0];
    let (first, first_radii) = &lines[0];
    let others = lines.iter().filter(|other| !std::ptr::eq(*other, line));
    distance(start, &first[0]) <= first_radii[0]
        || others
            .flat_map(|(points, radii)| points.iter().zip(radii))
            .any(|(x, r)| distance(x, start) <= *r)
}

/// Lines from the beginning of the tree, where the first one begins, to each end, with the number of the line that ends
/// there. A line that begins on another one is a branch of it.
pub fn from_the_beginning(lines: &[LineOfTree]) -> Vec<(usize, LineOfTree)> {
    let Some((first, first_radii)) = lines.first() else {
        return Vec::new();
    };
    // The line, and its point, that another one begins at, unless that one begins where the first does.
    let parent = |number: usize| {
        let start = lines[number].0[0];
        if distance(&start, &first[0]) <= first_radii[0] {
            return None;
        }
        let others = (lines.iter().enumerate()).filter(|(other, _)| *other != number);
        let points = others.flat_map(|(other, (points, radii))| {
            let of_point = move |(i, (x, r))| (other, i, distance(x, &start) / r);
            points.iter().zip(radii).enumerate().map(of_point)
        });
        let nearest = points.min_by(|a, b| a.2.total_cmp(&b.2));
        let nearest = nearest.filter(|(.., radii)| *radii <= 1.0);
        nearest.map(|(other, i, _)| (other, i))
    };
    let parents: Vec<Option<(usize, usize)>> = (0..lines.len()).map(parent).collect();
    let is_end = |number: &usize| {
        let last = lines[*number].0.len() - 1;
        // Not where others go on.
        let mut joints = parents.iter().flatten();
        !joints.any(|joint| *joint == (*number, last))
    };
    let whole = |number: usize| {
        let (mut points, mut radii) = lines[number].clone();
        let mut at = number;
        for _ in 0..lines.len() {
            let Some((other, i)) = parents[at] else { break };
            // The point where it begins is on both.
            points.splice(0..1, lines[other].0[..=i].iter().copied());
            radii.splice(0..1, lines[other].1[..=i].iter().copied());
            at = other;
        }
        (number, (points, radii))
    };
    (0..lines.len()).filter(is_end).map(whole).collect()
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
        let whole = from_the_beginning(&[trunk, left, side, twig]);
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
