//! Large walls, whose factors are stored in single precision at rest too, against the same walls treated as small ones:
//! here both ways are taken by walls that are small. That results differ at all shows that there were two ways.

use crate::pfem_support::artery;
use fsi_driver::case::{Case, Material, Preset};
use fsi_driver::geometry::tube_mesh;
use fsi_driver::pfem::discretization::Options;
use fsi_driver::pfem::element::surface::LoadKind;
use fsi_driver::pfem::solution::newton::NewtonOptions;
use fsi_driver::pfem::solution::stability::AtBifurcation;
use fsi_driver::pfem::solution::statics::StaticOptions;
use fsi_driver::pfem::solution::structure::State;
use fsi_driver::pfem::solution::time_scheme::TimeScheme;
use fsi_driver::pfem::supports::Support;
use fsi_driver::pfem::{Solid, Space, SpaceKind, Structure, StructureOptions, SurfaceLoad};
use fsi_driver::simulation::assembly::Domain;
use std::path::Path;

/// Operations from which on a wall counts as large: none does, all do.
const WAYS: [f64; 2] = [f64::INFINITY, 0.0];

fn options(large: f64, supports: Vec<Support>) -> StructureOptions {
    StructureOptions {
        discretization: Options {
            large,
            ..Options::new(Space::isotropic(SpaceKind::Trunk, 3))
        },
        density: 1100.0,
        damping: 0.01,
        time_scheme: TimeScheme::Newmark,
        load: LoadKind::default(),
        newton: NewtonOptions::default(),
        wet_surface: "inner".into(),
        supports,
        outer_pressure: None,
        gravity: None,
    }
}

/// The wall of a case.
fn of_case(folder: &str, set: &[(&str, &str)], large: f64) -> Structure {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let set: Vec<_> = (set.iter())
        .map(|(key, value)| (key.to_string(), value.to_string()))
        .collect();
    let case = Case::load(&folder, Preset::Demo, &set).unwrap();
    let domain = Domain::new(&case).unwrap();
    let options = StructureOptions {
        discretization: Options {
            large,
            ..Options::new(domain.space)
        },
        wet_surface: domain.wet_surface.into(),
        outer_pressure: domain.outer_pressure.clone(),
        ..options(large, domain.supports.clone())
    };
    Structure::new(&domain.solid, &domain.materials, &options).unwrap()
}

/// A tube of media and adventitia with their fibres, nearly incompressible.
fn tube(large: f64) -> Structure {
    let mesh = tube_mesh(2.35e-3, &[4.5e-4, 4.5e-4], 1.5e-2, 4, 8, 1);
    let ends = ["start", "end"].map(|end| Support::Clamped(end.into()));
    Structure::new(&mesh, &artery(), &options(large, ends.to_vec())).unwrap()
}

/// A carotid bifurcation of one Neo-Hookean layer in springs.
fn tree(large: f64) -> Structure {
    let coarse = [
        ("tree.length", "1.5"),
        ("tree.core", "2"),
        ("wall.extrude.faces_per_element", "1"),
    ];
    of_case("examples/trees/carotid", &coarse, large)
}

/// Its displacement under 10 kPa. Newton's method goes on until what it leaves is less than what is asked of the ways.
fn loaded(wall: &Structure) -> Vec<f64> {
    let options = StaticOptions {
        tolerance: 1e-13,
        ..StaticOptions::default()
    };
    wall.inflate(1e4, None, &options).unwrap().displacement
}

/// The largest difference of two displacements, as a share of the largest one.
fn difference(one: &[f64], other: &[f64]) -> f64 {
    let largest = one.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let pairs = one.iter().zip(other);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// Twelve steps under a growing pressure, handed over before the step `resumed`.
fn inflate(new: &dyn Fn() -> Structure, resumed: Option<usize>) -> Structure {
    let mut structure = new();
    for step in 1..=12 {
        if resumed == Some(step) {
            let memory = structure.memory();
            structure = new();
            structure.recall(memory).unwrap();
        }
        let pressure = 40.0 * step as f64;
        let load = SurfaceLoad::uniform_pressure(pressure, structure.wet_points().len());
        let trial = structure.solve(&load, 2e-3, 1e-8, None).unwrap();
        structure.accept(trial);
    }
    structure
}

#[test]
fn a_large_wall_is_resumed_to_the_last_bit() {
    let new = || tube(0.0);
    let straight = inflate(&new, None);
    for step in [2, 6, 12] {
        assert_eq!(
            straight.memory(),
            inflate(&new, Some(step)).memory(),
            "{step}"
        );
    }
}

#[test]
fn threads_change_no_bit_of_a_large_wall() {
    let states: Vec<State> = (1..=3)
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            pool.install(|| inflate(&|| tube(0.0), None).state().clone())
        })
        .collect();
    assert_eq!(states[0], states[1]);
    assert_eq!(states[0], states[2]);
}

#[test]
fn statics_of_a_large_wall_are_those_of_a_small_one() {
    for (name, new) in [("tube", tube as fn(f64) -> Structure), ("tree", tree)] {
        let [small, large] = WAYS.map(|way| loaded(&new(way)));
        let error = difference(&small, &large);
        // 2e-14 and 6e-13.
        assert!(error > 0.0 && error < 1e-11, "{name}: {error:e}");
    }
}

/// A wall that is given in its loaded shape: the unloaded one, and back.
#[test]
fn a_large_wall_is_prestressed_as_a_small_one() {
    let found = WAYS.map(|way| {
        let wall = tree(way);
        let unloaded = wall.unloaded_shape(1e4, None).unwrap().displacement;
        let wall = wall.unloaded_by(unloaded.clone()).unwrap();
        (unloaded, loaded(&wall))
    });
    let [(unloaded, loaded), (unloaded_large, loaded_large)] = found;
    let errors = [
        difference(&unloaded, &unloaded_large),
        difference(&loaded, &loaded_large),
    ];
    // 2e-14 and 3e-15.
    assert!(
        errors.iter().all(|error| *error > 0.0 && *error < 1e-11),
        "{errors:?}"
    );
}

#[test]
fn a_large_wall_buckles_as_a_small_one() {
    let factors = WAYS.map(|way| {
        let mesh = tube_mesh(0.95e-3, &[1e-4], 120e-3, 6, 4, 1);
        let ends = ["start", "end"].map(|end| Support::Clamped(end.into()));
        let material = Material::SaintVenantKirchhoff {
            youngs_modulus: 1e6,
            poisson_ratio: 0.3,
            viscosity: None,
        };
        let wall = Structure::new(&mesh, &[material], &options(way, ends.to_vec())).unwrap();
        let options = StaticOptions {
            at_bifurcation: AtBifurcation::Stop,
            ..StaticOptions::default()
        };
        let found = wall.inflate(1e3, None, &options).unwrap();
        found.bifurcation.expect("a slender tube buckles").factor
    });
    let [small, large] = factors;
    // They differ by 1.5e-7.
    let error = (large / small - 1.0).abs();
    assert!(error > 0.0 && error < 2e-6, "{small} {large}");
    assert!((0.7..0.85).contains(&small), "{small}");
}
