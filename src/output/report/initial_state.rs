//! The wall without load and as time begins, side by side, for runs that begin with a loaded wall.

use super::page::{chart, gallery, line, panel, table};
use crate::Vec3;
use crate::case::BloodVessel;
use crate::output::results::Results;
use crate::output::vtu::{self, Series};
use crate::simulation::assembly::Unloading;
use std::collections::BTreeMap;
use std::io;

/// Points within this distance (m) of each other along x are of one cross-section.
const NEAR: f64 = 1e-7;

/// Edges of the wall in the plane z = 0: place along x and across, mm, for each edge.
type Edges = [Vec<(f64, f64)>; 4];

/// The section's HTML; `None` if time begins with an unloaded wall.
pub fn section(run: &Results) -> io::Result<Option<String>> {
    let Some(vessel) = &run.vessel else {
        return Ok(None);
    };
    let files = &run.files;
    let series = Series::read(&files.structure())?;
    let Some((_, file)) = series.first().filter(|(time, _)| *time == 0.0) else {
        return Ok(None);
    };
    let points = vtu::read_vectors(&files.root().join(file), "displacement_m")?;
    // In the given shape the mesh has nodes in that plane.
    let is_loaded = unloading(run).is_some();
    let given = |x: &Vec3, u: &Vec3| if is_loaded { x + u } else { *x };
    let shapes = [
        ("without load", edges(&points, given, |x, _| *x)),
        ("as time begins", edges(&points, given, |x, u| x + u)),
    ];
    let figures = shapes.map(|(title, edges)| {
        let names = ["outer", "inner", "", ""];
        let curves = names.into_iter().zip(edges).enumerate();
        let curves =
            curves.map(|(i, (name, points))| line(name, if i % 3 == 0 { 1 } else { 2 }, points));
        chart(
            &format!("shape {title}"),
            &format!("The wall {title}, cut lengthwise in the plane z = 0."),
            panel(title, "x / mm", "y / mm", curves.collect()),
        )
    });
    Ok(Some(state(run, vessel) + &gallery(&figures)))
}

/// What the wall begins under.
fn state(run: &Results, vessel: &BloodVessel) -> String {
    let mut rows = vec![
        vec![
            "pressure inside".to_owned(),
            format!("{:.1} Pa", vessel.equilibrium_pressure()),
        ],
        vec![
            "axial stretch".to_owned(),
            format!("{:?}", vessel.axial_stretch()),
        ],
    ];
    if let Some(unloading) = unloading(run) {
        rows.push(vec![
            "pressure inside in the given shape".into(),
            format!("{:.1} Pa", unloading.pressure_Pa),
        ]);
        rows.push(vec![
            "iterations for the unloaded shape, the given one being the loaded one".into(),
            unloading.iterations.to_string(),
        ]);
        rows.push(vec![
            "distance from the given shape after loading it again".into(),
            format!("{:.1e} m", unloading.distance_after_loading_m),
        ]);
    }
    table(&["state of the wall when time begins", ""], &rows)
}

/// Where the unloaded shape comes from, if it is not the given one.
fn unloading(run: &Results) -> Option<Unloading> {
    run.summary.as_ref().and_then(|summary| summary.unloading)
}

/// The outer and inner edge above the axis, and those below, of the wall in a shape, cut where it is `given`.
fn edges(
    points: &[(Vec3, Vec3)],
    given: impl Fn(&Vec3, &Vec3) -> Vec3,
    shape: impl Fn(&Vec3, &Vec3) -> Vec3,
) -> Edges {
    // Of each cross-section the points in the plane, by their height in the given shape.
    let mut sections: BTreeMap<i64, Vec<(f64, Vec3)>> = BTreeMap::new();
    for (x, u) in points {
        let place = given(x, u);
        if place.z.abs() < NEAR {
            let key = (place.x / NEAR).round() as i64;
            let section = sections.entry(key).or_default();
            section.push((place.y, shape(x, u)));
        }
    }
    let mut edges = Edges::default();
    for section in sections.values_mut() {
        section.sort_by(|a, b| b.0.total_cmp(&a.0));
        let above = section.partition_point(|(y, _)| *y > 0.0);
        let (upper, lower) = section.split_at(above);
        let ends = [upper.first(), upper.last(), lower.first(), lower.last()];
        for (edge, end) in edges.iter_mut().zip(ends) {
            edge.extend(end.map(|(_, x)| (1e3 * x.x, 1e3 * x.y)));
        }
    }
    edges
}
