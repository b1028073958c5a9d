//! Lines in VTK's polydata, as VMTK writes them: each target has a line from its source, and
//! `MaximumInscribedSphereRadius` says how wide the lumen is; after `vmtkbranchextractor` they are cut into tracts with
//! `CenterlineIds`, `TractIds`, `GroupIds` and `Blanking`. Lines of two points each, as SimVascular's reduced-order
//! models have them, are a tree (`pairs`).

mod pairs;

use super::LineFile;
use super::{CentreLine, MOST_NAMED, listed};
use crate::files::{Fault, fault};
use crate::polydata::PolyData;
use std::collections::BTreeSet;
use std::path::Path;

/// Name of the radius in VMTK's files, which counts before others whose name speaks of a radius.
const RADIUS: &str = "MaximumInscribedSphereRadius";
/// What tells lines apart, in the order in which it is offered.
const NAMES: [&str; 2] = ["CenterlineIds", "GroupIds"];
/// A line goes on in the next one that begins so close to its end, relative to the largest distance of its points.
const JOINT: f64 = 3.0;

pub fn read(path: &Path, branch: Option<&str>) -> Result<LineFile, Fault> {
    let data = PolyData::read(path)?;
    if data.lines.is_empty() {
        return Err(match data.triangles.len() {
            0 => "the file has no lines".into(),
            n => fault!(
                "the file has {n} triangles and no lines: is it the surface, which vessel.lumen names?"
            ),
        });
    }
    let chosen = match pairs::Tree::new(&data) {
        Some(tree) => tree.branch(branch)?,
        None => of_lines(&data, branch)?,
    };
    let radius = radii(&data);
    let line = CentreLine {
        points: chosen.iter().map(|i| data.points[*i]).collect(),
        radii: radius.as_ref().map_or_else(Vec::new, |(_, radius)| {
            chosen.iter().map(|i| radius[*i]).collect()
        }),
    };
    let names: Vec<String> = data.of_points.keys().cloned().collect();
    let radii = match (radius, names.is_empty()) {
        (Some((name, _)), _) => format!("radii {name}"),
        (None, true) => "no radii".to_owned(),
        (None, false) => format!(
            "no radii among its arrays of points, {}",
            listed(&names, MOST_NAMED)
        ),
    };
    Ok(LineFile {
        line,
        unit: None,
        understood: format!(
            "VTK's polydata: {} lines, {} of {} points taken, {radii}",
            data.lines.len(),
            chosen.len(),
            data.points.len()
        ),
    })
}

/// All lines, or the ways from the root to each end where lines join two points each, in the unit of the file.
pub fn all(path: &Path) -> Result<Vec<CentreLine>, Fault> {
    let data = PolyData::read(path)?;
    let ids = values(&data, NAMES[0]);
    let chosen: Vec<Vec<usize>> = match pairs::Tree::new(&data) {
        Some(tree) => tree.ways()?,
        // Tracts of whole lines.
        None if ids.len() > 1 => ids
            .iter()
            .map(|id| {
                joined(
                    &data,
                    &in_order(&data, &find(&data, &format!("{}={id}", NAMES[0]))),
                )
                .0
            })
            .collect(),
        None => data.lines.clone(),
    };
    let names: Vec<String> = data.of_points.keys().cloned().collect();
    let (_, radius) = radii(&data).ok_or_else(|| {
        let found = match names.is_empty() {
            true => String::new(),
            false => format!(", found {}", listed(&names, MOST_NAMED)),
        };
        format!(
            "the lines have no radii: expected an array of the points called {RADIUS}, or whose name has \"radius\" or \
             \"diameter\" in it{found}"
        )
    })?;
    let line = |chosen: &Vec<usize>| CentreLine {
        points: chosen.iter().map(|i| data.points[*i]).collect(),
        radii: chosen.iter().map(|i| radius[*i]).collect(),
    };
    Ok(chosen.iter().map(line).collect())
}

/// The array of the radii, with its name: one called as VMTK does, `R`, or whose name speaks of radii or diameters.
fn radii(data: &PolyData) -> Option<(&str, Vec<f64>)> {
    let rank = |name: &str| match name.to_lowercase() {
        _ if name == RADIUS => Some(0),
        name if name == "radius" || name == "radii" => Some(1),
        name if name.contains("radius") || name.contains("radii") => Some(2),
        name if name == "r" => Some(3),
        name if name.contains("diameter") || name == "diam" => Some(4),
        _ => None,
    };
    let known = data.of_points.iter();
    let ranked = known.filter_map(|(name, values)| Some((rank(name)?, name, values)));
    let (rank, name, values) = ranked.min_by_key(|(rank, ..)| *rank)?;
    let share = if rank == 4 { 0.5 } else { 1.0 };
    Some((name, values.iter().map(|value| value * share).collect()))
}

