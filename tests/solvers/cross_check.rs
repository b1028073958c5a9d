//! `fsi-driver cross-check`: both solvers for the blood on the same case.

use crate::run_support::*;
use std::path::Path;
use std::process::{Command, Output};

fn cross_check(out: &Path, more: &[&str]) -> Output {
    let few = [
        "fluid.native.degree=3",
        "fluid.native.axial_extension=2",
        "fluid.native.axial_per_section=2",
    ];
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["cross-check", "tests/cases/S-0.25", "--preset", "demo"])
        .args(["--end-time", "0.01", "--quiet", "--out"])
        .arg(out)
        .args(more)
        .args(SMALL)
        .args(few);
    command.output().unwrap()
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn both_solvers_run_once_and_the_limits_decide_the_exit_code() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("both");
    // Of the first five steps from rest, when the layers at the wall are thinner than a cell.
    let output = cross_check(&out, &["--history", "0.02", "--wall", "10", "--osi", "0.5"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert!(
        text(&output).contains("S-0.25: outflow / m³/s"),
        "{}",
        text(&output)
    );
    let histories = ["openfoam", "native"].map(|solver| {
        let run = out.join("S-0.25").join(solver);
        assert_eq!(steps_done(&run), 5, "{solver}");
        std::fs::read_to_string(run.join("history.csv")).unwrap()
    });
    assert_ne!(histories[0], histories[1]);
    let table = std::fs::read_to_string(out.join("S-0.25/compare.csv")).unwrap();
    let volume = table.lines().find(|line| line.starts_with("lumen volume"));
    let relative: f64 = volume.unwrap().split(',').nth(5).unwrap().parse().unwrap();
    assert!((relative - 8.77e-4).abs() < 3e-5, "{relative}");
    let page = std::fs::read_to_string(out.join("cross-check.html")).unwrap();
    for expected in ["mean, OpenFOAM", "mean, native", "<svg", "beyond", "within"] {
        assert!(page.contains(expected), "{expected}");
    }

    // Finished runs are kept, and refused without --resume.
    let again = cross_check(&out, &[]);
    assert_eq!(again.status.code(), Some(2), "{}", text(&again));
    let generous = [
        "--resume",
        "--history",
        "10",
        "--wall",
        "10",
        "--osi",
        "0.5",
    ];
    let again = cross_check(&out, &generous);
    assert_eq!(again.status.code(), Some(0), "{}", text(&again));
    let native = out.join("S-0.25/native/history.csv");
    assert_eq!(std::fs::read_to_string(native).unwrap(), histories[1]);

    let refined = cross_check(&out, &[&generous[..], &["--refine"]].concat());
    assert_eq!(refined.status.code(), Some(0), "{}", text(&refined));
    let table = out.join("S-0.25/refinement.csv");
    let mut table = csv::Reader::from_path(table).unwrap();
    let headers = table.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = table.records().map(Result::unwrap).collect();
    let volume = rows.iter().find(|row| row[0].starts_with("lumen volume"));
    let value = |name: &str| -> f64 {
        let column = headers.iter().position(|header| header == name).unwrap();
        volume.unwrap()[column].parse().unwrap()
    };
    let (fine, exact) = (value("fine_a"), value("fine_b"));
    let error = value("extrapolated_a") / exact - 1.0;
    let order = value("observed_order_a");
    let uncertainty = value("uncertainty_b") / exact;
    assert!((fine / exact - 1.0 + 3.0e-4).abs() < 2e-5, "{fine} {exact}");
    assert!((error - 1.34e-4).abs() < 2e-5, "{error}");
    assert!((order - 2.55).abs() < 0.1, "{order}");
    assert!((2.5e-5..4.5e-5).contains(&uncertainty), "{uncertainty:e}");
    let page = std::fs::read_to_string(out.join("cross-check.html")).unwrap();
    assert!(page.contains("observed order"));
}

#[test]
fn what_cannot_be_checked_is_refused_and_nothing_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("both");
    for (more, expected) in [
        (&["--fluid", "native"][..], "leave out --fluid"),
        (&["--wall=-1"], "a limit of -1"),
        (&["tests/cases/S-0.25"], "two cases are called S-0.25"),
    ] {
        let output = cross_check(&out, more);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(expected), "{}", text(&output));
        assert!(!out.exists());
    }
}

/// Two runs of a tree may agree in what leaves it and differ in where that leaves.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_tree_is_compared_at_each_opening() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("both");
    let output = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["cross-check", "examples/trees/side-branch"])
        .args(["--preset", "demo", "--end-time", "0.015", "--quiet"])
        .args(["--history", "0.2", "--wall", "10", "--osi", "10", "--out"])
        .arg(&out)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let table = std::fs::read_to_string(out.join("side-branch/compare.csv")).unwrap();
    let row = |quantity: &str, opening: &str| -> Vec<f64> {
        let begin = format!("{quantity},{opening},");
        let row = table.lines().find_map(|line| line.strip_prefix(&begin));
        let cells = row
            .unwrap_or_else(|| panic!("{begin} in\n{table}"))
            .split(',');
        cells.map(|cell| cell.parse().unwrap()).collect()
    };
    // A ninth of the flow leaves through the branch, three steps from rest.
    let [artery, branch] = ["artery", "branch"].map(|name| row("flow in / m³/s", name));
    assert!(
        (branch[0] / artery[0] - 0.115).abs() < 0.01,
        "{}",
        branch[0] / artery[0]
    );
    assert!((1e-3..0.05).contains(&branch[3]), "{}", branch[3]);
    let pressure = row("pressure / Pa", "branch");
    assert!((1e-7..1e-3).contains(&pressure[3]), "{}", pressure[3]);
}
