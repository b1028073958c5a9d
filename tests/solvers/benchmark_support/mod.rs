//! Runs of the benchmark cases, and what their probes saw.

pub mod waves;

use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

/// Runs a case below `openfoam-case` to its end, with further arguments.
pub fn run(case: &str, out: &Path, arguments: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["--case", &format!("openfoam-case/{case}"), "--quiet"])
        .arg("--out")
        .arg(out)
        .args(arguments)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

/// The motion of each probe: time (s) and displacement (m) at the end of each step.
pub fn probes(run: &Path) -> Vec<Vec<[f64; 4]>> {
    let mut motion = Vec::new();
    let mut reader = csv::Reader::from_path(run.join("probes.csv")).unwrap();
    for row in reader.deserialize() {
        let row: HashMap<String, f64> = row.unwrap();
        let probe = row["probe"] as usize;
        if motion.len() <= probe {
            motion.resize(probe + 1, Vec::new());
        }
        motion[probe].push(["time_s", "ux_m", "uy_m", "uz_m"].map(|name| row[name]));
    }
    motion
}
