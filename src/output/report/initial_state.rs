//! The wall without load and at t = 0, side by side, for runs that begin with a loaded wall.

use super::page::{chart, file_name, gallery, line, panel, table};
use crate::Vec3;
use crate::case::BloodVessel;
use crate::geometry::Vessel;
use crate::output::results::Results;
use crate::output::vtu::{self, VtuSeries};
use crate::simulation::assembly::Unloading;
use std::io;

/// A point lies in the cut if its angle (rad) differs by less from 0 or π, and points are of one cross-section if they
/// lie closer along the centre-line, relative to their distance from it. Sampled points lie much further apart.
const NEAR: f64 = 0.02;

/// Edges of the wall at the angles 0 and π: arc length and distance from the centre-line, mm, for each edge.
type Edges = [Vec<(f64, f64)>; 4];

/// The section's HTML; `None` if the run starts with an unloaded wall.
pub fn section(run: &Results) -> io::Result<Option<String>> {
    let Some(vessel) = &run.vessel else {
        return Ok(None);
    };
    let files = &run.files;
    let series = VtuSeries::read(&files.structure())?;
    let Some((_, file)) = series.first().filter(|(time, _)| *time == 0.0) else {
        return Ok(None);
    };
    let points = vtu::read_vectors(&files.root().join(file), "displacement_m")?;
    // In the given shape the mesh has nodes in that plane.
    let is_loaded = unloading(run).is_some();
    let given = |x: &Vec3, u: &Vec3| if is_loaded { x + u } else { *x };
    let shapes = [
        ("without load", edges(vessel, &points, given, |x, _| *x)),
        ("at t = 0", edges(vessel, &points, given, |x, u| x + u)),
    ];
    let figures = shapes.map(|(title, edges)| {
        let names = ["outer", "inner", "", ""];
        let curves = names.into_iter().zip(edges).enumerate();
        let curves =
            curves.map(|(i, (name, points))| line(name, if i % 3 == 0 { 1 } else { 2 }, points));
        chart(
            &file_name(&format!("shape {title}")),
            &format!("The wall {title}, cut lengthwise at the angles 0° (above) and 180° (below) of its cross-sections."),
            panel(title, "arc length / mm", "distance from the centre-line / mm", curves.collect()),
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
    if let Some(steps) = run.case.steps_before() {
        rows.push(vec![
            "velocity of the blood".into(),
            format!("that after a beat between walls at rest, in {steps} steps"),
        ]);
    }
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
    table(&["initial state", ""], &rows)
}

/// Where the unloaded shape comes from, if it is not the given one.
fn unloading(run: &Results) -> Option<Unloading> {
    run.summary.as_ref().and_then(|summary| summary.unloading)
}

/// The outer and inner edge at the angle 0, and the inner and outer one at π, of the wall in a shape, cut where it is
/// `given`.
fn edges(
    vessel: &BloodVessel,
    points: &[(Vec3, Vec3)],
    given: impl Fn(&Vec3, &Vec3) -> Vec3,
    shape: impl Fn(&Vec3, &Vec3) -> Vec3,
) -> Edges {
    let vessel = Vessel::new(vessel);
    let line = vessel.centre_line();
    // Points in the cut: arc length and height in the given shape, both in the other.
    let mut cut = Vec::new();
    for (x, u) in points {
        let place = line.nearest(&given(x, u));
        let [y, z] = place.across;
        if z.abs() < NEAR * y.abs() {
            let nearest = line.nearest_from(&shape(x, u), place.s);
            cut.push(([place.s, y], (1e3 * nearest.s, 1e3 * nearest.across[0])));
        }
    }
    cut.sort_by(|a, b| a.0[0].total_cmp(&b.0[0]));
    let mut edges = Edges::default();
    let mut rest = &mut cut[..];
    while let Some(([from, y], _)) = rest.first() {
        let end = from + NEAR * y.abs();
        let count = rest.partition_point(|([s, _], _)| *s <= end);
        let (section, tail) = rest.split_at_mut(count);
        section.sort_by(|a, b| b.0[1].total_cmp(&a.0[1]));
        let above = section.partition_point(|([_, y], _)| *y > 0.0);
        let (upper, lower) = section.split_at(above);
        let ends = [upper.first(), upper.last(), lower.first(), lower.last()];
        for (edge, end) in edges.iter_mut().zip(ends) {
            edge.extend(end.map(|(_, place)| *place));
        }
        rest = tail;
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Case, Preset};
    use std::f64::consts::TAU;

    /// A bent tube in the coordinates of a scanner, far from z = 0: there was nothing in its figure.
    #[test]
    fn a_vessel_is_cut_along_its_own_centre_line() {
        let folder = tempfile::tempdir().unwrap();
        let points: Vec<String> = (0..=20)
            .map(|i| {
                let t = 0.05 * f64::from(i);
                let [x, y, z] = [0.12 + 0.03 * t.sin(), -0.3 + 0.03 * t.cos(), 1.4 + 0.01 * t];
                format!("[{x}, {y}, {z}]")
            })
            .collect();
        let text = format!(
            "extends = \"defaults\"\n[vessel]\npoints_m = [{}]\nradius_m = 2e-3\n[[vessel.section]]\nname = \"a\"\nlayers = \
             [\"w\"]\nthicknesses_m = [0.5e-3]\n[[vessel.material]]\nname = \"w\"\nmaterial = \"neo_hooke\"\nmu_Pa = \
             1e5\nkappa_Pa = 1e8\n",
            points.join(", ")
        );
        std::fs::write(folder.path().join("case.toml"), text).unwrap();
        let case = Case::load(folder.path(), Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
        let keys = case.vessel().unwrap();
        let vessel = Vessel::new(keys);
        // The unloaded wall is a tenth narrower.
        let mut samples = Vec::new();
        for i in 0..=30 {
            let s = vessel.end() * f64::from(i) / 30.0;
            for (r, j) in [2e-3, 2.25e-3, 2.5e-3]
                .into_iter()
                .flat_map(|r| (0..16).map(move |j| (r, j)))
            {
                let (sin, cos) = (TAU * f64::from(j) / 16.0).sin_cos();
                let at = |r: f64| vessel.centre_line().frame(s).point(r * cos, r * sin);
                samples.push((at(0.9 * r), at(r) - at(0.9 * r)));
            }
        }
        let given = |x: &Vec3, u: &Vec3| x + u;
        for (edges, share) in [
            (edges(keys, &samples, given, |x, u| x + u), 1.0),
            (edges(keys, &samples, given, |x, _| *x), 0.9),
        ] {
            for (edge, height) in edges.iter().zip([2.5, 2.0, -2.0, -2.5]) {
                assert_eq!(edge.len(), 31);
                for (i, (s, y)) in edge.iter().enumerate() {
                    let exact = 1e3 * vessel.end() * i as f64 / 30.0;
                    assert!(
                        (s - exact).abs() < 1e-6 && (y - share * height).abs() < 1e-6,
                        "{s} {y}"
                    );
                }
            }
        }
    }
}
