//! The structural mesh: orientation, conformity, volumes.

use fsi_driver::Vec3;
use fsi_driver::case::{BloodVessel, Case, Preset};
use fsi_driver::geometry::{
    HexMesh, Imperfection, Surfaces, Vessel, irregular_tube_mesh, solid_mesh, tube_mesh,
};
use std::path::Path;

fn load(model: &str) -> BloodVessel {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("openfoam-case")
        .join(model);
    let case = Case::load(&folder, Preset::Coarse, &[]).unwrap_or_else(|errors| panic!("{errors}"));
    case.vessel().unwrap().clone()
}

/// Volume (m³) of every element by the 4-point Gauss rule in each direction and central differences of the shape.
fn volumes(mesh: &HexMesh) -> Vec<f64> {
    let (a, b) = (
        (3.0 / 7.0 - 2.0 / 7.0 * 1.2f64.sqrt()).sqrt(),
        (3.0 / 7.0 + 2.0 / 7.0 * 1.2f64.sqrt()).sqrt(),
    );
    let (wa, wb) = ((18.0 + 30f64.sqrt()) / 36.0, (18.0 - 30f64.sqrt()) / 36.0);
    let rule = [(-b, wb), (-a, wa), (a, wa), (b, wb)];
    let h = 1e-5;
    (0..mesh.hexes.len())
        .map(|element| {
            let mut sum = 0.0;
            for (x, wx) in rule {
                for (y, wy) in rule {
                    for (z, wz) in rule {
                        let column = |axis: usize| -> Vec3 {
                            let shifted = |by: f64| {
                                let mut xi = [x, y, z];
                                xi[axis] += by;
                                mesh.shape.position(element, xi)
                            };
                            (shifted(h) - shifted(-h)) / (2.0 * h)
                        };
                        let jacobian = column(0).cross(&column(1)).dot(&column(2));
                        assert!(
                            jacobian > 0.0,
                            "element {element} is inside out at {:?}",
                            [x, y, z]
                        );
                        sum += wx * wy * wz * jacobian;
                    }
                }
            }
            sum
        })
        .collect()
}

/// Every vertex is a corner of the shape, and faces of neighbours coincide.
fn assert_conforming(mesh: &HexMesh) {
    for (element, hex) in mesh.hexes.iter().enumerate() {
        for (v, &index) in hex.iter().enumerate() {
            let corner = [v & 1, v >> 1 & 1, v >> 2 & 1].map(|bit| 2.0 * bit as f64 - 1.0);
            let distance = (mesh.shape.position(element, corner) - mesh.vertices[index]).norm();
            assert!(
                distance < 1e-15,
                "corner {v} of element {element} is {distance:e} m from its vertex"
            );
        }
    }
}

#[test]
fn a_tube_has_the_volume_of_its_layers() {
    let mesh = tube_mesh(3e-3, &[0.5e-3, 0.4e-3], 0.01, 3, 5, 2);
    assert_conforming(&mesh);
    let volumes = volumes(&mesh);
    for (layer, (inner, outer)) in [(3e-3f64, 3.5e-3f64), (3.5e-3, 3.9e-3)]
        .into_iter()
        .enumerate()
    {
        let sum: f64 = (0..volumes.len())
            .filter(|&e| mesh.regions[e] == layer)
            .map(|e| volumes[e])
            .sum();
        let exact = std::f64::consts::PI * (outer.powi(2) - inner.powi(2)) * 0.01;
        approx::assert_relative_eq!(sum, exact, max_relative = 1e-8);
    }
    assert_eq!(mesh.surfaces["outer"].len(), 15);
    assert_eq!(mesh.surfaces["start"].len(), 20);
}

#[test]
fn the_vessels_wall_is_right_handed_and_fills_its_surfaces() {
    for model in ["S-0.0", "S-0.75"] {
        let case = load(model);
        let (mesh, vessel) = (solid_mesh(&case), Vessel::new(&case));
        assert_conforming(&mesh);
        let total: f64 = volumes(&mesh).iter().sum();
        // ∫ r_outer²/2 dφ dx - lumen; the outer surface is circular.
        let outer: f64 = (0..60_000)
            .map(|i| {
                std::f64::consts::PI
                    * vessel.radius(2, 1e-6 * (f64::from(i) + 0.5), 0.0).powi(2)
                    * 1e-6
            })
            .sum();
        approx::assert_relative_eq!(
            total,
            outer - vessel.lumen_volume(0.0, 0.06),
            max_relative = 1e-4
        );
        let counts = [0, 1, 2].map(|region| mesh.regions.iter().filter(|r| **r == region).count());
        let per_layer = case.structure.axial_per_section * case.structure.circumferential;
        assert_eq!(counts, [2 * per_layer, per_layer, per_layer]);
        for (element, hex) in mesh.hexes.iter().enumerate() {
            let x = hex.iter().map(|v| mesh.vertices[*v].x).sum::<f64>() / 8.0;
            assert_eq!(mesh.regions[element] == 0, x < 0.03);
        }
        for (name, x) in [("start", 0.0), ("end", 0.06)] {
            for (element, face) in &mesh.surfaces[name] {
                let xi = if face.upper { 1.0 } else { -1.0 };
                assert_eq!(face.axis, 0);
                approx::assert_relative_eq!(
                    mesh.shape.position(*element, [xi, 0.3, -0.2]).x,
                    x,
                    epsilon = 1e-15
                );
            }
        }
    }
}

#[test]
fn neighbours_share_their_curved_faces() {
    let case = load("S-0.75");
    let mesh = solid_mesh(&case);
    let nc = case.structure.circumferential;
    let at = |element: usize, xi| mesh.shape.position(element, xi);
    for element in 0..mesh.hexes.len() {
        let (slice, j, k) = (element / (2 * nc), element / 2 % nc, element % 2);
        let next_around = slice * 2 * nc + (j + 1) % nc * 2 + k;
        for (s, w) in [(-0.7, 0.3), (0.9, -1.0)] {
            assert!((at(element, [s, 1.0, w]) - at(next_around, [s, -1.0, w])).norm() < 1e-15);
            if k == 0 {
                assert!((at(element, [s, w, 1.0]) - at(element + 1, [s, w, -1.0])).norm() < 1e-15);
            }
            if element + 2 * nc < mesh.hexes.len() {
                assert!(
                    (at(element, [1.0, s, w]) - at(element + 2 * nc, [-1.0, s, w])).norm() < 1e-15
                );
            }
        }
    }
}

#[test]
fn the_papers_irregular_artery_has_no_element_inside_out() {
    let case = load("S-0.0");
    for (axial, circumferential, radial) in [(2, 4, 1), (4, 8, 2)] {
        let imperfection = Imperfection::new(
            &case.anastomosis().unwrap().geometry.imperfection,
            [0.0, 0.02],
            1e-3,
        );
        let mesh = irregular_tube_mesh(
            3e-3,
            [0.5e-3, 0.5e-3],
            imperfection,
            axial,
            circumferential,
            radial,
        );
        assert_conforming(&mesh);
        let sum: f64 = volumes(&mesh).iter().sum();
        let regular = std::f64::consts::PI * (16.0 - 9.0) * 1e-6 * 0.02;
        assert!(
            sum > 1.2 * regular && sum < 1.9 * regular,
            "{sum:e} against {regular:e}"
        );
    }
}
