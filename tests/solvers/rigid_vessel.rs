//! Vessels with rigid walls: the flow alone, against exact solutions of what is prescribed at the ends.

use crate::run_support::*;
use nalgebra::Complex;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::process::Command;

/// Radius and length of a straight tube, m.
const RADIUS: f64 = 1e-3;
const LENGTH: f64 = 6e-3;
const DENSITY: f64 = 1050.0;
const VISCOSITY: f64 = 3.5e-3;
/// Largest flow, m³/s.
const FLOW: f64 = 1.2e-6;

/// A case of the tube with these lines; the flow in is `FLOW sin²(πt/T)` from the beginning on.
fn tube(folder: &Path, lines: &str) -> std::path::PathBuf {
    let text = format!(
        "extends = \"defaults\"\n[vessel]\nradius_m = {RADIUS:e}\n[[vessel.piece]]\npiece = \"line\"\nlength_m = {LENGTH:e}\n\
         [[vessel.section]]\nname = \"tube\"\nwall = \"rigid\"\n[blood]\ndensity_kg_m3 = {DENSITY:?}\nviscosity_Pa_s = {VISCOSITY:?}\n\
         [ramp]\nduration_s = 0.0\n[inflow]\nbase_m3_s = 0.0\namplitude_m3_s = {FLOW:e}\nexponent = 1.0\n{lines}\n"
    );
    std::fs::create_dir_all(folder).unwrap();
    std::fs::write(folder.join("case.toml"), text).unwrap();
    folder.to_owned()
}

/// Runs a case in its folder, and says where.
fn run(case: &Path, more: &[&str]) -> std::path::PathBuf {
    let out = case.join("run");
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    command.arg("--case").arg(case).args(["--preset", "demo"]);
    command.arg("--out").arg(&out).args(more);
    complete(command);
    out
}

/// Columns of a table.
fn table<const N: usize>(path: &Path, names: [&str; N]) -> Vec<[f64; N]> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let rows = reader
        .deserialize::<HashMap<String, f64>>()
        .map(Result::unwrap);
    rows.map(|row| names.map(|name| row[name])).collect()
}

/// Few elements of degree 3, in which the flow is that of the inlet to round-off.
const FEW: [&str; 5] = [
    "fluid.native.degree=3",
    "fluid.native.core=1",
    "fluid.native.radial=1",
    "fluid.native.axial_per_section=2",
    "structure.axial_per_section=1",
];

/// `C dp/dt + p/R = FLOW sin²(πt/T)` with T = 1 s and p(0) = 0, in closed form.
fn distal(t: f64, resistance: f64, compliance: f64) -> f64 {
    let tau = resistance * compliance;
    let size = Complex::new(1.0, TAU * tau);
    let wave = |t: f64| (Complex::from_polar(1.0, TAU * t) / size).re;
    let at = |t: f64| 0.5 * FLOW * resistance * (1.0 - wave(t));
    at(t) - at(0.0) * (-t / tau).exp()
}

/// Largest errors of the pressure at the outlet, `p + R_p Q`, and of that of the windkessel, relative to the largest;
/// at the times of the coarsest step.
fn windkessel_errors(folder: &Path, scheme: &str, step: f64, more: &[&str]) -> Vec<[f64; 2]> {
    let (resistance, compliance, proximal) = (4.0e9, 5.0e-11, 1.0e9);
    let case = tube(
        folder,
        &format!(
            "systole_s = 1.0\n[time]\nstep_s = {step:e}\nend_s = 0.1\nperiod_s = 1.0\n[windkessel]\nresistance_Pa_s_m3 = {resistance:e}\n\
             compliance_m3_Pa = {compliance:e}\ninitial_pressure_Pa = 0.0\nproximal_resistance_Pa_s_m3 = {proximal:e}\n"
        ),
    );
    let set = [&["--set", scheme], &FEW[..], more].concat();
    let run = run(&case, &set);
    let rows = table(
        &run.join("history.csv"),
        ["time_s", "p_out_Pa", "p_windkessel_Pa"],
    );
    assert_eq!(rows.len(), (0.1 / step).round() as usize);
    let exact = |t: f64| {
        let behind = distal(t, resistance, compliance);
        [behind + proximal * FLOW * (PI * t).sin().powi(2), behind]
    };
    let largest = exact(0.1);
    let every = (4e-3 / step).round() as usize;
    let whole = rows.iter().skip(every - 1).step_by(every);
    whole
        .map(|[t, at_outlet, behind]| {
            let exact = exact(*t);
            [at_outlet - exact[0], behind - exact[1]].map(|error| error / largest[1])
        })
        .collect()
}

fn largest(errors: &[[f64; 2]]) -> f64 {
    errors.iter().flatten().map(|e| e.abs()).fold(0.0, f64::max)
}

