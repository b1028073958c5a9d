//! Spaces and elements: polynomials reproduced, continuity across turned neighbours, patch test, consistent tangents.

use crate::pfem_support::{Numbers, artery, distorted_box};
use fsi_driver::case::Material;
use fsi_driver::geometry::{HexMesh, tube_mesh};
use fsi_driver::pfem::discretization::{Discretization, Options};
use fsi_driver::pfem::element::mapping::MappingKind;
use fsi_driver::pfem::element::surface::{LoadKind, Surface};
use fsi_driver::pfem::solution::statics::{self, StaticOptions};
use fsi_driver::pfem::space::shapes::Shapes;
use fsi_driver::pfem::supports::{self, Direction, Foundation, Profile, Support};
use fsi_driver::pfem::{Formulation, Space, SpaceKind, SurfaceLoad};
use fsi_driver::{Mat3, Vec3};

const KINDS: [SpaceKind; 2] = [SpaceKind::Trunk, SpaceKind::TensorProduct];

const FORMULATIONS: [Formulation; 2] = [Formulation::Displacement, Formulation::Mixed];

fn discretize(mesh: &HexMesh, space: Space, supports: &[Support]) -> Discretization {
    discretize_in(Formulation::default(), mesh, space, supports)
}

fn discretize_in(
    formulation: Formulation,
    mesh: &HexMesh,
    space: Space,
    supports: &[Support],
) -> Discretization {
    let materials = vec![
        Material::NeoHooke {
            mu: 1.0,
            kappa: 50.0,
            viscosity: None,
        };
        2
    ];
    let options = Options {
        mapping: MappingKind::Blended(1),
        formulation,
        ..Options::new(space)
    };
    Discretization::new(mesh, &materials, supports, &options).unwrap()
}

#[test]
fn spaces_reproduce_their_polynomials() {
    let axis: Vec<f64> = (0..8).map(|i| -1.0 + 2.0 * i as f64 / 7.0).collect();
    for (kind, p) in KINDS
        .into_iter()
        .flat_map(|kind| [1, 2, 3, 4, 6].map(|p| (kind, p)))
    {
        let space = Space::isotropic(kind, p);
        let modes = space.modes();
        let shapes = Shapes::new(&modes, &space, [&axis, &axis, &axis]);
        let matrix =
            nalgebra::DMatrix::from_column_slice(modes.len(), shapes.points, &shapes.values);
        let normal = (&matrix * matrix.transpose())
            .cholesky()
            .expect("independent modes");
        let powers =
            (0..=p).flat_map(|a| (0..=p).flat_map(move |b| (0..=p).map(move |c| [a, b, c])));
        for [a, b, c] in powers {
            if kind == SpaceKind::Trunk && a + b + c > p {
                continue;
            }
            let value = |n: usize| {
                let x = [axis[n % 8], axis[n / 8 % 8], axis[n / 64]];
                x[0].powi(a as i32) * x[1].powi(b as i32) * x[2].powi(c as i32)
            };
            let values = nalgebra::DVector::from_fn(shapes.points, |n, _| value(n));
            let coefficients = normal.solve(&(&matrix * &values));
            let error = (matrix.transpose() * coefficients - values).amax();
            assert!(
                error < 1e-10,
                "{kind:?} {p}: x^{a} y^{b} z^{c}, error {error:e}"
            );
        }
    }
}

#[test]
fn displacement_is_continuous_across_turned_neighbours() {
    let mesh = distorted_box([2, 2, 2], 0.2, true);
    let mut numbers = Numbers(3);
    let anisotropic = KINDS.map(|kind| Space {
        kind,
        degrees: [6, 3, 4],
    });
    let isotropic = KINDS.map(|kind| Space::isotropic(kind, 6));
    for space in anisotropic.into_iter().chain(isotropic) {
        let body = discretize(&mesh, space, &[Support::Vertex(0, [true; 3])]);
        let d = numbers.vector(body.coefficients(), 1.0);
        // Values at a lattice of all elements, by position.
        let axis = [-1.0, -0.6, 0.0, 0.6, 1.0];
        let mut values: std::collections::BTreeMap<[i64; 3], Vec<Vec3>> = Default::default();
        for e in 0..mesh.hexes.len() {
            for xi in fsi_driver::pfem::element::mapping::lattice([&axis, &axis, &axis]) {
                let x = body.mapping.at(e, xi).position;
                let key: [i64; 3] = std::array::from_fn(|i| (x[i] * 1e9).round() as i64);
                values
                    .entry(key)
                    .or_default()
                    .push(body.displacement_at(e, xi, &d));
            }
        }
        let mut shared = 0;
        for same in values.values().filter(|v| v.len() > 1) {
            shared += 1;
            assert!(
                same.iter().all(|u| (u - same[0]).norm() < 1e-12),
                "{space:?}: {same:?}"
            );
        }
        // Three inner planes of 9 by 9 points that cross each other.
        assert_eq!(shared, 3 * 81 - 3 * 9 + 1);
    }
}

