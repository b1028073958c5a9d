//! `fsi-driver new` keeps the shape of the files that it is given, and says what it changes.

use crate::new_case::{driver, succeeds};
use fsi_driver::case::{Case, FlowCurve, Preset, ResolvedCase, Shape};
use fsi_driver::geometry::Vessel;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::Path;

/// Rows x, y, z, r in millimetres.
fn write(path: &Path, rows: impl Iterator<Item = [f64; 4]>) {
    let mut text = String::from("x,y,z,r\n");
    for [x, y, z, r] in rows {
        let _ = writeln!(text, "{x:.6},{y:.6},{z:.6},{r:.6}");
    }
    std::fs::write(path, text).unwrap();
}

/// What `new` says of the line, and the case; it lies in the folder `name`.
fn made(here: &Path, name: &str, more: &[&str]) -> (String, ResolvedCase) {
    let line = format!("{name}.csv");
    let from = ["new", name, "--from", &line, "--unit", "mm"];
    let said = succeeds(here, &[&from, more].concat());
    let case = Case::load(&here.join(name), Preset::Paper, &[]).unwrap_or_else(|e| panic!("{e}"));
    (said, case)
}

fn smoothing(case: &str, key: &str) -> Option<f64> {
    let line = case.lines().find(|line| line.starts_with(key))?;
    let value = line.split(['=', '#']).nth(1)?;
    value.trim().parse().ok()
}

/// Narrowest radius (m) of the lumen.
fn narrowest(case: &ResolvedCase) -> f64 {
    let vessel = Vessel::new(case.vessel().unwrap());
    let radii = (0..=4000).map(|i| vessel.lumen_radius(vessel.end() * f64::from(i) / 4000.0, 0.3));
    radii.fold(f64::INFINITY, f64::min)
}

/// A straight line of 60 mm, 3 mm wide, with a narrowing to a tenth of the area over `long` millimetres, in points
/// `apart` mm.
fn stenosis(long: f64, apart: f64, noise: f64) -> impl Iterator<Item = [f64; 4]> {
    let depth = 3.0 * (1.0 - 0.1f64.sqrt());
    (0..=(60.0 / apart) as usize).map(move |i| {
        let x = apart * i as f64;
        let away = 2.0 * (x - 30.0) / long;
        let bump = if away.abs() < 1.0 {
            0.5 * (1.0 + (PI * away).cos())
        } else {
            0.0
        };
        let scatter = noise * ((i * 7919 % 101) as f64 / 50.0 - 1.0);
        [x, 0.0, 0.0, 3.0 - depth * bump + scatter]
    })
}

/// 0.949 mm in the file: 1.54 mm before, when radii were smoothed as the path is.
#[test]
fn a_stenosis_of_the_radii_stays_as_narrow_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (name, long, apart, noise, most) in [
        ("coarse", 12.0, 1.0, 0.0, 1e-4),
        ("fine", 12.0, 0.1, 0.0, 1e-3),
        ("short", 3.0, 0.1, 0.0, 5e-3), // of a radius' length
        ("scattering", 12.0, 0.2, 0.03, 0.03),
    ] {
        write(
            &here.join(format!("{name}.csv")),
            stenosis(long, apart, noise),
        );
        let (said, case) = made(here, name, &[]);
        let found = 1e3 * narrowest(&case);
        assert!((found - 0.9487).abs() < most, "{name}: {found}");
        assert!(said.contains("radius 0.9"), "{name}: {said}");
        let is_warned = said.contains("smoothing changes the radius");
        assert_eq!(is_warned, noise > 0.0, "{name}: {said}");
    }
}

