//! Measures of the wall along a vessel, or along each branch of a tree: means around the lumen.

use super::maps::{MapField, OSI, RADIUS, TAWSS, UnrolledPart};
use super::openings::COLOURS;
use super::page::{chart, line, panel};
use crate::output::figure::Curve;
use crate::output::results::Results;

/// Points of a curve are as far apart, in widths of the faces; each is a mean over as much on both sides, where what is
/// nearer counts more.
const STEP: f64 = 1.5;

/// A curve of each measure for each part.
pub fn figures(run: &Results, parts: &[UnrolledPart]) -> Vec<String> {
    let of = |field: &MapField| {
        let curve = |(number, part): (usize, &UnrolledPart)| Curve {
            open: number / COLOURS.len() % 2 == 1,
            ..line(
                &part.name,
                COLOURS[number % COLOURS.len()],
                means(run, part, field),
            )
        };
        let caption = format!(
            "{} along each branch from where it begins, mean around the lumen by area.",
            field.label
        );
        let curves = parts.iter().enumerate().map(curve).collect();
        let name = format!("along-{}", field.file);
        chart(
            &name,
            &caption,
            panel(field.file, "x / mm", field.label, curves),
        )
    };
    [RADIUS, TAWSS, OSI].iter().map(of).collect()
}

/// Pairs of x (mm) and the mean of a field over the faces near it.
fn means(run: &Results, part: &UnrolledPart, field: &MapField) -> Vec<(f64, f64)> {
    let area: f64 = part.faces.iter().map(|&face| run.faces[face].area_m2).sum();
    let step = STEP * (area / part.faces.len() as f64).sqrt();
    let [from, to] = part.x;
    let pieces = ((to - from) / step).ceil().max(1.0);
    let mut sums = vec![[0.0; 2]; pieces as usize + 1];
    for &face in &part.faces {
        let row = &run.faces[face];
        let value = (field.value)(row);
        let at = (part.place(face).x_m - from) / (to - from) * pieces;
        let before = (at.floor() as usize).min(sums.len() - 2);
        let later = at - before as f64;
        for (sum, share) in sums[before..].iter_mut().zip([1.0 - later, later]) {
            if value.is_finite() {
                sum[0] += share * row.area_m2;
                sum[1] += share * row.area_m2 * value;
            }
        }
    }
    let x = |i: usize| 1e3 * (from + (to - from) * i as f64 / pieces);
    let means = sums.iter().enumerate().filter(|(_, [area, _])| *area > 0.0);
    means.map(|(i, [area, sum])| (x(i), sum / area)).collect()
}
