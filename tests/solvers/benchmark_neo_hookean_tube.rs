//! A step of pressure in a neo-Hookean tube: see openfoam-case/neo-hookean-tube/README.md.

use crate::benchmark_support::{probes, run};
use crate::pfem_support::radial;
use fsi_driver::case::Material;
use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

/// Pressure at the inlet, Pa.
const PRESSURE: f64 = 5e3;
const RADIUS: f64 = 0.01;

/// Twice the time step of the case on a coarse mesh.
const COARSE: [&str; 5] = [
    "time.step_s=2e-4",
    "fluid.mesh.core=3",
    "fluid.mesh.radial=2",
    "fluid.mesh.axial_per_section=30",
    "output.structure_interval_s=0.01",
];

/// Young's modulus (Pa) and Poisson's ratio of the case.
const WALL: [f64; 2] = [1e6, 0.3];

/// What was computed over what theory says upstream of the front, in a wall of this Young's modulus (Pa) and Poisson's
/// ratio: the displacement 20 mm downstream of the inlet and the inflow, both means from 6 to 12 ms (or the end), in
/// which the wall rings; the mean number of coupling iterations; and the inflow of the last 4 ms.
fn behind_the_front(wall: [f64; 2], settings: &[&str]) -> [f64; 4] {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let arguments = [&["--preset", "demo", "--set"], settings].concat();
    run("neo-hookean-tube", &out, &arguments);
    let (radial, inflow) = exact(wall);
    let probes = probes(&out);
    let widenings = probes[0].iter().map(|row| [row[0], row[2]]);
    let widened = mean(widenings, 0.00615..0.0121);
    let history = history(&out);
    let flows = || {
        let rows = history.iter();
        rows.map(|row| [row["time_s"], row["Q_in_m3_s"]])
    };
    let end = history.last().unwrap()["time_s"];
    let iterations = history.iter().map(|row| row["coupling_iterations"]);
    let found = [
        widened / radial,
        mean(flows(), 0.00615..0.0121) / inflow,
        iterations.sum::<f64>() / history.len() as f64,
        mean(flows(), end - 0.0039..1.0) / inflow,
    ];
    println!("{settings:?}: {found:?}, exact {radial} m and {inflow} m3/s");
    found
}

/// Mean of the values at the times of a range (s).
fn mean(rows: impl Iterator<Item = [f64; 2]>, times: Range<f64>) -> f64 {
    let values = rows
        .filter(|[t, _]| times.contains(t))
        .map(|[_, value]| value);
    let values: Vec<f64> = values.collect();
    values.iter().sum::<f64>() / values.len() as f64
}

fn history(run: &Path) -> Vec<HashMap<String, f64>> {
    let mut table = csv::Reader::from_path(run.join("history.csv")).unwrap();
    table.deserialize().map(Result::unwrap).collect()
}

/// The radial displacement (m) of the tube under the pressure at rest, plane strain, and the flow (m³/s) behind a front
/// that has left this cross-section behind it: in its frame mass and Bernoulli's sum are kept, `A0 U = A1 (U - u)` and
/// `p = rho/2 (U² - (U - u)²)`.
fn exact(wall: [f64; 2]) -> (f64, f64) {
    let [mu, kappa] = parameters(wall);
    let wall = Material::NeoHooke {
        mu,
        kappa,
        viscosity: None,
    };
    let tube = radial::inflate(RADIUS, &[(2e-3, wall)], PRESSURE, true);
    let widened = tube.displacement[0];
    let ratio = (1.0 + widened / RADIUS).powi(-2);
    let speed = (2.0 * PRESSURE / (1000.0 * (1.0 - ratio * ratio))).sqrt();
    let area = std::f64::consts::PI * (RADIUS + widened).powi(2);
    (widened, area * speed * (1.0 - ratio))
}

/// Shear modulus and Lamé's first parameter, Pa.
fn parameters([youngs_modulus, poisson_ratio]: [f64; 2]) -> [f64; 2] {
    let mu = youngs_modulus / (2.0 * (1.0 + poisson_ratio));
    [mu, 2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio)]
}

/// Each is what was measured.
fn check(wall: [f64; 2], settings: &[&str], measured: [f64; 4]) {
    let found = behind_the_front(wall, settings);
    for ((value, measured), within) in found
        .into_iter()
        .zip(measured)
        .zip([2e-3, 2e-3, 0.15, 2e-3])
    {
        assert!((value - measured).abs() < within, "{found:?}");
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_front_widens_the_tube_as_its_pressure_does_at_rest() {
    let until = ["time.end_s=0.01"]; // The front is at the outlet
    let settings = [&COARSE[..], &until].concat();
    check(WALL, &settings, [1.0014, 0.9705, 5.92, 0.9705]);
}

/// Until the front has come back from the outlet as suction and is reflected again. What was rough in the blood that
/// enters used to grow: at 18 ms the inflow ran away.
#[test]
fn with_the_native_fluid_too_and_it_stays_calm() {
    let native = ["fluid.solver=native", "time.end_s=0.024"];
    let settings = [&COARSE[..], &native].concat();
    check(WALL, &settings, [1.0015, 0.9586, 4.64, 1.6133]);
}

/// The inflow is that of the theory once the two things are gone that this leaves out: friction, and a wall that moves
/// along itself because it becomes shorter where it is wide.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn inflow_without_friction_is_theoretical() {
    const WALL: [f64; 2] = [1e6, 1e-6];
    let [mu, kappa] = parameters(WALL);
    let settings = [
        format!("vessel.material[0].mu_Pa={mu:e}"),
        format!("vessel.material[0].kappa_Pa={kappa:e}"),
        "blood.viscosity_Pa_s=1e-5".to_owned(),
        "time.end_s=0.012".to_owned(),
    ];
    let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
    check(WALL, &settings, [0.9892, 0.9940, 4.47, 0.9998]);
}