/// In a rigid vessel the flow out is the flow in, and the exact pressures are known.
#[test]
fn a_windkessel_of_three_elements_is_its_differential_equation() {
    let folder = tempfile::tempdir().unwrap();
    let errors = |scheme: &str, step: f64| {
        let case = folder.path().join(format!("{scheme}-{step}"));
        // The solver's own key takes the place of that of the time axis
        let scheme = format!("fluid.native.time_scheme={scheme}");
        windkessel_errors(&case, &scheme, step, &["--fluid", "native"])
    };
    // The order, and to what three steps lead: a polynomial in the step through the errors at each time
    for (scheme, order, measured, limit) in [
        ("implicit_euler", 1, [4.81e-2, 2.40e-2, 1.20e-2], 7.2e-7),
        ("bdf2", 2, [2.09e-3, 5.18e-4, 1.29e-4], 8.0e-8),
    ] {
        let runs = [4e-3, 2e-3, 1e-3].map(|step| errors(scheme, step));
        for (run, measured) in runs.iter().zip(measured) {
            let found = largest(run);
            assert!((found / measured - 1.0).abs() < 0.02, "{scheme}: {found:e}");
        }
        let [a, b] = [order, order + 1].map(|order| 2f64.powi(order));
        let lead = |i: usize, c: usize| {
            let [x, y, z] = [0, 1, 2].map(|run: usize| runs[run][i][c]);
            let [x, y] = [(a * y - x) / (a - 1.0), (a * z - y) / (a - 1.0)];
            (b * y - x) / (b - 1.0)
        };
        let left: Vec<[f64; 2]> = (0..runs[0].len())
            .map(|i| [0, 1].map(|c| lead(i, c)))
            .collect();
        let found = largest(&left);
        println!("{scheme}: {found:e}");
        assert!(
            (0.5 * limit..1.5 * limit).contains(&found),
            "{scheme}: {found:e}"
        );
    }
    // And without such help
    let found = largest(&errors("bdf2", 8e-5));
    println!("bdf2, 8e-5 s: {found:e}");
    assert!((5e-7..1e-6).contains(&found), "{found:e}");
}

/// OpenFOAM's pressure follows the flux from corrector to corrector; with enough of them only the time scheme's error
/// is left.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_windkessel_has_the_order_of_the_time_scheme_with_openfoam() {
    let folder = tempfile::tempdir().unwrap();
    let accurate = ["fluid.pressure_residual=1e-7", "fluid.max_correctors=60"];
    for (scheme, measured) in [
        ("time.scheme=euler", [4.81e-2, 2.40e-2]),
        ("time.scheme=bdf2", [2.09e-3, 5.18e-4]),
    ] {
        for (step, measured) in [4e-3, 2e-3].into_iter().zip(measured) {
            let case = folder.path().join(format!("{scheme}-{step}"));
            let found = largest(&windkessel_errors(&case, scheme, step, &accurate));
            println!("{scheme}, {step} s: {found:e}");
            assert!((found / measured - 1.0).abs() < 0.02, "{scheme}: {found:e}");
        }
    }
}

/// Bessel's functions J0 and J1, by their series.
fn bessel(z: Complex<f64>) -> [Complex<f64>; 2] {
    let q = -0.25 * z * z;
    let (mut term, mut sums) = (Complex::new(1.0, 0.0), [Complex::new(0.0, 0.0); 2]);
    for k in 0..60 {
        sums[0] += term;
        sums[1] += term * 0.5 * z / (f64::from(k) + 1.0);
        term *= q / ((f64::from(k) + 1.0) * (f64::from(k) + 1.0));
    }
    sums
}

/// Womersley's parameter λ (1/m), `J0(λR)`, and the flow over that of a uniform velocity as fast as without friction.
fn harmonic(period: f64) -> [Complex<f64>; 3] {
    let lambda = (Complex::new(0.0, -TAU / period) * DENSITY / VISCOSITY).sqrt();
    let [wall, slope] = bessel(lambda * RADIUS);
    let share = Complex::from(1.0) - 2.0 * slope / (lambda * RADIUS * wall);
    [lambda, wall, share]
}

/// Womersley's velocity (m/s) in the periodic state of `FLOW sin²(πt/T)`.
fn womersley(r: f64, t: f64, period: f64) -> f64 {
    let [lambda, wall, share] = harmonic(period);
    let [here, _] = bessel(lambda * r);
    let shape = (Complex::from(1.0) - here / wall) / share;
    let steady = 2.0 * (1.0 - (r / RADIUS).powi(2));
    let mean = 0.5 * FLOW / (PI * RADIUS * RADIUS);
    mean * (steady - (shape * Complex::from_polar(1.0, TAU * t / period)).re)
}

