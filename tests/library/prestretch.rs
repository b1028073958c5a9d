//! Bodies that are free of stress nowhere: prestretched ones.

use crate::pfem_support::{artery, distorted_box};
use fsi_driver::Vec3;
use fsi_driver::case::{Case, Material, Preset};
use fsi_driver::geometry::{HexMesh, HexShape};
use fsi_driver::pfem::solution::statics::{StaticOptions, solve, stretch};
use fsi_driver::pfem::supports::Support;
use fsi_driver::pfem::{Discretization, Space, SpaceKind, discretization};
use fsi_driver::simulation::assembly::{CoupledModel, Workplace};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A shape whose coordinates are multiplied.
struct Scaled(Arc<dyn HexShape>, Vec3);

impl HexShape for Scaled {
    fn position(&self, element: usize, xi: [f64; 3]) -> Vec3 {
        self.0.position(element, xi).component_mul(&self.1)
    }
}

/// A box of this size (m) with the surfaces `start` and `end` across x.
fn block(size: Vec3) -> HexMesh {
    let unit = distorted_box([3, 2, 2], 0.0, false);
    let end = |upper: bool| {
        let faces = unit.surfaces["boundary"].iter();
        let own = faces.filter(|(_, face)| face.axis == 0 && face.upper == upper);
        own.copied().collect::<Vec<_>>()
    };
    let surfaces = [("start", end(false)), ("end", end(true))];
    HexMesh {
        surfaces: BTreeMap::from(surfaces.map(|(name, faces)| (name.to_owned(), faces))),
        vertices: unit
            .vertices
            .iter()
            .map(|x| x.component_mul(&size))
            .collect(),
        shape: Arc::new(Scaled(unit.shape.clone(), size)),
        ..unit
    }
}

fn body(
    mesh: &HexMesh,
    material: &Material,
    supports: &[Support],
    prestretch: f64,
) -> Discretization {
    let options = discretization::Options {
        prestretch,
        ..discretization::Options::new(Space::isotropic(SpaceKind::Trunk, 3))
    };
    Discretization::new(mesh, std::slice::from_ref(material), supports, &options).unwrap()
}

fn displacement(body: &Discretization, all: &[f64], vertex: usize) -> Vec3 {
    let function = body.numbering.of_vertex[vertex];
    Vec3::from_column_slice(&all[3 * function..3 * function + 3])
}

/// A block of fibred wall that was pulled to a length, its ends held there, is a prestretched one of that length: the
/// same shape, the same energy, the same forces.
#[test]
fn a_prestretched_block_is_one_that_was_pulled() {
    let (along, across) = (1.2f64, 1.0 / 1.2f64.sqrt());
    let material = &artery()[0];
    let clamped = ["start", "end"].map(|name| Support::Clamped(name.into()));
    let natural = block(Vec3::new(1.0 / along, 1.0 / across, 1.0 / across));
    let pulled = body(&natural, material, &clamped, 1.0);
    let mut guess = vec![0.0; pulled.coefficients()];
    for (vertex, &function) in pulled.numbering.of_vertex.iter().enumerate() {
        let x = natural.vertices[vertex];
        let moved = x.component_mul(&Vec3::new(along, across, across)) - x;
        guess[3 * function..3 * function + 3].copy_from_slice(moved.as_slice());
    }
    let options = StaticOptions::default();
    let of_pulled = stretch(&pulled, &guess, &options).unwrap().displacement;
    let given = block(Vec3::repeat(1.0));
    let stretched = body(&given, material, &clamped, along);
    let found = solve(&stretched, &[], None, &options).unwrap().displacement;
    let mut largest = [0.0f64; 2];
    for vertex in 0..given.vertices.len() {
        let place = |mesh: &HexMesh, body, all: &[f64]| {
            mesh.vertices[vertex] + displacement(body, all, vertex)
        };
        let off = place(&given, &stretched, &found) - place(&natural, &pulled, &of_pulled);
        let moved = displacement(&stretched, &found, vertex);
        largest = [largest[0].max(off.norm()), largest[1].max(moved.norm())];
    }
    println!(
        "{:.1e} m apart, {:.1e} m from the given shape",
        largest[0], largest[1]
    );
    assert!(largest[0] < 1e-9, "{largest:?}");
    // Its fibres are no solution of the given shape.
    assert!(largest[1] > 1e-3, "{largest:?}");
    let energies = [(&pulled, &of_pulled), (&stretched, &found)]
        .map(|(body, all)| body.energy(all, [4; 3]).unwrap());
    assert!(
        (energies[0] / energies[1] - 1.0).abs() < 1e-8,
        "{energies:?}"
    );
    let forces = [(&pulled, &of_pulled), (&stretched, &found)].map(|(body, all)| {
        let all = body.internal_forces(all).unwrap();
        displacement(body, &all, 0).x
    });
    assert!((forces[0] / forces[1] - 1.0).abs() < 1e-7, "{forces:?}");
}

/// Uniaxial tension of an incompressible neo-Hookean body: `σ = μ (λ² - 1/λ)`.
#[test]
fn its_ends_carry_uniaxial_tension() {
    let (mu, stretch) = (1e5, 1.3f64);
    let material = Material::NeoHooke {
        mu,
        kappa: 1e10,
        viscosity: None,
    };
    let mesh = block(Vec3::repeat(1.0));
    let held = |name: &str| Support::Surface(name.into(), [true, false, false]);
    let supports = [
        held("start"),
        held("end"),
        Support::SymmetryPlane(1),
        Support::SymmetryPlane(2),
    ];
    let body = body(&mesh, &material, &supports, stretch);
    let found = solve(&body, &[], None, &StaticOptions::default()).unwrap();
    let forces = body.internal_forces(&found.displacement).unwrap();
    let at_end = |vertex: &usize| mesh.vertices[*vertex].x > 0.999;
    let vertices = (0..mesh.vertices.len()).filter(at_end);
    // The functions of edges and faces do not move the end as a whole.
    let force: f64 = vertices
        .map(|vertex| displacement(&body, &forces, vertex).x)
        .sum();
    let exact = mu * (stretch.powi(2) - 1.0 / stretch);
    println!("{force:.1} N, exactly {exact:.1} N");
    assert!((force / exact - 1.0).abs() < 1e-4, "{force} {exact}");
}

/// A tree whose wall is stretched along its branches begins in the shape that is given.
#[test]
fn a_prestretched_tree_returns_to_its_loaded_shape() {
    let set = |key: &str, value: &str| (key.to_owned(), value.to_owned());
    let settings = [
        set("fluid.solver", "native"),
        set("wall.initial.axial_stretch", "1.2"),
    ];
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/trees/aneurysm");
    let case = Case::load(folder.as_ref(), Preset::Demo, &settings).unwrap();
    let model = CoupledModel::new(&case, Workplace::default(), None).unwrap();
    let unloading = model.unloading.unwrap();
    println!("{unloading:?}");
    assert!(unloading.distance_after_loading_m < 1e-8, "{unloading:?}");
    // Its bend straightens: without the stretch the wall moves by 0.20 mm.
    assert!(unloading.largest_displacement_m > 2.2e-4, "{unloading:?}");
}