/// The points of one of several lines.
fn of_lines(data: &PolyData, branch: Option<&str>) -> Result<Vec<usize>, Fault> {
    let all: Vec<usize> = (0..data.lines.len()).collect();
    Ok(match branch {
        None => {
            let (whole, is_all) = joined(data, &all);
            // Copies of the one centre-line that there is are no branches.
            let ids = values(data, NAMES[0]);
            match (is_all, ids.len()) {
                (true, _) => whole,
                (false, 1) => joined(data, &in_order(data, &all)).0,
                _ => {
                    return Err(fault!(
                        "the file has several lines: choose one by vessel.branch = {}",
                        offered(data)
                    ));
                }
            }
        }
        Some(branch) => {
            let lines = find(data, branch);
            if lines.is_empty() {
                return Err(fault!(
                    "there is no branch {branch:?}; there is {}",
                    offered(data)
                ));
            }
            joined(data, &in_order(data, &lines)).0
        }
    })
}

/// The distinct values of an array of the lines.
fn values(data: &PolyData, name: &str) -> Vec<i64> {
    let values = data.of_lines.get(name).into_iter().flatten();
    let values: BTreeSet<i64> = values.map(|value| *value as i64).collect();
    values.into_iter().collect()
}

/// Lines by `NAME=VALUE` of one of their arrays, or by `Line=N`, counted from 1.
fn find(data: &PolyData, branch: &str) -> Vec<usize> {
    let Some((name, value)) = branch.split_once('=') else {
        return Vec::new();
    };
    let Ok(value) = value.trim().parse::<i64>() else {
        return Vec::new();
    };
    match (name.trim(), data.of_lines.get(name.trim())) {
        (_, Some(array)) => {
            let lines = array.iter().enumerate();
            let same = lines.filter(|(_, found)| **found == value as f64);
            same.map(|(i, _)| i).collect()
        }
        ("Line", None) if (1..=data.lines.len() as i64).contains(&value) => {
            vec![value as usize - 1]
        }
        _ => Vec::new(),
    }
}

/// Tracts of a centre-line by their numbers.
fn in_order(data: &PolyData, lines: &[usize]) -> Vec<usize> {
    let mut lines = lines.to_vec();
    if let Some(tracts) = data.of_lines.get("TractIds") {
        lines.sort_by(|a, b| tracts[*a].total_cmp(&tracts[*b]));
    }
    lines
}

/// Points of the first of the lines and of those that go on where it ends; and whether these are all.
fn joined(data: &PolyData, lines: &[usize]) -> (Vec<usize>, bool) {
    let distance = |a: usize, b: usize| {
        let squares = (0..3).map(|c| (data.points[a][c] - data.points[b][c]).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let mut points = data.lines[lines[0]].clone();
    let mut is_all = true;
    for line in &lines[1..] {
        let next = &data.lines[*line];
        let gaps = points.windows(2).map(|pair| distance(pair[0], pair[1]));
        let reach = JOINT * gaps.fold(0.0, f64::max);
        match (points.last(), next.first()) {
            (Some(end), Some(start)) if distance(*end, *start) <= reach => points.extend(next),
            _ => is_all = false,
        }
    }
    (points, is_all)
}

/// The branches that there are.
fn offered(data: &PolyData) -> String {
    let length = |points: &[usize]| -> f64 {
        let points = points.iter().map(|i| crate::Vec3::from(data.points[*i]));
        let points: Vec<_> = points.collect();
        points
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).norm())
            .sum()
    };
    let describe = |branch: String| {
        let points = joined(data, &in_order(data, &find(data, &branch))).0;
        format!(
            "\"{branch}\" ({} points, {:.4} long)",
            points.len(),
            length(&points)
        )
    };
    let mut all = Vec::new();
    for name in NAMES {
        all.extend(
            values(data, name)
                .into_iter()
                .map(|value| describe(format!("{name}={value}"))),
        );
    }
    if all.is_empty() {
        all = (1..=data.lines.len())
            .map(|line| describe(format!("Line={line}")))
            .collect();
    }
    listed(&all, MOST_NAMED)
}
