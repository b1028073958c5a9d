//! What the samples of uncertain inputs say: moments, percentiles and indices of each measure, as tables and drawn.

use super::page::{chart, escape, figure, file_name, gallery, line, panel, significant, table};
use super::samples::moments_of;
use super::sweep;
use super::table::PageTable;
use super::uncertain_maps::UncertainWall;
use crate::case::{self, Override, Uncertain, ValuePlace};
use crate::files::FileError;
use crate::output::figure::Curve;
use crate::output::figure::bars::{Bars, bars};
use crate::output::results::Results;
use crate::uncertainty::{Chaos, Inputs, SensitivityIndex, sobol_point};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// The table of the samples in the folder of a study.
pub const SAMPLES: &str = "samples.csv";
/// Points at which a chaos is evaluated for its distribution.
const POINTS: usize = 4096;
/// The shares of the percentiles.
const PERCENTILES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];
/// Measures with figures on the page, at most.
const MOST_SHOWN: usize = 16;
/// Of the variance: chaos that misses more is not to be believed.
const LARGE_ERROR: f64 = 0.1;
/// Columns of a histogram.
const COLUMNS: usize = 24;

/// What the samples of a study say of its inputs.
pub struct Uncertainty {
    pub(super) inputs: Inputs,
    pub(super) tables: Vec<Uncertain>,
    is_dependent: bool,
    /// Samples of the table.
    samples: usize,
    /// Of each run that was used its name and the values of its inputs.
    pub(super) points: Vec<(String, Vec<f64>)>,
    pub(super) measures: Vec<UncertainMeasure>,
    wall: Option<UncertainWall>,
    /// The case of the first run that was used.
    base: PathBuf,
    /// Of each input whether it is the value of its key; otherwise a factor.
    is_value: Vec<bool>,
}

/// A measure that differs between the samples.
pub(super) struct UncertainMeasure {
    pub name: String,
    /// Of each run that was used, if it has the measure.
    pub of_runs: Vec<Option<f64>>,
    values: Vec<f64>,
    chaos: Option<Chaos>,
    indices: Vec<SensitivityIndex>,
    /// Values of the chaos at many points, in order.
    distribution: Vec<f64>,
}

impl Uncertainty {
    /// Of the runs of the study in a folder; none if that has no samples of uncertain inputs.
    ///
    /// # Errors
    /// If its table cannot be read, or is not of the inputs of its runs.
    pub fn of(runs: &[&Results], folder: &Path) -> Result<Option<Self>, FileError> {
        let path = folder.join(SAMPLES);
        let first = runs.first().map(|run| &run.case);
        let (Some(case), true) = (first, path.is_file()) else {
            return Ok(None);
        };
        let Some(tables) = case.uncertain.clone() else {
            return Ok(None);
        };
        let correlations = case.correlation.clone().unwrap_or_default();
        let usual = vec![1.0; tables.len()]; // those with the value of the case were given it as their mean
        let inputs = case::inputs(&tables, &correlations, &usual);
        let inputs = inputs.map_err(|what| FileError::new(&path, what))?;
        let rows = read(&path, tables.len())?;
        let found: Vec<(&&Results, &Vec<f64>)> = (runs.iter())
            .filter_map(|run| {
                let root = run.files.root().file_name()?.to_str()?;
                let (_, name) = root.rsplit_once('-')?;
                Some((run, rows.get(name)?))
            })
            .collect();
        let runs: Vec<&Results> = found.iter().map(|(run, _)| **run).collect();
        let germs: Vec<Vec<f64>> = found.iter().map(|(_, x)| inputs.germs_of(x)).collect();
        let measures = sweep::values_of_measures(&runs).into_iter();
        let measures = measures
            .filter_map(|(name, values)| UncertainMeasure::of(name, values, &germs, &inputs));
        let names = tables.iter().map(|input| input.name.clone()).collect();
        let Some(base) = runs.first() else {
            return Ok(None);
        };
        Ok(Some(Self {
            base: base.files.resolved_case(),
            is_value: (tables.iter())
                .map(|input| input.value_in(&base.case).is_some())
                .collect(),
            wall: UncertainWall::new(&runs, &germs, &inputs, names),
            measures: measures.collect(),
            is_dependent: !correlations.is_empty(),
            samples: rows.len(),
            points: (found.iter())
                .map(|(run, x)| (run.name(), (*x).clone()))
                .collect(),
            inputs,
            tables,
        }))
    }

    /// Its inputs.
    pub fn inputs(&self) -> &Inputs {
        &self.inputs
    }

    /// Their names.
    pub fn names(&self) -> Vec<String> {
        self.tables.iter().map(|input| input.name.clone()).collect()
    }

