//! Runs compared with an experiment: what each has at the points that were measured, and how far it is from that.

mod computed;
mod over_time;
mod panels;

use super::figure::Figure;
use super::report::PageTable;
use super::report::page::significant;
use crate::case::measured::{MeasuredPoint, MeasuredSeries, Measurements};
use crate::files::{Fault, fault};
use computed::Computed;
use fsi_numerics::twelve_digits;
use std::path::Path;

/// An experiment, and what runs have in its place.
pub struct Validation {
    measured: Measurements,
    runs: Vec<Computed>,
}

/// How far a run is from what was measured in a series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Root mean square of the differences, in the quantity's unit.
    pub rms: f64,
    /// Mean of the differences: above zero where the run has more than was measured.
    pub mean: f64,
    /// Points at which the run lies between the lowest and the highest measured value, and those that have such.
    pub within: [usize; 2],
}

impl Validation {
    /// Reads a file of measurements and the probes of runs.
    ///
    /// # Errors
    /// What is wrong with the file, or that a run has not recorded what was measured, in words.
    pub fn read(file: &Path, runs: &[impl AsRef<Path>]) -> Result<Self, Fault> {
        let measured = Measurements::read(file)?;
        let runs = runs
            .iter()
            .map(|run| Computed::read(run.as_ref(), &measured));
        let runs = runs.collect::<Result<_, _>>()?;
        Ok(Self { measured, runs })
    }

    /// A row for each series: how much was measured, how far measurements scatter, and how far each run is from them:
    /// root mean square of the difference, and in brackets its mean and how many points lie within what was measured.
    /// Shares are those of the largest measured value.
    pub fn summary(&self) -> PageTable {
        let heads = ["series", "points", "largest", "standard deviation"].map(str::to_owned);
        let names = self.runs.iter().map(|run| run.name.clone());
        let mut table = PageTable::new(heads.into_iter().chain(names));
        for (i, series) in self.at_times() {
            let scale = largest(series);
            let percent = |x: f64| format!("{} %", significant(100.0 * x / scale, 2));
            let scatter = series.points.iter().filter_map(|point| point.sd);
            let mut row = vec![
                series.name.clone(),
                series.points.len().to_string(),
                format!("{} {}", significant(scale, 3), series.quantity.unit()),
                rms(scatter).map_or(String::new(), percent),
            ];
            row.extend(self.runs.iter().map(|run| {
                let deviation = deviation(series, &run.values[i]);
                let within = match deviation.within {
                    [_, 0] => String::new(),
                    [within, of] => format!("; {within} of {of}"),
                };
                let [rms, mean] = [deviation.rms, deviation.mean].map(percent);
                format!("{rms} ({mean}{within})")
            }));
            table.push(row);
        }
        table
    }

    /// A row for each point of a series: what was measured, with its standard deviation, and what each run has.
    ///
    /// # Errors
    /// If there is no series of this name.
    pub fn points(&self, name: &str) -> Result<PageTable, Fault> {
        let Some((i, series)) = self.at_times().find(|(_, series)| series.name == name) else {
            let names: Vec<&str> = self.series().collect();
            return Err(fault!(
                "no series of points is called `{name}`; expected one of {}",
                names.join(", ")
            ));
        };
        let (scale, unit) = (largest(series), series.quantity.unit());
        let heads = ["place".to_owned(), format!("reference / {unit}")];
        let names = self.runs.iter().map(|run| format!("{} / {unit}", run.name));
        let mut table = PageTable::new(heads.into_iter().chain(names));
        let places = places(series);
        for (j, point) in series.points.iter().enumerate() {
            let sd = point.sd.map(|sd| format!(" ± {}", significant(sd, 2)));
            let mut row = vec![
                places[j].clone(),
                significant(point.value, 3) + &sd.unwrap_or_default(),
            ];
            row.extend(self.runs.iter().map(|run| {
                let value = run.values[i][j];
                let share = significant(100.0 * (value - point.value) / scale, 2);
                let sign = if value > point.value { "+" } else { "" };
                format!("{} ({sign}{share} %)", significant(value, 3))
            }));
            table.push(row);
        }
        Ok(table)
    }

    /// A panel for each series: what was measured, within dashed lines between which the measurements lie, and each
    /// run; or each run over time, within dashed lines at the measured range.
    pub fn figure(&self) -> Figure {
        let panel = |(i, series): (usize, &MeasuredSeries)| match series.is_over_time() {
            true => panels::over_time(i, series, &self.runs),
            false => panels::of_points(i, series, &self.runs),
        };
        let panels: Vec<_> = self.measured.series.iter().enumerate().map(panel).collect();
        let columns = if panels.len() == 4 { 2 } else { 3 };
        Figure { panels, columns }
    }

