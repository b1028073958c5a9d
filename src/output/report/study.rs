//! The page of a study: runs of any cases side by side, each by its own name.

use super::key_figures::{COUPLING, COURSE, KeyFigure, RESULTS};
use super::maps::{self, OSI, RADIUS, TAWSS};
use super::page::{Page, chart, download, escape, figure, gallery, line, panel, table, warnings};
use super::scene;
use super::surface::{DrawnSurface, SurfaceField};
use super::sweep::{self, values};
use super::table::PageTable;
use super::uncertainty::Uncertainty;
use crate::output::figure::Curve;
use crate::output::refinement::Limit;
use crate::output::results::Results;
use crate::output::tables::HistoryRow;
use crate::tabular::units::MMHG;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::PathBuf;

/// Curves with colours of their own; later ones are dashed.
const COLOURS: usize = 7;
/// Runs that are each named and drawn; of more, the spread is shown.
const MOST_DRAWN: usize = 16;
/// Shares of the percentiles of many runs.
const PERCENTILES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
/// A value that is longer is not shown in a table.
const LONGEST_VALUE: usize = 40;

/// Runs of different cases.
#[derive(Debug)]
pub struct Study {
    /// Its name.
    pub title: String,
    /// The runs in the order in which they are shown.
    pub runs: Vec<Results>,
    /// Runs that cannot be shown, and why.
    pub missing: Vec<String>,
    /// Its folder.
    pub folder: PathBuf,
}

/// Writes the page.
pub fn page(study: &Study) -> io::Result<String> {
    let runs: Vec<&Results> = study.runs.iter().collect();
    let names: Vec<String> = runs.iter().map(|run| run.name()).collect();
    let lead = format!("{} run(s): {}.", runs.len(), listed(&names));
    let mut page = Page::new(&study.title, &lead);
    let uncertainty = Uncertainty::of(&runs, &study.folder).map_err(io::Error::other)?;
    if let Some(uncertainty) = uncertainty {
        let folder = &study.folder;
        let html = uncertainty.section(runs[0])?
            + &super::uncertainty_total::kept(folder)
            + &super::uncertainty_control::kept(folder);
        page.section("uncertainty", "Uncertainty", &html);
    }
    page.section("cases", "Cases", &cases(&runs, &study.missing));
    page.section("differences", "What differs", &differences(&runs));
    let over_parameters = sweep::figures(&runs);
    if !over_parameters.is_empty() {
        let table = download("measures", &sweep::table(&runs).to_csv());
        let html = format!(
            "<p>Parameters and measures: {table}</p>\n{}",
            gallery(&over_parameters)
        );
        page.section("measures", "Measures over parameters", &html);
    }
    page.section("histories", "Over time", &gallery(&histories(&runs)));
    if runs.len() > MOST_DRAWN {
        return Ok(page.to_html());
    }
    let mut views = pictures(&runs, "Displacement", "Displacement of the wet surface")?;
    views.extend(pictures(
        &runs,
        "Von Mises",
        "Von Mises stress at the inner side of the wall",
    )?);
    if !views.is_empty() {
        page.section("view", "Deformed wall", &gallery(&views));
    }
    let maps = all_maps(&runs);
    if !maps.is_empty() {
        page.section("maps", "On the unrolled wall", &gallery(&maps));
    }
    Ok(page.to_html())
}

/// Names in a row; of many, the first and the last.
fn listed(names: &[String]) -> String {
    match names {
        [first, second, .., last] if names.len() > MOST_DRAWN => {
            format!("{first}, {second}, ... {last}")
        }
        _ => names.join(", "),
    }
}

/// A row for each run, what is to be known before it is believed, and those that are missing.
pub(crate) fn cases(runs: &[&Results], missing: &[String]) -> String {
    let table = key_figures(runs);
    let mut html = warnings(&doubts(runs)) + &table.to_html();
    html += &format!("<p>{}</p>\n", download("cases", &table.to_csv()));
    for missing in missing {
        html += &format!("<p class=\"lead\">{}</p>\n", escape(missing));
    }
    html
}

/// What each run has cost and found.
pub fn key_figures(runs: &[&Results]) -> PageTable {
    figures_of(runs, "case", COURSE.iter().chain(&RESULTS))
}

/// How large each run is, and how its coupling went.
pub fn coupling(runs: &[&Results]) -> PageTable {
    figures_of(runs, "run", COUPLING.iter())
}

/// A row for each run; what none of them has, such as a region of another kind of vessel, has no column.
fn figures_of<'a>(
    runs: &[&Results],
    head: &str,
    figures: impl Iterator<Item = &'a KeyFigure>,
) -> PageTable {
    let is_there = |figure: &&KeyFigure| runs.iter().any(|run| figure.of(run).is_some());
    let figures: Vec<&KeyFigure> = figures.filter(is_there).collect();
    let names = figures.iter().map(|figure| figure.name);
    let mut table = PageTable::new(std::iter::once(head).chain(names));
    for run in runs {
        let cells = figures.iter().map(|figure| figure.show(run));
        table.push(std::iter::once(run.name()).chain(cells).collect());
    }
    table
}

