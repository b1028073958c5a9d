//! CPU seconds of one Newton iteration on the two-layer tube: `cargo bench --bench structure`, `RAYON_NUM_THREADS=1`
//! for one thread. The smallest of several repetitions counts, since other programs disturb.

use fsi_driver::geometry::tube_mesh;
use fsi_driver::paper::convergence::cases::TestCase;
use fsi_driver::pfem::discretization::{Discretization, Options};
use fsi_driver::pfem::element::surface::Surface;
use fsi_driver::pfem::supports::{self, Support};
use fsi_driver::pfem::{Space, SpaceKind, SurfaceLoad};
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

/// Smallest wall-clock and CPU seconds of some repetitions.
fn measure(mut f: impl FnMut()) -> (f64, f64) {
    let mut best = (f64::INFINITY, f64::INFINITY);
    let begin = Instant::now();
    for repetition in 0..200 {
        let (wall, cpu) = (Instant::now(), cpu_seconds());
        f();
        best.0 = wall.elapsed().as_secs_f64().min(best.0);
        best.1 = (cpu_seconds() - cpu).min(best.1);
        if repetition >= 4 && begin.elapsed().as_secs_f64() > 2.0 {
            break;
        }
    }
    best
}

fn run(kind: SpaceKind, p: usize, points: usize, mesh: [usize; 3]) {
    let materials = TestCase::Circular.materials();
    let [axial, circumferential, radial] = mesh;
    let mesh = tube_mesh(3e-3, &[5e-4, 5e-4], 6e-3, axial, circumferential, radial);
    let ends = ["start", "end"].map(|end| Support::Surface(end.into(), [true, false, false]));
    let [start, end] = ends;
    let supports = [
        start,
        end,
        Support::SymmetryPlane(1),
        Support::SymmetryPlane(2),
    ];
    let space = Space::isotropic(kind, p);
    let options = Options {
        quadrature_points: [points; 3],
        ..Options::new(space)
    };
    let begin = Instant::now();
    let body = Discretization::new(&mesh, &materials, &supports, &options).expect("well posed");
    let setup = begin.elapsed().as_secs_f64();
    let faces = supports::surface(&mesh, "inner").expect("tubes have one");
    let surface =
        Surface::new(&body.numbering, &space, &body.mapping, faces, points).expect("regular");
    let load = SurfaceLoad::uniform_pressure(100.0, surface.points.len());
    let d = vec![0.0; body.coefficients()];
    let mut tangent = Vec::new();
    let assembly = measure(|| {
        tangent = body
            .tangent(&d, Some(&d), &[(&surface, &load)])
            .expect("regular")
    });
    body.pattern.hold(&mut tangent);
    let mut factor = None;
    let factorization = measure(|| factor = body.factorize(&tangent).ok());
    let factor = factor.expect("regular");
    let mut rhs = vec![1.0; body.pattern.len()];
    let substitution = measure(|| factor.solve(&mut rhs).expect("regular"));
    let residual = measure(|| drop(body.internal_forces(&d)));
    println!(
        "{:<14} p {p:>2} points {points:>2} elements {:>3} dofs {:>6} | wall, cpu s: assembly {:.4} {:.4} factorization {:.4} {:.4} substitution {:.4} residual {:.4} {:.4} | iteration {:.4} cpu s | setup {setup:.2} s, factor {:.1} MB",
        format!("{kind:?}"),
        axial * circumferential * radial * 2,
        body.degrees_of_freedom(),
        assembly.0,
        assembly.1,
        factorization.0,
        factorization.1,
        substitution.1,
        residual.0,
        residual.1,
        assembly.1 + factorization.1 + substitution.1 + residual.1,
        body.symbolic.entries() as f64 * 8e-6,
    );
}

fn main() {
    let small = [2, 4, 1];
    for p in 3..=5 {
        run(SpaceKind::TensorProduct, p, p + 2, small);
    }
    run(SpaceKind::TensorProduct, 4, 5, small);
    run(SpaceKind::Trunk, 5, 6, small);
    for p in [3, 4, 5, 6, 8, 10] {
        run(SpaceKind::Trunk, p, p + 2, small);
    }
    for p in [3, 4] {
        run(SpaceKind::Trunk, p, p + 1, [16, 8, 1]);
    }
}
