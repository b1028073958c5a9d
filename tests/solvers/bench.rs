//! `fsi-driver bench`: the parts add up, the warm state is made once, and nonsense is refused.

use crate::run_support::{SMALL, text, unless_set};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn bench(folder: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["bench", "--case", "tests/cases/S-0.25", "--preset", "demo"])
        .arg("--warm")
        .arg(folder.join("warm"))
        .args(unless_set(&SMALL, more))
        .args(more)
        .output()
        .unwrap()
}

#[test]
fn the_native_fluid_is_measured_without_openfoam() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("old.json");
    let file = json.to_str().unwrap();
    let measure = |more: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .env("PATH", "")
            .args(["bench", "--case", "tests/cases/S-0.25", "--preset", "demo"])
            .args(["--fluid", "native", "--from", "0.004", "--steps", "2"])
            .arg("--warm")
            .arg(folder.path().join("warm"))
            .args(["--set", "fluid.native.core=1", "fluid.native.degree=3"])
            .args(["structure.axial_per_section=2"])
            .args(more)
            .output()
            .unwrap()
    };
    let first = measure(&["--json", file]);
    assert!(first.status.success(), "{}", text(&first));
    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    // An element within, and four around it, in 6 + 2 x 4 layers, and the two at the rims are halved.
    assert_eq!(report["fluid_cells"], 80);
    let part = |name: &str| report["per_step"][name].as_f64().unwrap();
    assert!(part("fluid_s") > 0.0 && part("coupling_iterations") >= 1.0);
    let second = measure(&["--compare", file]);
    assert!(second.status.success(), "{}", text(&second));
    assert!(text(&second).contains("now/old"), "{}", text(&second));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn the_parts_add_up_and_two_versions_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("old.json");
    let file = json.to_str().unwrap();
    let first = bench(
        folder.path(),
        &["--from", "0.006", "--steps", "3", "--json", file],
    );
    assert!(first.status.success(), "{}", text(&first));
    assert!(text(&first).contains("warming up"), "{}", text(&first));
    let report: Value = serde_json::from_slice(&std::fs::read(&json).unwrap()).unwrap();
    let part = |name: &str| report["per_step"][name].as_f64().unwrap();
    let sum = |names: &[&str]| names.iter().map(|name| part(name)).sum::<f64>();
    for (whole, parts) in [
        (
            "step_s",
            &["fluid_s", "structure_s", "coupling_s", "output_s"][..],
        ),
        (
            "structure_s",
            &[
                "structure_residual_s",
                "structure_substitution_s",
                "structure_assembly_s",
                "structure_factorization_s",
                "structure_rest_s",
            ],
        ),
    ] {
        assert!((part(whole) / sum(parts) - 1.0).abs() < 1e-9, "{whole}");
        assert!(parts.iter().all(|name| part(name) >= 0.0), "{report:#}");
    }
    // OpenFOAM's own clocks measure a part of what the driver waits for.
    let measured = [
        "fluid_mesh_motion_s",
        "fluid_momentum_s",
        "fluid_pressure_s",
    ];
    assert!(measured.iter().all(|name| part(name) > 0.0), "{report:#}");
    assert!(sum(&measured) < part("fluid_s"), "{report:#}");
    assert!(part("coupling_iterations") >= 1.0 && part("fluid_correctors") >= 1.0);
    assert!(part("fluid_cpu_s") > 0.0 && part("driver_cpu_s") > 0.0);

    // The second time starts from the same state, and takes the same steps.
    let again = folder.path().join("new.json");
    let second = bench(
        folder.path(),
        &[
            "--from",
            "0.006",
            "--steps",
            "3",
            "--compare",
            file,
            "--json",
            again.to_str().unwrap(),
        ],
    );
    assert!(second.status.success(), "{}", text(&second));
    assert!(!text(&second).contains("warming up") && text(&second).contains("now/old"));
    let again: Value = serde_json::from_slice(&std::fs::read(&again).unwrap()).unwrap();
    for count in [
        "coupling_iterations",
        "fluid_correctors",
        "newton_iterations",
    ] {
        assert_eq!(report["per_step"][count], again["per_step"][count]);
    }

    // Another mesh is neither measured from this state nor compared with these figures.
    let other = ["--from", "0.006", "--set", "fluid.mesh.axial_per_section=8"];
    let refused = bench(folder.path(), &other);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        text(&refused).contains("axial_per_section: 6 in the run, 8 now"),
        "{}",
        text(&refused)
    );
    let refused = bench(folder.path(), &[&other[..], &["--compare", file]].concat());
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused).contains("--compare"), "{}", text(&refused));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_parallel_fluid_is_measured_too() {
    let folder = tempfile::tempdir().unwrap();
    let output = bench(
        folder.path(),
        &["--from", "0.004", "--steps", "2", "--ranks", "2"],
    );
    assert!(output.status.success(), "{}", text(&output));
    assert!(text(&output).contains("2 rank(s)"), "{}", text(&output));
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn growth_measures_the_sizes_that_are_missing_and_fits_a_power() {
    let folder = tempfile::tempdir().unwrap();
    let growth = folder.path().join("growth");
    let measure = || {
        let output = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
            .current_dir(env!("CARGO_MANIFEST_DIR"))
            .args(["bench", "--case", "tests/cases/S-0.25"])
            .args(["--preset", "demo", "--from", "0.004", "--steps", "2"])
            .args(["--set", "fluid.mesh.axial_extension=5"])
            .args(["--set", "fluid.mesh.axial_per_section=6"])
            .args(["--set", "structure.axial_per_section=3"])
            .arg("--growth")
            .arg(&growth)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output));
    };
    // All sizes but the first are said to be there already, with costs that grow as the square of the size.
    std::fs::create_dir(&growth).unwrap();
    let sizes = [
        (1.0, 0.7),
        (1.45, 0.7),
        (2.0, 0.7),
        (2.5, 0.7),
        (0.8, 1.0),
        (0.8, 1.35),
        (0.8, 2.0),
    ];
    let file = |fluid: f64, structure: f64| {
        growth.join(format!("fluid-{fluid}-structure-{structure}.json"))
    };
    let known = |fluid: f64, structure: f64| {
        let names = [
            "coupling_iterations",
            "fluid_correctors",
            "newton_iterations",
            "factorizations",
            "step_s",
            "fluid_s",
            "fluid_mesh_motion_s",
            "fluid_momentum_s",
            "fluid_pressure_s",
            "fluid_rest_s",
            "structure_s",
            "structure_residual_s",
            "structure_substitution_s",
            "structure_assembly_s",
            "structure_factorization_s",
            "structure_rest_s",
            "coupling_s",
            "output_s",
            "driver_peak_memory_MB",
            "fluid_peak_memory_MB",
        ];
        let mut means: serde_json::Map<String, Value> = names
            .map(|name| (name.to_owned(), 1.0.into()))
            .into_iter()
            .collect();
        means.insert("fluid_cpu_s".into(), (fluid * fluid).into());
        means.insert("driver_cpu_s".into(), (structure * structure).into());
        serde_json::json!({
            "version": "", "case": "", "preset": "", "ranks": 1, "threads": 1, "from_s": 0.0, "steps": 1,
            "fluid_cells": (1000.0 * fluid) as usize,
            "structure_dofs": (1000.0 * structure) as usize,
            "per_step": means,
        })
    };
    for (fluid, structure) in sizes {
        let text = known(fluid, structure).to_string();
        std::fs::write(file(fluid, structure), text).unwrap();
    }
    measure();
    let first: Value = serde_json::from_slice(&std::fs::read(file(0.8, 0.7)).unwrap()).unwrap();
    assert!(first["per_step"]["fluid_cpu_s"].as_f64().unwrap() > 0.0);
    assert!(!growth.join("fluid-0.8-structure-0.7").exists());
    let table = std::fs::read_to_string(growth.join("growth.csv")).unwrap();
    assert_eq!(table.lines().count(), 9, "{table}");

    // With the first as the others, the fit is exact, and nothing is measured.
    std::fs::write(file(0.8, 0.7), known(0.8, 0.7).to_string()).unwrap();
    measure();
    let figure = std::fs::read_to_string(growth.join("growth.svg")).unwrap();
    assert_eq!(figure.matches("2.00").count(), 4, "{figure}");
    assert!(growth.join("growth.png").exists());
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn impossible_measurements_are_refused_and_leave_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, expected) in [
        (&["--from", "0"][..], "--from 0"),
        (&["--steps", "0"], "--steps"),
        (&["--compare", "no-such-file.json"], "no-such-file.json"),
        (&["--growth", "g", "--json", "j"], "--growth"),
        (&["--compare", "Cargo.toml"], "--json"),
    ] {
        let refused = bench(folder.path(), arguments);
        assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
        assert!(text(&refused).contains(expected), "{}", text(&refused));
    }
    assert!(!folder.path().join("warm").exists());
}