/// A wave of 0.4 mm in a vessel of 0.5 mm radius, whose bends are sharper than its wall: 34.7 mm became 30.7 mm,
/// without a word.
#[test]
fn sharp_bends_are_rounded_off_where_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let kinked = (0..=200).map(|i| {
        let x = 0.15 * f64::from(i);
        [x, 0.4 * (TAU * x / 3.0).sin(), 0.0, 0.5]
    });
    write(&here.join("kinked.csv"), kinked);
    let (said, case) = made(here, "kinked", &[]);
    let length = 1e3 * Vessel::new(case.vessel().unwrap()).end();
    assert!((32.5..34.0).contains(&length), "{length}\n{said}");
    assert!(
        said.contains("length from 34.68")
            && said.contains("warning: smoothing changes the length"),
        "{said}"
    );
    let text = std::fs::read_to_string(here.join("kinked/case.toml")).unwrap();
    let least = smoothing(&text, "least_bend_m").unwrap();
    assert!((0.65e-3..0.9e-3).contains(&least), "{text}");
    // One kink in a long straight vessel: the rest stays where it is.
    let kink = (0..=300).map(|i| {
        let x = 0.2 * f64::from(i);
        [x, (0.7 * (x - 30.0)).max(0.0), 0.0, 1.0]
    });
    write(&here.join("kink.csv"), kink);
    let (said, case) = made(here, "kink", &[]);
    let Shape::Vessel(vessel) = &case.vessel().unwrap().shape else {
        panic!("another vessel");
    };
    let curve = vessel.curve();
    for x in [5.0_f64, 15.0, 25.0, 35.0, 45.0, 55.0] {
        let point = 1e-3 * fsi_driver::Vec3::new(x, (0.7 * (x - 30.0)).max(0.0), 0.0);
        let beside = curve.nearest(&point);
        let away = beside.across[0].hypot(beside.across[1]);
        assert!(away < 5e-6, "{x}: {away}\n{said}");
    }
    // A line that the wall could only follow as another vessel is asked about.
    let zigzag = (0..=200).map(|i| {
        let x = 0.2 * f64::from(i);
        [x, 2.0 * (TAU * x / 5.0).sin(), 0.0, 1.0]
    });
    write(&here.join("zigzag.csv"), zigzag);
    let from = ["new", "zigzag", "--from", "zigzag.csv", "--unit", "mm"];
    let output = driver(here, &from);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(
        error.contains("points move by up to")
            && error.contains("--thickness")
            && error.contains("--smoothing"),
        "{error}"
    );
    assert!(!here.join("zigzag").exists());
    // A thinner wall follows, or the user insists.
    made(here, "zigzag", &["--smoothing", "4mm"]);
}

#[test]
fn a_closed_circle_stays_one_and_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let circle = (0..=100).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / 100.0).sin_cos();
        [10.0 * cos, 10.0 * sin, 0.0, 1.0]
    });
    write(&here.join("circle.csv"), circle);
    let from = ["new", "circle", "--from", "circle.csv", "--unit", "mm"];
    let output = driver(here, &from);
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("the vessel crosses itself"), "{error}");
}

/// 920 and 1295 ml/min were proposed for one vessel, by the points that its file had.
#[test]
fn a_proposal_does_not_depend_on_the_distances_of_points() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    // An arc that is wide at first and narrow later.
    let row = |t: f64| {
        let (sin, cos) = (1.5 * t).sin_cos();
        let r = 4.0 - 2.0 * (1.0 / (1.0 + (-20.0 * (t - 0.4)).exp()));
        [40.0 * sin, 40.0 * (1.0 - cos), 5.0 * t, r]
    };
    type Way = (&'static str, usize, fn(f64) -> f64);
    let ways: [Way; 4] = [
        ("fifty", 50, |t| t),
        ("many", 500, |t| t),
        ("dense-first", 200, |t| t.powi(3)),
        ("dense-last", 200, |t| 1.0 - (1.0 - t).powi(3)),
    ];
    let found = ways.map(|(name, count, place)| {
        let rows = (0..=count).map(|i| row(place(i as f64 / count as f64)));
        write(&here.join(format!("{name}.csv")), rows);
        let (_, case) = made(here, name, &[]);
        let keys = case.vessel().unwrap();
        let flow = FlowCurve::new(&keys.inflow, case.time.period).unwrap();
        let mean = (0..100)
            .map(|i| flow.flow(f64::from(i) / 100.0))
            .sum::<f64>()
            / 100.0;
        let text = std::fs::read_to_string(here.join(name).join("case.toml")).unwrap();
        let [windkessel, initial] = [keys.windkessel.resistance, keys.windkessel.compliance];
        [
            mean,
            windkessel,
            initial,
            smoothing(&text, "smoothing_m").unwrap(),
            smoothing(&text, "upstream_extension_m").unwrap(),
            Vessel::new(keys).end(),
            case.time.step,
            narrowest(&case),
        ]
    });
    for (values, (name, ..)) in found.iter().zip(ways).skip(1) {
        for (i, (a, b)) in values.iter().zip(&found[0]).enumerate() {
            assert!(
                (a / b - 1.0).abs() < 0.012,
                "{name}, {i}: {values:?} {:?}",
                found[0]
            );
        }
    }
}