    /// Names of the measures that have a polynomial.
    pub fn measures_with_chaos(&self) -> impl Iterator<Item = &str> {
        let measures = self.measures.iter().filter(|m| m.chaos.is_some());
        measures.map(|measure| measure.name.as_str())
    }

    /// The full name of a measure with a polynomial, whose unit may be left out.
    ///
    /// # Errors
    /// A sentence with the names that there are.
    pub fn measure_called(&self, name: &str) -> Result<&str, String> {
        let is_meant = |known: &&str| *known == name || known.split(" / ").next() == Some(name);
        let found = self.measures_with_chaos().find(is_meant);
        found.ok_or_else(|| {
            let known: Vec<&str> = self.measures_with_chaos().collect();
            format!("no such measure; the study has: {}", known.join("; "))
        })
    }

    /// The polynomial of a measure.
    pub fn chaos(&self, measure: &str) -> Option<&Chaos> {
        let found = self.measures.iter().find(|m| m.name == measure)?;
        found.chaos.as_ref()
    }

    /// What a run has of a measure.
    pub fn value(&self, run: &Results, measure: &str) -> Option<f64> {
        let measures = sweep::values_of_measures(&[run]).into_iter();
        let mut found = measures.filter(|(name, _)| name == measure);
        found.next()?.1[0]
    }

    /// The case at a point of the unit cube: a file, and what replaces its values.
    pub fn case_at(&self, point: &[f64]) -> (PathBuf, Vec<Override>) {
        let values = self.inputs.values_at(point);
        let (_, of_base) = &self.points[0];
        let given = (0..values.len()).flat_map(|i| {
            let value = match self.is_value[i] {
                true => format!("{:?}", values[i]),
                false => format!("*{:?}", values[i] / of_base[i]),
            };
            self.tables[i].keys.iter().map(move |key| Override {
                place: ValuePlace::Set,
                key: key.clone(),
                value: value.clone(),
            })
        });
        (self.base.clone(), given.collect())
    }

    /// Runs that were used.
    pub fn used(&self) -> usize {
        self.points.len()
    }

    /// Everything as tables, each with the name of its file; `run` is one of those that were used.
    pub fn tables(&self, run: &Results) -> Vec<(&'static str, PageTable)> {
        let wall = self.wall.as_ref();
        let wall = wall.map(|wall| ("wall-uncertainty.csv", wall.table(run)));
        let measures = [
            ("moments.csv", self.moments()),
            ("indices.csv", self.indices()),
        ];
        measures.into_iter().chain(wall).collect()
    }

    fn moments(&self) -> PageTable {
        let heads = [
            "measure",
            "samples",
            "mean",
            "standard deviation",
            "smallest",
            "largest",
            "degree of the chaos",
            "terms",
            "cross-validation error",
            "cross-validation deviation",
            "mean of the chaos",
            "standard deviation of the chaos",
        ];
        let percent = PERCENTILES.map(|share| format!("{:.0} %", 100.0 * share));
        let heads = heads.map(str::to_owned).into_iter().chain(percent);
        let mut table = PageTable::new(heads);
        for measure in &self.measures {
            let [mean, deviation] = measure.moments();
            let [low, high] = measure.ends();
            let mut row = vec![measure.name.clone(), measure.values.len().to_string()];
            row.extend([mean, deviation, low, high].map(shown));
            match &measure.chaos {
                Some(chaos) => {
                    row.extend([chaos.degree(), chaos.size()].map(|n| n.to_string()));
                    let figures = [
                        chaos.error,
                        chaos.error_deviation(),
                        chaos.mean(),
                        chaos.deviation(),
                    ];
                    row.extend(figures.map(shown));
                    row.extend(PERCENTILES.map(|share| shown(measure.percentile(share))));
                }
                None => row.extend(vec![String::new(); 6 + PERCENTILES.len()]),
            }
            table.push(row);
        }
        table
    }

    fn indices(&self) -> PageTable {
        let mut table = PageTable::new([
            "measure",
            "input",
            "first-order index",
            "first-order, 2.5 %",
            "first-order, 97.5 %",
            "total index",
            "total, 2.5 %",
            "total, 97.5 %",
            "samples",
            "cross-validation error",
        ]);
        for measure in &self.measures {
            for (input, index) in self.tables.iter().zip(&measure.indices) {
                let [a, b] = index.first_interval;
                let [c, d] = index.total_interval;
                let figures = [index.first, a, b, index.total, c, d].map(shown);
                let error = measure.chaos.as_ref().map(|c| shown(c.error));
                let mut row = vec![measure.name.clone(), input.name.clone()];
                row.extend(figures);
                row.extend([measure.values.len().to_string(), error.unwrap_or_default()]);
                table.push(row);
            }
        }
        table
    }

