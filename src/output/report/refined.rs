//! What refining one thing at a time says of the figures of a run.

use super::key_figures::RESULTS;
use super::table::PageTable;
use crate::output::refinement::Limit;
use crate::output::results::Results;

/// Runs of one case in which one thing was refined by the same factor each time, from coarse to fine.
pub struct RefinementSeries {
    /// What was refined.
    pub name: String,
    /// The runs.
    pub runs: Vec<Results>,
}

/// What refining one thing at a time says of the run `base`: by how much each moves a figure where it leads to, and the
/// figure with all of that, whose uncertainty is the root of the sum of squares of all.
pub fn uncertainty(base: &Results, series: &[RefinementSeries]) -> PageTable {
    let heads = ["figure".to_owned(), base.name()].into_iter();
    let heads = heads.chain(series.iter().map(|series| series.name.clone()));
    let mut table = PageTable::new(heads.chain(["with all of that".to_owned()]));
    for figure in RESULTS.iter().filter(|figure| !figure.is_place()) {
        let Some(value) = figure.of(base) else {
            continue;
        };
        let mut row = vec![figure.name.to_owned(), figure.show(base)];
        let (moved, limit) = refined(value, |run| figure.of(run), series);
        let shown = moved.iter().map(|moved| {
            let moved = moved.as_ref();
            moved.map_or("–".into(), |moved| figure.show_limit(moved))
        });
        row.extend(shown);
        row.push(figure.show_limit(&limit));
        table.push(row);
    }
    table
}

/// By how much each series moves a value where it leads to, if its runs have one, and the value with all of that.
pub(super) fn refined(
    value: f64,
    of: impl Fn(&Results) -> Option<f64>,
    series: &[RefinementSeries],
) -> (Vec<Option<Limit>>, Limit) {
    let moved = series.iter().map(|series| {
        let values: Option<Vec<f64>> = series.runs.iter().map(&of).collect();
        let limit = Limit::of_series(&values.filter(|values| values.len() > 1)?);
        Some(Limit {
            value: limit.value - value,
            ..limit
        })
    });
    let moved: Vec<Option<Limit>> = moved.collect();
    let all = moved.iter().flatten();
    let limit = Limit {
        value: value + all.clone().map(|moved| moved.value).sum::<f64>(),
        uncertainty: all.map(|m| m.uncertainty.powi(2)).sum::<f64>().sqrt(),
    };
    (moved, limit)
}
