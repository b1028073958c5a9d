//! Figures of a run that a case asks for, from the tables that the run has left.

use crate::case::{MeasureOf, MeasureTable, OutputMeasure};
use crate::hemodynamics::summary::{Course, FieldSummary, RegionSummary};
use crate::output::results::Results;
use crate::output::tables;
use std::path::Path;

/// What a run has of a measure; none if its table has no such rows in the window.
pub(super) fn value(measure: &OutputMeasure, run: &Results) -> Option<f64> {
    let at = measure.at.as_deref();
    if measure.table == MeasureTable::Wall {
        let field = field(run.hemodynamics.region(at?)?, &measure.column)?;
        return extreme(measure.of, [field.min, field.mean, field.max]);
    }
    let rows = column(run, measure.table, at, &measure.column)?;
    if measure.of == MeasureOf::AtPhase {
        return at_phase(&rows, measure.phase?, run);
    }
    let (window, step) = (run.hemodynamics.window, run.case.time.step);
    let counts = |t: f64| window.contains(t, step) && tables::is_whole(t, step);
    let inside = rows.iter().filter(|[t, _]| counts(*t));
    let course = Course::of(&inside.map(|[_, x]| *x).collect::<Vec<_>>())?;
    extreme(measure.of, [course.min, course.mean, course.max])
}

fn field<'a>(region: &'a RegionSummary, column: &str) -> Option<&'a FieldSummary> {
    match column {
        "TAWSS_Pa" => Some(&region.TAWSS_Pa),
        "OSI" => Some(&region.OSI),
        "RRT_1_Pa" => Some(&region.RRT_1_Pa),
        _ => None,
    }
}

fn extreme(of: MeasureOf, [min, mean, max]: [f64; 3]) -> Option<f64> {
    match of {
        MeasureOf::Mean => Some(mean),
        MeasureOf::Lowest => Some(min),
        MeasureOf::Highest => Some(max),
        MeasureOf::Range => Some(max - min),
        MeasureOf::AtPhase => None,
    }
}

/// Times (s) and values of the rows `at` an opening, cross-section or region, or of all rows.
fn column(
    run: &Results,
    table: MeasureTable,
    at: Option<&str>,
    column: &str,
) -> Option<Vec<[f64; 2]>> {
    let files = &run.files;
    let (path, of) = match table {
        MeasureTable::History | MeasureTable::Wall => (files.history(), None),
        MeasureTable::Openings => (files.openings(), Some("opening")),
        MeasureTable::Sections => (files.sections(), Some("section")),
        MeasureTable::Regions => (files.regions(), Some("region")),
    };
    read(&path, of.zip(at), column)
}

fn read(path: &Path, at: Option<(&str, &str)>, column: &str) -> Option<Vec<[f64; 2]>> {
    let mut reader = csv::Reader::from_path(path).ok()?;
    let heads = reader.headers().ok()?.clone();
    let place = |name: &str| heads.iter().position(|head| head == name);
    let (time, value) = (place("time_s")?, place(column)?);
    let at = match at {
        Some((of, name)) => Some((place(of)?, name)),
        None => None,
    };
    let row = |row: csv::StringRecord| {
        if at.is_some_and(|(of, name)| row.get(of) != Some(name)) {
            return None;
        }
        Some([row.get(time)?.parse().ok()?, row.get(value)?.parse().ok()?])
    };
    Some(reader.records().filter_map(|r| row(r.ok()?)).collect())
}

/// The value at a share of the last whole beat that ends within the window, linear between two rows.
fn at_phase(rows: &[[f64; 2]], phase: f64, run: &Results) -> Option<f64> {
    let period = run.case.time.period;
    let end = run.hemodynamics.window.end_s;
    // A run of part of a beat is at the beginning of its first one.
    let beats = ((end / period + 1e-9).floor() - 1.0).max(0.0);
    let time = (beats + phase) * period;
    let after = rows.partition_point(|[t, _]| *t < time);
    let tolerance = 1e-9 * period;
    match (after.checked_sub(1).map(|i| rows[i]), rows.get(after)) {
        (_, Some([t, x])) if *t <= time + tolerance => Some(*x),
        (Some([before, a]), Some([t, b])) => Some(a + (b - a) * (time - before) / (t - before)),
        (Some([t, x]), None) if t >= time - tolerance => Some(x),
        _ => None,
    }
}
