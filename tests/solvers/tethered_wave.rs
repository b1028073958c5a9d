//! Pulses along an artery that is stretched and under pressure: with a wall that slides along itself, and with one that
//! tissue holds along its axis.

use crate::run_support::*;
use std::path::Path;

/// The artery of the defaults, 120 mm of it, at 100 mmHg and 1.2 times its length, with 2 mmHg more for 10 ms at the
/// inlet.
const CASE: &str = r#"
extends = "defaults"
[vessel]
radius_m = 3.2e-3
[[vessel.piece]]
piece = "line"
length_m = 0.12
[[vessel.section]]
name = "artery"
layers = ["media", "adventitia"]
thicknesses_m = [0.55e-3, 0.55e-3]
[[vessel.material]]
name = "media"
material = "holzapfel_gasser_ogden"
mu_Pa = 5.4e4
kappa_Pa = 1.0e9
k1_Pa = 0.64e3
k2 = 3.54
fibre_angle_deg = 10.0
[[vessel.material]]
name = "adventitia"
material = "holzapfel_gasser_ogden"
mu_Pa = 5.4e3
kappa_Pa = 1.0e8
k1_Pa = 5.1e3
k2 = 15.4
fibre_angle_deg = 40.0
[wall]
damping_1_s = 0.0
[blood]
viscosity_Pa_s = 1.0e-4
[initial]
start = "equilibrium"
axial_stretch = 1.2
[inlet]
condition = "pressure"
file = "pulse.csv"
[outlet]
condition = "pressure"
pressure_Pa = 13332.2
[ramp]
duration_s = 0.0
[time]
step_s = 1e-3
end_s = 0.025
period_s = 0.05
[structure]
p = 3
axial_per_section = 6
circumferential = 4
[fluid]
solver = "native"
[fluid.native]
degree = 3
core = 1
radial = 1
axial_extension = 0
axial_per_section = 8
[output]
structure_interval_s = 0.05
fluid_interval_s = 0.05
probes_m = [[0.03, 3.2e-3, 0.0], [0.07, 3.2e-3, 0.0]]
"#;

/// When the pulse passes the probes, s: where the parabola through the largest radial displacement and its neighbours
/// has its peak.
fn passes(out: &Path) -> [f64; 2] {
    let mut table = csv::Reader::from_path(out.join("probes.csv")).unwrap();
    let headers = table.headers().unwrap().clone();
    let [time, probe, across] = ["time_s", "probe", "uy_m"]
        .map(|name| headers.iter().position(|header| header == name).unwrap());
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    [0, 1].map(|wanted| {
        let own = rows.iter().filter(|row| row[probe].parse() == Ok(wanted));
        let motion: Vec<[f64; 2]> = own
            .map(|row| [time, across].map(|column| row[column].parse().unwrap()))
            .collect();
        let at = (1..motion.len() - 1)
            .max_by(|&a, &b| motion[a][1].total_cmp(&motion[b][1]))
            .unwrap();
        let [before, peak, after] = [at - 1, at, at + 1].map(|i| motion[i][1]);
        let step = motion[at][0] - motion[at - 1][0];
        motion[at][0] + 0.5 * step * (before - after) / (before - 2.0 * peak + after)
    })
}

/// Tissue along the axis makes pulses as fast as Bramwell and Hill say.
#[test]
fn axial_tissue_gives_bramwell_hill_speed() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("case.toml"), CASE).unwrap();
    let pulse = |t: f64| match t < 0.01 {
        true => 266.6 * (std::f64::consts::PI * t / 0.01).sin().powi(2),
        false => 0.0,
    };
    let rows = (0..=100).map(|i| 5e-4 * f64::from(i));
    let rows: String = rows
        .map(|t| format!("{t:.4},{:.4}\n", 13332.2 + pulse(t)))
        .collect();
    let table = format!("time_s,pressure_Pa\n{rows}");
    std::fs::write(folder.path().join("pulse.csv"), table).unwrap();
    let speed = |name: &str, tissue: &[&str]| {
        let out = folder.path().join(name);
        let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        run.arg("--case").arg(folder.path()).arg("--out").arg(&out);
        run.args(tissue);
        complete(run);
        let [near, far] = passes(&out);
        let speed = 1.2 * 0.04 / (far - near);
        println!("{name}: {speed} m/s");
        speed
    };
    let sliding = speed("sliding", &[]);
    let held = speed(
        "held",
        &[
            "--set",
            "surroundings.direction=axial",
            "surroundings.spring_Pa_m=1e8",
            "surroundings.at_rest=loaded",
        ],
    );
    // A long tube that slides carries them at 5.41 m/s; this one is clamped at both ends, near which it slides less.
    // Held along its axis: 8.76 m/s. Measured 7.097 and 8.914.
    assert!((sliding - 7.097).abs() < 0.07, "{sliding}");
    assert!((held - 8.914).abs() < 0.07, "{held}");
    assert!((held / 8.76 - 1.0).abs() < 0.03, "{held}");
}
