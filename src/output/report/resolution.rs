//! How well a run resolves its flow.

use super::maps;
use super::page::{figure, gallery, significant, table};
use crate::hemodynamics::Place;
use crate::output::results::Results;
use crate::output::tables::{self, ResolutionRow};
use std::io;

/// Figures, and a map of where the mesh is too coarse; none of a run that has not been judged.
///
/// # Errors
/// If `resolution.csv` cannot be read.
pub fn section(run: &Results) -> io::Result<Option<String>> {
    let summary = run.summary.as_ref();
    let Some((summary, found)) = summary.and_then(|s| Some((s, s.resolution.as_ref()?))) else {
        return Ok(None);
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    let mut row = |what: &str, value: Option<f64>, unit: &str| {
        let shown = value.map(|value| format!("{}{unit}", significant(value, 3)));
        rows.extend(shown.map(|shown| vec![what.to_owned(), shown]));
    };
    if let Some(numbers) = &found.numbers {
        let points = match found.highest_modes {
            Some(_) => "distances of nodes",
            None => "cells",
        };
        let jet = numbers.jet.as_ref();
        row("largest Reynolds number", Some(numbers.reynolds), "");
        row("steps per period", Some(numbers.steps_per_period), "");
        row(
            "layer at the wall",
            numbers.layer_m.map(|layer| 1e3 * layer),
            " mm",
        );
        row(&format!("{points} in it"), numbers.points_in_layer, "");
        let of_jet = jet.and_then(|jet| jet.points);
        row(
            &format!("{points} from the axis of the jet to its edge"),
            of_jet,
            "",
        );
        row("Courant number", numbers.courant, "");
        row("cell Reynolds number", numbers.cell_reynolds, "");
    }
    let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
    let at_wall = percent(found.highest_modes_at_wall);
    row(
        "velocity in the highest polynomials, elements at the wall",
        at_wall,
        " %",
    );
    row("the same, all elements", percent(found.highest_modes), " %");
    row(
        "wall shear from face to face, root mean square",
        percent(found.jumps),
        " %",
    );
    let findings = match found.findings.len() {
        0 => "Nothing was found that makes the results doubtful. ",
        _ => "What makes the results doubtful stands at the top of this page. ",
    };
    let mut html = format!(
        "<p>{findings}Limits and what they were measured against: docs/resolution.md.</p>\n{}",
        table(&["size", "value"], &rows)
    );
    if let Some(steadiness) = &summary.steadiness {
        html += &format!(
            "<p>What drives the blood is constant; over the last {:.3} s the largest change was that of the {}, {} %.</p>\n",
            steadiness.over_s,
            super::page::escape(&steadiness.measure),
            significant(100.0 * steadiness.change, 2)
        );
    }
    let path = run.files.resolution();
    if run.vessel.is_some() && path.is_file() {
        html += &gallery(&[map(run, &tables::read(&path)?)]);
    }
    Ok(Some(html))
}

/// A map of what tells most: the elements' polynomials, or the jumps where there are none.
fn map(run: &Results, faces: &[ResolutionRow]) -> String {
    let (label, about, value): (_, _, fn(&ResolutionRow) -> Option<f64>) = match faces
        .iter()
        .any(|face| face.highest_modes.is_some())
    {
        true => (
            "highest polynomials / %",
            "Share of the velocity that is in the highest polynomials of each element at the wall: where it is large, so is the error.",
            |face| face.highest_modes,
        ),
        false => (
            "jump of TAWSS / %",
            "Difference of the time-averaged wall shear stress from that of the neighbouring faces, relative to the mean of the wall.",
            |face| face.jump,
        ),
    };
    let values: Vec<f64> = faces
        .iter()
        .map(|face| 100.0 * value(face).unwrap_or(0.0))
        .collect();
    let places: Vec<Place> = (faces.iter())
        .map(|face| Place::on_tube(face.x_m, face.phi_deg))
        .collect();
    let range = [0.0, values.iter().copied().fold(0.0, f64::max)];
    let title = format!("{}, resolution", run.name());
    let svg = maps::draw(
        &places,
        &values,
        &title,
        label,
        maps::whole(run),
        range,
        Vec::new(),
    );
    figure(&svg, about, None)
}
