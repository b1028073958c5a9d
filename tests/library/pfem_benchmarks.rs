//! Benchmarks that others publish.

use fsi_driver::Vec3;
use fsi_driver::case::Material;
use fsi_driver::geometry::{HexFace, HexMesh, HexShape};
use fsi_driver::pfem::discretization::{Discretization, Options};
use fsi_driver::pfem::solution::statics::{self, Load, StaticOptions};
use fsi_driver::pfem::supports::Support;
use fsi_driver::pfem::{Space, SpaceKind};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The elastic beam of Turek and Hron behind their cylinder: 0.02 m high, it begins on the circle of radius 0.05 m around
/// (0.2, 0.2) m and ends at x = 0.6 m. One element thick.
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

/// CSM1 and CSM2 of Turek and Hron, *Proposal for numerical benchmarking of fluid-structure interaction*, 2006: the beam
/// under its own weight, static, and the same four times as stiff.
#[test]
fn csm1_beam_under_its_own_weight() {
    assert_tip(1.4e6, [-7.187e-3, -66.10e-3]);
}

#[test]
fn csm2_stiffer_beam_under_its_own_weight() {
    assert_tip(5.6e6, [-0.4690e-3, -16.97e-3]);
}

/// The displacement (m) of the tip within 0.5 % of the published one.
fn assert_tip(youngs_modulus: f64, published: [f64; 2]) {
    let mesh = beam(vec![0.0, 0.02, 0.1, 0.4, 0.7, 1.0]);
    let material = Material::SaintVenantKirchhoff {
        youngs_modulus,
        poisson_ratio: 0.4,
        viscosity: None,
    };
    let supports = [
        Support::Clamped("start".into()),
        Support::Surface("sides".into(), [false, false, true]),
    ];
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
