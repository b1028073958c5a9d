//! The examples of vessels, run in short form.

use crate::run_support::*;
use std::path::Path;
use std::process::Command;

fn example(name: &str, out: &Path, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["--case", &format!("examples/vessels/{name}")])
        .args(["--preset", "demo", "--end-time", "0.006", "--out"])
        .arg(out)
        .args(more);
    command
}

/// Each with the share of the outflow of the native solver in that of OpenFOAM after three steps, as measured: a wall of
/// facets encloses less.
const EXAMPLES: [(&str, f64); 5] = [
    ("aneurysm", 1.0016),
    ("curved", 1.0128),
    ("graft", 1.0152),
    ("stenosis", 1.0129),
    ("uniform", 1.0204),
];

/// Columns of the steps of a run, in this order.
fn columns<const N: usize>(run: &Path, names: [&str; N]) -> Vec<[f64; N]> {
    let mut reader = csv::Reader::from_path(run.join("history.csv")).unwrap();
    let headers = reader.headers().unwrap().clone();
    let places = names.map(|name| headers.iter().position(|header| header == name).unwrap());
    let rows = reader.records().map(Result::unwrap);
    rows.map(|row| places.map(|place| row[place].parse().unwrap()))
        .collect()
}

/// What flows in and not out is in the vessel, and every elastic section is a region.
#[test]
fn the_examples_of_vessels_run_with_either_fluid_and_can_be_reported() {
    let folder = tempfile::tempdir().unwrap();
    for (name, expected) in EXAMPLES {
        // Measured: at most 4e-8 and 2e-5.
        let outflow = [("native", 1e-7), ("openfoam", 5e-5)].map(|(fluid, within)| {
            let out = folder.path().join(format!("{name}-{fluid}"));
            complete(example(name, &out, &["--fluid", fluid]));
            let steps = columns(&out, ["Q_in_m3_s", "Q_out_m3_s", "dVdt_m3_s"]);
            assert_eq!(steps.len(), 3, "{name} {fluid}");
            for [inflow, outflow, rate] in &steps {
                let error = (rate - (inflow - outflow)).abs() / rate.abs();
                assert!(error < within, "{name} {fluid}: {error:e}");
            }
            let mut report = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
            report.arg("report").arg(&out);
            complete(report);
            steps[2][1]
        });
        let share = outflow[0] / outflow[1];
        assert!((share - expected).abs() < 2e-3, "{name}: {share}");
    }
    let regions = rows(&folder.path().join("aneurysm-native/regions.csv"));
    let names: Vec<&str> = regions[..3].iter().map(|row| row[1].as_str()).collect();
    assert_eq!(names, ["region=proximal", "region=sac", "region=distal"]);
}
