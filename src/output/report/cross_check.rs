//! The page of a cross-check: two solvers on the same cases, figures over each other, a table with verdicts.

use super::page::{Page, escape, figure, gallery, significant, table};
use crate::output::comparison::{Comparison, RunDifference};
use crate::output::refinement::Refined;

/// The page about named cases, and what finer meshes change in some of them.
pub fn page(compared: &[(String, Comparison)], refined: &[(String, Vec<Refined>)]) -> String {
    let lead = "The same cases, the same wall and coupling, two solvers for the blood that share nothing but the geometry.";
    let mut page = Page::new("Cross-check of the flow solvers", lead);
    for (name, comparison) in compared {
        let beyond = comparison.differences.iter().filter(|d| d.is_beyond());
        let verdict = match beyond.count() {
            0 => "All that is judged lies within its limit.".to_owned(),
            1 => "One quantity lies beyond its limit.".to_owned(),
            n => format!("{n} quantities lie beyond their limits."),
        };
        let [a, b] = comparison.names();
        let heads = [
            "quantity",
            &format!("mean, {}", escape(a)),
            &format!("mean, {}", escape(b)),
            "rms of the difference",
            "relative",
            "largest",
            "limit",
            "verdict",
        ];
        let rows: Vec<Vec<String>> = comparison.differences.iter().map(row).collect();
        let figures: Vec<String> = (comparison.figures().iter())
            .map(|(name, svg)| figure(svg, &escape(&name.replace('-', " ")), None))
            .collect();
        let finer = refined.iter().find(|(other, _)| other == name);
        let finer = finer.map_or(String::new(), |(_, rows)| refinement(rows));
        let html = format!(
            "<p>{verdict}</p>\n{}{finer}{}",
            table(&heads, &rows),
            gallery(&figures)
        );
        page.section(name, name, &html);
    }
    page.to_html()
}

/// What finer meshes change, with the values to which they lead.
fn refinement(rows: &[Refined]) -> String {
    let heads = [
        "quantity, mean",
        "OpenFOAM",
        "finer",
        "extrapolated",
        "uncertainty",
        "observed order",
        "native",
        "a degree more",
        "uncertainty",
        "relative difference",
        "finer meshes",
        "extrapolated values",
    ];
    let row = |row: &Refined| {
        let numbers = [
            row.coarse_a,
            row.fine_a,
            row.extrapolated_a,
            row.uncertainty_a,
            row.observed_order_a,
            row.coarse_b,
            row.fine_b,
            row.uncertainty_b,
            row.relative_rms_coarse,
            row.relative_rms_fine,
        ];
        let verdict = match row.agree {
            true => "agree",
            false => "<strong>do not agree</strong>",
        };
        let mut cells = vec![escape(&row.name())];
        cells.extend(numbers.map(number));
        cells.push(verdict.to_owned());
        cells
    };
    let rows: Vec<Vec<String>> = rows.iter().map(row).collect();
    format!(
        "<p>On finer meshes: OpenFOAM's cells shorter by half, the native solver's elements with a degree more. OpenFOAM is \
         extrapolated with second order; its uncertainty is the grid convergence index of two meshes, the native one's what \
         the last degree has changed.</p>\n{}",
        table(&heads, &rows)
    )
}

fn number(value: f64) -> String {
    if value.is_finite() {
        significant(value, 3)
    } else {
        "–".to_owned()
    }
}

fn row(difference: &RunDifference) -> Vec<String> {
    let verdict = match (difference.limit, difference.is_beyond()) {
        (None, _) => "not judged",
        (_, true) => "<strong>beyond</strong>",
        _ => "within",
    };
    vec![
        escape(&difference.name()),
        number(difference.mean_a),
        number(difference.mean_b),
        number(difference.rms),
        number(difference.relative_rms),
        number(difference.largest),
        difference
            .limit
            .map_or("–".to_owned(), |limit| significant(limit, 2)),
        verdict.to_owned(),
    ]
}
