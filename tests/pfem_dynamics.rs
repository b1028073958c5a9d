//! The structure in motion: repeatability, energy, damping.

use fsi_driver::Vec3;
use fsi_driver::case::Material;
use fsi_driver::geometry::tube_mesh;
use fsi_driver::pfem::discretization::Options;
use fsi_driver::pfem::newton::NewtonOptions;
use fsi_driver::pfem::supports::Support;
use fsi_driver::pfem::{Solid, Space, SpaceKind, Structure, StructureOptions, SurfaceLoad};

fn artery() -> Vec<Material> {
    vec![
        Material::HolzapfelGasserOgden {
            mu: 5.4e4,
            kappa: 1e9,
            k1: 640.0,
            k2: 3.54,
            fibre_angle_deg: 10.0,
            tension_only: false,
        },
        Material::HolzapfelGasserOgden {
            mu: 5.4e3,
            kappa: 1e8,
            k1: 5.1e3,
            k2: 15.4,
            fibre_angle_deg: 40.0,
            tension_only: false,
        },
    ]
}

#[test]
#[ignore = "by hand"]
fn explore() {
    let env = |n: &str, d: f64| std::env::var(n).map_or(d, |v| v.parse().unwrap());
    let p = env("P", 3.0) as usize;
    let axial = env("AX", 8.0) as usize;
    let circ = env("CI", 8.0) as usize;
    let mesh = tube_mesh(
        2.35e-3,
        &[0.45e-3, 0.45e-3],
        axial as f64 * 3.75e-3,
        axial,
        circ,
        1,
    );
    let options = StructureOptions {
        discretization: Options::new(Space::isotropic(SpaceKind::Trunk, p)),
        density: 1100.0,
        damping: 0.01,
        newton: NewtonOptions {
            contraction: env("CON", 0.2),
            ..Default::default()
        },
        wet_surface: "inner".into(),
        supports: vec![
            Support::Clamped("start".into()),
            Support::Clamped("end".into()),
        ],
    };
    let t0 = std::time::Instant::now();
    let mut s = Structure::new(&mesh, &artery(), &options).unwrap();
    println!(
        "dofs {} factor {} setup {:.3}",
        s.body().degrees_of_freedom(),
        s.body().symbolic.entries(),
        t0.elapsed().as_secs_f64()
    );
    let n = s.wet_points().len();
    let dt = env("DT", 2e-3);
    let steps = env("STEPS", 50.0) as usize;
    let tol = env("TOL", 1e-6);
    for i in 1..=steps {
        let t = i as f64 * dt;
        let ramp = if t < 0.2 {
            0.5 - 0.5 * (std::f64::consts::PI * t / 0.2).cos()
        } else {
            1.0
        };
        let amplitude = env("PRESSURE", 1.33e4) * ramp;
        let x = |k: usize, s: &Structure| s.wet_points()[k].position.x;
        let load = SurfaceLoad {
            pressure: (0..n)
                .map(|k| {
                    amplitude * (1.0 + 0.2 * (std::f64::consts::TAU * (t - x(k, &s) / 6.0)).sin())
                })
                .collect(),
            shear: vec![Vec3::new(1.0, 0.0, 0.0); n],
        };
        let t1 = std::time::Instant::now();
        let trial = match s.solve(&load, dt, tol, None) {
            Ok(t) => t,
            Err(e) => panic!("step {i}: {e}"),
        };
        let (vm, at) = s.max_von_mises(&trial).unwrap();
        if i % (steps / 25).max(1) == 0 || i < 5 {
            println!(
                "{i} t {t:.4} {:.3}s  max d {:.3e} vm {vm:.3e} at {:.1e} {:?} {:?}",
                t1.elapsed().as_secs_f64(),
                trial.state.d.iter().fold(0.0f64, |a, b| a.max(b.abs())),
                at.x,
                trial
                    .residuals
                    .iter()
                    .map(|r| format!("{r:.0e}"))
                    .collect::<Vec<_>>(),
                (trial.stats.assemblies, trial.stats.iterations)
            );
        }
        s.accept(trial);
    }
    println!("{:?}", s.stats());
}
