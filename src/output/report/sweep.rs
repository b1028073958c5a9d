//! Measures of the runs of a study over what differs between their cases: as a table, and drawn.

use super::measure;
use super::page::{chart, line, panel};
use super::table::PageTable;
use crate::case::{Case, MeasureOf, MeasureTable, OutputMeasure};
use crate::hemodynamics::RegionName;
use crate::hemodynamics::summary::{Course, RegionSummary, VesselSummary};
use crate::output::figure::{Curve, Marker};
use crate::output::results::Results;
use crate::output::tables::{self, HistoryRow};
use crate::tabular::units::MMHG;
use std::collections::{BTreeMap, BTreeSet};

/// Curves of a figure, at most.
const MOST_CURVES: usize = 8;
/// Parameters that get figures, at most.
const MOST_PARAMETERS: usize = 4;

/// A measure of a run: its name with its unit, and its value if the run has it.
struct SweepMeasure {
    name: String,
    value: ValueOf,
}

/// What a run has of a measure.
type ValueOf = Box<dyn Fn(&Results) -> Option<f64>>;

type OfVessel = (&'static str, fn(&VesselSummary) -> f64);
type OfHistory = (&'static str, fn(&HistoryRow) -> f64, fn(&Course) -> f64);
type OfRegion = (&'static str, fn(&RegionSummary) -> f64);

const OF_VESSEL: [OfVessel; 4] = [
    ("outlet pressure, lowest / mmHg", |v| v.p_out_Pa.min / MMHG),
    ("outlet pressure, highest / mmHg", |v| v.p_out_Pa.max / MMHG),
    ("largest outflow / (ml/s)", |v| 1e6 * v.Q_out_m3_s.max),
    ("largest displacement / mm", |v| {
        1e3 * v.max_displacement_m.max
    }),
];

/// Of what the history has in the window.
const OF_HISTORY: [OfHistory; 6] = [
    (
        "outlet pressure, mean / mmHg",
        |row| row.p_out_Pa / MMHG,
        |c| c.mean,
    ),
    (
        "inlet pressure, lowest / mmHg",
        |row| row.p_in_Pa / MMHG,
        |c| c.min,
    ),
    (
        "inlet pressure, mean / mmHg",
        |row| row.p_in_Pa / MMHG,
        |c| c.mean,
    ),
    (
        "inlet pressure, highest / mmHg",
        |row| row.p_in_Pa / MMHG,
        |c| c.max,
    ),
    (
        "inlet pulse pressure / mmHg",
        |row| row.p_in_Pa / MMHG,
        |c| c.max - c.min,
    ),
    (
        "distension of the lumen's volume / %",
        |row| row.lumen_volume_m3,
        |c| 100.0 * (c.max / c.min - 1.0),
    ),
];

const OF_REGION: [OfRegion; 6] = [
    ("TAWSS, mean / Pa", |r| r.TAWSS_Pa.mean),
    ("TAWSS, largest / Pa", |r| r.TAWSS_Pa.max),
    ("OSI, mean", |r| r.OSI.mean),
    ("OSI, largest", |r| r.OSI.max),
    ("lumen volume, mean / ml", |r| 1e6 * r.mean_volume()),
    ("von Mises stress, largest / kPa", |r| {
        1e-3 * r.max_von_mises_Pa.max
    }),
];

/// All values of a case by their dotted keys.
pub(super) fn values(case: &Case) -> BTreeMap<String, String> {
    let values = case.values_by_name().into_iter();
    values
        .map(|(path, value)| (path, value.to_string()))
        .collect()
}

/// Those that any of the runs has, of the vessel and of each of its regions.
fn measures(runs: &[&Results]) -> Vec<SweepMeasure> {
    let mut regions: Vec<RegionName> = Vec::new();
    for region in runs.iter().flat_map(|run| &run.hemodynamics.regions) {
        if !regions.contains(&region.region.name) {
            regions.push(region.region.name);
        }
    }
    let of_vessel = OF_VESSEL.iter().map(|&(name, value)| SweepMeasure {
        name: name.to_owned(),
        value: Box::new(move |run| run.hemodynamics.vessel.as_ref().map(value)),
    });
    let of_region = regions.iter().flat_map(|&region| {
        OF_REGION.iter().map(move |&(name, value)| SweepMeasure {
            name: format!("{region}: {name}"),
            value: Box::new(move |run| run.hemodynamics.region(region.as_str()).map(value)),
        })
    });
    let of_history = OF_HISTORY.iter().map(|&(name, value, of)| SweepMeasure {
        name: name.to_owned(),
        value: Box::new(move |run| {
            let (window, step) = (run.hemodynamics.window, run.case.time.step);
            let rows = tables::whole_steps(&run.history, step).into_iter();
            let inside = rows.filter(|row| window.contains(row.time_s, step));
            Course::of(&inside.map(value).collect::<Vec<_>>())
                .as_ref()
                .map(of)
        }),
    });
    let of_cases = asked_for(runs).into_iter().map(|asked| SweepMeasure {
        name: asked.name.clone(),
        value: Box::new(move |run| measure::value(&asked, run)),
    });
    let is_there = |measure: &SweepMeasure| runs.iter().any(|run| measure.of(run).is_some());
    of_vessel
        .chain(of_region)
        .chain(of_history)
        .chain(of_cases)
        .filter(is_there)
        .collect()
}

/// The measures that the cases of the runs add, each once, and of vessels with more than two openings what flows
/// through each of them under which pressure.
fn asked_for(runs: &[&Results]) -> Vec<OutputMeasure> {
    let of_cases = runs.iter().flat_map(|run| run.case.measures().to_vec());
    let mut asked: Vec<OutputMeasure> = Vec::new();
    for measure in of_openings(runs).into_iter().chain(of_cases) {
        if !asked.iter().any(|other| other.name == measure.name) {
            asked.push(measure);
        }
    }
    asked
}

fn of_openings(runs: &[&Results]) -> Vec<OutputMeasure> {
    let names = runs.first().and_then(|run| run.case.opening_names());
    let names = names.filter(|names| names.len() > 2).unwrap_or_default();
    let measure = |name: &String, what: &str, column: &str| OutputMeasure {
        name: format!("{name}: {what}"),
        table: MeasureTable::Openings,
        at: Some(name.clone()),
        column: column.to_owned(),
        of: MeasureOf::Mean,
        phase: None,
    };
    let both = |name: &String| {
        [
            measure(name, "mean inflow / (m³/s)", "flow_m3_s"),
            measure(name, "mean pressure / Pa", "p_Pa"),
        ]
    };
    names.iter().flat_map(both).collect()
}

/// What each of the runs has of each measure.
pub(super) fn values_of_measures(runs: &[&Results]) -> Vec<(String, Vec<Option<f64>>)> {
    let measures = measures(runs).into_iter();
    measures
        .map(|measure| {
            let values = runs.iter().map(|run| measure.of(run)).collect();
            (measure.name, values)
        })
        .collect()
}

impl SweepMeasure {
    fn of(&self, run: &Results) -> Option<f64> {
        (self.value)(run).filter(|value| value.is_finite())
    }
}

/// The keys whose values are not the same in all runs, but for those of what is written.
fn parameters(cases: &[BTreeMap<String, String>]) -> Vec<String> {
    let keys: BTreeSet<&String> = cases.iter().flat_map(BTreeMap::keys).collect();
    let differs = |key: &&String| {
        cases
            .iter()
            .any(|case| case.get(*key) != cases[0].get(*key))
    };
    let is_input = |key: &&String| !key.starts_with("output.");
    keys.into_iter()
        .filter(is_input)
        .filter(differs)
        .cloned()
        .collect()
}

/// A row a run: what differs between the cases, then what was found.
pub fn table(runs: &[&Results]) -> PageTable {
    let cases: Vec<_> = runs.iter().map(|run| values(&run.case)).collect();
    let (keys, measures) = (parameters(&cases), measures(runs));
    let heads = std::iter::once("case".to_owned()).chain(keys.iter().cloned());
    let mut table =
        PageTable::new(heads.chain(measures.iter().map(|measure| measure.name.clone())));
    for (run, case) in runs.iter().zip(&cases) {
        let given = keys
            .iter()
            .map(|key| case.get(key).cloned().unwrap_or_default());
        let given = given.map(|value| match value.parse::<f64>() {
            Ok(number) => format!("{number:?}"),
            Err(_) => value.trim_matches('"').to_owned(),
        });
        let found = measures
            .iter()
            .map(|measure| measure.of(run).map_or(String::new(), seven_digits));
        table.push(
            std::iter::once(run.name())
                .chain(given)
                .chain(found)
                .collect(),
        );
    }
    table
}

fn seven_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    rounded.to_string()
}

/// Each measure over each numeric parameter; runs that are alike in all other parameters are joined by a line.
pub fn figures(runs: &[&Results]) -> Vec<String> {
    let cases: Vec<_> = runs.iter().map(|run| values(&run.case)).collect();
    let keys = parameters(&cases);
    let number = |case: &BTreeMap<String, String>, key: &String| -> Option<f64> {
        case.get(key)?.parse().ok()
    };
    let is_numeric = |key: &&String| cases.iter().all(|case| number(case, key).is_some());
    let numeric: Vec<&String> = keys
        .iter()
        .filter(is_numeric)
        .take(MOST_PARAMETERS)
        .collect();
    let measures = measures(runs);
    let mut figures = Vec::new();
    for key in numeric {
        let others: Vec<&String> = keys.iter().filter(|other| *other != key).collect();
        let mut groups: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (i, case) in cases.iter().enumerate() {
            let alike: Vec<String> = others
                .iter()
                .map(|key| label(key, case.get(*key)))
                .collect();
            groups.entry(alike.join(", ")).or_default().push(i);
        }
        // What varies all at once is a cloud of points.
        let is_cloud = groups.len() > MOST_CURVES || groups.values().all(|group| group.len() == 1);
        if is_cloud {
            groups = BTreeMap::from([(String::new(), (0..runs.len()).collect())]);
        }
        for measure in &measures {
            let curve = |(number_of, (name, group)): (usize, (&String, &Vec<usize>))| {
                let point = |&i: &usize| Some((number(&cases[i], key)?, measure.of(runs[i])?));
                let mut points: Vec<(f64, f64)> = group.iter().filter_map(point).collect();
                points.sort_by(|a, b| a.0.total_cmp(&b.0));
                Curve {
                    marker: Some(Marker::Circle),
                    ..line(name, number_of, points)
                }
            };
            let curves: Vec<Curve> = match is_cloud {
                // A curve a point: nothing joins them.
                true => {
                    let points = curve((2, (&String::new(), &groups[""]))).points;
                    let alone = |point| Curve {
                        marker: Some(Marker::Circle),
                        ..line("", 2, vec![point])
                    };
                    points.into_iter().map(alone).collect()
                }
                false => groups.iter().enumerate().map(curve).collect(),
            };
            if curves.iter().map(|curve| curve.points.len()).sum::<usize>() > 1 {
                let file = format!("{}-over-{}", measure.name, key)
                    .replace([' ', '/', '(', ')', ':', ','], "-");
                let caption = format!("{} over {key}.", measure.name);
                figures.push(chart(
                    &file,
                    &caption,
                    panel("", key, &measure.name, curves),
                ));
            }
        }
    }
    figures
}

/// A key by its last name, with its value.
fn label(key: &str, value: Option<&String>) -> String {
    let name = key.rsplit('.').next().unwrap_or(key);
    format!(
        "{name} {}",
        value.map_or("absent", String::as_str).trim_matches('"')
    )
}
