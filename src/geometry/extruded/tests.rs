use super::*;
use crate::curve::CentreLine;
use std::f64::consts::{PI, TAU};

/// A tube of radius 3 m and length 8 m along z, normals outward.
fn tube(around: usize, along: usize) -> WetQuads {
    let at = |i: usize, j: usize| i % around + around * j;
    let points = (0..around * (along + 1)).map(|p| {
        let phi = TAU * (p % around) as f64 / around as f64;
        let z = 8.0 * (p / around) as f64 / along as f64;
        Vec3::new(3.0 * phi.cos(), 3.0 * phi.sin(), z)
    });
    let faces = (0..around * along).map(|f| {
        let (i, j) = (f % around, f / around);
        [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]
    });
    let rim = (0..around).flat_map(|i| {
        [
            ((at(i, 0), at(i + 1, 0)), "left".to_owned()),
            ((at(i + 1, along), at(i, along)), "right".to_owned()),
        ]
    });
    WetQuads {
        quads: Quads {
            points: points.collect(),
            faces: faces.collect(),
        },
        rim: rim.collect(),
        patches: vec![0; around * along],
    }
}

fn growth(surface: &WetQuads, faces: Option<usize>) -> Growth {
    let points = surface.quads.points.len();
    Growth {
        faces,
        elements_per_layer: 2,
        thicknesses: vec![vec![0.5; points], vec![0.25; points]],
        regions: vec![vec![1, 0]],
        parts: vec!["tube".into()],
        normals: surface.normals(0),
        axes: None,
    }
}

/// Volume by the divergence theorem would need surfaces: Gauss points on differences of the shape are enough here.
fn volume(mesh: &HexMesh) -> f64 {
    let rule = crate::quadrature::Rule::gauss_legendre(6);
    let mut sum = 0.0;
    for element in 0..mesh.hexes.len() {
        for (x, wx) in rule.points.iter().zip(&rule.weights) {
            for (y, wy) in rule.points.iter().zip(&rule.weights) {
                for (z, wz) in rule.points.iter().zip(&rule.weights) {
                    let tangent = |d: usize| {
                        let at = |sign: f64| {
                            let mut xi = [*x, *y, *z];
                            xi[d] += sign * 1e-5;
                            mesh.shape.position(element, xi)
                        };
                        (at(1.0) - at(-1.0)) / 2e-5
                    };
                    let jacobian = tangent(0).cross(&tangent(1)).dot(&tangent(2));
                    assert!(jacobian > 0.0, "element {element} is inside out");
                    sum += wx * wy * wz * jacobian;
                }
            }
        }
    }
    sum
}

/// The wall of a tube has the volume of a hollow cylinder, whatever its elements are grouped from.
#[test]
fn a_tube_gets_the_wall_of_a_hollow_cylinder() {
    let surface = tube(24, 12);
    let exact = PI * (3.75f64.powi(2) - 9.0) * 8.0;
    // The errors of the interpolation around, computed by themselves.
    for (n, expected) in [(4, 6.588e-6), (3, 1.1251e-4), (2, 1.5531e-4), (1, 4.480e-5)] {
        let mesh = surface.wall(&growth(&surface, Some(n)), None).unwrap();
        assert_eq!(mesh.hexes.len(), 4 * 24 * 12 / (n * n));
        let error = (volume(&mesh) / exact - 1.0).abs();
        assert!((error / expected - 1.0).abs() < 2e-2, "{n}: {error:.4e}");
        assert_eq!(mesh.surfaces["left"].len(), 4 * 24 / n);
        assert_eq!(mesh.surfaces["inner"].len(), 24 * 12 / (n * n));
        // Around it bends, along it does not.
        let along =
            mesh.shape.position(0, [1.0, 0.0, 0.0]) - mesh.shape.position(0, [-1.0, 0.0, 0.0]);
        assert!(along.normalize().z.abs() > 0.999);
    }
    let found = surface.wall(&growth(&surface, None), None).unwrap();
    assert_eq!(found.hexes.len(), 4 * 18);
    let error = surface
        .wall(&growth(&surface, Some(5)), None)
        .err()
        .unwrap()
        .to_string();
    assert!(error.ends_with("possible are 1, 2, 3, 4"), "{error}");
}

#[test]
fn normals_and_radii_of_a_tube_are_those_of_a_cylinder() {
    let surface = tube(24, 12);
    let normals = surface.normals(3);
    for (x, n) in surface.quads.points.iter().zip(&normals) {
        let exact = Vec3::new(x.x, x.y, 0.0) / 3.0;
        assert!((n - exact).norm() < 1e-12, "{n:?}");
    }
    for radius in surface.radii(&normals) {
        assert!((radius - 3.0).abs() < 1e-12, "{radius}");
    }
}