#[test]
fn patch_test_of_a_large_affine_deformation() {
    let mesh = distorted_box([2, 2, 2], 0.2, true);
    let gradient = Mat3::new(1.3, 0.2, -0.1, 0.1, 0.9, 0.3, 0.0, -0.2, 1.1);
    let choices = KINDS
        .into_iter()
        .flat_map(|kind| [1, 2, 4].map(|p| (kind, p)))
        .flat_map(|(kind, p)| FORMULATIONS.map(|formulation| (kind, p, formulation)));
    for (kind, p, formulation) in choices {
        let space = Space::isotropic(kind, p);
        let supports = [Support::Clamped("boundary".into())];
        let body = discretize_in(formulation, &mesh, space, &supports);
        let mut exact = vec![0.0; body.coefficients()];
        for (v, &f) in body.numbering.of_vertex.iter().enumerate() {
            let u = (gradient - Mat3::identity()) * mesh.vertices[v];
            (0..3).for_each(|i| exact[3 * f + i] = u[i]);
        }
        let options = StaticOptions {
            steps: 3,
            ..Default::default()
        };
        let result = statics::solve(&body, &[], Some(&exact), &options).unwrap();
        let error = (0..exact.len())
            .map(|i| (result.displacement[i] - exact[i]).abs())
            .fold(0.0, f64::max);
        assert!(error < 1e-11, "{kind:?} {p} {formulation:?}: {error:e}");
        let volume = gradient.determinant();
        let density =
            0.5 * (gradient.norm_squared() - 3.0) - volume.ln() + 25.0 * volume.ln().powi(2);
        let energy = body.energy(&result.displacement, [p + 2; 3]).unwrap();
        assert!((energy / density - 1.0).abs() < 1e-11);
    }
}