/// By how much what the second run of each pair has found is larger than in the first.
pub fn changes(pairs: &[(&Results, &Results)]) -> PageTable {
    let heads = std::iter::once("case");
    let mut table = PageTable::new(heads.chain(RESULTS.iter().map(|figure| figure.name)));
    for (run, other) in pairs {
        let changes = RESULTS.iter().map(|figure| figure.show_change(run, other));
        table.push(std::iter::once(other.name()).chain(changes).collect());
    }
    table
}

/// A case on two meshes of each of two solvers.
pub struct RefinedPair<'a> {
    /// The first solver, whose order in space is two: coarser and finer mesh.
    pub first: [&'a Results; 2],
    /// The second, whose errors fall faster than any power: lower and higher resolution.
    pub second: [&'a Results; 2],
    /// The same case before and after something else was refined, with either solver.
    pub other_refinements: [Vec<[&'a Results; 2]>; 2],
}

impl RefinedPair<'_> {
    /// How much longer the first solver's cells are on the coarser mesh.
    fn ratio(&self) -> Option<f64> {
        let [coarse, fine] = self.first.map(|run| run.summary.as_ref());
        Some((fine?.fluid_cells as f64 / coarse?.fluid_cells as f64).cbrt())
    }
}

/// Where both solvers lead as their meshes become finer, with uncertainties, and whether they lead to the same.
pub fn agreement(pairs: &[RefinedPair], names: [&str; 2]) -> PageTable {
    let heads = pairs.iter().flat_map(|pair| {
        let case = pair.first[1].name();
        [
            format!("{case}: {}", names[0]),
            names[1].to_owned(),
            "agree".to_owned(),
        ]
    });
    let mut table = PageTable::new(std::iter::once("figure".to_owned()).chain(heads));
    for figure in RESULTS.iter().filter(|figure| !figure.is_place()) {
        let cells = pairs.iter().flat_map(|pair| {
            let limits = pair.ratio().and_then(|ratio| {
                let [a, b] = [pair.first, pair.second]
                    .map(|runs| Some([figure.of(runs[0])?, figure.of(runs[1])?]));
                let ([coarse, fine], [low, high]) = a.zip(b)?;
                let limits = [
                    Limit::of_meshes(coarse, fine, ratio),
                    Limit::of_degrees(low, high),
                ];
                let [first, second] = [0, 1].map(|i| {
                    let other_refinements = pair.other_refinements[i].iter();
                    other_refinements.fold(limits[i], |limit, runs| {
                        match (figure.of(runs[0]), figure.of(runs[1])) {
                            (Some(before), Some(after)) => limit.with(after - before),
                            _ => limit,
                        }
                    })
                });
                Some((first, second))
            });
            match limits {
                None => ["–", "–", "–"].map(str::to_owned),
                Some((first, second)) => [
                    figure.show_limit(&first),
                    figure.show_limit(&second),
                    if first.agrees_with(&second) {
                        "yes"
                    } else {
                        "no"
                    }
                    .to_owned(),
                ],
            }
        });
        table.push(
            std::iter::once(figure.name.to_owned())
                .chain(cells)
                .collect(),
        );
    }
    table
}

/// The warnings of all runs, each once with the names of those that it is about.
fn doubts(runs: &[&Results]) -> Vec<String> {
    let mut about: Vec<(String, Vec<String>)> = Vec::new();
    for run in runs {
        for warning in run.warnings() {
            match about.iter_mut().find(|(text, _)| *text == warning) {
                Some((_, names)) => names.push(run.name()),
                None => about.push((warning, vec![run.name()])),
            }
        }
    }
    let sentence = |(text, names): (String, Vec<String>)| match names.len() {
        count if count > MOST_DRAWN => format!("{count} runs ({}): {text}.", listed(&names)),
        _ => format!("{}: {text}.", names.join(", ")),
    };
    about.into_iter().map(sentence).collect()
}

/// The keys whose values are not the same in all cases.
fn differences(runs: &[&Results]) -> String {
    let cases: Vec<BTreeMap<String, String>> = runs.iter().map(|run| values(&run.case)).collect();
    let keys: BTreeSet<&String> = cases.iter().flat_map(BTreeMap::keys).collect();
    let shown = |value: Option<&String>| match value {
        None => "–".into(),
        Some(value) if value.chars().count() > LONGEST_VALUE => "…".into(),
        Some(value) => escape(value),
    };
    let differs = |key: &&&String| {
        cases
            .iter()
            .any(|case| case.get(**key) != cases[0].get(**key))
    };
    let row = |key: &String| {
        let values = cases.iter().map(|case| shown(case.get(key)));
        std::iter::once(escape(key)).chain(values).collect()
    };
    let rows: Vec<Vec<String>> = keys.iter().filter(differs).map(|key| row(key)).collect();
    if rows.is_empty() {
        return "<p>The cases have the same values.</p>\n".into();
    }
    let names = runs.iter().map(|run| escape(&run.name()));
    let heads: Vec<String> = std::iter::once("key".to_owned()).chain(names).collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    table(&heads, &rows)
}

/// What the vessels do over time: a curve for each run, or percentiles of many.
fn histories(runs: &[&Results]) -> Vec<String> {
    type Quantity = (
        &'static str,
        &'static str,
        &'static str,
        fn(&HistoryRow) -> f64,
    );
    let quantities: [Quantity; 6] = [
        ("inflow", "flow / (ml/s)", "Flow at the inlet.", |row| {
            1e6 * row.Q_in_m3_s
        }),
        ("outflow", "flow / (ml/s)", "Flow at the outlet.", |row| {
            1e6 * row.Q_out_m3_s
        }),
        (
            "outlet pressure",
            "pressure / mmHg",
            "Mean pressure at the outlet.",
            |row| row.p_out_Pa / MMHG,
        ),
        (
            "lumen volume",
            "volume / ml",
            "Volume of the deformable lumen.",
            |row| 1e6 * row.lumen_volume_m3,
        ),
        (
            "displacement",
            "displacement / mm",
            "Largest displacement of the wet surface.",
            |row| 1e3 * row.max_displacement_m,
        ),
        (
            "von Mises stress",
            "stress / kPa",
            "Largest stress at the quadrature points.",
            |row| 1e-3 * row.max_von_mises_Pa,
        ),
    ];
    let draw = |(title, label, caption, value): Quantity| {
        let curve = |(i, run): (usize, &&Results)| {
            let rows = run.history.iter();
            Curve {
                open: i / COLOURS % 2 == 1,
                ..line(
                    &run.name(),
                    i,
                    rows.map(|row| (row.time_s, value(row))).collect(),
                )
            }
        };
        let (curves, caption) = match percentiles(runs, value) {
            Some(curves) => (curves, format!("{caption} Percentiles of all runs.")),
            None => (runs.iter().enumerate().map(curve).collect(), caption.into()),
        };
        let file = title.replace(' ', "-");
        chart(&file, &caption, panel(title, "time / s", label, curves))
    };
    quantities.into_iter().map(draw).collect()
}

/// Percentiles of many runs over time; none of few ones, or if their times are not the same.
fn percentiles(runs: &[&Results], value: fn(&HistoryRow) -> f64) -> Option<Vec<Curve>> {
    let first = &runs.first()?.history;
    let is_alike = |run: &&Results| {
        run.history.len() == first.len()
            && (run.history.iter().zip(first)).all(|(a, b)| a.time_s == b.time_s)
    };
    if runs.len() <= MOST_DRAWN || !runs.iter().all(is_alike) {
        return None;
    }
    let sorted = |step: usize| {
        let at = runs.iter().map(|run| value(&run.history[step]));
        let mut values: Vec<f64> = at.collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let all: Vec<Vec<f64>> = (0..first.len()).map(sorted).collect();
    let curve = |(i, share): (usize, f64)| {
        let place = (share * (runs.len() - 1) as f64).round() as usize;
        let points = first.iter().zip(&all);
        let points = points.map(|(row, values)| (row.time_s, values[place]));
        let name = format!("{:.0} %", 100.0 * share);
        line(&name, i, points.collect())
    };
    Some(PERCENTILES.into_iter().enumerate().map(curve).collect())
}

/// Rendered pictures of some runs with the same colours, where their field is largest.
pub(crate) fn pictures(runs: &[&Results], field: &str, caption: &str) -> io::Result<Vec<String>> {
    let mut found = Vec::new();
    for run in runs {
        if let Some(surface) = DrawnSurface::of(run)?
            && let Some(field) = surface.field(field).cloned()
        {
            found.push((run.name(), surface, field));
        }
    }
    let highs = found.iter().map(|(.., field)| field.high);
    let high = highs.fold(0.0, f64::max);
    let picture = |(name, surface, field): (String, DrawnSurface, SurfaceField)| {
        // What is averaged over the window has no largest frame.
        let frame = match field.values.len() {
            1 => surface.widest_frame(),
            _ => field.largest_frame(),
        };
        let time = surface.times[frame];
        let field = SurfaceField { high, ..field };
        let caption = format!("{name}, t = {time:.3} s: {caption}.");
        scene::picture(&surface, &field, frame, &caption)
    };
    Ok(found.into_iter().map(picture).collect())
}

/// Maps of all runs of vessels with the same colours.
pub(crate) fn all_maps(runs: &[&Results]) -> Vec<String> {
    let mapped = |run: &&Results| run.vessel.is_some() && !run.faces.is_empty();
    let with_faces = runs.iter().copied().filter(mapped);
    let runs: Vec<&Results> = with_faces.collect();
    let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
    let mut figures = Vec::new();
    for (field, from_zero) in [(RADIUS, false), (TAWSS, true), (OSI, true)] {
        let range = maps::range(&runs, field, everywhere, from_zero);
        for run in &runs {
            let svg = maps::map(run, field, &run.name(), maps::whole(run), range);
            let caption = format!("{}, same colours for all runs.", field.label);
            figures.push(figure(&svg, &caption, None));
        }
    }
    figures
}
