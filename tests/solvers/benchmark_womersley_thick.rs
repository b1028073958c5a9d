//! Waves of oscillating flow in a tube with a thick elastic wall: see openfoam-case/womersley-thick/README.md.

use crate::benchmark_support::run;
use crate::benchmark_support::waves::{Rates, Tube, harmonics, wave_number, without};
use nalgebra::Complex;
use std::path::Path;

/// That of the case.
const TUBE: Tube = Tube {
    radius: 0.01,
    thickness: 1e-3,
    youngs_modulus: 5e5,
    poisson_ratio: 0.3,
    density: 1000.0,
    viscosity: 0.25,
};
const PERIOD: f64 = 0.1;
/// Distance of two probes, m.
const SPACING: f64 = 0.02;

/// γ of the pressure's waves and of the wall's, which run along the wall.
fn exact(tube: &Tube, rates: Rates) -> [Complex<f64>; 2] {
    let guesses = tube.of_a_thin_wall(rates.first);
    guesses.map(|guess| tube.wave_number(rates, guess))
}

/// A tube that is a hundred times as large and as slow has the published speed and decay within a wavelength; the one
/// whose wall is thin and stiff enough has the wave numbers of the theory of such walls.
#[test]
fn the_exact_waves_of_a_thick_wall_are_as_published() {
    let large = Tube {
        radius: 1.0,
        thickness: 0.1,
        youngs_modulus: 2e4,
        viscosity: 5.0,
        ..TUBE
    };
    let [gamma, _] = exact(&large, Rates::exact(50.0));
    let speed = std::f64::consts::TAU / 50.0 / gamma.im;
    let decay = (-gamma.re * std::f64::consts::TAU / gamma.im).exp();
    assert!((speed - 0.8728).abs() < 5e-5, "{speed}");
    assert!((decay - 0.405).abs() < 5e-4, "{decay}");

    let thin = [1e-2, 1e-3].map(|part| {
        let tube = Tube {
            thickness: part * TUBE.thickness,
            youngs_modulus: TUBE.youngs_modulus / part / part,
            ..TUBE
        };
        let rates = Rates::exact(PERIOD);
        let theory = tube.of_a_thin_wall(rates.first);
        let found = theory.map(|guess| tube.wave_number(rates, guess));
        [0, 1].map(|i| (found[i] / theory[i] - 1.0).norm())
    });
    println!("thin walls differ by {thin:?}");
    for [thicker, thinner] in [0, 1].map(|i| [thin[0][i], thin[1][i]]) {
        assert!(thinner < 1e-4 && thinner < 0.2 * thicker, "{thin:?}");
    }
}

/// Sixteen steps per period and a coarse mesh: what is compared is the wave of these steps.
#[test]
fn waves_of_a_thick_wall_have_the_exact_speed_and_attenuation() {
    let coarse = [
        "time.step_s=0.00625",
        "time.end_s=0.5",
        "structure.p=3",
        "structure.axial_per_section=4",
        "fluid.native.axial_per_section=4",
    ];
    check(0.00625, &coarse, [0.00222, -0.00174]);
}

#[test]
#[ignore = "the full form: minutes"]
fn waves_of_a_thick_wall_with_forty_steps_a_period() {
    check(0.0025, &["time.step_s=0.0025"], [0.00008, -0.00062]);
}

/// By which parts speed and attenuation were `measured` to differ from the exact ones.
fn check(dt: f64, settings: &[&str], measured: [f64; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    run("womersley-thick", &out, &[&["--set"], settings].concat());
    let [exact, found] = waves(&out, dt);
    let errors = errors(exact, found);
    println!("found {found}, exact {exact}, speed and attenuation differ by {errors:?}");
    for (error, measured) in errors.into_iter().zip(measured) {
        assert!((error - measured).abs() < 3e-4, "{errors:?}");
    }
}

/// γ of the pressure's wave: the exact one for these steps, and that of a run's last period.
fn waves(out: &Path, dt: f64) -> [Complex<f64>; 2] {
    let pressures = harmonics(&out.join("fluid-probes.csv"), dt, PERIOD);
    let [exact, of_the_wall] = exact(&TUBE, Rates::of_steps(PERIOD, dt));
    let found = wave_number(&without(&pressures, of_the_wall, SPACING), SPACING);
    [exact, found]
}

/// By which parts speed and attenuation of a wave differ from those of the exact one.
fn errors(exact: Complex<f64>, found: Complex<f64>) -> [f64; 2] {
    [exact.im / found.im - 1.0, found.re / exact.re - 1.0]
}

/// The table of the case's page is that of its kept runs.
#[test]
fn the_page_has_the_waves_of_the_kept_runs() {
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/womersley-thick");
    let row = |steps: &str, of: &str, wave: Complex<f64>, errors: [String; 2]| {
        let [speed, attenuation] = [std::f64::consts::TAU / PERIOD / wave.im, wave.re];
        let [speed_error, attenuation_error] = errors;
        format!(
            "| {steps} | {of} | {speed:.4}{speed_error} | {attenuation:.4}{attenuation_error} |\n"
        )
    };
    let none = || [String::new(), String::new()];
    let [gamma, _] = exact(&TUBE, Rates::exact(PERIOD));
    let mut table = row("∞", "exact", gamma, none());
    for (steps, of, kept) in [
        ("125", "computed", "125-steps"),
        ("40", "computed", "40-steps"),
        ("16", "computed on a coarse mesh", "16-steps"),
    ] {
        let dt = PERIOD / steps.parse::<f64>().unwrap();
        let [exact, found] = waves(&case.join("kept").join(kept), dt);
        let shares = errors(exact, found).map(|e| format!(" ({:+.2} %)", 100.0 * e));
        table += &row(steps, "exact for these steps", exact, none());
        table += &row(steps, of, found, shares);
    }
    let page = std::fs::read_to_string(case.join("README.md")).unwrap();
    assert!(page.contains(&table), "the page should have\n{table}");
}
