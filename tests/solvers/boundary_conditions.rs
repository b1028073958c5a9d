//! What a case prescribes at the ends of a vessel, with both fluids: docs/boundary-conditions.md.

use crate::native_run::FEW;
use crate::run_support::*;
use std::collections::HashMap;
use std::path::Path;

/// Time, inflow, outflow, pressures at both ends and of the windkessel, of each step.
fn courses(run: &Path) -> Vec<[f64; 6]> {
    let names = [
        "time_s",
        "Q_in_m3_s",
        "Q_out_m3_s",
        "p_in_Pa",
        "p_out_Pa",
        "p_windkessel_Pa",
    ];
    let mut reader = csv::Reader::from_path(run.join("history.csv")).unwrap();
    let rows = reader.deserialize::<HashMap<String, f64>>();
    rows.map(|row| {
        let row = row.unwrap();
        names.map(|name| row[name])
    })
    .collect()
}

const STEP: f64 = 0.002;
/// No ramp: what is prescribed acts from the beginning.
const NO_RAMP: &str = "ramp.duration_s=0.0";
/// OpenFOAM's pressure follows the flux from corrector to corrector: enough of them, and nothing lags.
const ACCURATE: [&str; 2] = ["fluid.pressure_residual=1e-7", "fluid.max_correctors=60"];

/// A short coupled run.
fn run(out: &Path, steps: usize, native: bool, set: &[&str]) -> Vec<[f64; 6]> {
    let fluid: &[&str] = match native {
        true => &FEW,
        false => &["--set", ACCURATE[0], ACCURATE[1]],
    };
    complete(driver(out, steps, &[fluid, set].concat()));
    courses(out)
}

/// `C dp/dt + p/R = Q` by implicit Euler or, where it is of second order, by BDF2 from the second step on, and `p + R_p
/// Q` at the outlet.
fn three_elements(native: bool, second_order: bool, within: f64) {
    let folder = tempfile::tempdir().unwrap();
    let [straight, resumed] = ["straight", "resumed"].map(|name| folder.path().join(name));
    let set = [
        NO_RAMP,
        "initial.start=equilibrium",
        "windkessel.initial_pressure_Pa=1.0e3",
        "windkessel.proximal_resistance_Pa_s_m3=2.0e8",
        match second_order {
            true => "time.scheme=bdf2",
            false => "time.scheme=euler",
        },
    ];
    let rows = run(&straight, 5, native, &set);
    let (resistance, compliance, proximal) = (1.785e9, 1.83e-10, 2.0e8);
    let [mut before, mut last] = [1.0e3; 2];
    for (n, [t, _, outflow, _, at_outlet, behind]) in rows.iter().enumerate() {
        let [new, earlier] = match second_order && n > 0 {
            true => [1.5, 2.0 * last - 0.5 * before],
            false => [1.0, last],
        };
        let rate = compliance / STEP;
        let next = (rate * earlier + outflow) / (rate * new + 1.0 / resistance);
        assert!(
            (behind / next - 1.0).abs() < within,
            "t = {t}: {behind} {next}"
        );
        let expected = behind + proximal * outflow;
        assert!(
            (at_outlet / expected - 1.0).abs() < within,
            "t = {t}: {at_outlet} {expected}"
        );
        [before, last] = [last, *behind];
    }
    // Measured with the native fluid: 314 Pa of 1.3 kPa, with BDF2 219 Pa
    let [.., outflow, _, _, _] = rows[rows.len() - 1];
    assert!(proximal * outflow > 200.0, "{outflow:e}");
    // And the state of it goes on to the last digit.
    run(&resumed, 2, native, &set);
    let again: Vec<&str> = set.iter().copied().chain(["--resume"]).collect();
    run(&resumed, 5, native, &again);
    assert_same_run(&resumed, &straight);
}

#[test]
fn a_windkessel_of_three_elements_is_its_equation() {
    three_elements(true, false, 1e-9);
    three_elements(true, true, 1e-9);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_windkessel_of_three_elements_is_its_equation_with_openfoam() {
    three_elements(false, false, 1e-6);
}

/// The run that is stopped and resumed here has a windkessel and a moving wall that remember two steps.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn second_order_windkessel_with_openfoam() {
    three_elements(false, true, 1e-6);
}

