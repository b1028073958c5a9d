//! The page of a cross-check: two solvers on the same cases, figures over each other, a table with verdicts.

use super::page::{Page, escape, figure, gallery, significant, table};
use crate::output::comparison::{Comparison, Difference};

/// The page about named cases.
pub fn page(compared: &[(String, Comparison)]) -> String {
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
        let html = format!(
            "<p>{verdict}</p>\n{}{}",
            table(&heads, &rows),
            gallery(&figures)
        );
        page.section(name, name, &html);
    }
    page.to_html()
}

fn row(difference: &Difference) -> Vec<String> {
    let number = |value: f64| {
        if value.is_finite() {
            significant(value, 3)
        } else {
            "–".to_owned()
        }
    };
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
