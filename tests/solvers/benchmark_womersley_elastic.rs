//! Waves of oscillating flow in a tube with a thin elastic wall: see openfoam-case/womersley-elastic/README.md.

use crate::benchmark_support::run;
use crate::benchmark_support::waves::{bessel, harmonics, wave_number};
use nalgebra::Complex;
use std::f64::consts::TAU;

const DENSITY: f64 = 1000.0;
const VISCOSITY: f64 = 3.5e-3;
const INNER: f64 = 5.0e-3;
const OUTER: f64 = 5.25e-3;
const YOUNGS_MODULUS: f64 = 6e5;
const PERIOD: f64 = 0.5;
/// Distance of two probes, m.
const SPACING: f64 = 0.03;

/// Sixteen steps per period: what is compared is the wave of these steps.
#[test]
fn waves_have_womersleys_speed_and_attenuation() {
    check(0.03125, &["time.step_s=0.03125"], [0.00012, 0.00191]);
}

#[test]
#[ignore = "the full form: minutes"]
fn a_hundred_steps_a_period() {
    check(0.005, &["time.step_s=0.005"], [0.00029, -0.00331]);
}

/// Two periods with sixteen and with 32 steps each, on a coarse mesh of OpenFOAM's: what the scheme and the step do to
/// the wave is what they do to Womersley's, and the mesh's own error stays the same.
#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn waves_with_openfoam_have_the_error_of_the_time_scheme() {
    for (scheme, measured, distance) in [
        ("euler", [[0.00122, 0.0107], [0.00090, 0.0200]], 0.3327),
        ("bdf2", [[0.00116, 0.0373], [0.00059, 0.0512]], 0.1275),
    ] {
        let waves = [16.0, 32.0].map(|steps| {
            let dt = PERIOD / steps;
            let (step, scheme_of) = (format!("time.step_s={dt}"), format!("time.scheme={scheme}"));
            let settings = [&COARSE_CELLS[..], &[&step, &scheme_of]].concat();
            (computed(dt, &settings), exact(scheme, dt))
        });
        for ((found, exact), measured) in waves.into_iter().zip(measured) {
            let errors = [exact.im / found.im - 1.0, found.re / exact.re - 1.0];
            println!(
                "{scheme}: found {found}, exact {exact}, speed and attenuation differ by {errors:?}"
            );
            for ((error, measured), within) in errors.into_iter().zip(measured).zip([3e-4, 3e-3]) {
                assert!((error - measured).abs() < within, "{scheme}: {errors:?}");
            }
        }
        let [(long, exact_long), (short, exact_short)] = waves;
        let (found, exact) = ((long - short).norm(), (exact_long - exact_short).norm());
        println!("{scheme}: from one step to the other {found}, exact {exact}");
        assert!((found / distance - 1.0).abs() < 0.01, "{scheme}: {found}");
        assert!(
            (found / exact - 1.0).abs() < 0.03,
            "{scheme}: {found} {exact}"
        );
    }
}

/// Cells for the blood and elements for the wall that take seconds; correctors until nothing but the mesh and the step
/// matter.
const COARSE_CELLS: [&str; 10] = [
    "time.end_s=1.0",
    "fluid.solver=openfoam",
    "fluid.ranks=1",
    "fluid.mesh.core=2",
    "fluid.mesh.radial=6",
    "fluid.mesh.axial_per_section=10",
    "fluid.mesh.axial_extension=0",
    "structure.axial_per_section=4",
    "fluid.max_correctors=20",
    "fluid.pressure_residual=1e-5",
];

/// By which parts speed and attenuation were `measured` to differ from the exact ones.
fn check(dt: f64, settings: &[&str], measured: [f64; 2]) {
    let found = computed(dt, settings);
    let exact = exact("bdf2", dt);
    let errors = [exact.im / found.im - 1.0, found.re / exact.re - 1.0];
    println!("found {found}, exact {exact}, speed and attenuation differ by {errors:?}");
    for (error, measured) in errors.into_iter().zip(measured) {
        assert!((error - measured).abs() < 3e-4, "{errors:?}");
    }
}

/// The wave's γ, of a run.
fn computed(dt: f64, settings: &[&str]) -> Complex<f64> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    run("womersley-elastic", &out, &[&["--set"], settings].concat());
    let pressures = harmonics(&out.join("fluid-probes.csv"), dt, PERIOD);
    wave_number(&pressures, SPACING)
}

/// The exact γ with the time derivatives of a scheme: d/dt of backward differences is a complex number.
fn exact(scheme: &str, dt: f64) -> Complex<f64> {
    let back = Complex::new(0.0, -TAU / PERIOD * dt).exp();
    womersley(match scheme {
        "bdf2" => (1.5 - 2.0 * back + 0.5 * back * back) / dt,
        _ => (1.0 - back) / dt,
    })
}

/// Womersley (1957) for a tube that does not move along its axis and has no Poisson effect: `γ = s/(c0 √(1 - F10))` for
/// fields like `exp(s t)`. The wall is as thick as it is: `c0² = E (b² - a²)/(2 ρ (a² + b²))`, from Lamé's solution.
fn womersley(rate: Complex<f64>) -> Complex<f64> {
    let lambda = (-rate * DENSITY / VISCOSITY).sqrt() * INNER;
    let [j0, j1] = bessel(lambda);
    let (a, b) = (INNER * INNER, OUTER * OUTER);
    let speed = (YOUNGS_MODULUS * (b - a) / (2.0 * DENSITY * (a + b))).sqrt();
    rate / (speed * (1.0 - 2.0 * j1 / (lambda * j0)).sqrt())
}