    /// The section of the page of a study; `run` is one of those that were used.
    ///
    /// # Errors
    /// If the wall of the run cannot be read.
    pub fn section(&self, run: &Results) -> io::Result<String> {
        let mut html = format!(
            "<p>{} of {} samples were used. The bars are Sobol' indices: the share of a measure's variance that an input \
             has by itself (first-order) and with its interactions (total), of a polynomial chaos fitted by least squares, \
             with intervals of 95 % by bootstrap. The cross-validation error is the share of the variance that polynomials of \
             some of the samples miss at the others.</p>\n",
            self.used(),
            self.samples
        );
        if self.is_dependent {
            html += "<p>Some inputs are correlated. Of them the index of one that is listed earlier counts what it shares \
                     with later ones; that of a later one counts only what is new in it.</p>\n";
        }
        html += &self.table_of_inputs();
        html += &self.table_of_measures();
        let shown = self.measures.iter().filter(|m| m.chaos.is_some());
        let shown: Vec<&UncertainMeasure> = shown.take(MOST_SHOWN).collect();
        let figures = |draw: &dyn Fn(&UncertainMeasure) -> String| -> String {
            gallery(&shown.iter().map(|m| draw(m)).collect::<Vec<_>>())
        };
        html += "<h3>Which input moves what</h3>\n";
        html += &figures(&|measure| self.bars(measure));
        html += "<h3>Distributions</h3>\n";
        html += &figures(&|measure| measure.histogram());
        html += "<h3>Response to each input, the others at their medians</h3>\n";
        html += &figures(&|measure| self.response(measure));
        if let Some(wall) = &self.wall
            && let Some((text, figures)) = wall.section(run)?
        {
            html += &format!("<h3>On the unrolled wall</h3>\n<p>{text}</p>\n");
            html += &gallery(&figures);
        }
        Ok(html)
    }

    fn table_of_inputs(&self) -> String {
        let heads = ["input", "keys", "distribution", "5 %", "median", "95 %"];
        let quantile =
            |i: usize, share: f64| significant(self.inputs.marginal(i).quantile(share), 4);
        let row = |(i, input): (usize, &Uncertain)| {
            let mut row = vec![
                escape(&input.name),
                escape(&input.keys.join(", ")),
                input.distribution.to_string(),
            ];
            row.extend([0.05, 0.5, 0.95].map(|share| quantile(i, share)));
            row
        };
        let rows: Vec<_> = self.tables.iter().enumerate().map(row).collect();
        table(&heads, &rows)
    }

    fn table_of_measures(&self) -> String {
        let heads = [
            "measure",
            "mean",
            "standard deviation",
            "5 to 95 %",
            "cross-validation error",
            "leading inputs (total index)",
        ];
        let row = |measure: &UncertainMeasure| {
            let [mean, deviation] = measure.moments();
            let mut row = vec![
                escape(&measure.name),
                significant(mean, 4),
                significant(deviation, 3),
            ];
            let Some(chaos) = &measure.chaos else {
                row.extend(["–", "–", "–"].map(str::to_owned));
                return row;
            };
            let [low, high] = [0.05, 0.95].map(|share| significant(measure.percentile(share), 4));
            let mut order: Vec<usize> = (0..measure.indices.len()).collect();
            order.sort_by(|a, b| {
                measure.indices[*b]
                    .total
                    .total_cmp(&measure.indices[*a].total)
            });
            let leading = order.iter().take(2).map(|&i| {
                let total = measure.indices[i].total;
                format!("{} {}", escape(&self.tables[i].name), significant(total, 2))
            });
            let doubt = match chaos.error > LARGE_ERROR {
                true => " <span>(large: more samples are needed)</span>",
                false => "",
            };
            row.extend([
                format!("{low} to {high}"),
                format!("{} %{doubt}", significant(100.0 * chaos.error, 2)),
                leading.collect::<Vec<_>>().join(", "),
            ]);
            row
        };
        let rows: Vec<_> = self.measures.iter().map(row).collect();
        table(&heads, &rows)
    }

    fn bars(&self, measure: &UncertainMeasure) -> String {
        let row = |(input, index): (&Uncertain, &SensitivityIndex)| Bars {
            name: input.name.clone(),
            shares: [
                (index.first, index.first_interval),
                (index.total, index.total_interval),
            ],
        };
        let rows: Vec<Bars> = self.tables.iter().zip(&measure.indices).map(row).collect();
        let svg = bars(&measure.name, ["first-order", "total"], &rows);
        let error = measure.chaos.as_ref().map_or(f64::NAN, |c| c.error);
        let caption = format!(
            "Sobol' indices of {}; {} samples, cross-validation error {} %.",
            measure.name,
            measure.values.len(),
            significant(100.0 * error, 2)
        );
        figure(&svg, &caption, None)
    }

