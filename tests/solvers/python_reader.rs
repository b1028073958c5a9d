//! What a run leaves, read by the package in `src/python` with the real Python and numpy.

use crate::run_support::{complete, driver};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

/// Set, it lets tests that need numpy pass without it.
const SKIP: &str = "FSI_DRIVER_SKIP_PYTHON";

/// A Python with numpy; `None` if the tests shall be skipped.
pub fn python() -> Option<&'static str> {
    let with_numpy = |program: &&str| {
        let tried = Command::new(program).args(["-c", "import numpy"]).output();
        tried.is_ok_and(|output| output.status.success())
    };
    let found = ["python3", "/usr/bin/python3"].into_iter().find(with_numpy);
    if found.is_none() {
        assert!(
            std::env::var_os(SKIP).is_some(),
            "no python3 with numpy was found: apt-get install python3-numpy, or set {SKIP}=1 to do without this test"
        );
        println!("not tested: there is no python3 with numpy, and {SKIP} is set");
    }
    found
}

/// Runs a script that finds the reader, with the folder of a run as its argument.
fn run_script(python: &str, script: &str, run: &Path) -> Output {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/python");
    Command::new(python)
        .env("PYTHONPATH", folder)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .args(["-c", script])
        .arg(run)
        .output()
        .unwrap()
}

const SHOW: &str = r#"
import json, sys, numpy
from fsi_driver import Run
run = Run(sys.argv[1])
P, F, V, H = numpy.fromfile(sys.argv[1] + "/wall.bin", "<u4", 4, offset=8)
steps = numpy.fromfile(sys.argv[1] + "/wall.bin", [("time_s", "<f8"), ("number", "<u4"), ("wall_shear_Pa", "<f4", (F, 3)), ("displacement_m", "<f4", (P, 3)), ("checksum", "<u4")], offset=H)
tawss, osi = run.wall.averages(0.004, 0.012)
table = run.wall_shear
largest = numpy.linalg.norm(run.wall.displacement_m.astype(float), axis=2).max(axis=1)
print(json.dumps({
    "times": run.wall.time_s.tolist(),
    "history": run.history["time_s"].tolist(),
    "same": bool((steps == run.wall.steps).all()),
    "displacement": float(abs(largest / run.history["max_displacement_m"] - 1).max()),
    "TAWSS": float(abs(tawss / table["TAWSS_Pa"] - 1).max()),
    "OSI": float(abs(osi - table["OSI"]).max()),
    "x": float(abs(run.wall.centres()[:, 0] - table["x_m"]).max()),
    "faces": len(run.wall.faces),
    "bypass": run.region("bypass").size,
    "iterations": run.iterations.size,
    "steps": run.summary["steps"],
    "window": run.hemodynamics["window"],
}))
"#;

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn numbers_read_from_python_are_those_of_the_run() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let window = [
        "--set",
        "output.window_start_s=0.004",
        "output.window_end_s=0.012",
    ];
    complete(driver(&out, 6, &window));
    let output = run_script(python, SHOW, &out);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        found["times"],
        serde_json::json!([0.002, 0.004, 0.006, 0.008, 0.01, 0.012])
    );
    assert_eq!(found["history"], found["times"]);
    assert_eq!(found["same"], true);
    // Stored in single precision, which rounds by at most 6e-8; the table has what was computed from it in double.
    let limits = [
        ("displacement", 1e-7),
        ("TAWSS", 1e-12),
        ("OSI", 1e-12),
        ("x", 1e-15),
    ];
    for (name, limit) in limits {
        let error = found[name].as_f64().unwrap();
        assert!(error < limit, "{name}: {error:e}");
    }
    let faces = csv::Reader::from_path(out.join("wall-shear.csv")).unwrap();
    assert_eq!(found["faces"], faces.into_records().count());
    assert_eq!((&found["bypass"], &found["steps"]), (&6.into(), &6.into()));
    assert!(found["iterations"].as_u64() >= Some(6));
    assert_eq!(found["window"]["end_s"], 0.012);

    // As a program.
    let program = "from fsi_driver.__main__ import main; main()";
    let output = run_script(python, program, &out);
    assert!(String::from_utf8_lossy(&output.stdout).contains("6 steps to t = 0.012 s"));
    let path = out.join("wall.bin");
    let mut bytes = std::fs::read(&path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(&path, bytes).unwrap();
    let output = run_script(python, program, &out);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.starts_with("error: ") && said.contains("record 2 (from byte"),
        "{said}"
    );
}

const SPLIT: &str = r#"
import json, sys
from fsi_driver import Run
run = Run(sys.argv[1])
def measured(name):
    rows = run.opening(name)
    rows = rows[rows["time_s"] > 0.0125]
    p = rows["p_Pa"]
    return [-rows["flow_m3_s"].mean(), p.min(), p.mean(), p.max()]
def told(opening):
    p = opening["p_Pa"]
    return [opening["mean_outflow_m3_s"], p["min"], p["mean"], p["max"]]
openings = run.summary["openings"]
print(json.dumps({
    "names": [opening["opening"] for opening in openings],
    "shares": [opening.get("share_of_outflow") for opening in openings],
    "outflows": [opening["mean_outflow_m3_s"] for opening in openings],
    "errors": [abs(a / b - 1) for opening in openings for a, b in zip(told(opening), measured(opening["opening"]))],
    "regions": [region["name"] for region in run.hemodynamics["regions"]],
    "left": run.region("left").size,
}))
"#;

/// A Y one end of which resists more: the shares of its flow, over two of four steps, and what else is read of a tree.
#[test]
fn the_split_of_a_tree_is_read_from_python() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    let changes = [
        "tree.opening[right].proximal_resistance_Pa_s_m3=*8",
        "output.window_start_s=0.01",
        "output.window_end_s=0.02",
    ];
    command.args([
        "--case",
        "examples/trees/y",
        "--fluid",
        "native",
        "--preset",
        "demo",
        "--end-time",
        "0.02",
    ]);
    command.arg("--out").arg(&out).arg("--set").args(changes);
    complete(command);
    let output = run_script(python, SPLIT, &out);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    println!("{found}");
    assert_eq!(
        found["names"],
        serde_json::json!(["inlet", "left", "right"])
    );
    assert_eq!(found["regions"], found["names"]);
    assert_eq!(found["left"], 4);
    for error in found["errors"].as_array().unwrap() {
        assert!(error.as_f64().unwrap() < 1e-12, "{found}");
    }
    let numbers = |key: &str, i: usize| found[key][i].as_f64().unwrap();
    let [left, right] = [1, 2].map(|i| numbers("shares", i));
    assert!(found["shares"][0].is_null() && (left + right - 1.0).abs() < 1e-12);
    let [a, b] = [1, 2].map(|i| numbers("outflows", i));
    assert!((left - a / (a + b)).abs() < 1e-12);
    // 0.8680
    assert!((0.86..0.875).contains(&left), "{left}");

    let program = run_script(python, "from fsi_driver.__main__ import main; main()", &out);
    let lines = String::from_utf8_lossy(&program.stdout);
    assert!(lines.contains("right: mean outflow"), "{lines}");
    let mut report = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    report.arg("report").arg(&out);
    complete(report);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    let share = format!("{:.1}", 100.0 * left);
    assert!(
        page.contains("share of what leaves") && page.contains(&share),
        "{share}"
    );
}
