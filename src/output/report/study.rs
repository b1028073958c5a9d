//! The page of a study: runs of any cases beside each other, each by its own name.

use super::maps::{self, OSI, RADIUS, TAWSS};
use super::page::{
    Page, chart, download, escape, figure, gallery, line, panel, significant, table, warnings,
};
use super::quantities::MMHG;
use super::scene;
use super::surface::{Field, Surface};
use crate::case::Case;
use crate::hemodynamics::RegionName::{Artery, Bypass, MidArtery};
use crate::hemodynamics::periodicity::Difference;
use crate::hemodynamics::summary::RegionSummary;
use crate::output::figure::Curve;
use crate::output::results::Results;
use crate::output::tables::HistoryRow;
use std::collections::{BTreeMap, BTreeSet};
use std::io;

/// Curves with colours of their own; later ones are dashed.
const COLOURS: usize = 7;
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
}

/// Writes the page.
pub fn page(study: &Study) -> io::Result<String> {
    let runs: Vec<&Results> = study.runs.iter().collect();
    let names: Vec<String> = runs.iter().map(|run| run.name()).collect();
    let lead = format!("{} run(s): {}.", runs.len(), names.join(", "));
    let mut page = Page::new(&study.title, &lead);
    page.section("cases", "Cases", &cases(&runs, &study.missing));
    page.section("differences", "What differs", &differences(&runs));
    page.section("histories", "Over time", &gallery(&histories(&runs)));
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

/// A row for each run, what is to be known before it is believed, and those that are missing.
pub(crate) fn cases(runs: &[&Results], missing: &[String]) -> String {
    let heads = [
        "case",
        "steps",
        "coupling iterations a step",
        "s per step",
        "outlet pressure / mmHg",
        "period to period, outflow / %",
        "period to period, displacement / %",
        "artery volume / ml",
        "artery mean WSS / Pa",
        "mid-artery largest WSS / Pa",
        "bypass largest OSI",
        "artery largest OSI",
        "mid-artery largest OSI",
        "mid-artery largest von Mises / kPa",
    ];
    let show = |value: Option<String>| value.unwrap_or_else(|| "–".into());
    let row = |run: &&Results| {
        let found = &run.hemodynamics;
        let last = |differences: &[Difference]| {
            show(
                differences
                    .last()
                    .map(|d| significant(100.0 * d.relative, 3)),
            )
        };
        let of = |region, value: fn(&RegionSummary) -> f64| {
            show(found.region(region).map(|r| significant(value(r), 4)))
        };
        let summary = run.summary.as_ref();
        vec![
            escape(&run.name()),
            run.history.len().to_string(),
            show(summary.map(|s| format!("{:.2}", s.mean_coupling_iterations))),
            show(summary.map(|s| significant(s.seconds_per_step, 3))),
            show(found.vessel.as_ref().map(|v| {
                let [low, high] =
                    [v.p_out_Pa.min, v.p_out_Pa.max].map(|p| significant(p / MMHG, 3));
                format!("{low} to {high}")
            })),
            last(&found.periodicity.outflow),
            last(&found.periodicity.max_displacement),
            of(Artery, |r| 1e6 * r.mean_volume()),
            of(Artery, |r| r.mean_wall_shear_Pa.mean),
            of(MidArtery, |r| r.max_wall_shear_Pa.max),
            of(Bypass, |r| r.OSI.max),
            of(Artery, |r| r.OSI.max),
            of(MidArtery, |r| r.OSI.max),
            of(MidArtery, |r| 1e-3 * r.max_von_mises_Pa.max),
        ]
    };
    let rows: Vec<Vec<String>> = runs.iter().map(row).collect();
    let mut html = warnings(&doubts(runs)) + &table(&heads, &rows);
    let lines = std::iter::once(heads.map(str::to_owned).to_vec()).chain(rows);
    let quoted = lines.map(|line| {
        let cells = line.iter().map(|cell| format!("\"{cell}\""));
        cells.collect::<Vec<_>>().join(",")
    });
    let csv = quoted.collect::<Vec<_>>().join("\n");
    html += &format!("<p>{}</p>\n", download("cases", &csv));
    for missing in missing {
        html += &format!("<p class=\"lead\">{}</p>\n", escape(missing));
    }
    html
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
    let sentence = |(text, names): (String, Vec<String>)| format!("{}: {text}.", names.join(", "));
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

/// All values of a case by their dotted keys.
fn values(case: &Case) -> BTreeMap<String, String> {
    let values = case.values().into_iter();
    values
        .map(|(path, _, value)| (path, value.to_string()))
        .collect()
}

/// What the vessels do over time, a curve for each run.
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
        let curves = runs.iter().enumerate().map(curve).collect();
        let file = title.replace(' ', "-");
        chart(&file, caption, panel(title, "time / s", label, curves))
    };
    quantities.into_iter().map(draw).collect()
}

/// Rendered pictures of some runs with the same colours, where their field is largest.
pub(crate) fn pictures(runs: &[&Results], field: &str, caption: &str) -> io::Result<Vec<String>> {
    let mut found = Vec::new();
    for run in runs {
        if let Some(surface) = Surface::of(run)?
            && let Some(field) = surface.field(field).cloned()
        {
            found.push((run.name(), surface, field));
        }
    }
    let highs = found.iter().map(|(.., field)| field.high);
    let high = highs.fold(0.0, f64::max);
    let picture = |(name, surface, field): (String, Surface, Field)| {
        // What is averaged over the window has no largest frame.
        let frame = match field.values.len() {
            1 => surface.widest_frame(),
            _ => field.largest_frame(),
        };
        let time = surface.times[frame];
        let field = Field { high, ..field };
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