fn resistance(native: bool, within: f64) {
    let folder = tempfile::tempdir().unwrap();
    let set = [
        NO_RAMP,
        "outlet.condition=resistance",
        "outlet.resistance_Pa_s_m3=3.0e8",
        "outlet.pressure_Pa=200.0",
        "inlet.profile=parabolic",
    ];
    let rows = run(folder.path(), 3, native, &set);
    for [t, inflow, outflow, _, at_outlet, _] in rows {
        let expected = 200.0 + 3.0e8 * outflow;
        assert!(
            (at_outlet / expected - 1.0).abs() < within,
            "t = {t}: {at_outlet} {expected}"
        );
        // The formula of the inflow
        let flow = 5.0e-6 + 9.0e-6 * (std::f64::consts::PI * (t / 0.5).powf(0.8)).sin().powi(2);
        assert!(
            (inflow / flow - 1.0).abs() < 1e-5,
            "t = {t}: {inflow:e} {flow:e}"
        );
    }
}

#[test]
fn a_resistance_is_proportional_to_the_flow() {
    resistance(true, 1e-9);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_resistance_is_proportional_to_the_flow_with_openfoam() {
    resistance(false, 1e-6);
}

/// Pressures at both ends from files, in their own units and stretched to the beat.
fn pressures(native: bool, within: f64) {
    let folder = tempfile::tempdir().unwrap();
    let [inlet, outlet, out] = ["in.csv", "out.csv", "run"].map(|name| folder.path().join(name));
    std::fs::write(
        &inlet,
        "# catheter\nt (ms); p (mmHg)\n0;1\n200;2\n400;1\n800;1\n",
    )
    .unwrap();
    std::fs::write(&outlet, "0 100\n0.25 200\n0.4 150\n0.5 100\n").unwrap();
    let [inlet, outlet] = [("inlet", inlet), ("outlet", outlet)]
        .map(|(end, file)| format!("{end}.file={}", file.display()));
    let set = [
        NO_RAMP,
        "inlet.condition=pressure",
        &inlet,
        "inlet.file_period_s=0.8",
        "outlet.condition=pressure",
        &outlet,
        "outlet.unit=Pa",
        "outlet.file_period_s=0.5",
    ];
    let rows = run(&out, 3, native, &set);
    for [t, inflow, _, at_inlet, at_outlet, _] in rows {
        // Between the first two points of the files, which are a quarter and a half of the beat apart: zero slopes at
        // both.
        let cubic = |s: f64| s * s * (3.0 - 2.0 * s);
        let expected = [
            133.322 * (1.0 + cubic(t / 0.25)),
            100.0 + 100.0 * cubic(t / 0.5),
        ];
        for (found, expected) in [at_inlet, at_outlet].into_iter().zip(expected) {
            assert!(
                (found / expected - 1.0).abs() < within,
                "t = {t}: {found} {expected}"
            );
        }
        assert!(inflow > 1e-7, "t = {t}: {inflow:e}");
    }
}

#[test]
fn pressures_of_files_act_at_both_ends() {
    // Weakly at the inlet
    pressures(true, 2e-2);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn pressures_of_files_act_at_both_ends_with_openfoam() {
    pressures(false, 1e-6);
}

/// Inflow, outflow and growth of the lumen (m³/s), and the pressure at the inlet, of each step.
fn balance(run: &Path) -> Vec<[f64; 4]> {
    let mut reader = csv::Reader::from_path(run.join("history.csv")).unwrap();
    let rows = reader
        .deserialize::<HashMap<String, f64>>()
        .map(Result::unwrap);
    let names = ["Q_in_m3_s", "Q_out_m3_s", "dVdt_m3_s", "p_in_Pa"];
    rows.map(|row| names.map(|name| row[name])).collect()
}

/// Openings by name in `openings.csv`: flow into the domain.
fn flows(run: &Path, wanted: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(run.join("openings.csv")).unwrap();
    let rows = reader.deserialize::<(f64, String, f64, f64, Option<f64>)>();
    let rows = rows.map(Result::unwrap).filter(|row| row.1 == wanted);
    rows.map(|row| row.2).collect()
}

/// A pressure at the inlet, and at the end what a table `[[opening]]` says.
fn opening(out: &Path, native: bool, set: &[&str]) -> Vec<[f64; 4]> {
    let inlet = [
        NO_RAMP,
        "inlet.condition=pressure",
        "inlet.pressure_Pa=400.0",
        "opening[0].end=end",
    ];
    run(out, 4, native, &[&inlet, set].concat());
    balance(out)
}

/// A pulse that leaves under another name: all of it, with the profile that was asked for, and what else enters fills
/// the vessel.
fn flow_out(native: bool, within: f64) {
    let folder = tempfile::tempdir().unwrap();
    let set = [
        "opening[0].condition=flow",
        "opening[0].name=femoral",
        "opening[0].base_m3_s=2.0e-6",
        "opening[0].amplitude_m3_s=3.0e-6",
        "opening[0].systole_s=0.1",
        "opening[0].profile=womersley",
    ];
    let rows = opening(folder.path(), native, &set);
    let named = flows(folder.path(), "femoral");
    assert_eq!(named.len(), 4);
    for (n, ([inflow, outflow, grows, pressure], named)) in rows.into_iter().zip(named).enumerate()
    {
        let t = STEP * (n + 1) as f64;
        let flow = 2.0e-6 + 3.0e-6 * (std::f64::consts::PI * t / 0.1).sin().powi(2);
        assert!(
            (outflow / flow - 1.0).abs() < within,
            "{t}: {outflow:e} {flow:e}"
        );
        assert_eq!(named, -outflow);
        assert!(
            (inflow - outflow - grows).abs() < 1e-3 * flow,
            "{t}: {inflow:e} {grows:e}"
        );
        // More leaves than enters, as long as the blood is at rest before.
        assert!(grows < 0.0, "{t}: {grows:e}");
        assert!((pressure / 400.0 - 1.0).abs() < 0.05, "{t}: {pressure}");
    }
}

#[test]
fn a_flow_is_prescribed_at_the_outlet() {
    flow_out(true, 1e-9);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_flow_is_prescribed_at_the_outlet_with_openfoam() {
    flow_out(false, 1e-6);
}

/// Three tenths of what enters under a pressure leave, and the rest fills the vessel.
fn flow_split(out: &Path, native: bool, within: f64) -> Vec<[f64; 4]> {
    let set = ["opening[0].condition=flow_split", "opening[0].fraction=0.3"];
    let rows = opening(out, native, &set);
    for [inflow, outflow, grows, _] in &rows {
        assert!(*inflow > 1e-7);
        let share = outflow / inflow;
        assert!((share / 0.3 - 1.0).abs() < within, "{share} of {inflow:e}");
        assert!(
            (inflow - outflow - grows).abs() < 1e-3 * inflow,
            "{inflow:e} {grows:e}"
        );
    }
    rows
}

#[test]
fn a_fixed_share_of_the_inflow_leaves() {
    flow_split(tempfile::tempdir().unwrap().path(), true, 1e-6);
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_fixed_share_of_the_inflow_leaves_with_either_fluid() {
    let folder = tempfile::tempdir().unwrap();
    let [of, native] = ["openfoam", "native"].map(|name| folder.path().join(name));
    let rows = flow_split(&of, false, 1e-6);
    let others = flow_split(&native, true, 1e-6);
    for (a, b) in rows.iter().zip(&others) {
        println!("{:e} {:e}", a[1], b[1]);
        assert!((a[1] / b[1] - 1.0).abs() < 0.05, "{a:?} {b:?}");
    }
}

/// Templates that choose between the conditions by `#ifeq`, as those of the project once did, and those that include
/// them.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn templates_of_earlier_versions_give_the_same_run() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let templates = folder.path().join("templates");
    for from in ["openfoam-case/base", "tests/data/earlier-templates"] {
        let mut copy = std::process::Command::new("cp");
        std::fs::create_dir_all(&templates).unwrap();
        let from = root.join(from).join(".");
        assert!(
            copy.arg("-r")
                .arg(from)
                .arg(&templates)
                .status()
                .unwrap()
                .success()
        );
    }
    let own = format!("fluid.templates={}", templates.display());
    for (case, set) in [
        (
            "windkessel",
            &[
                "inlet.profile=womersley",
                "windkessel.proximal_resistance_Pa_s_m3=2.0e8",
            ][..],
        ),
        (
            "pressures",
            &[
                "inlet.condition=pressure",
                "inlet.pressure_Pa=400.0",
                "outlet.condition=pressure",
                "outlet.pressure_Pa=300.0",
            ],
        ),
        (
            "equilibrium",
            &[
                "initial.start=equilibrium",
                "windkessel.initial_pressure_Pa=1.0e3",
                "ends.outlet=radial",
            ],
        ),
    ] {
        let out = |name: &str| folder.path().join(format!("{case}-{name}"));
        let rows = run(&out("included"), 2, false, set);
        assert_eq!(
            run(&out("chosen"), 2, false, &[&[own.as_str()], set].concat()),
            rows,
            "{case}"
        );
    }
}