/// The pressure (Pa) that drives it through the tube.
fn driving_pressure(t: f64, period: f64) -> f64 {
    let omega = TAU / period;
    let [_, _, share] = harmonic(period);
    let mean = 0.5 * FLOW / (PI * RADIUS * RADIUS);
    let inertia = Complex::new(0.0, omega * DENSITY) / share * Complex::from_polar(1.0, omega * t);
    LENGTH * mean * (8.0 * VISCOSITY / (RADIUS * RADIUS) - inertia.re)
}

/// Largest differences in the last of some beats from Womersley's velocity, relative to the largest one: in the
/// cross-sections half a radius from the inlet, in the middle, and half a radius from the outlet. `inlet` are lines
/// of the case.
fn profile_errors(folder: &Path, inlet: &str, beats: u32, more: &[&str]) -> [f64; 3] {
    let period = 0.2;
    let case = tube(
        folder,
        &format!(
            "systole_s = {period}\n[time]\nstep_s = 2e-3\nend_s = {}\nperiod_s = {period}\n[inlet]\n{inlet}\n\
             [outlet]\ncondition = \"pressure\"\npressure_Pa = 0.0\n",
            period * f64::from(beats)
        ),
    );
    let places = [0.25e-3, 0.5 * LENGTH, LENGTH - 0.5 * RADIUS];
    let radii = [0.0, 0.3, 0.6, 0.9].map(|share| share * RADIUS);
    let points: Vec<String> = (places.iter())
        .flat_map(|x| radii.iter().map(move |r| format!("[{x:e}, {r:e}, 0.0]")))
        .collect();
    let watched = format!("output.fluid_probes_m=[{}]", points.join(", "));
    let run = run(&case, &[&["--set", &watched], more].concat());
    let rows = table(
        &run.join("fluid-probes.csv"),
        ["time_s", "x_m", "y_m", "ux_m_s"],
    );
    let last = period * (f64::from(beats) - 1.0);
    let mut worst = [0.0f64; 3];
    let mut highest = 0.0f64;
    for [t, x, r, u] in rows.into_iter().filter(|row| row[0] > last) {
        let exact = womersley(r, t, period);
        highest = highest.max(exact);
        let place = places.iter().position(|place| (place - x).abs() < 1e-9);
        let worst = &mut worst[place.unwrap()];
        *worst = worst.max((u - exact).abs());
    }
    worst.map(|error| error / highest)
}

/// Elements of the driver's own fluid for these profiles.
const NATIVE: [&str; 7] = [
    "time.scheme=bdf2",
    "fluid.native.core=1",
    "fluid.native.radial=2",
    "fluid.native.axial_per_section=6",
    "structure.axial_per_section=1",
    "--fluid",
    "native",
];

#[test]
fn womersleys_profile_is_there_from_the_first_slice_on() {
    let folder = tempfile::tempdir().unwrap();
    let errors = |profile, beats| {
        let inlet = format!("profile = \"{profile}\"");
        profile_errors(&folder.path().join(profile), &inlet, beats, &NATIVE)
    };
    // The error of the time scheme is (ω Δt)²/3 = 1.3e-3 of the harmonic.
    let found = errors("womersley", 3);
    for (found, measured) in found.into_iter().zip([3.14e-4, 4.91e-4, 4.91e-4]) {
        assert!((found / measured - 1.0).abs() < 0.1, "{found:e}");
    }
    // The tube is too short for a plug to become that.
    let plug = errors("plug", 2);
    assert!(plug[0] > 0.2 && plug[2] > 0.05, "{plug:?}");
}

