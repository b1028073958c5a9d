//! Flows and pressures over time at the openings of a run, and at the cross-sections that its case watches.

use super::results::Results;
use super::tables::{self, OpeningRow, SectionRow};
use std::io;

/// A quantity at a place over time.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceHistory {
    /// What, with its unit.
    pub quantity: &'static str,
    /// Name of the opening or the cross-section.
    pub place: String,
    /// Time (s) and value.
    pub points: Vec<(f64, f64)>,
}

/// All of a run: those of openings where these are more than the inlet and the outlet of its history.
///
/// # Errors
/// If a table cannot be read.
pub fn all(run: &Results) -> io::Result<Vec<PlaceHistory>> {
    let (openings, sections) = (run.files.openings(), run.files.sections());
    let mut histories = Vec::new();
    if openings.is_file() {
        let rows: Vec<OpeningRow> = tables::read(&openings)?;
        let mut of = |quantity, value: fn(&OpeningRow) -> Option<f64>| {
            let point = |row: &OpeningRow| Some((row.time_s, value(row)?));
            histories.extend(by_place(quantity, &rows, |row| &row.opening, point));
        };
        of("flow in / m³/s", |row| Some(row.flow_m3_s));
        of("pressure / Pa", |row| Some(row.p_Pa));
        if histories.len() <= 4 {
            histories.clear();
        }
    }
    if sections.is_file() {
        let rows: Vec<SectionRow> = tables::read(&sections)?;
        let mut of = |quantity, value: fn(&SectionRow) -> Option<f64>| {
            let point = |row: &SectionRow| Some((row.time_s, value(row)?));
            histories.extend(by_place(quantity, &rows, |row| &row.section, point));
        };
        of("flow / m³/s", |row| row.flow_m3_s);
        of("pressure / Pa", |row| Some(row.p_Pa));
        of("area / m²", |row| Some(row.area_m2));
    }
    Ok(histories)
}

fn by_place<Row>(
    quantity: &'static str,
    rows: &[Row],
    place: fn(&Row) -> &str,
    point: impl Fn(&Row) -> Option<(f64, f64)>,
) -> impl Iterator<Item = PlaceHistory> {
    let found = tables::by_name(rows, place, point).into_iter();
    found.map(move |(place, points)| PlaceHistory {
        quantity,
        place,
        points,
    })
}
