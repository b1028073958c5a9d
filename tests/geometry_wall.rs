//! The structural mesh: orientation, conformity, volumes.

use fsi_driver::Vec3;
use fsi_driver::geometry::{HexMesh, tube_mesh};

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
