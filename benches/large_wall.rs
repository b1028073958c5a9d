//! Memory and seconds of a wall without blood, by its size: `cargo bench --bench large_wall -- FOLDER STEPS
//! [KEY=VALUE...]` for the case in FOLDER. `docs/speed/measure.sh FOLDER walls` runs it over sizes, each in a process
//! of its own, so that the largest memory is that of one size.
//!
//! A tangent of the wall at rest is assembled, factorized and solved with; then the wall takes STEPS steps of 2 ms, in
//! which the pressure inside rises by 100 Pa each, solved in three coupling iterations. Seconds are those of the
//! processors, which other work on the machine changes less than those of the clock.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset};
use fsi_driver::pfem::discretization::Discretization;
use fsi_driver::pfem::{Solid, Structure, SurfaceLoad};
use fsi_driver::processes::{cpu_seconds, peak_memory};
use fsi_driver::simulation::assembly::{Domain, structure};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// The result of `f`, and the seconds of all processors that it takes.
fn timed<T>(f: impl FnOnce() -> T) -> (T, f64) {
    let process = std::process::id();
    let begin = cpu_seconds(process);
    let result = f();
    (result, cpu_seconds(process) - begin)
}

fn gigabytes() -> f64 {
    peak_memory(std::process::id()).unwrap_or(0.0) * 1e-9
}

/// Assembles, factorizes and solves once.
fn parts(body: &Discretization) {
    let still = vec![0.0; body.coefficients()];
    let (tangent, assembly) = timed(|| body.tangent(&still, None, &[]));
    let mut tangent = tangent.expect("regular");
    body.pattern.hold(&mut tangent);
    let wanted = AtomicBool::new(false);
    let (factor, factorization) =
        timed(|| (body.factorize_moving(&wanted, &tangent)).expect("regular"));
    let mut x = vec![1.0; body.pattern.len()];
    let ((), substitution) = timed(|| factor.solve(&mut x).expect("regular"));
    println!(
        "assembly {assembly:.2} s, factorization {factorization:.2} s, substitution {substitution:.3} s; {:.2} GB",
        gigabytes()
    );
}

/// One time step under a pressure (Pa) that the coupling approaches.
fn step(wall: &mut Structure, pressure: f64) {
    let mut trial = None;
    for iteration in 0..3 {
        let wave = 20.0 * 0.1f64.powi(iteration);
        let points = wall.wet_points().iter();
        let pressure = points.map(|point| pressure + wave * (100.0 * point.position.x).cos());
        let load = SurfaceLoad {
            pressure: pressure.collect(),
            shear: vec![Vec3::zeros(); wall.wet_points().len()],
        };
        trial = Some(
            wall.solve(&load, 2e-3, 1e-6, trial.as_ref())
                .expect("solvable"),
        );
    }
    wall.accept(trial.expect("there are iterations"));
}

fn main() {
    let words: Vec<String> = (std::env::args().skip(1))
        .filter(|word| word != "--bench")
        .collect();
    let [folder, steps, keys @ ..] = &words[..] else {
        println!("cargo bench --bench large_wall -- FOLDER STEPS [KEY=VALUE...]");
        return;
    };
    let steps: usize = steps.parse().expect("a number of steps");
    let keys: Vec<(String, String)> = (keys.iter())
        .map(|key| key.split_once('=').expect("KEY=VALUE"))
        .map(|(key, value)| (key.into(), value.into()))
        .collect();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let case = Case::load(&folder, Preset::Coarse, &keys).unwrap_or_else(|e| panic!("{e}"));
    let domain = Domain::new(&case).unwrap_or_else(|e| panic!("{e}"));
    let (wall, setup) = timed(|| structure(&case, &domain));
    let mut wall = wall.unwrap_or_else(|e| panic!("{e}"));
    let body = wall.body();
    println!(
        "{} unknowns, p = {}; {:.1}e6 entries of the matrix, {:.1}e6 of the factor, {:.1}e9 operations; setup \
         {setup:.2} s; {:.2} GB",
        body.pattern.len(),
        case.structure.p,
        body.pattern.entries() as f64 * 1e-6,
        body.symbolic.entries() as f64 * 1e-6,
        body.symbolic.operations() * 1e-9,
        gigabytes()
    );
    if steps == 0 {
        return;
    }
    parts(body);
    for count in 1..=steps {
        let before = wall.stats();
        let ((), seconds) = timed(|| step(&mut wall, 100.0 * count as f64));
        let now = wall.stats();
        println!(
            "step {count}: {seconds:.2} s, {} iterations, {} factorizations; {:.2} GB",
            now.iterations - before.iterations,
            now.factorizations - before.factorizations,
            gigabytes()
        );
    }
    let largest = wall.state().d.iter().fold(0.0, |l: f64, d| l.max(d.abs()));
    println!("largest coefficient {largest:.9e} m");
}