    /// Names of the series of values at one time, in the order of the file.
    pub fn series(&self) -> impl Iterator<Item = &str> {
        self.at_times().map(|(_, series)| series.name.as_str())
    }

    /// The series of values at one time, with their numbers.
    fn at_times(&self) -> impl Iterator<Item = (usize, &MeasuredSeries)> {
        let series = self.measured.series.iter().enumerate();
        series.filter(|(_, series)| !series.is_over_time())
    }

    /// A row for each statistic over time: what was measured, what each run has, and in brackets by how much that is
    /// more. If the runs are those of a series that `is_refined` by the same factor from each to the next, also where
    /// they lead ([`Limit::of_series`](super::refinement::Limit::of_series)). None if the file has no statistics.
    pub fn statistics(&self, is_refined: bool) -> Option<PageTable> {
        over_time::table(&self.measured.series, &self.runs, is_refined)
    }
}

/// The largest magnitude that was measured: what differences are relative to. 1 if all is zero.
fn largest(series: &MeasuredSeries) -> f64 {
    let largest = series.points.iter().map(|point| point.value.abs());
    Some(largest.fold(0.0, f64::max))
        .filter(|x| *x > 0.0)
        .unwrap_or(1.0)
}

/// How far values, one for each point, are from what was measured.
pub fn deviation(series: &MeasuredSeries, values: &[f64]) -> Deviation {
    let pairs = || series.points.iter().zip(values);
    let differences = || pairs().map(|(point, value)| value - point.value);
    let ranges = pairs().filter_map(|(point, value)| Some((point.range?, *value)));
    let within =
        |([lowest, highest], value): &([f64; 2], f64)| (*lowest..=*highest).contains(value);
    Deviation {
        rms: rms(differences()).unwrap_or(f64::NAN),
        mean: differences().sum::<f64>() / series.points.len() as f64,
        within: [ranges.clone().filter(within).count(), ranges.count()],
    }
}

/// Where the points lie, in mm: those coordinates that differ among them, or all; with times, if the file gives
/// any.
fn places(series: &MeasuredSeries) -> Vec<String> {
    let first = series.points[0].place;
    let differs = [0, 1, 2].map(|i| series.points.iter().any(|point| point.place[i] != first[i]));
    let is_told = |i: usize| differs[i] || differs == [false; 3];
    let show = |point: &MeasuredPoint| {
        let axes = ["x", "y", "z"].into_iter().enumerate();
        let axes = axes.filter(|(i, _)| is_told(*i));
        let place =
            axes.map(|(i, axis)| format!("{axis} = {} mm", twelve_digits(1e3 * point.place[i])));
        let time = point.time.map(|time| format!("t = {time} s"));
        place.chain(time).collect::<Vec<_>>().join(", ")
    };
    series.points.iter().map(show).collect()
}

/// Root mean square; none of nothing.
fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::measured::MeasuredQuantity;

    fn series(values: &[(f64, Option<[f64; 2]>)]) -> MeasuredSeries {
        let points = values.iter().enumerate();
        let points = points.map(|(i, (value, range))| MeasuredPoint {
            place: [1e-3 * i as f64, 2e-3, 0.0],
            time: None,
            statistic: None,
            value: *value,
            sd: None,
            range: *range,
        });
        MeasuredSeries {
            name: "axis".into(),
            quantity: MeasuredQuantity::VelocityX,
            points: points.collect(),
        }
    }

    #[test]
    fn a_deviation_counts_what_lies_within_the_measurements() {
        let series = series(&[
            (1.0, Some([0.9, 1.1])),
            (2.0, Some([1.9, 2.1])),
            (3.0, None),
        ]);
        let deviation = deviation(&series, &[1.1, 2.2, 3.0]);
        assert!((deviation.rms - (0.05_f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((deviation.mean - 0.1).abs() < 1e-12);
        assert_eq!(deviation.within, [1, 2]);
        assert_eq!(largest(&series), 3.0);
    }

    #[test]
    fn places_are_named_by_what_differs() {
        assert_eq!(
            places(&series(&[(1.0, None), (2.0, None)])),
            ["x = 0 mm", "x = 1 mm"]
        );
    }
}
