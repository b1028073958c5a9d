//! The lines of a tree: each from its beginning to one of its ends, whether a file has them so or in branches.

use super::{CentreLine, swc, vtp};
use std::path::Path;

/// Points and radii of a line, in the unit of its file.
pub type LineOfTree = (Vec<[f64; 3]>, Vec<f64>);

/// The lines of a file, each from the beginning of the tree to one of its ends. Lines that begin on another one are
/// branches of it.
///
/// # Errors
/// What is wrong with the file, in a sentence.
pub fn lines_of_tree(path: &Path) -> Result<Vec<LineOfTree>, String> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let lines = match ending.as_deref() {
        Some("swc") => swc::all(path),
        Some("vtp" | "vtk") => vtp::all(path),
        _ => Err("expected a file that ends with .vtp, .vtk or .swc".into()),
    }?;
    let lines = lines.into_iter().map(CentreLine::without_repeated);
    let lines: Vec<CentreLine> = lines.filter(|line| line.points.len() > 1).collect();
    for line in &lines {
        if let Some(i) = line.radii.iter().position(|r| !(r.is_finite() && *r > 0.0)) {
            let (r, [x, y, z]) = (line.radii[i], line.points[i]);
            return Err(format!(
                "the radius at ({x}, {y}, {z}) is {r:?}: expected one above 0"
            ));
        }
    }
    Ok(from_the_beginning(&lines)
        .into_iter()
        .map(|line| (line.points, line.radii))
        .collect())
}

/// Lines from the beginning of the tree to each end. The first line of the file begins there.
fn from_the_beginning(lines: &[CentreLine]) -> Vec<CentreLine> {
    let distance =
        |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    let Some(first) = lines.first() else {
        return Vec::new();
    };
    // The line, and its point, that another one begins at, unless that one begins where the first does.
    let parent = |number: usize| {
        let start = lines[number].points[0];
        if distance(&start, &first.points[0]) <= first.radii[0] {
            return None;
        }
        let points = lines
            .iter()
            .enumerate()
            .filter(|(other, _)| *other != number);
        let points = points.flat_map(|(other, line)| {
            let radii = line.radii.iter();
            (line.points.iter().zip(radii).enumerate())
                .map(move |(i, (x, r))| (other, i, distance(x, &start) / r))
        });
        let nearest = points.min_by(|a, b| a.2.total_cmp(&b.2));
        nearest
            .filter(|(.., radii)| *radii <= 1.0)
            .map(|(other, i, _)| (other, i))
    };
    let parents: Vec<Option<(usize, usize)>> = (0..lines.len()).map(parent).collect();
    let is_end = |number: usize| {
        let last = lines[number].points.len() - 1;
        // Not where others go on.
        !parents
            .iter()
            .flatten()
            .any(|(other, i)| *other == number && *i == last)
    };
    let whole = |number: usize| {
        let mut line = lines[number].clone();
        let mut at = number;
        for _ in 0..lines.len() {
            let Some((other, i)) = parents[at] else { break };
            let above = &lines[other];
            // The point where it begins is on both.
            line.points.splice(0..1, above.points[..=i].iter().copied());
            line.radii.splice(0..1, above.radii[..=i].iter().copied());
            at = other;
        }
        line
    };
    (0..lines.len())
        .filter(|number| is_end(*number))
        .map(whole)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branches_are_led_back_to_the_beginning() {
        let line = |points: &[[f64; 3]]| CentreLine {
            points: points.to_vec(),
            radii: vec![0.4; points.len()],
        };
        let trunk = line(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        let left = line(&[[2.0, 0.0, 0.0], [3.0, 1.0, 0.0]]);
        let side = line(&[[1.1, 0.0, 0.0], [1.1, -2.0, 0.0]]);
        let twig = line(&[[3.0, 1.0, 0.0], [3.0, 2.0, 0.0]]);
        let whole = from_the_beginning(&[trunk, left, side, twig]);
        let points: Vec<Vec<[f64; 3]>> = whole.into_iter().map(|line| line.points).collect();
        assert_eq!(
            points,
            [
                vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.1, -2.0, 0.0]],
                vec![
                    [0.0, 0.0, 0.0],
                    [1.0, 0.0, 0.0],
                    [2.0, 0.0, 0.0],
                    [3.0, 1.0, 0.0],
                    [3.0, 2.0, 0.0]
                ],
            ]
        );
    }
}
