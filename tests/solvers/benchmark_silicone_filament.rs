//! The silicone filament between two jets, after Hessenthaler and others (2017): see
//! openfoam-case/silicone-filament/README.md, which has the whole run beside the experiment.

use crate::benchmark_support::probes;
use crate::run_support::{complete, copy, edit, text};
use std::path::Path;
use std::process::Command;

/// The beginning, while inflow and buoyancy grow, on a coarse mesh with long steps: the end of the filament rises by so
/// much as long as buoyancy prevails, 0.823 mm in cells half as large and steps half as long.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn buoyancy_lifts_the_silicone_filament_between_the_jets() {
    let folder = tempfile::tempdir().unwrap();
    let [case, out] = ["case", "run"].map(|name| folder.path().join(name));
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/silicone-filament");
    copy(&example, &case);
    edit(&case.join("case.toml"), "../defaults.toml", "defaults");
    // The example may have one.
    let _ = std::fs::remove_dir_all(case.join("fluid/constant/polyMesh"));
    let mut check = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    let refused = check.arg("check").arg(&case).output().unwrap();
    assert_eq!(refused.status.code(), Some(2));
    let said = text(&refused);
    assert!(said.contains("there is no mesh yet"), "{said}");
    assert!(said.contains("run make_mesh.sh beside the case"), "{said}");
    let mut mesh = Command::new(case.join("make_mesh.sh"));
    mesh.arg("6");
    let said = text(&complete(mesh));
    assert!(said.contains("Mesh OK"), "{said}");
    let mut driver = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    driver.args(["--quiet", "--end-time", "0.3", "--set", "time.step_s=0.01"]);
    driver.arg("--case").arg(&case).arg("--out").arg(&out);
    complete(driver);
    // The places of experiment.csv: along the middle line, and the end.
    let tip = probes(&out).pop().unwrap();
    let [_, x, y, z] = tip[29];
    println!("{x}, {y}, {z}");
    assert!((y / 7.491e-4 - 1.0).abs() < 5e-3, "{y}");
    assert!(x.abs() < 5e-6 && z.abs() < 1e-5, "{x}, {z}");
}
