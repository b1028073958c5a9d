//! The load on its way from the fluid's faces to the wall: its force arrives whatever the two meshes look like.

use fsi_driver::Vec3;
use fsi_driver::case::Material;
use fsi_driver::coupling::transfer::Transfer;
use fsi_driver::fluid::FluidInterface;
use fsi_driver::geometry::WallFile;
use fsi_driver::pfem::solution::newton::NewtonOptions;
use fsi_driver::pfem::supports::Support;
use fsi_driver::pfem::{Solid, Space, SpaceKind, Structure, StructureOptions, discretization};
use std::fmt::Write;

/// A plate of 1 m by 1 m, 0.1 m thick, of these elements along and across; its lower side is wet.
fn plate(elements: [usize; 2], degree: usize) -> Structure {
    let [nx, ny] = elements;
    let mut text = String::from("*NODE\n");
    let tag = |i: usize, j: usize, k: usize| 1 + i + (nx + 1) * (j + (ny + 1) * k);
    for (k, z) in [0.0, 0.1].into_iter().enumerate() {
        for j in 0..=ny {
            for i in 0..=nx {
                let (x, y) = (i as f64 / nx as f64, j as f64 / ny as f64);
                writeln!(text, "{}, {x}, {y}, {z}", tag(i, j, k)).unwrap();
            }
        }
    }
    text += "*ELEMENT, TYPE=C3D8, ELSET=plate\n";
    for j in 0..ny {
        for i in 0..nx {
            let around =
                |k| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| tag(i, j, k));
            let corners = [around(0), around(1)].concat();
            let corners: Vec<String> = corners.iter().map(usize::to_string).collect();
            writeln!(text, "{}, {}", 1 + i + nx * j, corners.join(", ")).unwrap();
        }
    }
    text += "*SURFACE, NAME=wet\nplate, S1\n";
    let file = tempfile::Builder::new().suffix(".inp").tempfile().unwrap();
    std::fs::write(file.path(), text).unwrap();
    let mesh = WallFile::read(file.path()).unwrap();
    let mesh = mesh.mesh(1.0, &["wet".into()], |_| Ok(0)).unwrap();
    let options = StructureOptions {
        discretization: discretization::Options::new(Space::isotropic(SpaceKind::Trunk, degree)),
        density: 1000.0,
        damping: 0.0,
        time_scheme: Default::default(),
        load: Default::default(),
        newton: NewtonOptions::default(),
        wet_surface: fsi_driver::geometry::WET.into(),
        supports: vec![Support::Clamped(fsi_driver::geometry::WET.into())],
        outer_pressure: None,
        gravity: None,
    };
    let rubber = Material::NeoHooke {
        mu: 1e5,
        kappa: 1e6,
        viscosity: None,
    };
    Structure::new(&mesh, &[rubber], &options).unwrap()
}

/// Faces below the plate between x from `begin` to `end`, in rows; every second row is shifted by a share of a face's
/// length.
fn faces(
    begin: f64,
    end: f64,
    [nx, ny]: [usize; 2],
    shift: f64,
    triangles: bool,
) -> FluidInterface {
    let mut fluid = FluidInterface {
        points: vec![],
        faces: vec![],
        face_centres: vec![],
    };
    let mut add = |corners: &[[f64; 2]]| {
        // The fluid lies below: normals point up. Faces share their corners.
        let points: Vec<Vec3> = (corners.iter())
            .map(|[x, y]| Vec3::new(*x, *y, 0.0))
            .collect();
        let centre = points.iter().sum::<Vec3>() / points.len() as f64;
        let number = |x: &Vec3| {
            let known = fluid.points.iter().position(|y| (x - y).norm() < 1e-9);
            known.unwrap_or_else(|| {
                fluid.points.push(*x);
                fluid.points.len() - 1
            }) as u32
        };
        fluid.faces.push(points.iter().map(number).collect());
        fluid.face_centres.push(centre);
    };
    for j in 0..ny {
        let (low, high) = (j as f64 / ny as f64, (j + 1) as f64 / ny as f64);
        let length = (end - begin) / nx as f64;
        let offset = if j % 2 == 1 { shift * length } else { 0.0 };
        let mut cuts: Vec<f64> = (0..=nx)
            .map(|i| begin + i as f64 * length + offset)
            .filter(|x| *x < end - 1e-9)
            .collect();
        if offset > 0.0 {
            cuts.insert(0, begin);
        }
        cuts.push(end);
        for pair in cuts.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            match triangles {
                true => {
                    add(&[[a, low], [b, low], [b, high]]);
                    add(&[[a, low], [b, high], [a, high]]);
                }
                false => add(&[[a, low], [b, low], [b, high], [a, high]]),
            }
        }
    }
    fluid
}

/// Any numbers from -1 to 1, the same each time.
fn noise(i: usize) -> f64 {
    (12.9898 * (i as f64 + 1.0)).sin() * 43758.5453 % 1.0
}