    /// The measure over the percentile of each input.
    fn response(&self, measure: &UncertainMeasure) -> String {
        let Some(chaos) = &measure.chaos else {
            return String::new();
        };
        let curve = |(i, input): (usize, &Uncertain)| {
            let points = (1..40).map(|step| {
                let mut point = vec![0.5; self.tables.len()];
                point[i] = f64::from(step) / 40.0;
                (100.0 * point[i], chaos.value(&self.inputs.germs_at(&point)))
            });
            Curve {
                open: i >= 7,
                ..line(&input.name, i, points.collect())
            }
        };
        let curves = self.tables.iter().enumerate().map(curve).collect();
        let name = format!("response-{}", file_name(&measure.name));
        let caption = format!("{} over the percentile of each input.", measure.name);
        let label = "percentile of the input / %";
        chart(&name, &caption, panel("", label, &measure.name, curves))
    }
}

impl UncertainMeasure {
    /// With what the runs have; none if they all have the same.
    fn of(
        name: String,
        of_runs: Vec<Option<f64>>,
        germs: &[Vec<f64>],
        inputs: &Inputs,
    ) -> Option<Self> {
        let found = of_runs
            .iter()
            .zip(germs)
            .filter_map(|(v, g)| Some(((*v)?, g.clone())));
        let (values, germs): (Vec<f64>, Vec<Vec<f64>>) = found.unzip();
        let chaos = Chaos::fit(inputs, &germs, &values);
        let first = *values.first()?;
        if values.iter().all(|value| *value == first) {
            return None;
        }
        let mut distribution: Vec<f64> = chaos
            .iter()
            .flat_map(|chaos| {
                let points = (0..POINTS).map(|i| sobol_point(i, inputs.count()));
                points.map(|point| chaos.value(&inputs.germs_at(&point)))
            })
            .collect();
        distribution.sort_by(f64::total_cmp);
        Some(Self {
            indices: chaos.as_ref().map_or(Vec::new(), Chaos::indices),
            name,
            of_runs,
            values,
            chaos,
            distribution,
        })
    }

    /// Mean and standard deviation of the samples.
    fn moments(&self) -> [f64; 2] {
        moments_of(&self.values)
    }

    /// Standard deviation, that of the polynomial if there is one.
    pub(super) fn deviation(&self) -> f64 {
        let chaos = self.chaos.as_ref();
        chaos.map_or_else(|| self.moments()[1], Chaos::deviation)
    }

    fn ends(&self) -> [f64; 2] {
        let low = self.values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self
            .values
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        [low, high]
    }

    fn percentile(&self, share: f64) -> f64 {
        self.distribution[(share * (self.distribution.len() - 1) as f64).round() as usize]
    }

    /// How likely the values are: of the chaos, and of the samples.
    fn histogram(&self) -> String {
        let (Some(low), Some(high)) = (self.distribution.first(), self.distribution.last()) else {
            return String::new();
        };
        let [least, most] = self.ends();
        let (low, high) = (low.min(least), high.max(most));
        let width = (high - low) / COLUMNS as f64;
        let steps = |values: &[f64]| -> Vec<(f64, f64)> {
            let mut counts = [0_usize; COLUMNS];
            for value in values {
                counts[(((value - low) / width) as usize).min(COLUMNS - 1)] += 1;
            }
            let columns = counts.iter().enumerate();
            let share = |count: usize| 100.0 * count as f64 / values.len() as f64;
            columns
                .flat_map(|(i, &count)| {
                    let left = low + i as f64 * width;
                    [(left, share(count)), (left + width, share(count))]
                })
                .collect()
        };
        let curves = vec![
            line("chaos", 2, steps(&self.distribution)),
            Curve {
                open: true,
                ..line("samples", 1, steps(&self.values))
            },
        ];
        let name = format!("distribution-{}", file_name(&self.name));
        let caption = format!("Distribution of {}.", self.name);
        let label = "share in a column / %";
        chart(&name, &caption, panel("", &self.name, label, curves))
    }
}

fn shown(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    rounded.to_string()
}

/// The values of the inputs by the name of the sample.
fn read(path: &Path, inputs: usize) -> Result<BTreeMap<String, Vec<f64>>, FileError> {
    let wrong = |what: &dyn std::fmt::Display| FileError::new(path, what);
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(path)
        .map_err(|e| wrong(&e))?;
    let mut rows = BTreeMap::new();
    for row in reader.records() {
        let row = row.map_err(|e| wrong(&e))?;
        let values: Option<Vec<f64>> = (row.iter().skip(1))
            .map(|cell| cell.trim_start_matches('*').parse().ok())
            .collect();
        match values.filter(|values| values.len() == inputs) {
            Some(values) => drop(rows.insert(row[0].to_owned(), values)),
            None => {
                return Err(wrong(&format!(
                    "expected a name and {inputs} numbers, the [[uncertain]] inputs of the runs, in the row {}",
                    &row[0]
                )));
            }
        }
    }
    Ok(rows)
}