/// Those of a bent tube that narrows, found by the points nearest to balls, are the least of all points.
#[test]
fn radii_are_the_least_of_all_pairs_of_points() {
    let mut surface = tube(16, 20);
    for x in &mut surface.quads.points {
        let r = 1.0 - 0.08 * x.z;
        *x = Vec3::new(r * x.x + 0.1 * x.z * x.z, r * x.y, x.z);
    }
    let normals = surface.normals(4);
    let points = &surface.quads.points;
    let found = surface.radii(&normals);
    for ((x, n), found) in points.iter().zip(&normals).zip(&found) {
        let of = |y: &Vec3| {
            let d = y - x;
            let depth = -d.dot(n);
            (depth > 1e-9 * d.norm()).then(|| d.norm_squared() / (2.0 * depth))
        };
        let least = points.iter().filter_map(of).fold(f64::INFINITY, f64::min);
        assert!((found / least - 1.0).abs() < 1e-12, "{found} {least}");
    }
    let [least, most] = [f64::min, f64::max].map(|of| found.iter().copied().reduce(of).unwrap());
    assert!(
        (0.3..0.6).contains(&least) && (2.5..3.5).contains(&most),
        "{least} {most}"
    );
}

/// All inner points of the groups lie on the wall that is made of them.
#[test]
fn the_inner_side_passes_through_all_points() {
    let surface = tube(24, 12);
    let mesh = surface.wall(&growth(&surface, Some(4)), None).unwrap();
    let mut seen = 0;
    for &(element, _) in &mesh.surfaces["inner"] {
        for i in 0..=4 {
            for j in 0..=4 {
                let xi = [i, j].map(|k| 0.5 * f64::from(k) - 1.0);
                let x = mesh.shape.position(element, [xi[0], xi[1], -1.0]);
                let near = |y: &&Vec3| (*y - x).norm() < 1e-12;
                seen += usize::from(surface.quads.points.iter().any(|y| near(&y)));
            }
        }
    }
    assert_eq!(seen, 18 * 25);
}

/// Between the points of the faces as well, and rims stay in their planes.
#[test]
fn on_a_known_lumen_all_of_the_inner_side_lies() {
    let surface = tube(16, 8);
    let line = CentreLine::new(&[Vec3::zeros(), Vec3::z() * 8.0], &[3.0, 3.0]);
    let lumen = Lumen::new(vec![line], None);
    let off = |lumen: Option<&Lumen>| {
        let mesh = surface.wall(&growth(&surface, Some(2)), lumen).unwrap();
        let sides = ["inner", "outer"].map(|side| {
            let off = mesh.surfaces[side].iter().flat_map(|&(element, face)| {
                let radius = if face.upper { 3.75 } else { 3.0 };
                let xi = (0..81).map(|k| [k % 9, k / 9].map(|i| 0.25 * f64::from(i) - 1.0));
                let shape = &mesh.shape;
                xi.map(move |[a, b]| {
                    let x = shape.position(element, [a, b, if face.upper { 1.0 } else { -1.0 }]);
                    (x.x.hypot(x.y) - radius).abs()
                })
            });
            off.fold(0.0f64, f64::max)
        });
        let on_rim = mesh.surfaces["right"].iter().flat_map(|&(element, face)| {
            let along = |k: usize| 0.5 * k as f64 - 1.0;
            let end = if face.upper { 1.0 } else { -1.0 };
            let xi = (0..5).map(move |k| match face.axis {
                0 => [end, along(k), -1.0],
                _ => [along(k), end, -1.0],
            });
            let shape = &mesh.shape;
            xi.map(move |xi| (shape.position(element, xi).z - 8.0).abs())
        });
        (sides, on_rim.fold(0.0, f64::max))
    };
    let ([inner, _], _) = off(None);
    assert!((1e-3..4e-3).contains(&inner), "{inner:.2e}");
    let ([inner, outer], rim) = off(Some(&lumen));
    assert!((1e-6..1e-4).contains(&inner), "{inner:.2e}");
    assert!(outer < 4e-3, "{outer:.2e}");
    assert!(rim < 1e-14, "{rim:.2e}");
}

/// On a tube the potential is linear along it.
#[test]
fn the_axes_of_a_tube_run_along_it() {
    let surface = tube(24, 12);
    let normals = surface.normals(0);
    let [left, right] = ["left", "right"].map(|name| vec![name.to_owned()]);
    let potential = surface.potential_between(&left, &right).unwrap();
    let axes = surface.gradients(&potential, &normals);
    for axis in &axes {
        assert!((axis - Vec3::z()).norm() < 1e-8, "{axis:?}");
    }
    assert_eq!(surface.potential_between(&left, &["top".to_owned()]), None);
    let grown = Growth {
        axes: Some(axes),
        ..growth(&surface, Some(3))
    };
    let mesh = surface.wall(&grown, None).unwrap();
    // Whatever the tangents of an element are.
    let tangents = mesh.directions.tangents(
        5,
        [0.3, -0.2, 0.9],
        Vec3::new(0.0, 1.0, 1.0),
        Vec3::new(0.0, -1.0, 1.0),
    );
    assert!(
        (tangents[0] - Vec3::z()).norm() < 1e-8
            && (tangents[1] - Vec3::x().cross(&Vec3::z())).norm() < 1e-8
    );
}
