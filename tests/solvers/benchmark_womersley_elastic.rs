//! Waves of oscillating flow in a tube with a thin elastic wall: see openfoam-case/womersley-elastic/README.md.

use crate::benchmark_support::run;
use nalgebra::Complex;
use std::f64::consts::TAU;
use std::path::Path;

const DENSITY: f64 = 1000.0;
const VISCOSITY: f64 = 3.5e-3;
const INNER: f64 = 5.0e-3;
const OUTER: f64 = 5.25e-3;
const YOUNGS_MODULUS: f64 = 6e5;
const PERIOD: f64 = 0.5;
/// Distance of two probes, m.
const SPACING: f64 = 0.03;

/// Sixteen steps a period: what is compared is the wave of these steps.
#[test]
fn waves_have_womersleys_speed_and_attenuation() {
    check(0.03125, &["time.step_s=0.03125"], [0.00012, 0.00191]);
}

#[test]
#[ignore = "the full form: minutes"]
fn a_hundred_steps_a_period() {
    check(0.005, &["time.step_s=0.005"], [0.00029, -0.00331]);
}

/// By which parts speed and attenuation were `measured` to differ from the exact ones.
fn check(dt: f64, settings: &[&str], measured: [f64; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    run("womersley-elastic", &out, &[&["--set"], settings].concat());
    let found = wave_number(&harmonics(&out.join("fluid-probes.csv"), dt));
    // Backward differences of second order: d/dt is a complex number.
    let back = Complex::new(0.0, -TAU / PERIOD * dt).exp();
    let exact = womersley((1.5 - 2.0 * back + 0.5 * back * back) / dt);
    let errors = [exact.im / found.im - 1.0, found.re / exact.re - 1.0];
    println!("found {found}, exact {exact}, speed and attenuation differ by {errors:?}");
    for (error, measured) in errors.into_iter().zip(measured) {
        assert!((error - measured).abs() < 3e-4, "{errors:?}");
    }
}

/// Complex amplitude of the pressure at each probe over the last period.
fn harmonics(path: &Path, dt: f64) -> Vec<Complex<f64>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let headers = reader.headers().unwrap().clone();
    let column = |name: &str| headers.iter().position(|header| header == name).unwrap();
    let columns = ["time_s", "probe", "p_Pa"].map(column);
    let rows: Vec<[f64; 3]> = (reader.records().map(Result::unwrap))
        .map(|row| columns.map(|column| row[column].parse().unwrap()))
        .collect();
    let end = rows[rows.len() - 1][0];
    let last = rows.iter().filter(|row| row[0] > end - PERIOD + 0.5 * dt);
    let mut sums = vec![Complex::new(0.0, 0.0); 5];
    for [t, probe, p] in last {
        sums[*probe as usize] +=
            Complex::new(0.0, -TAU / PERIOD * t).exp() * p * (2.0 * dt / PERIOD);
    }
    sums
}

/// The γ with `p(x) = A exp(-γ x) + B exp(γ x)`, from `p(x - h) + p(x + h) = 2 cosh(γ h) p(x)` by least squares.
fn wave_number(pressures: &[Complex<f64>]) -> Complex<f64> {
    let triples = || pressures.windows(3);
    let sums: Complex<f64> = triples().map(|p| p[1].conj() * (p[0] + p[2])).sum();
    let squares: f64 = triples().map(|p| p[1].norm_sqr()).sum();
    let wave_number = (0.5 * sums / squares).acosh() / SPACING;
    if wave_number.re < 0.0 {
        -wave_number
    } else {
        wave_number
    }
}

/// Womersley (1957) for a tube that does not move along its axis and has no Poisson effect: `γ = s/(c0 √(1 - F10))` for fields like
/// `exp(s t)`. The wall is as thick as it is: `c0² = E (b² - a²)/(2 ρ (a² + b²))`, from Lamé's solution.
fn womersley(rate: Complex<f64>) -> Complex<f64> {
    let lambda = (-rate * DENSITY / VISCOSITY).sqrt() * INNER;
    let [j0, j1] = bessel(lambda);
    let (a, b) = (INNER * INNER, OUTER * OUTER);
    let speed = (YOUNGS_MODULUS * (b - a) / (2.0 * DENSITY * (a + b))).sqrt();
    rate / (speed * (1.0 - 2.0 * j1 / (lambda * j0)).sqrt())
}

/// Bessel functions J0 and J1 by their series.
fn bessel(z: Complex<f64>) -> [Complex<f64>; 2] {
    let q = -0.25 * z * z;
    let (mut term, mut sums) = (Complex::new(1.0, 0.0), [Complex::new(0.0, 0.0); 2]);
    for k in 0..60 {
        sums[0] += term;
        sums[1] += term * 0.5 * z / (k as f64 + 1.0);
        term *= q / ((k as f64 + 1.0) * (k as f64 + 1.0));
    }
    sums
}
