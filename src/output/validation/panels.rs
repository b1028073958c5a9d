//! Runs beside what was measured, drawn: a panel for each series.

use super::computed::Computed;
use crate::case::measured::{MeasuredSeries, Statistic};
use crate::output::figure::{Curve, Marker, Panel, Scale};
use fsi_numerics::twelve_digits;

/// What was measured at points in the series `i`, within dashed lines between which the measurements lie, and each run.
pub fn of_points(i: usize, series: &MeasuredSeries, runs: &[Computed]) -> Panel {
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
        ..curve("reference", 0, &|j| Some(points[j].value))
    }];
    curves.extend([0, 1].map(|end| Curve {
        open: true,
        ..curve("", 0, &|j| points[j].range.map(|range| range[end]))
    }));
    curves.extend(
        runs.iter().enumerate().map(|(run, computed)| {
            curve(&computed.name, 1 + run, &|j| Some(computed.values[i][j]))
        }),
    );
    curves.retain(|curve| !curve.points.is_empty());
    Panel {
        title: series.name.clone(),
        x_label: along,
        y_label: series.quantity.label(),
        scales: [Scale::Linear; 2],
        curves,
    }
}

/// Each run over time, with dashed lines at the ends of the range in which the quantity of the series `i` was measured.
pub fn over_time(i: usize, series: &MeasuredSeries, runs: &[Computed]) -> Panel {
    let times = runs.iter().flat_map(|run| &run.over_time[i]);
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
            let name = if j == 0 { "reference" } else { "" };
            curve(name, vec![(begin, level), (end, level)], 0, true)
        })
        .collect();
    curves.extend(
        runs.iter()
            .enumerate()
            .map(|(j, run)| curve(&run.name, run.over_time[i].clone(), 1 + j, false)),
    );
    Panel {
        title: series.name.clone(),
        x_label: "time / s".into(),
        y_label: series.quantity.label(),
        scales: [Scale::Linear; 2],
        curves,
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
