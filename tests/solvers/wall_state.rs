//! Runs that begin with a wall that is stretched, stands in tissue and is under pressure already.

use crate::run_support::*;
use std::path::Path;
use std::process::Command;

/// A wall in static equilibrium at 10 kPa, stretched by a tenth, in springs.
const STATE: [&str; 8] = [
    "--set",
    "initial.start=equilibrium",
    "initial.axial_stretch=1.1",
    "surroundings.spring_Pa_m=1e7",
    "surroundings.damping_Pa_s_m=1e3",
    "surroundings.pressure_Pa=500.0",
    "windkessel.initial_pressure_Pa=1e4",
    "output.probes_m=[[0.045, 3.2e-3, 0.0]]",
];
/// Blood that stands still under this pressure.
const STILL: [&str; 3] = [
    "inflow.base_m3_s=0.0",
    "inflow.amplitude_m3_s=0.0",
    "windkessel.resistance_Pa_s_m3=1e15",
];
/// Few elements of degree 3.
const NATIVE: [&str; 7] = [
    "--fluid",
    "native",
    "--set",
    "fluid.native.degree=3",
    "fluid.native.core=1",
    "fluid.native.axial_extension=2",
    "fluid.native.axial_per_section=2",
];

/// A column of the history.
fn column(run: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(run.join("history.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let at = headers.iter().position(|header| header == name);
    let at = at.unwrap_or_else(|| panic!("no column {name}"));
    let rows = reader.records();
    rows.map(|row| row.unwrap()[at].parse().unwrap()).collect()
}

fn run(out: &Path, steps: usize, more: &[&[&str]]) -> Command {
    driver(out, steps, &[&STATE[..], &more.concat()].concat())
}

/// A wall in equilibrium with still blood stays where it is with both fluids.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn equilibrium_with_still_blood_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut volumes = Vec::new();
    // Faces carry a uniform pressure to the wall exactly: it does not move, whatever the mesh.
    let (still, even) = (1e-8, 1e-6);
    for (name, fluid) in [("native", &NATIVE[..]), ("openfoam", &[])] {
        let out = folder.path().join(name);
        complete(run(&out, 5, &[&STILL, fluid]));
        let volume = column(&out, "lumen_volume_m3");
        let pressure = column(&out, "p_in_Pa");
        let change = volume.iter().map(|v| (v / volume[0] - 1.0).abs());
        let change = change.fold(0.0, f64::max);
        let worst = pressure.iter().map(|p| (p / 1e4 - 1.0).abs());
        let worst = worst.fold(0.0, f64::max);
        println!("{name}: volume changes by {change:.1e}, pressure by {worst:.1e}");
        assert!(change < still, "{name}: {volume:?}");
        assert!(worst < even, "{name}: {pressure:?}");
        // The first step starts with the loaded lumen, not with the unloaded one.
        let rate = column(&out, "dVdt_m3_s")[0];
        assert!(rate.abs() * STEP < still * volume[0], "{name}: {rate:e}");
        volumes.push(volume[0]);
    }
    // Of the round lumen it lacks only what bulges between its stations along the vessel.
    let ratio = volumes[0] / volumes[1];
    println!("native over openfoam: {ratio}");
    assert!((ratio - 1.0081).abs() < 5e-4, "{ratio}");
}

/// A wall that is given loaded begins in its given shape with both fluids.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn loaded_wall_starts_in_its_given_shape() {
    let folder = tempfile::tempdir().unwrap();
    let loaded = ["initial.shape=loaded"];
    for (name, fluid) in [("native", &NATIVE[..]), ("openfoam", &[])] {
        let out = folder.path().join(name);
        complete(run(&out, 4, &[&STILL, &loaded, fluid]));
        let moved = column(&out, "max_displacement_m");
        println!("{name}: {moved:?}");
        assert!(moved.iter().all(|u| *u < 1e-10), "{name}: {moved:?}");
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        let of = |key: &str| summary["unloading"][key].as_f64().unwrap();
        assert!(of("distance_after_loading_m") < 1e-8, "{summary}");
        // The outlet has come from 60 mm / 1.1, and the wall from further inside.
        let outlet = 0.06 * (1.0 - 1.0 / 1.1);
        let largest = of("largest_displacement_m");
        assert!((largest / outlet - 1.0).abs() < 0.05, "{largest:e}");
        // Both shapes stand in the first of the wall's grids.
        let series = std::fs::read_to_string(out.join("structure.pvd")).unwrap();
        assert!(series.contains("timestep=\"0\""), "{series}");
    }
    let [straight, resumed] = ["straight", "resumed"].map(|kind| folder.path().join(kind));
    complete(run(&straight, 4, &[&NATIVE, &loaded]));
    complete(run(&resumed, 2, &[&NATIVE, &loaded]));
    complete(run(&resumed, 4, &[&NATIVE, &loaded, &["--resume"]]));
    assert_same_run(&resumed, &straight);
}

