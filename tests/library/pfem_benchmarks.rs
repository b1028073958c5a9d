//! Benchmarks that others publish.

use fsi_driver::Vec3;
use fsi_driver::case::Material;
use fsi_driver::geometry::{HexFace, HexMesh, HexShape};
use fsi_driver::pfem::discretization::{Discretization, Options};
use fsi_driver::pfem::element::surface::LoadKind;
use fsi_driver::pfem::mesh::block_mesh;
use fsi_driver::pfem::solution::newton::NewtonOptions;
use fsi_driver::pfem::solution::statics::{self, Load, StaticOptions};
use fsi_driver::pfem::solution::time_scheme::TimeScheme;
use fsi_driver::pfem::supports::Support;
use fsi_driver::pfem::{
    Gravity, Solid, Space, SpaceKind, Structure, StructureOptions, SurfaceLoad,
};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The elastic beam of Turek and Hron downstream of their cylinder: 0.02 m high, it begins on the circle of radius 0.05
/// m around (0.2, 0.2) m and ends at x = 0.6 m. One element thick.
struct Beam {
    stations: Vec<f64>,
}

impl HexShape for Beam {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        let y = 0.2 + 0.01 * xi[1];
        let begin = 0.2 + (0.05f64.powi(2) - (y - 0.2).powi(2)).sqrt();
        let (a, b) = (self.stations[element], self.stations[element + 1]);
        let share = a + (b - a) * 0.5 * (1.0 + xi[0]);
        Vec3::new(begin + share * (0.6 - begin), y, 0.01 * (1.0 + xi[2]))
    }
}

fn beam(stations: Vec<f64>) -> HexMesh {
    let n = stations.len() - 1;
    let shape = Beam { stations };
    let corner = |v: usize| -> f64 { if v == 1 { 1.0 } else { -1.0 } };
    let mut vertices = Vec::new();
    for i in 0..=n {
        for v in 0..4 {
            let (element, end) = if i == n { (n - 1, 1.0) } else { (i, -1.0) };
            vertices.push(shape.position(element, [end, corner(v & 1), corner(v >> 1)]));
        }
    }
    let hexes: Vec<[usize; 8]> = (0..n)
        .map(|e| std::array::from_fn(|v| 4 * (e + (v & 1)) + (v >> 1)))
        .collect();
    let face = |axis, upper| HexFace { axis, upper };
    let sides = |upper| (0..n).map(|e| (e, face(2, upper))).collect::<Vec<_>>();
    let surfaces = BTreeMap::from([
        ("start".to_string(), vec![(0, face(0, false))]),
        ("sides".to_string(), [sides(false), sides(true)].concat()),
    ]);
    HexMesh {
        vertices,
        regions: vec![0; n],
        hexes,
        surfaces,
        directions: fsi_driver::geometry::WallDirections::Local,
        shape: Arc::new(shape),
    }
}

/// CSM1 and CSM2 of Turek and Hron, *Proposal for numerical benchmarking of fluid-structure interaction*, 2006: the
/// beam under its own weight, static, and the same four times as stiff.
#[test]
fn csm1_beam_under_its_own_weight() {
    assert_tip(1.4e6, [-7.187e-3, -66.10e-3]);
}

#[test]
fn csm2_stiffer_beam_under_its_own_weight() {
    assert_tip(5.6e6, [-0.4690e-3, -16.97e-3]);
}

fn material(youngs_modulus: f64) -> Material {
    Material::SaintVenantKirchhoff {
        youngs_modulus,
        poisson_ratio: 0.4,
        viscosity: None,
    }
}

/// Clamped at the cylinder, in plane strain.
fn supports() -> Vec<Support> {
    vec![
        Support::Clamped("start".into()),
        Support::Surface("sides".into(), [false, false, true]),
    ]
}

/// The displacement (m) of the tip within 0.5 % of the published one.
fn assert_tip(youngs_modulus: f64, published: [f64; 2]) {
    let mesh = beam(vec![0.0, 0.02, 0.1, 0.4, 0.7, 1.0]);
    let (material, supports) = (material(youngs_modulus), supports());
    let space = Space {
        kind: SpaceKind::TensorProduct,
        degrees: [6, 4, 1],
    };
    let body = Discretization::new(&mesh, &[material], &supports, &Options::new(space)).unwrap();
    let weight = body.body_forces(Vec3::new(0.0, -2.0 * 1000.0, 0.0));
    let options = StaticOptions::default();
    let result = statics::solve(&body, &[Load::Forces(weight)], None, &options).unwrap();
    let tip = body.displacement_at(mesh.hexes.len() - 1, [1.0, 0.0, 0.0], &result.displacement);
    println!("{tip:?}, {} iterations", result.stats.iterations);
    for (found, published) in [tip.x, tip.y].into_iter().zip(published) {
        let error = found / published - 1.0;
        assert!(error.abs() < 5e-3, "{found}, {:+.3} %", 100.0 * error);
    }
}