#[test]
fn tangent_is_the_derivative_of_the_forces_and_symmetric() {
    let mesh = tube_mesh(3e-3, &[5e-4, 5e-4], 6e-3, 2, 4, 1);
    let supports = [
        Support::Clamped("start".into()),
        Support::Surface("end".into(), [true, false, false]),
        // As stiff as the wall.
        Support::Foundation(Foundation {
            surface: "outer".into(),
            spring: Profile(vec![(0.0, 1e12), (3e-3, 3e12)]),
            damping: Profile::default(),
            direction: Direction::Radial,
            ..Foundation::default()
        }),
    ];
    let choices = KINDS
        .into_iter()
        .flat_map(|kind| FORMULATIONS.map(|formulation| (kind, formulation)));
    for (kind, formulation) in choices {
        let space = Space {
            kind,
            degrees: [3, 4, 2],
        };
        let options = Options {
            formulation,
            ..Options::new(space)
        };
        let body = Discretization::new(&mesh, &artery(), &supports, &options).unwrap();
        let faces = supports::surface(&mesh, "inner").unwrap();
        let surface = Surface::new(&body.numbering, &space, &body.mapping, faces, 9).unwrap();
        let points = surface.points.len();
        // So large a pressure that its stiffness matters compared with that of a nearly incompressible wall.
        let load = SurfaceLoad::uniform_pressure(1e9, points);
        let mut numbers = Numbers(5);
        let project =
            |v: Vec<f64>| body.moved(&vec![0.0; body.coefficients()], &body.restrict(&v), 1.0);
        let d = project(numbers.vector(body.coefficients(), 2e-5));
        let direction = project(numbers.vector(body.coefficients(), 1e-5));
        let forces = |h: f64| {
            let d: Vec<f64> = d.iter().zip(&direction).map(|(d, e)| d + h * e).collect();
            let mut external = vec![0.0; d.len()];
            surface.add_forces(
                &body.numbering,
                &d,
                &load,
                LoadKind::Follower,
                &mut external,
            );
            let internal = body.internal_forces(&d).unwrap();
            body.restrict(
                &internal
                    .iter()
                    .zip(&external)
                    .map(|(i, e)| i - e)
                    .collect::<Vec<_>>(),
            )
        };
        // Forces are the derivative of the energy.
        let moved =
            |h: f64| -> Vec<f64> { d.iter().zip(&direction).map(|(d, e)| d + h * e).collect() };
        let energy = |h: f64| {
            let elements = body.energy(&moved(h), options.quadrature_points).unwrap();
            elements + body.spring_energy(&moved(h))
        };
        let h = 1e-2;
        let difference = 8.0 * (energy(h) - energy(-h)) - (energy(2.0 * h) - energy(-2.0 * h));
        let internal = body.internal_forces(&d).unwrap();
        let power: f64 = internal.iter().zip(&direction).map(|(f, e)| f * e).sum();
        let error = difference / (12.0 * h) / power - 1.0;
        assert!(error.abs() < 1e-8, "{kind:?} {formulation:?}: {error:e}");
        let values: [Vec<f64>; 4] = [-2.0, -1.0, 1.0, 2.0].map(|k| forces(k * h));
        let slope: Vec<f64> = (0..values[0].len())
            .map(|i| {
                (8.0 * (values[2][i] - values[1][i]) - (values[3][i] - values[0][i])) / (12.0 * h)
            })
            .collect();
        let mut tangent = body.tangent(&d, None, &[(&surface, &load)]).unwrap();
        body.pattern.hold(&mut tangent);
        let matrix = body.pattern.matrix(&tangent);
        let x = body.restrict(&direction);
        let mut product = vec![0.0; x.len()];
        for column in 0..x.len() {
            for (&row, value) in matrix
                .symbolic()
                .row_idx_of_col_raw(column)
                .iter()
                .zip(matrix.val_of_col(column))
            {
                product[row] += value * x[column];
                if row != column {
                    product[column] += value * x[row];
                }
            }
        }
        let norm = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let error: Vec<f64> = product.iter().zip(&slope).map(|(a, b)| a - b).collect();
        let error = norm(&error) / norm(&slope);
        assert!(error < 1e-8, "{kind:?} {formulation:?}: {error:e}");
    }
}

#[test]
fn a_free_rigid_motion_is_named() {
    let mesh = tube_mesh(3e-3, &[1e-3], 6e-3, 2, 4, 1);
    let slide = |name: &str| Support::Surface(name.into(), [true, false, false]);
    let check = |supports: &[Support]| {
        let body = discretize(&mesh, Space::isotropic(SpaceKind::Trunk, 2), supports);
        body.check_rigid_motions().map_err(|e| e.to_string())
    };
    let ends = [slide("start"), slide("end")];
    let message =
        check(&[ends[0].clone(), ends[1].clone(), Support::SymmetryPlane(1)]).unwrap_err();
    assert!(message.contains("translation along z"), "{message}");
    let turning = [Support::Vertex(0, [true; 3])];
    assert!(check(&turning).unwrap_err().contains("rotation"));
    let held = [
        ends.to_vec(),
        vec![Support::SymmetryPlane(1), Support::SymmetryPlane(2)],
    ]
    .concat();
    check(&held).unwrap();
    check(&[Support::Clamped("start".into())]).unwrap();
    // Radial springs leave a tube free to slide along its axis and to turn about it.
    let springs = |direction| {
        Support::Foundation(Foundation {
            surface: "outer".into(),
            spring: Profile::constant(1e6),
            direction,
            ..Foundation::default()
        })
    };
    let radial = springs(Direction::Radial);
    let message = check(std::slice::from_ref(&radial)).unwrap_err();
    assert!(message.contains("along x") || message.contains("axis parallel to x"));
    let message = check(&[radial, ends[0].clone()]).unwrap_err();
    assert!(message.contains("axis parallel to x"), "{message}");
    check(&[springs(Direction::All)]).unwrap();
}