/// Tissue that is at rest in the given shape, across and along, each with its own stiffness.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn wall_in_tissue_stays_in_its_given_shape() {
    let folder = tempfile::tempdir().unwrap();
    let tissue = [
        "initial.shape=loaded",
        "initial.pressure_Pa=1e4",
        "surroundings.at_rest=loaded",
        "surroundings.axial_spring_Pa_m=1e8",
        "surroundings.axial_damping_Pa_s_m=1e3",
    ];
    for (name, fluid) in [("native", &NATIVE[..]), ("openfoam", &[])] {
        let out = folder.path().join(name);
        complete(run(&out, 3, &[&STILL, &tissue, fluid]));
        let moved = column(&out, "max_displacement_m");
        assert!(moved.iter().all(|u| *u < 1e-10), "{name}: {moved:?}");
    }
    // From another pressure than that of the given shape, with blood that flows.
    let higher = ["windkessel.initial_pressure_Pa=1.2e4"];
    let [straight, resumed] = ["straight", "resumed"].map(|kind| folder.path().join(kind));
    let state = unless_set(&STATE, &higher);
    let run = |out: &Path, steps: usize, more: &[&[&str]]| {
        driver(
            out,
            steps,
            &[&state[..], &NATIVE, &tissue, &higher, &more.concat()].concat(),
        )
    };
    complete(run(&straight, 4, &[]));
    complete(run(&resumed, 2, &[]));
    complete(run(&resumed, 4, &[&["--resume"]]));
    assert_same_run(&resumed, &straight);
    let moved = column(&straight, "max_displacement_m");
    assert!(moved[0] > 1e-5, "{moved:?}");
}

