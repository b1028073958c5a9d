//! Runs compared with an experiment: what each has at the points that were measured, and how far it is from that.

use super::figure::{Curve, Figure, Marker, Panel, Scale};
use super::function_object;
use super::refinement::Limit;
use super::report::PageTable;
use super::report::page::significant;
use super::results::Results;
use super::tables::{self, FluidProbeRow, ProbeRow, SectionRow};
use super::time_statistics::statistic;
use crate::Vec3;
use crate::case::measured::{
    MeasuredPoint, MeasuredQuantity, MeasuredSeries, Measurements, Recorder, Statistic,
};
use crate::files::{Fault, fault};
use fsi_numerics::twelve_digits;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;

/// A probe lies at a measured point if it is no further away than this (m).
const SAME_PLACE: f64 = 1e-9;
/// A row counts for a time from which it is no further than this share of a step.
const SAME_TIME: f64 = 0.51;

/// An experiment, and what runs have in its place.
pub struct Validation {
    measured: Measurements,
    runs: Vec<Computed>,
}

/// What a run has at the measured points.
struct Computed {
    name: String,
    /// A value for each point of each series.
    values: Vec<Vec<f64>>,
    /// Of each series of statistics what was recorded (time in s, value) where its first point counts.
    over_time: Vec<Vec<(f64, f64)>>,
}

/// A value at a place and time of a run.
struct Sample {
    place: [f64; 3],
    time: f64,
    value: f64,
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
        let heads = ["measured", "points", "largest", "standard deviation"].map(str::to_owned);
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
        let heads = ["place".to_owned(), format!("measured / {unit}")];
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
            true => self.panel_over_time(i, series),
            false => self.panel_of_points(i, series),
        };
        Figure {
            panels: self.measured.series.iter().enumerate().map(panel).collect(),
            columns: 3,
        }
    }

    fn panel_of_points(&self, i: usize, series: &MeasuredSeries) -> Panel {
        let (along, at) = abscissa(series);
        let curve = |name: &str, colour, values: &dyn Fn(usize) -> Option<f64>| {
            let points = (0..at.len()).filter_map(|j| Some((at[j], values(j)?)));
            let mut points: Vec<(f64, f64)> = points.collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            Curve {
                name: name.to_owned(),
                points,
                colour,
                marker: None,
                open: false,
            }
        };
        let points = &series.points;
        let mut curves = vec![Curve {
            marker: Some(Marker::Circle),
            ..curve("measured", 0, &|j| Some(points[j].value))
        }];
        curves.extend([0, 1].map(|end| Curve {
            open: true,
            ..curve("", 0, &|j| points[j].range.map(|range| range[end]))
        }));
        curves.extend(self.runs.iter().enumerate().map(|(run, computed)| {
            curve(&computed.name, 1 + run, &|j| Some(computed.values[i][j]))
        }));
        curves.retain(|curve| !curve.points.is_empty());
        Panel {
            title: series.name.clone(),
            x_label: along,
            y_label: series.quantity.label(),
            scales: [Scale::Linear; 2],
            curves,
        }
    }

    fn panel_over_time(&self, i: usize, series: &MeasuredSeries) -> Panel {
        let times = self.runs.iter().flat_map(|run| &run.over_time[i]);
        let times = times.map(|sample| sample.0);
        let [begin, end] = [
            times.clone().fold(f64::INFINITY, f64::min),
            times.fold(f64::NEG_INFINITY, f64::max),
        ];
        let curve = |name: &str, points, colour, open| Curve {
            name: name.to_owned(),
            points,
            colour,
            marker: None,
            open,
        };
        let levels = measured_levels(series).into_iter().enumerate();
        let mut curves: Vec<Curve> = levels
            .map(|(j, level)| {
                let name = if j == 0 { "measured" } else { "" };
                curve(name, vec![(begin, level), (end, level)], 0, true)
            })
            .collect();
        let runs = self.runs.iter().enumerate();
        curves
            .extend(runs.map(|(j, run)| curve(&run.name, run.over_time[i].clone(), 1 + j, false)));
        Panel {
            title: series.name.clone(),
            x_label: "time / s".into(),
            y_label: series.quantity.label(),
            scales: [Scale::Linear; 2],
            curves,
        }
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
    /// they lead ([`Limit::of_series`]). None if the file has no statistics.
    pub fn statistics(&self, is_refined: bool) -> Option<PageTable> {
        let heads = ["over time", "unit", "measured"].map(str::to_owned);
        let names = self.runs.iter().map(|run| run.name.clone());
        let limit = is_refined.then(|| "refined further".to_owned());
        let mut table = PageTable::new(heads.into_iter().chain(names).chain(limit));
        let mut is_empty = true;
        for (i, series) in self.measured.series.iter().enumerate() {
            for (j, point) in series.points.iter().enumerate() {
                let Some(statistic) = point.statistic else {
                    continue;
                };
                is_empty = false;
                let unit = statistic.unit(series.quantity.unit());
                let (unit, factor) = match unit {
                    "m" => ("mm", 1e3),
                    other => (other, 1.0),
                };
                let show = |value: f64| significant(factor * value, 4);
                let plus_minus = |value: f64, uncertainty: Option<f64>| match uncertainty {
                    _ if value.is_nan() => String::new(),
                    Some(uncertainty) => {
                        format!("{} ± {}", show(value), significant(factor * uncertainty, 2))
                    }
                    None => show(value),
                };
                let values: Vec<f64> = self.runs.iter().map(|run| run.values[i][j]).collect();
                let mut row = vec![
                    format!("{}, {}", series.name, statistic.name()),
                    unit.to_owned(),
                    plus_minus(point.value, point.sd),
                ];
                row.extend(values.iter().map(|value| {
                    if point.value.is_nan() {
                        return show(*value);
                    }
                    let share = 100.0 * (value - point.value) / point.value.abs();
                    let sign = if share > 0.0 { "+" } else { "" };
                    format!("{} ({sign}{} %)", show(*value), significant(share, 2))
                }));
                if is_refined {
                    let limit = Limit::of_series(&values);
                    row.push(plus_minus(limit.value, Some(limit.uncertainty)));
                }
                table.push(row);
            }
        }
        (!is_empty).then_some(table)
    }
}

