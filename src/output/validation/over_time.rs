//! Statistics over time of runs beside those that were measured, as a table.

use super::computed::Computed;
use crate::case::measured::{MeasuredPoint, MeasuredSeries};
use crate::output::refinement::Limit;
use crate::output::report::PageTable;
use crate::output::report::page::significant;

/// Digits of values, and of their uncertainties and differences.
const DIGITS: [usize; 2] = [4, 2];

/// A row for each statistic; see [`super::Validation::statistics`].
pub fn table(series: &[MeasuredSeries], runs: &[Computed], is_refined: bool) -> Option<PageTable> {
    let all = series.iter().enumerate();
    let rows: Vec<_> = all
        .filter(|(_, series)| series.is_over_time())
        .flat_map(|(i, series)| {
            series
                .points
                .iter()
                .enumerate()
                .map(move |point| (i, series, point))
        })
        .collect();
    if rows.is_empty() {
        return None;
    }
    let is_measured = rows.iter().any(|(_, _, (_, point))| !point.value.is_nan());
    let heads = ["over time", "unit"]
        .into_iter()
        .chain(is_measured.then_some("reference"));
    let names = runs.iter().map(|run| run.name.as_str());
    let limit = is_refined.then_some("refined further");
    let mut table = PageTable::new(heads.chain(names).chain(limit));
    for (i, series, (j, point)) in rows {
        let values: Vec<f64> = runs.iter().map(|run| run.values[i][j]).collect();
        table.push(row(series, point, &values, is_measured, is_refined));
    }
    Some(table)
}

fn row(
    series: &MeasuredSeries,
    point: &MeasuredPoint,
    values: &[f64],
    is_measured: bool,
    is_refined: bool,
) -> Vec<String> {
    let statistic = point
        .statistic
        .expect("a series of statistics has nothing else");
    let (unit, factor) = match statistic.unit(series.quantity.unit()) {
        "m" => ("mm", 1e3),
        other => (other, 1.0),
    };
    let show = |value: f64, digits| significant(factor * value, digits);
    let plus_minus = |value: f64, uncertainty: f64| {
        format!(
            "{} ± {}",
            show(value, DIGITS[0]),
            show(uncertainty, DIGITS[1])
        )
    };
    let measured = match point.sd {
        _ if point.value.is_nan() => String::new(),
        Some(sd) => plus_minus(point.value, sd),
        None => show(point.value, DIGITS[0]),
    };
    let beside = |value: &f64| {
        let value_shown = show(*value, DIGITS[0]);
        if point.value.is_nan() {
            return value_shown;
        }
        let share = 100.0 * (value - point.value) / point.value.abs();
        let sign = if share > 0.0 { "+" } else { "" };
        format!("{value_shown} ({sign}{} %)", significant(share, DIGITS[1]))
    };
    let limit = is_refined.then(|| Limit::of_series(values));
    let name = format!("{}, {}", series.name, statistic.name());
    [name, unit.to_owned()]
        .into_iter()
        .chain(is_measured.then_some(measured))
        .chain(values.iter().map(beside))
        .chain(limit.map(|limit| plus_minus(limit.value, limit.uncertainty)))
        .collect()
}