/// Options for the wall and what is around it.
#[test]
fn a_wall_can_be_given_with_its_thickness_and_state() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let row = |i: i32| [f64::from(i), 0.0, 0.0, 3.0];
    write(&here.join("tube.csv"), (0..=40).map(row));
    let options = [
        "--thickness",
        "0.7mm",
        "--loaded",
        "80mmHg",
        "--rcr",
        "--tissue",
    ];
    let (_, case) = made(here, "tube", &options);
    let keys = case.vessel().unwrap();
    let vessel = Vessel::new(keys);
    let section = vessel.elastic_sections().next().unwrap();
    let thickness: f64 = vessel.layers_of(section).iter().map(|(_, t)| t).sum();
    assert!((thickness - 0.7e-3).abs() < 1e-12, "{thickness}");
    assert!((keys.equilibrium_pressure() - 80.0 * 133.322).abs() < 1e-6);
    let proximal = keys.windkessel.proximal.unwrap();
    let share = proximal / (proximal + keys.windkessel.resistance);
    assert!((0.08..0.12).contains(&share), "{share}");
    assert!(
        keys.surroundings
            .as_ref()
            .is_some_and(|tissue| tissue.spring.is_some())
    );
    // The image has its pressure, whatever the windkessel starts with, and the tissue is at rest in it.
    let image = keys.initial.as_ref().unwrap().pressure;
    assert_eq!(image, Some(keys.equilibrium_pressure()));
    assert!(keys.tissue_rests_loaded());
    let text = std::fs::read_to_string(here.join("tube/case.toml")).unwrap();
    assert!(text.contains("# 80 mmHg, under which"), "{text}");
    // A ramp begins with the mean pressure, not with the 247 mmHg that fall while it rises.
    write(&here.join("ramped.csv"), (0..=40).map(row));
    let (_, case) = made(here, "ramped", &[]);
    let start = case.vessel().unwrap().windkessel.initial_pressure / 133.322;
    assert!((90.0..105.0).contains(&start), "{start}");
    for (arguments, message) in [
        (
            ["--radius", "-0.003"],
            "--radius -0.003: expected metres, from 1e-5 to 0.05",
        ),
        (
            ["--thickness", "-1mm"],
            "--thickness -1mm: expected a length",
        ),
        (["--thickness", "thin"], "expected a length such as 3mm"),
        (["--loaded", "80"], "expected a pressure with its unit"),
        (["--loaded", "80mm"], "expected a pressure with its unit"),
        (
            ["--loaded", "8000mmHg"],
            "expected a pressure from 1 Pa to 100 kPa",
        ),
        (["--period", "-1"], "--period -1: expected a duration"),
    ] {
        let output = driver(here, &[&["new", "none"], &arguments[..]].concat());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(message), "{arguments:?}: {error}");
        assert!(!here.join("none").exists());
    }
}

/// A case can be named as people name it.
#[test]
fn a_case_is_found_by_its_folder_or_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    for (arguments, message) in [
        (&["run", "nowhere"][..], "nowhere/case.toml"),
        (&["run"], "<DIR>"),
        (&["--case", "nowhere/case.toml"], "nowhere/case.toml"),
        (&["run", "nowhere", "--end-time", "-1"], "--end-time"),
    ] {
        let output = driver(here, arguments);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(error.contains(message), "{arguments:?}: {error}");
    }
}