/// CSM3: the beam of CSM1 is let go and swings under its own weight, without damping. Published: -14.305 ± 14.305 mm,
/// -63.607 ± 65.160 mm, 1.0995 Hz. What was measured is read from the rows of the case's page.
#[test]
fn csm3_beam_swings_under_its_own_weight() {
    let page = include_str!("../../openfoam-case/turek-hron/README.md");
    let rows = page.lines().filter(|line| line.starts_with("| here |"));
    assert_eq!(rows.clone().count(), 6, "rows of CSM3");
    for row in rows {
        let words = row.split(['|', ',', '±']);
        let numbers: Vec<f64> = words.filter_map(|word| word.trim().parse().ok()).collect();
        let [elements, degree, dt, displacements @ .., frequency] = &numbers[..] else {
            panic!("{row}");
        };
        let swing = swing(*elements as usize, *degree as usize, *dt, 3.0);
        println!("{row}: {swing:?}");
        let found = [swing.x, swing.y].concat();
        assert_eq!(displacements.len(), found.len());
        for (found, measured) in found.iter().zip(displacements) {
            assert!((found - 1e-3 * measured).abs() < 2e-5, "{row}: {found} m");
        }
        assert!(
            (swing.frequency - frequency).abs() < 1e-3,
            "{row}: {swing:?}"
        );
    }
}

/// Mean and amplitude of both displacements of the tip, from the largest and smallest value, and frequency, Hz.
#[derive(Debug)]
struct Swing {
    x: [f64; 2],
    y: [f64; 2],
    frequency: f64,
}

/// Steps of `dt` (s) up to the time `end` (s) from rest, in m.
fn swing(elements: usize, degree: usize, dt: f64, end: f64) -> Swing {
    let mesh = beam(match elements {
        4 => vec![0.0, 0.05, 0.3, 0.65, 1.0],
        _ => vec![0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 1.0],
    });
    let space = Space {
        kind: SpaceKind::TensorProduct,
        degrees: [degree, 4, 1],
    };
    let options = StructureOptions {
        discretization: Options::new(space),
        density: 1000.0,
        damping: 0.0,
        time_scheme: TimeScheme::Newmark,
        load: LoadKind::default(),
        newton: NewtonOptions::default(),
        wet_surface: "sides".into(),
        supports: supports(),
        outer_pressure: None,
        gravity: Some(Gravity {
            acceleration: Vec3::new(0.0, -2.0, 0.0),
            ramp: 0.0,
        }),
    };
    let mut beam = Structure::new(&mesh, &[material(1.4e6)], &options).unwrap();
    let load = SurfaceLoad::uniform_pressure(0.0, beam.wet_points().len());
    let mut tip = vec![Vec3::zeros()];
    for _ in 0..(end / dt).round() as usize {
        let trial = beam.solve(&load, dt, 1e-8, None).unwrap();
        beam.accept(trial);
        let d = &beam.state().d;
        let last = mesh.hexes.len() - 1;
        tip.push(beam.body().displacement_at(last, [1.0, 0.0, 0.0], d));
    }
    let range = |of: &dyn Fn(&Vec3) -> f64| {
        let values = tip.iter().map(of);
        let [low, high] = [
            values.clone().fold(f64::INFINITY, f64::min),
            values.fold(f64::NEG_INFINITY, f64::max),
        ];
        [0.5 * (low + high), 0.5 * (high - low)]
    };
    // Times of the lowest points, each by the parabola through it and its neighbours.
    let turns: Vec<f64> = (1..tip.len() - 1)
        .filter(|&i| tip[i].y < -0.06 && tip[i].y < tip[i - 1].y && tip[i].y <= tip[i + 1].y)
        .map(|i| {
            let [before, at, after] = [i - 1, i, i + 1].map(|i| tip[i].y);
            dt * (i as f64 + 0.5 * (before - after) / (before - 2.0 * at + after))
        })
        .collect();
    Swing {
        x: range(&|u| u.x),
        y: range(&|u| u.y),
        frequency: (turns.len() - 1) as f64 / (turns[turns.len() - 1] - turns[0]),
    }
}