/// The values between which, at which or about which a quantity moves as it was measured.
fn measured_levels(series: &MeasuredSeries) -> Vec<f64> {
    let of = |kind| {
        let point = series.points.iter().find(|it| it.statistic == Some(kind));
        point
            .map(|point| point.value)
            .filter(|value| !value.is_nan())
    };
    let mut levels = match (of(Statistic::Middle), of(Statistic::Amplitude)) {
        (Some(middle), Some(amplitude)) => vec![middle - amplitude, middle + amplitude],
        (middle, _) => Vec::from_iter(middle),
    };
    levels.extend(
        [Statistic::Mean, Statistic::Largest, Statistic::Least]
            .map(of)
            .into_iter()
            .flatten(),
    );
    levels
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

/// What its points differ in most, as the label of an axis, and its value at each: a coordinate (mm) or the time
/// (s).
fn abscissa(series: &MeasuredSeries) -> (String, Vec<f64>) {
    let coordinate = |i: usize| -> Vec<f64> {
        let points = series.points.iter();
        points
            .map(|point| twelve_digits(1e3 * point.place[i]))
            .collect()
    };
    let extent = |values: &Vec<f64>| {
        let ends = |(low, high): (f64, f64), x: &f64| (low.min(*x), high.max(*x));
        let (low, high) = values.iter().fold((f64::MAX, f64::MIN), ends);
        high - low
    };
    let axes = [0, 1, 2].map(|i| (["x", "y", "z"][i], coordinate(i)));
    let widest = axes
        .into_iter()
        .max_by(|a, b| extent(&a.1).total_cmp(&extent(&b.1)));
    match widest.filter(|(_, values)| extent(values) > 0.0) {
        Some((axis, values)) => (format!("{axis} / mm"), values),
        None => {
            let times = series.points.iter().map(|point| point.time.unwrap_or(0.0));
            ("time / s".to_owned(), times.collect())
        }
    }
}

impl Computed {
    fn read(folder: &Path, measured: &Measurements) -> Result<Self, Fault> {
        let run = Results::load_figures(folder).map_err(|e| e.to_string())?;
        let recorded = Recorded {
            wall: read(&run.files.probes())?,
            blood: read(&run.files.fluid_probes())?,
            sections: read(&run.files.sections())?,
            forces: forces(&run, measured)?,
        };
        let series = || measured.series.iter();
        let values = series().map(|series| computed(&run, &recorded, series));
        let over_time = series().map(|series| match series.is_over_time() {
            true => {
                let samples = recorded.samples(series);
                counted(&run, &series.points[0], &samples)
            }
            false => Vec::new(),
        });
        Ok(Self {
            name: run.name(),
            values: values.collect::<Result<_, _>>()?,
            over_time: over_time.collect(),
        })
    }
}

/// The rows of a table of probes; none if the run has recorded nothing at points.
fn read<T: DeserializeOwned>(table: &Path) -> Result<Vec<T>, Fault> {
    match table.is_file() {
        true => tables::read(table).map_err(|e| fault!("cannot read {e}")),
        false => Ok(Vec::new()),
    }
}

/// What the function objects have added up that a file of measurements names, by their names.
fn forces(
    run: &Results,
    measured: &Measurements,
) -> Result<HashMap<String, Vec<(f64, [f64; 3])>>, Fault> {
    let mut forces = HashMap::new();
    let is_force =
        |series: &&MeasuredSeries| series.quantity.recorder() == Recorder::FunctionObject;
    for series in measured.series.iter().filter(is_force) {
        let name = series.recorded_by();
        if !forces.contains_key(name) {
            let folder = run.files.function_object(name);
            forces.insert(name.to_owned(), function_object::forces(&folder)?);
        }
    }
    Ok(forces)
}

/// What a run has recorded at points and cross-sections, and what function objects have added up.
struct Recorded {
    wall: Vec<ProbeRow>,
    blood: Vec<FluidProbeRow>,
    sections: Vec<SectionRow>,
    forces: HashMap<String, Vec<(f64, [f64; 3])>>,
}

fn is_at(sample: &Sample, point: &MeasuredPoint) -> bool {
    let away = Vec3::from(sample.place) - Vec3::from(point.place);
    away.norm() <= SAME_PLACE
}

/// What counts for a statistic: time (s) and value of the samples at its place from its time on.
fn counted(run: &Results, point: &MeasuredPoint, samples: &[Sample]) -> Vec<(f64, f64)> {
    let from = point.time.unwrap_or(0.0) - SAME_TIME * run.case.time.step;
    let counts = |sample: &&Sample| is_at(sample, point) && sample.time >= from;
    let counted = samples.iter().filter(counts);
    counted.map(|sample| (sample.time, sample.value)).collect()
}

/// What a run has at each point of a series.
fn computed(
    run: &Results,
    recorded: &Recorded,
    series: &MeasuredSeries,
) -> Result<Vec<f64>, Fault> {
    let (table, key) = match series.quantity.recorder() {
        Recorder::WallProbe => (run.files.probes(), "the point in output.probes_m"),
        Recorder::BloodProbe => (
            run.files.fluid_probes(),
            "the point in output.fluid_probes_m",
        ),
        Recorder::Section => (
            run.files.sections(),
            "the cross-section of its name in output.section",
        ),
        Recorder::FunctionObject => (
            run.files.function_object(series.recorded_by()),
            "a function object of the type `forces` in the templates",
        ),
    };
    let samples = recorded.samples(series);
    let last = samples.iter().map(|sample| sample.time).fold(0.0, f64::max);
    let at = |point: &MeasuredPoint| {
        let mut here = samples
            .iter()
            .filter(|sample| is_at(sample, point))
            .peekable();
        if let (Some(kind), Some(_)) = (point.statistic, here.peek()) {
            let counted = counted(run, point, &samples);
            return statistic(kind, &counted).ok_or_else(|| {
                fault!(
                    "{} has {} rows of `{}` from t = {} s on, to {} s: not enough for its {}",
                    table.display(),
                    counted.len(),
                    series.name,
                    point.time.unwrap_or(0.0),
                    twelve_digits(last),
                    kind.name()
                )
            });
        }
        let time = point.time.unwrap_or(last);
        let away = |sample: &Sample| (sample.time - time).abs();
        let nearest = here.min_by(|a, b| away(a).total_cmp(&away(b)));
        let Some(nearest) = nearest else {
            return Err(fault!(
                "{} has no probe at {:?} m, where `{}` was measured: give the file to the case as output.measured, or {key}, and \
                 compute the run again",
                table.display(),
                point.place,
                series.name
            ));
        };
        match away(nearest) <= SAME_TIME * run.case.time.step {
            true => Ok(nearest.value),
            false => Err(fault!(
                "{} has no row at t = {time} s, where `{}` was measured; it reaches {} s",
                table.display(),
                series.name,
                twelve_digits(last)
            )),
        }
    };
    let mut values: Vec<f64> = series.points.iter().map(at).collect::<Result<_, _>>()?;
    if series.quantity.is_difference() {
        let first = values[0];
        values.iter_mut().for_each(|value| *value -= first);
    }
    Ok(values)
}

impl Recorded {
    /// All that was recorded of a series' quantity; what sections and function objects have stands at the
    /// place of the first of its points.
    fn samples(&self, series: &MeasuredSeries) -> Vec<Sample> {
        use MeasuredQuantity::*;
        let quantity = series.quantity;
        let of_the_wall = |row: &ProbeRow| Sample {
            place: [row.x_m, row.y_m, row.z_m],
            time: row.time_s,
            value: match quantity {
                WallShear => Vec3::new(
                    row.wall_shear_x_Pa,
                    row.wall_shear_y_Pa,
                    row.wall_shear_z_Pa,
                )
                .norm(),
                DisplacementX => row.ux_m,
                DisplacementY => row.uy_m,
                DisplacementZ => row.uz_m,
                _ => row.p_Pa,
            },
        };
        let of_the_blood = |row: &FluidProbeRow| Sample {
            place: [row.x_m, row.y_m, row.z_m],
            time: row.time_s,
            value: match quantity {
                VelocityX => row.ux_m_s,
                VelocityY => row.uy_m_s,
                VelocityZ => row.uz_m_s,
                Speed => Vec3::new(row.ux_m_s, row.uy_m_s, row.uz_m_s).norm(),
                _ => row.p_Pa,
            },
        };
        let of_a_section = |row: &SectionRow| {
            let value = match quantity {
                SectionPressure => Some(row.p_Pa),
                SectionRadiusDifference => Some((row.area_m2 / PI).sqrt()),
                _ => row.flow_m3_s,
            };
            value.map(|value| Sample {
                place: series.points[0].place,
                time: row.time_s,
                value,
            })
        };
        match quantity.recorder() {
            Recorder::WallProbe => self.wall.iter().map(of_the_wall).collect(),
            Recorder::BloodProbe => self.blood.iter().map(of_the_blood).collect(),
            Recorder::Section => (self.sections.iter())
                .filter(|row| row.section == series.recorded_by())
                .filter_map(of_a_section)
                .collect(),
            Recorder::FunctionObject => (self.forces.get(series.recorded_by()).into_iter())
                .flatten()
                .map(|(time, force)| Sample {
                    place: series.points[0].place,
                    time: *time,
                    value: match quantity {
                        ForceX => force[0],
                        ForceY => force[1],
                        _ => force[2],
                    },
                })
                .collect(),
        }
    }
}

/// Root mean square; none of nothing.
fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

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
