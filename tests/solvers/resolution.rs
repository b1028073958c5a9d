//! What runs say of their own resolution and steadiness, in text, `summary.json` and on the page.

use crate::run_support::*;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A straight rigid tube, 1 mm wide, in a few elements of degree 3, with these lines.
fn tube(folder: &Path, lines: &str) -> PathBuf {
    let text = format!(
        "extends = \"defaults\"\n[vessel]\nradius_m = 1e-3\n[[vessel.piece]]\npiece = \"line\"\nlength_m = 6e-3\n[[vessel.section]]\n\
         name = \"tube\"\nwall = \"rigid\"\n[outlet]\ncondition = \"pressure\"\npressure_Pa = 0.0\n[ramp]\nduration_s = 0.0\n\
         [structure]\naxial_per_section = 1\n[fluid]\nsolver = \"native\"\n[fluid.native]\ndegree = 3\ncore = 1\nradial = 1\naxial_per_section = 4\n{lines}\n"
    );
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("case.toml"), text).unwrap();
    folder.to_owned()
}

/// What a run says, and its summary.
fn run(case: &Path, name: &str, more: &[&str]) -> (String, Value, PathBuf) {
    let out = case.join(name);
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
        .arg("--case")
        .arg(case)
        .arg("--out")
        .arg(&out)
        .args(more);
    let said = text(&complete(command));
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    (said, serde_json::from_str(&summary).unwrap(), out)
}

fn page(out: &Path) -> String {
    let mut report = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    complete({
        report.arg("report").arg(out);
        report
    });
    std::fs::read_to_string(out.join("report.html")).unwrap()
}

const CONSTANT: &str = "[inflow]\nbase_m3_s = 4e-7\namplitude_m3_s = 0.0\n[time]\nstep_s = 2e-3\nend_s = 0.4\nperiod_s = 0.6\n[output]\nwindow_start_s = 0.0";

#[test]
fn a_run_with_constant_inputs_says_whether_it_has_become_steady() {
    let folder = tempfile::tempdir().unwrap();
    let case = tube(folder.path(), CONSTANT);
    // A plug begins at once; it takes about as long to become developed flow as blood takes through the tube, 47 ms.
    let short = ["--end-time", "0.02", "--set", "time.step_s=1e-3"];
    let (said, summary, out) = run(&case, "short", &short);
    let found = &summary["steadiness"];
    assert_eq!(found["steady"], false);
    let change = found["change"].as_f64().unwrap();
    assert!((0.018..0.022).contains(&change), "{change}"); // 0.0204
    assert!((found["over_s"].as_f64().unwrap() - 0.004).abs() < 1e-9);
    let sentence = "but the flow has not become steady: over the last 0.004 s";
    assert!(said.contains(sentence), "{said}");
    assert!(page(&out).contains(sentence));

    let (said, summary, out) = run(&case, "long", &[]);
    let found = &summary["steadiness"];
    assert_eq!(found["steady"], true, "{found}");
    assert!(found["change"].as_f64().unwrap() < 1e-4, "{found}");
    assert!(
        said.contains("the flow has become steady: over the last 0.080 s"),
        "{said}"
    );
    assert!(!page(&out).contains("not become steady"));
}

#[test]
fn a_run_that_is_driven_by_pulses_says_nothing_of_steadiness() {
    let folder = tempfile::tempdir().unwrap();
    let lines = CONSTANT.replace("amplitude_m3_s = 0.0", "amplitude_m3_s = 1e-7");
    let case = tube(folder.path(), &lines);
    let (said, summary, _) = run(&case, "run", &["--end-time", "0.02"]);
    assert!(summary.get("steadiness").is_none());
    assert!(!said.contains("steady"), "{said}");
}

/// The axisymmetric solution of others on 227 x 22 elements, whose mesh error is 0.2 %: places on the axis (m) and
/// velocities (m/s).
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
#[test]
fn the_fda_nozzle_on_a_wedge_meets_the_axisymmetric_solution() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["--case", "openfoam-case/fda-nozzle/axisymmetric"])
        .args([
            "--set",
            "output.structure_interval_s=1",
            "output.fluid_interval_s=1",
            "output.window_start_s=0.2",
        ])
        .args(["--end-time", "0.24", "--out"])
        .arg(&out);
    complete(command);
    let rows = rows(&out.join("fluid-probes.csv"));
    let speed = |x: &str| -> f64 {
        let here = rows.iter().rev().find(|row| row[2] == format!("x_m={x}"));
        here.unwrap()[6]
            .strip_prefix("ux_m_s=")
            .unwrap()
            .parse()
            .unwrap()
    };
    // At 0.24 s the flow stands from the throat to 40 mm downstream of it: these are within 0.3 % of those at 1.4 s.
    for (x, reference) in [
        ("0.0", 0.7472),
        ("0.008", 0.7290),
        ("0.016", 0.7096),
        ("0.024", 0.6866),
        ("0.032", 0.6610),
        ("0.04", 0.6339),
    ] {
        let found = speed(x);
        assert!(
            (found / reference - 1.0).abs() < 5e-3,
            "{x}: {found} beside {reference}"
        );
    }
}
