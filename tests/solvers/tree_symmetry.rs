//! Trees whose results are known: turned, mirrored, symmetric, or Poiseuille's flow far from the junction.

use crate::trees::{CASE, column, opening, run};
use fsi_driver::Vec3;
use nalgebra::{Matrix3, Rotation3};
use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

/// A daughter of a Y: its name, the angle (degrees) to the parent, that out of the plane, its radius (m).
type Daughter = (&'static str, f64, f64, f64);
const SYMMETRIC: [Daughter; 2] = [("left", -30.0, 0.0, 2.4e-3), ("right", 30.0, 0.0, 2.4e-3)];
/// No two of the daughters' properties are the same, and nothing lies in a plane.
const SKEW: [Daughter; 2] = [("left", -38.0, 20.0, 2.4e-3), ("right", 25.0, -5.0, 1.9e-3)];

/// The case of a parent of 3 mm with these daughters, so many mm long, all points transformed.
fn write(folder: &Path, daughters: [Daughter; 2], length: f64, turned: &Matrix3<f64>) {
    let line = |(name, angle, out, radius): Daughter| {
        let [(sin, cos), (up, level)] = [angle, out].map(|a| a.to_radians().sin_cos());
        let direction = Vec3::new(level * cos, level * sin, up);
        let parent = (-4..=0).map(|i| (Vec3::x() * 3e-3 * f64::from(i), 3e-3));
        let daughter =
            (1..=(length / 3.0) as i32).map(|i| (direction * 3e-3 * f64::from(i), radius));
        let (points, radii): (Vec<[f64; 3]>, Vec<f64>) = (parent.chain(daughter))
            .map(|(x, r)| (<[f64; 3]>::from(turned * x), r))
            .unzip();
        format!("[[tree.line]]\nname = \"{name}\"\npoints_m = {points:?}\nradii_m = {radii:?}\n")
    };
    let elements = "[tree.native]\ndegree = 3\nradial = 1\nlength = 1.5\n[fluid]";
    let text = CASE
        .replace("LINES", &daughters.map(line).concat())
        .replace("[fluid]", elements);
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("case.toml"), text).unwrap();
}

/// All equations as exact as they can be.
const EXACT: [&str; 5] = [
    "--fluid",
    "native",
    "--set",
    "coupling.e_rel=1e-9",
    "coupling.e_abs_m=1e-18",
];

fn rotated() -> Matrix3<f64> {
    *Rotation3::from_euler_angles(1.1, -0.4, 2.0).matrix()
}

fn mirrored() -> Matrix3<f64> {
    let normal = Vec3::new(0.3, -0.8, 0.5).normalize();
    Matrix3::identity() - 2.0 * normal * normal.transpose()
}

/// Largest difference of two series, relative to the largest value.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = a.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    // What is rigid has no displacement.
    apart.fold(0.0, f64::max) / largest.max(f64::MIN_POSITIVE)
}

/// Flows, pressures, volumes and the largest displacement of a run.
fn series(run: &Path) -> Vec<(String, Vec<f64>)> {
    let of_openings = ["inlet", "left", "right"].into_iter().flat_map(|name| {
        let all = opening(run, name);
        [("flow", 0), ("pressure", 1)].map(|(what, k)| {
            (
                format!("{what} of {name}"),
                all.iter().map(|row| row[k]).collect(),
            )
        })
    });
    let of_wall = ["lumen_volume_m3", "max_displacement_m", "max_von_mises_Pa"];
    let of_wall = of_wall.map(|name| {
        (
            name.to_owned(),
            column(&run.join("history.csv"), name, |_| true),
        )
    });
    of_openings.chain(of_wall).collect()
}

fn is_the_same_wherever_it_lies(more: &[&str], most: f64) {
    let folder = tempfile::tempdir().unwrap();
    let runs = [
        ("as it is", Matrix3::identity()),
        ("rotated", rotated()),
        ("mirrored", mirrored()),
    ];
    let runs = runs.map(|(name, turned)| {
        let [at, out] = ["case", "run"].map(|part| folder.path().join(name).join(part));
        write(&at, SKEW, 15.0, &turned);
        run(&at, &out, 4, &[&EXACT[..], more].concat());
        (name, series(&out))
    });
    let [(_, first), others @ ..] = &runs;
    for (name, other) in others {
        for ((what, a), (_, b)) in first.iter().zip(other) {
            let apart = difference(a, b);
            println!("{name}, {what}: {apart:.1e}");
            assert!(apart < most, "{name}, {what}: {apart:e}");
        }
    }
}