/// Displacement of a point of the outlet's rim along the vessel and across after four steps, with what moves freely
/// there.
fn outlet_rim(out: &Path, end: &str, fluid: &[&str]) -> [f64; 2] {
    let probe = "output.probes_m=[[0.06, 3.2e-3, 0.0]]";
    let outlet = format!("ends.outlet={end}");
    let mut sets = vec!["--set", &outlet, &probe, "ramp.duration_s=0.008"];
    if end == "springs" {
        sets.extend(["ends.spring_Pa_m=1e8", "initial.axial_stretch=1.0"]);
    }
    let state = unless_set(&STATE, &sets);
    complete(driver(out, 4, &[&state[..], fluid, &sets].concat()));
    // What flows in and does not come out widens the vessel; an outlet that moves along it takes nothing away.
    let [inflow, outflow, rate] =
        ["Q_in_m3_s", "Q_out_m3_s", "dVdt_m3_s"].map(|name| column(out, name));
    for step in 0..inflow.len() {
        let missing = inflow[step] - outflow[step] - rate[step];
        assert!(missing.abs() < 3e-10, "{end}: {missing:e} of {inflow:?}");
    }
    let mut table = csv::Reader::from_path(out.join("probes.csv")).unwrap();
    let headers = table.headers().unwrap().clone();
    let row = table.records().last().unwrap().unwrap();
    ["ux_m", "uy_m"].map(|name| {
        let at = headers.iter().position(|header| header == name).unwrap();
        row[at].parse().unwrap()
    })
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn the_outlet_moves_with_the_end_of_the_wall_with_both_fluids() {
    let folder = tempfile::tempdir().unwrap();
    for (end, moves) in [
        ("clamped", false),
        ("sliding", true),
        ("radial", true),
        ("springs", true),
    ] {
        let of = |name: &str, fluid: &[&str]| {
            let out = folder.path().join(format!("{end}-{name}"));
            outlet_rim(&out, end, fluid)
        };
        let native = of("native", &NATIVE);
        let [along, across] = native;
        assert_eq!(across > 5e-5, moves, "{end}: {across:e}");
        if end == "sliding" || end == "radial" {
            assert!((along - 6e-3).abs() < 1e-12, "{end}: {along:e}");
        }
        if end == "clamped" || end == "radial" {
            continue;
        }
        let openfoam = of("openfoam", &[]);
        println!("{end}: {native:?} {openfoam:?}");
        let apart = (across - openfoam[1]).abs() / across.abs().max(1e-9);
        assert!(apart < 5e-3, "{end}: {native:?} {openfoam:?}");
        assert!(
            (along - openfoam[0]).abs() < 5e-7,
            "{end}: {native:?} {openfoam:?}"
        );
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_resumed_run_from_equilibrium_is_the_uninterrupted_one() {
    let folder = tempfile::tempdir().unwrap();
    for (name, fluid) in [("native", &NATIVE[..]), ("openfoam", &[])] {
        let [straight, resumed] =
            ["straight", "resumed"].map(|kind| folder.path().join(format!("{name}-{kind}")));
        complete(run(&straight, 4, &[fluid]));
        complete(run(&resumed, 2, &[fluid]));
        complete(run(&resumed, 4, &[fluid, &["--resume"]]));
        assert_same_run(&resumed, &straight);
    }
}

#[test]
fn a_wall_without_equilibrium_is_refused_with_what_helps() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let slack = [
        "--set",
        "initial.start=equilibrium",
        "windkessel.initial_pressure_Pa=4e4",
        "model.d_max_m=0.0",
    ];
    let output = driver(&out, 1, &slack).output().unwrap();
    let said = text(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("there is no state for time to begin in"),
        "{said}"
    );
    assert!(said.contains("surroundings.spring_Pa_m"), "{said}");
    assert!(!out.exists());
}

#[test]
fn bad_values_of_the_wall_state_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    for (setting, expected) in [
        ("initial.start=slowly", "\"ramp\", \"equilibrium\""),
        ("initial.axial_stretch=3.0", "a number from 0.8 to 2.0"),
        ("surroundings.spring_Pa_m=-1.0", "a number from 0.0"),
        ("surroundings.damping_Pa_s_m=-1.0", "a number from 0.0"),
        ("surroundings.pressure_Pa=1e9", "a number from -1e6 to 1e6"),
        (
            "surroundings.direction=along",
            "\"radial\", \"axial\", \"all\"",
        ),
        (
            "surroundings.at_rest=loaded",
            "write initial.start = \"equilibrium\"",
        ),
        (
            "initial.pressure_Pa=1e4",
            "the pressure in a given shape that is loaded",
        ),
        (
            "initial.shape=loaded",
            "write initial.start = \"equilibrium\"",
        ),
        ("ends.outlet=loose", "\"clamped\", \"sliding\""),
        (
            "ends.spring_Pa_m=1e8",
            "only an end that is on springs has any",
        ),
        (
            "surroundings.stations_m=[0.0, 0.03]",
            "as many numbers as surroundings.shares has",
        ),
    ] {
        let output = driver(&out, 1, &["--set", setting]).output().unwrap();
        let said = text(&output);
        assert_eq!(output.status.code(), Some(2), "{setting}: {said}");
        let key = setting.split('=').next().unwrap();
        assert!(
            said.contains(key) && said.contains(expected),
            "{setting}: {said}"
        );
        assert!(!out.exists());
    }
}

/// Templates of one's own are asked for what the state of the wall needs.
#[test]
fn user_templates_must_read_the_wall_state() {
    let folder = tempfile::tempdir().unwrap();
    let templates = folder.path().join("templates");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (part, from) in [
        ("0", "tests/data/earlier-templates/0"),
        ("constant", "openfoam-case/base/constant"),
        ("system", "openfoam-case/base/system"),
    ] {
        std::fs::create_dir_all(templates.join(part)).unwrap();
        for file in std::fs::read_dir(root.join(from)).unwrap() {
            let file = file.unwrap();
            // As they stood before there was such a state.
            let text = std::fs::read_to_string(file.path()).unwrap();
            let text = (text.replace("$:pressureRampStart", "0"))
                .replace("$:initialPressure", "(0)")
                .replace("$:outletMotion", "fixedValue");
            std::fs::write(templates.join(part).join(file.file_name()), text).unwrap();
        }
    }
    let own = format!("fluid.templates={}", templates.display());
    let out = folder.path().join("run");
    for (setting, file, missing) in [
        (
            "initial.start=equilibrium",
            "0/p",
            "$:initialPressure and $:pressureRampStart",
        ),
        (
            "ends.outlet=sliding",
            "0/pointDisplacement",
            "$:outletMotion",
        ),
    ] {
        let output = driver(&out, 1, &["--set", &own, setting]).output().unwrap();
        let said = text(&output);
        assert_eq!(output.status.code(), Some(2), "{setting}: {said}");
        assert!(said.contains(file) && said.contains(missing), "{said}");
        assert!(!out.exists());
    }
}

#[test]
fn the_straight_artery_needs_prestretch_or_tissue() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let case = root.join("examples/straight-artery");
    let probes = "output.probes_m=[[0.025, 2.0e-3, 0.0], [0.025, -2.0e-3, 0.0]]";
    // Displacement outwards under 80 mmHg, measured with elements of degree 4.
    for (name, state, outwards) in [
        ("stretch", "initial.axial_stretch=1.2", 6.44e-4),
        ("tissue", "surroundings.spring_Pa_m=2e7", 4.62e-4),
    ] {
        let mut sets = vec!["--set", state, probes];
        if name == "tissue" {
            sets.push("initial.axial_stretch=1.0");
        }
        let out = folder.path().join(name);
        let mut run = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        run.args(["--preset", "demo", "--case"]).arg(&case);
        run.arg("--out").arg(&out).args(["--end-time", "0.006"]);
        run.args(NATIVE).args(sets);
        complete(run);
        let mut table = csv::Reader::from_path(out.join("probes.csv")).unwrap();
        let at = table.headers().unwrap().iter().position(|h| h == "uy_m");
        let rows: Vec<f64> = (table.records())
            .map(|row| row.unwrap()[at.unwrap()].parse().unwrap())
            .collect();
        // Both sides go outwards alike.
        for sides in rows.chunks_exact(2) {
            println!("{name}: {sides:?}");
            assert!((sides[0] + sides[1]).abs() < 1e-8, "{name}: {sides:?}");
            assert!((sides[0] - outwards).abs() < 4e-6, "{name}: {sides:?}");
        }
    }
    let mut check = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    check.arg("check").arg(&case).args(["--preset", "demo"]);
    check.args(["--fluid", "native", "--set", "initial.axial_stretch=1.0"]);
    let output = check.output().unwrap();
    let said = text(&output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("bends sideways at 6.12 kPa of 10.67 kPa"),
        "{said}"
    );
}