/// Under a pressure at the inlet blood enters as it flows farther in, so that its profile is there as well, as in a
/// tube without beginning.
#[test]
fn womersleys_profile_enters_under_its_pressure() {
    let folder = tempfile::tempdir().unwrap();
    // What is brought is extrapolated from the steps before, with second order.
    for (step, measured) in [
        ("time.step_s=2e-3", [2.17e-2, 1.87e-2, 1.68e-2]),
        ("time.step_s=1e-3", [4.98e-3, 4.13e-3, 3.69e-3]),
    ] {
        let case = folder.path().join(step);
        let found = profile_errors(
            &case,
            &under_pressure(&case),
            3,
            &[&[step], &NATIVE[..]].concat(),
        );
        println!("{step}: {found:?}");
        for (found, measured) in found.into_iter().zip(measured) {
            assert!((found / measured - 1.0).abs() < 0.05, "{found:e}");
        }
    }
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn womersleys_profile_enters_under_its_pressure_with_openfoam() {
    let folder = tempfile::tempdir().unwrap();
    let openfoam = ["time.scheme=bdf2", "structure.axial_per_section=1"];
    let found = profile_errors(folder.path(), &under_pressure(folder.path()), 3, &openfoam);
    println!("{found:?}");
    for (found, measured) in found.into_iter().zip([0.0413, 0.0401, 0.0400]) {
        assert!((found / measured - 1.0).abs() < 0.05, "{found:e}");
    }
}

/// Lines of a case for the pressure that drives Womersley's flow, whose file is written into a folder.
fn under_pressure(folder: &Path) -> String {
    std::fs::create_dir_all(folder).unwrap();
    let period = 0.2;
    let row = |i: i32| {
        let t = period * f64::from(i) / 400.0;
        format!("{t:e}, {:e}\n", driving_pressure(t, period))
    };
    let rows: String = (0..=400).map(row).collect();
    std::fs::write(
        folder.join("pressure.csv"),
        format!("t (s), p (Pa)\n{rows}"),
    )
    .unwrap();
    "condition = \"pressure\"\nfile = \"pressure.csv\"".to_owned()
}

/// From the first slice of cells on.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn womersleys_profile_is_there_at_once_with_openfoam() {
    let folder = tempfile::tempdir().unwrap();
    let openfoam = ["structure.axial_per_section=1"];
    // The cells of `demo`, and implicit Euler
    let found = profile_errors(folder.path(), "profile = \"womersley\"", 3, &openfoam);
    println!("{found:?}");
    for (found, measured) in found.into_iter().zip([0.0453, 0.0430, 0.0430]) {
        assert!((found / measured - 1.0).abs() < 0.05, "{found:e}");
    }
}

/// A bent vessel without any elastic wall is a case like any other: nothing moves, each step takes one iteration, and
/// tables, checkpoints and the page are there.
#[test]
fn a_rigid_vessel_runs_is_resumed_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    let lines = "[time]\nend_s = 0.008\n[initial]\nstart = \"equilibrium\"\n[output]\ncheckpoint_interval_min = 0.0\n[[vessel.piece]]\npiece = \"arc\"\n\
                 length_m = 4e-3\nbend_radius_m = 5e-3\n[[vessel.section]]\nname = \"bend\"\nwall = \"rigid\"\nlength_m = 4e-3\n";
    let [straight, resumed] =
        ["straight", "resumed"].map(|name| tube(&folder.path().join(name), lines));
    let few = [&["--set"], &FEW[..], &["--fluid", "native"]].concat();
    run(&straight, &few);
    run(&resumed, &[&few[..], &["--end-time", "0.004"]].concat());
    run(
        &resumed,
        &[&few[..], &["--end-time", "0.008", "--resume"]].concat(),
    );
    let [straight, resumed] = [straight, resumed].map(|case| case.join("run"));
    assert_same_run(&resumed, &straight);
    let names = [
        "Q_in_m3_s",
        "Q_out_m3_s",
        "lumen_volume_m3",
        "max_displacement_m",
        "coupling_iterations",
    ];
    let steps = table(&straight.join("history.csv"), names);
    assert_eq!(steps.len(), 4);
    // A torus' part has the volume of a cylinder.
    let volume = PI * RADIUS * RADIUS * (LENGTH + 4e-3);
    for [inflow, outflow, found, displacement, iterations] in steps {
        // To the accuracy of the linear solver, for which the pressure of the equilibrium counts too: measured 8e-6
        let error = (inflow - outflow).abs() / FLOW;
        assert!(error < 2e-5, "{error:e}");
        // What four elements of degree 3 lack of the circle
        let share = found / volume;
        assert!((share - 0.999_812).abs() < 2e-6, "{share}");
        assert_eq!([displacement, iterations], [0.0, 1.0]);
    }
    let mut report = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    report.arg("report").arg(&straight);
    complete(report);
    let regions = rows(&straight.join("regions.csv"));
    assert_eq!(regions[0][1], "region=tube");
    assert_eq!(regions[1][1], "region=bend");
}

#[test]
fn keys_of_elastic_walls_are_refused_for_a_rigid_vessel() {
    let folder = tempfile::tempdir().unwrap();
    for (lines, key) in [
        ("[ends]\noutlet = \"sliding\"", "ends.outlet"),
        ("[initial]\naxial_stretch = 1.1", "initial.axial_stretch"),
        (
            "[surroundings]\nspring_Pa_m = 1e6",
            "surroundings.spring_Pa_m",
        ),
    ] {
        let case = tube(folder.path(), lines);
        let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
        let output = command.arg("check").arg(&case).output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let told = text(&output);
        assert!(
            told.contains(key) && told.contains("wall = \"rigid\""),
            "{told}"
        );
    }
    let case = tube(folder.path(), "");
    let mut command = Command::new(env!("CARGO_BIN_EXE_fsi-driver"));
    let output = command
        .arg("check")
        .arg(&case)
        .args(["--wall", "--fluid", "native"])
        .output()
        .unwrap();
    assert!(
        text(&output).contains("no section of the vessel is elastic"),
        "{}",
        text(&output)
    );
}