/// Up and back (m) of the free end of the silicone filament of Hessenthaler and others (2017), 11 x 2 x 65 mm, which
/// buoyancy lifts: a neo-Hookean body with this shear modulus (Pa) and Poisson's ratio.
fn lifted(elements: [usize; 3], degree: usize, shear: f64, poisson_ratio: f64) -> [f64; 2] {
    let mesh = block_mesh([0.065, 0.011, 0.002], elements);
    let material = Material::NeoHooke {
        mu: shear,
        kappa: 2.0 * shear * poisson_ratio / (1.0 - 2.0 * poisson_ratio),
        viscosity: None,
    };
    let clamp = [Support::Clamped("start".into())];
    let options = Options::new(Space::isotropic(SpaceKind::Trunk, degree));
    let body = Discretization::new(&mesh, &[material], &clamp, &options).unwrap();
    let load = Load::Forces(body.body_forces(1058.3 * 0.9733 * Vec3::z()));
    let result = statics::solve(&body, &[load], None, &StaticOptions::default()).unwrap();
    let tip = body.displacement_at(mesh.hexes.len() - 1, [1.0, 0.0, 0.0], &result.displacement);
    [tip.z, -tip.x]
}

/// Measured: its middle line ends 29.5 mm up. By calibration to that others found a shear modulus of 61 kPa for
/// incompressible silicone and 63.95 kPa for Poisson's ratio 0.45. Here, of finer meshes (20 x 4 x 1, p = 6): 29.41 and
/// 29.41 mm up, 8.25 and 8.22 mm back.
#[test]
fn the_silicone_filament_is_lifted_as_measured() {
    let (nearly, compressible) = (0.4995, 0.45);
    for (degree, shear, poisson_ratio, up, back) in [
        (4, 6.1e4, nearly, 28.967, 8.028),
        (5, 6.1e4, nearly, 29.200, 8.143),
        (5, 6.395e4, compressible, 29.236, 8.138),
    ] {
        let found = lifted([10, 2, 1], degree, shear, poisson_ratio);
        println!("degree {degree}, {shear} Pa, {poisson_ratio}: {found:?}");
        for (found, measured) in found.into_iter().zip([up, back]) {
            assert!((1e3 * found - measured).abs() < 2e-3, "{found}");
        }
    }
}

/// A weight that grows by half a cosine: so much of its deflection has a bar that is hardly heavy, nearly without
/// inertia, and in the end it has that of statics.
#[test]
fn a_weight_grows_by_half_a_cosine() {
    let mesh = block_mesh([0.1, 0.01, 0.01], [2, 1, 1]);
    let mut options = StructureOptions {
        discretization: Options::new(Space::isotropic(SpaceKind::Trunk, 3)),
        density: 1000.0,
        damping: 0.0,
        time_scheme: TimeScheme::ImplicitEuler,
        load: LoadKind::default(),
        newton: NewtonOptions::default(),
        wet_surface: "end".into(),
        supports: vec![Support::Clamped("start".into())],
        outer_pressure: None,
        gravity: Some(Gravity {
            acceleration: 1e-3 * Vec3::z(),
            ramp: 400.0,
        }),
    };
    let bent = |options: &StructureOptions, steps: usize| {
        let mut bar = Structure::new(&mesh, &[material(1e6)], options).unwrap();
        let load = SurfaceLoad::uniform_pressure(0.0, bar.wet_points().len());
        for _ in 0..steps {
            let trial = bar.solve(&load, 100.0, 1e-10, None).unwrap();
            bar.accept(trial);
        }
        let d = &bar.state().d;
        bar.body().displacement_at(1, [1.0, 0.0, 0.0], d).z
    };
    let whole = bent(&options, 6);
    for (steps, share) in [
        (1, 0.5 * (1.0 - 0.5f64.sqrt())),
        (2, 0.5),
        (3, 0.5 * (1.0 + 0.5f64.sqrt())),
        (4, 1.0),
    ] {
        let found = bent(&options, steps) / whole;
        assert!((found - share).abs() < 1e-5, "{steps}: {found}, {share}");
    }
    options.gravity = None;
    assert_eq!(bent(&options, 1), 0.0);
}
