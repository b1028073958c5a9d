//! Flow and pressure of openings, and of the cross-sections that a case watches.

use super::page::{chart, line, panel, significant};
use super::table::PageTable;
use crate::output::figure::Curve;
use crate::output::opening_summary::OpeningSummary;
use crate::output::results::Results;
use crate::output::tables::{self, OpeningRow, SectionRow};
use crate::tabular::units::MMHG;
use std::io;

/// Colours of the openings on a page, the inlet first and then the outlets.
pub const COLOURS: [usize; 6] = [2, 1, 4, 3, 5, 6];

/// A curve for each name among the rows, in the order in which they come; `point` is none where a row has no value.
fn curves<Row>(
    rows: &[Row],
    name: fn(&Row) -> &str,
    point: fn(&Row) -> Option<(f64, f64)>,
) -> Vec<Curve> {
    let curve = |(number, (name, points)): (usize, (String, _))| Curve {
        open: number / COLOURS.len() % 2 == 1,
        ..line(&name, COLOURS[number % COLOURS.len()], points)
    };
    let found = tables::by_name(rows, name, point).into_iter();
    found.enumerate().map(curve).collect()
}

/// Flow and pressure of openings by name, where there are more than two.
///
/// # Errors
/// If the table cannot be read.
pub fn openings(run: &Results) -> io::Result<Vec<String>> {
    let path = run.files.openings();
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let rows: Vec<OpeningRow> = tables::read(&path)?;
    let of = |point| curves(&rows, |row: &OpeningRow| row.opening.as_str(), point);
    let flows = of(|row| Some((row.time_s, 1e6 * row.flow_m3_s)));
    if flows.len() < 3 {
        return Ok(Vec::new());
    }
    let pressures = of(|row| Some((row.time_s, row.p_Pa / MMHG)));
    let split = split(run, &rows);
    let shown = of_most_flow(&flows);
    let which = match shown.len() < flows.len() {
        true => format!(
            "the {} openings of {} with most flow",
            shown.len(),
            flows.len()
        ),
        false => "each opening".into(),
    };
    let [flows, pressures] = [flows, pressures].map(|curves| {
        let all = curves.into_iter().enumerate();
        let kept = all.filter(|(i, _)| shown.contains(i)).zip(COLOURS);
        let curve = |((_, curve), colour)| Curve {
            colour,
            open: false,
            ..curve
        };
        kept.map(curve).collect::<Vec<Curve>>()
    });
    Ok(vec![
        split,
        chart(
            "opening-flow",
            &format!("Flow into the domain through {which}."),
            panel("flow into the domain", "time / s", "flow / (ml/s)", flows),
        ),
        chart(
            "opening-pressure",
            &format!("Mean pressure at {which}."),
            panel("pressure", "time / s", "pressure / mmHg", pressures),
        ),
    ])
}

/// What leaves through each opening on average over the evaluated window, as a share of all that leaves too, and the
/// pressures there.
fn split(run: &Results, rows: &[OpeningRow]) -> String {
    let mut table = PageTable::new([
        "opening",
        "mean outflow / (ml/s)",
        "share of what leaves / %",
        "pressure, lowest / mmHg",
        "mean / mmHg",
        "highest / mmHg",
    ]);
    for it in OpeningSummary::all(rows, run.hemodynamics.window, run.case.time.step) {
        let share = it.share_of_outflow;
        let share = share.map_or("–".into(), |share| significant(100.0 * share, 3));
        let p = it.p_Pa;
        let pressures = [p.min, p.mean, p.max].map(|p| significant(p / MMHG, 4));
        let outflow = significant(1e6 * it.mean_outflow_m3_s, 4);
        table.push(
            [it.opening, outflow, share]
                .into_iter()
                .chain(pressures)
                .collect(),
        );
    }
    table.to_html()
}

/// Which curves are drawn, in their order: as many as there are colours, those whose flow is largest on average.
fn of_most_flow(flows: &[Curve]) -> Vec<usize> {
    let size = |i: &usize| {
        flows[*i]
            .points
            .iter()
            .map(|(_, flow)| flow.abs())
            .sum::<f64>()
    };
    let mut order: Vec<usize> = (0..flows.len()).collect();
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    order.truncate(COLOURS.len());
    order.sort_unstable();
    order
}

/// Flow, pressure and area of the cross-sections that the case watches, if there are any.
///
/// # Errors
/// If the table cannot be read.
pub fn sections(run: &Results) -> io::Result<Vec<String>> {
    let path = run.files.sections();
    if !path.is_file() {
        return Ok(Vec::new());
    }
    let rows: Vec<SectionRow> = tables::read(&path)?;
    let of = |point| curves(&rows, |row: &SectionRow| row.section.as_str(), point);
    let flows = of(|row| Some((row.time_s, 1e6 * row.flow_m3_s?)));
    let pressures = of(|row| Some((row.time_s, row.p_Pa / MMHG)));
    let areas = of(|row| Some((row.time_s, 1e6 * row.area_m2)));
    Ok(vec![
        chart(
            "section-flow",
            "Flow through each cross-section, away from the inlet.",
            panel("flow", "time / s", "flow / (ml/s)", flows),
        ),
        chart(
            "section-pressure",
            "Mean pressure on the wall at each cross-section.",
            panel("pressure", "time / s", "pressure / mmHg", pressures),
        ),
        chart(
            "section-area",
            "Area of each cross-section.",
            panel("area", "time / s", "area / mm\u{b2}", areas),
        ),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The six openings of most flow, in their order, whichever way it goes; all where there are no more.
    #[test]
    fn as_many_openings_are_drawn_as_there_are_colours() {
        let flows = [9.0, -0.1, -5.0, 3.0, -0.2, 2.0, -7.0, -6.0];
        let curves = flows.map(|flow| line("", 0, vec![(0.0, 0.0), (1.0, flow)]));
        assert_eq!(of_most_flow(&curves), [0, 2, 3, 5, 6, 7]);
        assert_eq!(of_most_flow(&curves[..3]), [0, 1, 2]);
    }
}
