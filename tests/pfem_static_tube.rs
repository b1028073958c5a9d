//! The two-layer artery under internal pressure against its semi-analytic solution.

use fsi_driver::Vec3;
use fsi_driver::case::Material;
use fsi_driver::geometry::tube_mesh;
use fsi_driver::pfem::discretization::{Discretization, Options};
use fsi_driver::pfem::mapping::MappingKind;
use fsi_driver::pfem::statics::{self, Loading, StaticOptions};
use fsi_driver::pfem::supports::{self, Support};
use fsi_driver::pfem::surface::{LoadKind, Surface};
use fsi_driver::pfem::{Space, SpaceKind, SurfaceLoad};

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

fn run(space: Space, mapping: MappingKind, points: usize, kind: LoadKind) -> (usize, f64) {
    let length = 0.006;
    let mesh = tube_mesh(0.003, &[0.0005, 0.0005], length, 2, 4, 1);
    let sliding = [true, false, false];
    let supports = [
        Support::Surface("start".into(), sliding),
        Support::Surface("end".into(), sliding),
        Support::SymmetryPlane(1),
        Support::SymmetryPlane(2),
    ];
    let options = Options {
        space,
        mapping,
        quadrature_points: [points; 3],
    };
    let t0 = std::time::Instant::now();
    let body = Discretization::new(&mesh, &artery(), &supports, &options).unwrap();
    let setup = t0.elapsed().as_secs_f64();
    let faces = supports::surface(&mesh, "inner").unwrap();
    let surface = Surface::new(&body.numbering, &space, &body.mapping, faces, points).unwrap();
    let n = surface.points.len();
    let loading = Loading {
        surface: &surface,
        load: SurfaceLoad {
            pressure: vec![1.6e4; n],
            shear: vec![Vec3::zeros(); n],
        },
        kind,
    };
    let result = statics::solve(&body, Some(&loading), None, &StaticOptions::default()).unwrap();
    let energy = body.energy(&result.displacement, [points + 2; 3]).unwrap() / length;
    let exact = match kind {
        LoadKind::Follower => 0.1654547651,
        LoadKind::Dead => 0.1283939496,
    };
    let dofs = body.degrees_of_freedom();
    println!(
        "{:?} {:?} p {} q {points} {mapping:?}: dofs {dofs} factor {} energy {energy:.10} error {:.2e} setup {setup:.3} {:?}",
        kind,
        space.kind,
        space.max_degree(),
        body.symbolic.entries(),
        energy / exact - 1.0,
        result.stats
    );
    for s in &result.steps {
        println!(
            "   {:.3} {:?}",
            s.factor,
            s.residuals
                .iter()
                .map(|r| format!("{r:.1e}"))
                .collect::<Vec<_>>()
        );
    }
    (dofs, energy / exact - 1.0)
}

#[test]
#[ignore = "by hand"]
fn explore() {
    let p: usize = std::env::var("P").map_or(4, |v| v.parse().unwrap());
    let q: usize = std::env::var("Q").map_or(p + 2, |v| v.parse().unwrap());
    let mapping = std::env::var("PG").map_or(MappingKind::Exact, |v| {
        MappingKind::Blended(v.parse().unwrap())
    });
    let kind = if std::env::var("TP").is_ok() {
        SpaceKind::TensorProduct
    } else {
        SpaceKind::Trunk
    };
    let load = if std::env::var("DEAD").is_ok() {
        LoadKind::Dead
    } else {
        LoadKind::Follower
    };
    run(Space::isotropic(kind, p), mapping, q, load);
}
