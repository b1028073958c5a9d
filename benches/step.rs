//! CPU seconds of the wall's time steps, without blood: `cargo bench --bench step -- [p] [mixed|displacement] [steps]`.
//!
//! The wall of S-0.25 on the mesh of `paper` beats under a given pressure, 10.6 to 15.7 kPa, with the study's time
//! step, its tolerance and its damping. Each step is solved four times, as the coupling asks: the pressure comes closer
//! to its last value by a factor of ten from one iteration to the next.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset};
use fsi_driver::geometry::solid_mesh;
use fsi_driver::pfem::discretization::{Discretization, Options};
use fsi_driver::pfem::element::surface::{LoadKind, Surface};
use fsi_driver::pfem::solution::newton::NewtonOptions;
use fsi_driver::pfem::solution::statics::{self, Load, StaticOptions};
use fsi_driver::pfem::solution::structure::State;
use fsi_driver::pfem::solution::time_scheme::TimeScheme;
use fsi_driver::pfem::supports::{self, Support};
use fsi_driver::pfem::{
    Formulation, Solid, Space, SpaceKind, Structure, StructureOptions, SurfaceLoad,
};
use std::path::Path;

/// Coupling iterations of a step.
const ITERATIONS: i32 = 4;
/// Lowest pressure and how far it rises, Pa.
const PRESSURE: [f64; 2] = [10.6e3, 5.1e3];
/// Steps that are not counted: the kept tangent and the load are new there.
const FIRST: usize = 5;

/// CPU seconds of all threads of this process, those that have ended included.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    let fields: Vec<&str> = stat.rsplit(") ").next().unwrap_or("").split(' ').collect();
    let ticks = |field: usize| fields[field].parse::<f64>().expect("a number");
    (ticks(11) + ticks(12)) / 100.0
}

fn main() {
    let words: Vec<String> = std::env::args().filter(|word| word != "--bench").collect();
    let p: usize = words
        .get(1)
        .map_or(4, |word| word.parse().expect("a degree"));
    let formulation = match words.get(2).map(String::as_str) {
        None | Some("mixed") => Formulation::Mixed,
        Some("displacement") => Formulation::Displacement,
        Some(other) => panic!("{other}: mixed or displacement"),
    };
    let steps: usize = words
        .get(3)
        .map_or(40, |word| word.parse().expect("a number of steps"));

    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/S-0.25");
    let case = Case::load(&folder, Preset::Paper, &[]).unwrap_or_else(|e| panic!("{e}"));
    let vessel = case.vessel().expect("an artery");
    let mesh = solid_mesh(vessel);
    let wall = &case.anastomosis().expect("the paper's vessel").wall;
    let materials = [&wall.graft, &wall.media, &wall.adventitia].map(Clone::clone);
    let held = ["start", "end"].map(|end| Support::Clamped(end.into()));
    let discretization = Options {
        formulation,
        ..Options::new(Space::isotropic(SpaceKind::Trunk, p))
    };
    let load = |points: &[fsi_driver::pfem::SurfacePoint], mean: f64, wave: f64| SurfaceLoad {
        pressure: (points.iter())
            .map(|point| mean + wave * (100.0 * point.position.x).cos())
            .collect(),
        shear: vec![Vec3::zeros(); points.len()],
    };

    // The wall stands under the lowest pressure before it beats.
    let body = Discretization::new(&mesh, &materials, &held, &discretization).expect("well posed");
    let faces = supports::surface(&mesh, "inner").expect("vessels have one");
    let surface =
        Surface::new(&body.numbering, &body.space, &body.mapping, faces, p + 1).expect("regular");
    let rest = Load::Surface {
        before: None,
        values: load(&surface.points, PRESSURE[0], 0.0),
        surface: &surface,
        kind: LoadKind::Follower,
    };
    let options = StaticOptions {
        tolerance: 1e-6,
        ..Default::default()
    };
    let found = statics::solve(&body, &[rest], None, &options).expect("it stands");
    let zero = vec![0.0; body.coefficients()];
    let mut wall = Structure::new(
        &mesh,
        &materials,
        &StructureOptions {
            discretization,
            density: 1100.0,
            damping: 0.01,
            time_scheme: TimeScheme::default(),
            load: LoadKind::default(),
            newton: NewtonOptions::default(),
            wet_surface: "inner".into(),
            supports: held.to_vec(),
            outer_pressure: None,
            gravity: None,
        },
    )
    .expect("well posed");
    wall.set_state(State {
        d: found.displacement,
        v: zero.clone(),
        a: zero,
    })
    .expect("the same discretization");

    let dt = 2e-3;
    let mut begin = (cpu_seconds(), wall.stats());
    for step in 1..=FIRST + steps {
        if step == FIRST + 1 {
            begin = (cpu_seconds(), wall.stats());
        }
        let phase = std::f64::consts::PI * step as f64 * dt / 0.3;
        let mean = PRESSURE[0] + PRESSURE[1] * phase.sin().powi(2);
        let mut trial = None;
        for iteration in 0..ITERATIONS {
            let wave = 20.0 * 0.1f64.powi(iteration);
            let load = load(wall.wet_points(), mean, wave);
            trial = Some(
                wall.solve(&load, dt, 1e-6, trial.as_ref())
                    .expect("solvable"),
            );
        }
        wall.accept(trial.expect("there are iterations"));
    }
    let largest = wall.state().d.iter().fold(0.0, |l: f64, d| l.max(d.abs()));
    let (stats, count) = (wall.stats(), steps as f64);
    let per_step = |now: f64, before: f64| (now - before) / count;
    println!(
        "{formulation:?} p {p}, {} degrees of freedom, factor {:.1} million entries, a step of {ITERATIONS} solutions: \
         {:.4} CPU s; {:.2} Newton iterations, {:.3} factorizations; wall-clock s: residuals {:.4}, substitutions \
         {:.4}, assemblies {:.4}, factorizations {:.4}; largest coefficient {largest:.9e} m",
        wall.body().degrees_of_freedom(),
        wall.body().symbolic.entries() as f64 * 1e-6,
        per_step(cpu_seconds(), begin.0),
        per_step(stats.iterations as f64, begin.1.iterations as f64),
        per_step(stats.factorizations as f64, begin.1.factorizations as f64),
        per_step(stats.residual_s, begin.1.residual_s),
        per_step(stats.substitution_s, begin.1.substitution_s),
        per_step(stats.assembly_s, begin.1.assembly_s),
        per_step(stats.factorization_s, begin.1.factorization_s),
    );
}
