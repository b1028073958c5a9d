//! Seconds of a coupling iteration of the driver's own flow solver: `cargo bench --bench flow`, `RAYON_NUM_THREADS=1`
//! for one thread. S-0.25 with a prescribed motion of its wall, two trials a step that differ as those of a coupled run
//! do. `CASES=3` takes degree 6 as well.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset};
use fsi_driver::fluid::native::NativeFluid;
use fsi_driver::fluid::{Fluid, FluidEffort, Wanted};
use std::path::Path;
use std::time::Instant;

/// CPU seconds of all threads of this process.
fn cpu_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux");
    let nanoseconds = |task: std::fs::DirEntry| -> Option<f64> {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse().ok()
    };
    tasks.flatten().filter_map(nanoseconds).sum::<f64>() * 1e-9
}

const DT: f64 = 2e-3;
const EFFORT: FluidEffort = FluidEffort {
    max_sweeps: 1,
    residual: 1e-2,
    from_old_state: false,
};

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/S-0.25");
    let set = |key: &str, value: &str| (key.to_owned(), value.to_owned());
    let cases = [
        ("paper", Preset::Paper, vec![]),
        ("demo", Preset::Demo, vec![]),
        (
            "paper",
            Preset::Paper,
            vec![set("fluid.native.degree", "6")],
        ),
    ];
    let wanted: usize = std::env::var("CASES").map_or(2, |v| v.parse().unwrap());
    for (name, preset, mut overrides) in cases.into_iter().take(wanted) {
        overrides.push(set("ramp.duration_s", "0.02"));
        let case = Case::load(&folder, preset, &overrides).unwrap().case;
        let begin = Instant::now();
        let mut fluid = NativeFluid::new(&case).unwrap();
        let points = fluid.interface().points.clone();
        let made = begin.elapsed().as_secs_f64();
        let length = points.iter().map(|x| x.x).fold(0.0, f64::max);
        let displacement = |t: f64, error: f64| -> Vec<Vec3> {
            let widening = 0.1 * (1.0 - (20.0 * t).cos()) * (1.0 + error);
            let shape = |x: f64| (std::f64::consts::PI * x / length).sin().powi(2);
            let radial = |x: &Vec3| Vec3::new(0.0, x.y, x.z);
            (points.iter())
                .map(|x| radial(x) * (widening * shape(x.x)))
                .collect()
        };
        let (mut wall, mut cpu, mut trials, mut iterations) = (0.0, 0.0, 0, 0);
        for step in 1..=20 {
            let t = step as f64 * DT;
            for error in [1e-3, 1e-5] {
                let (begin, cpu_begin) = (Instant::now(), cpu_seconds());
                let trial = fluid.solve(&displacement(t, error), DT, EFFORT).unwrap();
                if step > 10 {
                    wall += begin.elapsed().as_secs_f64();
                    cpu += cpu_seconds() - cpu_begin;
                    trials += 1;
                    iterations += fluid.iterations();
                }
                std::hint::black_box(trial);
            }
            let accepted = fluid.accept(Wanted::default()).unwrap();
            if step == 20 {
                let shear: f64 = accepted.wall_shear.iter().map(|s| s.norm()).sum();
                println!(
                    "  outflow {:.9e} shear {:.9e} inlet {:.9e}",
                    accepted.outflow(),
                    shear / accepted.wall_shear.len() as f64,
                    accepted.inlet_pressure()
                );
            }
        }
        let each = |sum: f64| 1e3 * sum / trials as f64;
        println!(
            "{name}, {} elements: made in {made:.2} s; a trial: {:.1} ms, {:.1} CPU ms, {:.1} iterations",
            fluid.elements(),
            each(wall),
            each(cpu),
            iterations as f64 / trials as f64
        );
    }
}