#[test]
fn the_force_arrives_whatever_the_meshes() {
    let coarse = plate([2, 1], 4);
    let fine = plate([9, 7], 2);
    for (what, fluid) in [
        ("one cell deep", faces(0.0, 1.0, [20, 1], 0.0, false)),
        (
            "one cell deep, 200 times as deep as long",
            faces(0.0, 1.0, [200, 1], 0.0, false),
        ),
        ("two deep", faces(0.0, 1.0, [60, 2], 0.0, false)),
        (
            "in rows like bricks, 25 times as long as wide",
            faces(0.0, 1.0, [2, 50], 0.5, false),
        ),
        ("crossing the elements", faces(0.0, 1.0, [7, 5], 0.3, false)),
        ("a single one", faces(0.0, 1.0, [1, 1], 0.0, false)),
        ("triangles", faces(0.0, 1.0, [13, 3], 0.4, true)),
        (
            "on a part of the plate",
            faces(0.13, 0.77, [11, 2], 0.0, false),
        ),
        (
            "on less than an element",
            faces(0.03, 0.2, [3, 1], 0.0, true),
        ),
    ] {
        for solid in [&coarse, &fine] {
            let (transfer, common) = Transfer::conserving(&fluid, solid).unwrap();
            let at_rest = vec![Vec3::zeros(); fluid.points.len()];
            let areas = transfer.face_areas(&at_rest);
            let wet = solid.wet_points();
            // The fluid's force and the wall's, and the largest of the wall's loads.
            let forces = |tractions: &[Vec3]| {
                let load = transfer.load(tractions, &areas);
                let on_wall = load.pressure.iter().zip(&load.shear).zip(wet);
                let on_wall =
                    on_wall.map(|((p, shear), point)| (shear - *p * point.normal) * point.area);
                let by_fluid = tractions
                    .iter()
                    .zip(&areas)
                    .map(|(t, area)| t * area.norm());
                let most = load
                    .pressure
                    .iter()
                    .fold(0.0, |most: f64, p| most.max(p.abs()));
                (by_fluid.sum::<Vec3>(), on_wall.sum::<Vec3>(), most)
            };
            let size: f64 = areas.iter().map(|area| area.norm()).sum();
            let rough: Vec<Vec3> = (0..areas.len())
                .map(|i| Vec3::new(noise(3 * i), noise(3 * i + 1), noise(3 * i + 2)))
                .collect();
            let (by_fluid, on_wall, most) = forces(&rough);
            assert!(
                (by_fluid - on_wall).norm() < 1e-12 * size,
                "{what}: {by_fluid} and {on_wall}"
            );
            assert!(most < 12.0, "{what}: {most}");
            // A pressure of 1 Pa stays 1 Pa, where it acts.
            let even = vec![Vec3::z(); areas.len()];
            let (by_fluid, on_wall, most) = forces(&even);
            assert!((by_fluid - on_wall).norm() < 1e-12 * size, "{what}");
            assert!(
                (most - 1.0).abs() < 1e-12 || common.uncovered() > 0.2,
                "{what}: {most}"
            );
            let bare = 1.0 - size;
            assert!(
                (common.uncovered() - bare).abs() < 1e-9,
                "{what}: {} of {bare}",
                common.uncovered()
            );
        }
    }
}

/// Fields that are linear in the two directions of the plate keep their values.
#[test]
fn linear_loads_keep_their_values() {
    for (solid, fluid) in [
        (plate([3, 2], 3), faces(0.0, 1.0, [40, 2], 0.0, false)),
        (plate([5, 5], 2), faces(0.0, 1.0, [7, 6], 0.0, false)),
        (plate([7, 5], 2), faces(0.0, 1.0, [3, 3], 0.0, true)),
    ] {
        let (transfer, _) = Transfer::conserving(&fluid, &solid).unwrap();
        let areas = transfer.face_areas(&vec![Vec3::zeros(); fluid.points.len()]);
        let field = |x: &Vec3| 3.0 + 2.0 * x.x - x.y;
        let tractions: Vec<Vec3> = fluid
            .face_centres
            .iter()
            .map(|x| field(x) * Vec3::z())
            .collect();
        let load = transfer.load(&tractions, &areas);
        for (p, point) in load.pressure.iter().zip(solid.wet_points()) {
            let error = (p - field(&point.position)).abs();
            assert!(error < 1e-9, "{error:e} at {}", point.position.transpose());
        }
    }
}

#[test]
fn meshes_of_other_units_and_other_walls_are_refused() {
    let solid = plate([2, 2], 2);
    let refused = |fluid: &FluidInterface| {
        Transfer::conserving(fluid, &solid)
            .err()
            .unwrap()
            .to_string()
    };
    let scaled = |factor: f64| {
        let mut fluid = faces(0.0, 1.0, [10, 10], 0.0, false);
        fluid
            .points
            .iter_mut()
            .chain(&mut fluid.face_centres)
            .for_each(|x| *x *= factor);
        fluid
    };
    for (factor, words) in [
        (
            1e-3,
            "times as large as the fluid: the wall seems to be in millimetres, the fluid in metres",
        ),
        (
            1e-2,
            "89 times as large as the fluid: the wall seems to be in centimetres",
        ),
        (
            1e3,
            "times as large as the wall: the fluid seems to be in millimetres, the wall in metres",
        ),
    ] {
        let text = refused(&scaled(factor));
        assert!(text.contains(words), "{text}");
    }
    let mut turned = scaled(1.0);
    turned.faces.iter_mut().for_each(|face| face.reverse());
    let text = refused(&turned);
    assert!(
        text.contains("100.0 % of the wall's wet surface has no face of the fluid next to it"),
        "{text}"
    );
}
