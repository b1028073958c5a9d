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
    "output.probes_m=[[0.045, 2.35e-3, 0.0]]",
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

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_wall_in_equilibrium_with_still_blood_stays_where_it_is_with_both_fluids() {
    let folder = tempfile::tempdir().unwrap();
    let mut volumes = Vec::new();
    // OpenFOAM's flat faces carry a uniform pressure to the wall exactly. The native fluid's tractions are means over parts
    // of a curved wall, which are a little smaller: here, with twelve of them around, the wall moves by 8e-8 m.
    for (name, fluid, still, even) in [
        ("native", &NATIVE[..], 1.5e-4, 6e-3),
        ("openfoam", &[], 1e-8, 1e-6),
    ] {
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
    // Sixteen facets enclose 2.55 % less than the round lumen, and less yet where it bulges between them along the vessel.
    let ratio = volumes[0] / volumes[1];
    println!("native over openfoam: {ratio}");
    assert!((ratio - 1.0316).abs() < 1e-3, "{ratio}");
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_run_from_equilibrium_that_is_resumed_is_the_uninterrupted_one() {
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
        ("surroundings.direction=along", "\"radial\", \"all\""),
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
