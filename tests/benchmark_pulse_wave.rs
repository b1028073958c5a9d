//! The speed of a pressure pulse in a thin-walled tube: see openfoam-case/pulse-wave/README.md.

use std::collections::HashMap;
use std::process::Command;

#[test]
fn a_pulse_travels_at_the_speed_of_moens_and_korteweg() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let output = Command::new(env!("CARGO_BIN_EXE_fsi-driver"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(["--case", "openfoam-case/pulse-wave", "--preset", "demo"])
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );

    // Time and radial displacement of each probe.
    let mut motion = vec![Vec::new(); 3];
    for row in csv::Reader::from_path(out.join("probes.csv"))
        .unwrap()
        .deserialize()
    {
        let row: HashMap<String, f64> = row.unwrap();
        motion[row["probe"] as usize].push([row["time_s"], row["uy_m"]]);
    }
    let arrival: Vec<f64> = motion.iter().map(|probe| time_of_the_peak(probe)).collect();

    let (youngs_modulus, thickness, density, radius) = (6e5, 0.25e-3, 1000.0, 5e-3);
    let exact = f64::sqrt(youngs_modulus * thickness / (2.0 * density * radius));
    for [from, to] in [[0, 1], [1, 2], [0, 2]] {
        let speed = 0.04 * (to - from) as f64 / (arrival[to] - arrival[from]);
        println!("{from} to {to}: {speed} m/s, exact {exact} m/s");
        assert!((speed / exact - 1.0).abs() < 0.03, "{speed} {exact}");
    }
}

/// Where the parabola through the largest value and its neighbours has its peak.
fn time_of_the_peak(motion: &[[f64; 2]]) -> f64 {
    let at = (1..motion.len() - 1)
        .max_by(|&a, &b| motion[a][1].total_cmp(&motion[b][1]))
        .unwrap();
    let [before, peak, after] = [at - 1, at, at + 1].map(|i| motion[i][1]);
    let step = motion[at][0] - motion[at - 1][0];
    motion[at][0] + 0.5 * step * (before - after) / (before - 2.0 * peak + after)
}