/// Flows and pressures differ by up to 1.1e-11: the blood is solved to 1e-11.
#[test]
fn a_rigid_tree_has_the_same_flow_wherever_it_lies() {
    is_the_same_wherever_it_lies(&["wall.mode=rigid"], 5e-11);
}

/// As of a rigid tree, 1.7e-11; the largest displacement and stress by 3e-12.
#[test]
fn a_tree_has_the_same_history_wherever_it_lies() {
    is_the_same_wherever_it_lies(&["structure.newton_tolerance=1e-10"], 5e-11);
}

/// Flows and pressures of two equal daughters with equal resistances differ by up to 7.6e-13 where the wall is rigid,
/// and 5.6e-11 where it is elastic: meshes, and what leads from one to the other, are symmetric to rounding. With
/// points of the blood in the plane of symmetry that move with one of the two daughters' walls there were 8.8e-8.
#[test]
fn equal_daughters_have_the_same_flow() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path().join("case");
    write(&at, SYMMETRIC, 15.0, &Matrix3::identity());
    for (mode, most) in [("rigid", 1e-11), ("elastic", 3e-10)] {
        let out = folder.path().join(mode);
        let mode = format!("wall.mode={mode}");
        let wall = ["structure.newton_tolerance=1e-10", &mode];
        run(&at, &out, 4, &[&EXACT[..], &wall].concat());
        let [left, right] = ["left", "right"].map(|name| opening(&out, name));
        for k in 0..2 {
            let [a, b] =
                [&left, &right].map(|all| all.iter().map(|row| row[k]).collect::<Vec<f64>>());
            let apart = difference(&a, &b);
            println!("{mode}, {k}: {apart:.1e}");
            assert!(apart < most, "{mode}, {k}: {apart:e}");
        }
    }
}

/// Mean wall shear over that of Poiseuille's flow in each branch of a rigid Y, three diameters and more from the
/// junction, at a Reynolds number of 6 in the parent.
fn shear(fluid: &str, more: &[&str]) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let [at, out] = ["case", "run"].map(|part| folder.path().join(part));
    write(&at, SKEW, 30.0, &Matrix3::identity());
    let file = at.join("case.toml");
    let region = |name: &str| {
        format!(
            "[[fluid.region]]\nname = \"of {name}\"\nbranch = \"{name}\"\nfrom_m = 0.016\nto_m = 0.024\n"
        )
    };
    let text = std::fs::read_to_string(&file).unwrap();
    let windkessel = "condition = \"windkessel\"\nresistance_Pa_s_m3 = 5e8\ncompliance_m3_Pa = 6e-11\n\
                      initial_pressure_Pa = 1e3\n";
    let text = text.replace(windkessel, "condition = \"pressure\"\npressure_Pa = 0.0\n");
    let text = text.replace(
        "base_m3_s = 4e-6",
        "base_m3_s = 1e-6\nprofile = \"parabolic\"",
    );
    let blood = "[blood]\nviscosity_Pa_s = 0.035\n";
    std::fs::write(&file, text + blood + &region("left") + &region("right")).unwrap();
    let set = [
        "--fluid",
        fluid,
        "--set",
        "wall.mode=rigid",
        "coupling.e_rel=1e-6",
        "ramp.duration_s=0",
    ];
    run(&at, &out, 600, &[&set[..], more].concat());
    (SKEW.iter())
        .map(|(name, .., radius)| {
            let region = format!("of {name}");
            let shear = column(&out.join("regions.csv"), "mean_wall_shear_Pa", |row| {
                row[1] == region
            });
            let flow = opening(&out, name);
            let [before, last] = [flow.len() - 2, flow.len() - 1].map(|n| -flow[n][0]);
            println!(
                "{name}: {last:e} m³/s, {} Pa, {:?}",
                shear[shear.len() - 1],
                last / before - 1.0
            );
            assert!((last / before - 1.0).abs() < 1e-5, "steady");
            shear[shear.len() - 1] * PI * radius.powi(3) / (4.0 * 0.035 * last)
        })
        .collect()
}

fn is_poiseuilles(found: &[f64], off: Range<f64>) {
    println!("{found:?}");
    assert!(
        found.iter().all(|ratio| off.contains(&(ratio - 1.0))),
        "{found:?}"
    );
}

/// 1.1e-4 too much in both daughters, in elements of degree 3.
#[test]
fn poiseuilles_shear_is_found_far_from_a_junction() {
    is_poiseuilles(&shear("native", &["time.step_s=0.1"]), 5e-5..2e-4);
}

/// 3.0 % too little in both daughters, with eight cells around.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn poiseuilles_shear_is_found_with_openfoam() {
    is_poiseuilles(&shear("openfoam", &["time.step_s=0.05"]), -0.034..-0.027);
}
