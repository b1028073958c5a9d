//! Tissue around a vessel: values that vary along it, and springs that hold all directions.

use crate::pfem_support::{Numbers, artery};
use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset};
use fsi_driver::curve::{Bend, Frame, SpaceCurve};
use fsi_driver::geometry::supports::AlongLine;
use fsi_driver::geometry::tube_mesh;
use fsi_driver::pfem::discretization::Options;
use fsi_driver::pfem::supports::{AtRest, Direction, Foundation, Profile, Support};
use fsi_driver::pfem::{Discretization, Solid, Space, SpaceKind};
use fsi_driver::simulation::assembly::{CoupledModel, Workplace};

/// Displacement of the lumen's surface, m, at two places of the artery under 10 kPa.
fn displacement(tissue: &[(&str, &str)]) -> [Vec3; 2] {
    let state = [
        ("initial.start", "equilibrium"),
        ("windkessel.initial_pressure_Pa", "1e4"),
        ("fluid.solver", "native"),
        ("fluid.native.degree", "3"),
        ("fluid.native.core", "1"),
        ("coupling.surrogate", "none"),
    ];
    let settings = state.iter().chain(tissue);
    let settings: Vec<_> = settings
        .map(|(key, value)| (key.to_string(), value.to_string()))
        .collect();
    let case = Case::load("tests/cases/S-0.0".as_ref(), Preset::Demo, &settings).unwrap();
    let solid = CoupledModel::new(&case, Workplace::default(), None)
        .unwrap()
        .coupling
        .solid;
    let places = [0.0375, 0.0525].map(|x| Vec3::new(x, 3.2e-3, 0.0));
    let moved = solid.accepted_displacement(&solid.locate(&places).unwrap());
    [moved[0], moved[1]]
}

#[test]
fn springs_hold_where_they_stand_and_in_their_directions() {
    let spring = ("surroundings.spring_Pa_m", "2e7");
    let none = displacement(&[]);
    let even = displacement(&[spring]);
    let rising = displacement(&[
        spring,
        ("surroundings.stations_m", "[0.03, 0.06]"),
        ("surroundings.shares", "[0.0, 1.0]"),
    ]);
    // The share of what even springs take away: at a quarter of them and at three quarters.
    let taken = [0, 1].map(|i| (none[i].y - rising[i].y) / (none[i].y - even[i].y));
    println!("{none:?} {even:?} {taken:?}");
    // Measured: 1.127 mm, 0.457 mm; 0.318 and 0.837.
    assert!((none[0].y / 1.127e-3 - 1.0).abs() < 0.01);
    assert!((even[0].y / 4.566e-4 - 1.0).abs() < 0.01);
    assert!((taken[0] - 0.3179).abs() < 0.01, "{taken:?}");
    assert!((taken[1] - 0.837).abs() < 0.01, "{taken:?}");
    let all = displacement(&[spring, ("surroundings.direction", "all")]);
    // Measured: 0.0306 of the displacement along, 0.9917 of that across.
    let [along, across] = [all[0].x / even[0].x, all[0].y / even[0].y];
    println!("{along} {across}");
    assert!((along - 0.0306).abs() < 0.003, "{along}");
    assert!((across - 0.9917).abs() < 0.003, "{across}");
}

/// Around a centre-line that bends next to the wall, and from a state of rest that is not the reference configuration.
#[test]
fn springs_around_a_curve_derive_from_their_energy() {
    let mesh = tube_mesh(3e-3, &[5e-4, 5e-4], 6e-3, 2, 4, 1);
    let bend = Bend::helix(5e-3, 20e-3, 0.3);
    let start = Frame::new(
        Vec3::new(-2e-3, 1e-3, 0.0),
        Vec3::new(1.0, -0.1, 0.2),
        Vec3::y(),
    );
    let line = SpaceCurve::of_pieces(start, &[(20e-3, bend)]);
    let options = Options::new(Space::isotropic(SpaceKind::Trunk, 3));
    let clamped = Support::Clamped("start".into());
    let bare = Discretization::new(&mesh, &artery(), std::slice::from_ref(&clamped), &options);
    let bare = bare.unwrap();
    for direction in [
        Direction::Radial,
        Direction::Axial,
        Direction::Tangential,
        Direction::All,
    ] {
        let springs = Foundation {
            surface: "outer".into(),
            spring: Profile(vec![(0.0, 1e9), (6e-3, 3e9)]),
            direction,
            at_rest: AtRest::Loaded,
            axis: Some(std::sync::Arc::new(AlongLine(line.clone()))),
            ..Foundation::default()
        };
        let supports = [clamped.clone(), Support::Foundation(springs)];
        let mut body = Discretization::new(&mesh, &artery(), &supports, &options).unwrap();
        let mut numbers = Numbers(11);
        let mut random = |size: f64| {
            let all = numbers.vector(body.coefficients(), size);
            body.moved(&vec![0.0; all.len()], &body.restrict(&all), 1.0)
        };
        let (rest, d, along) = (random(1e-4), random(1e-4), random(1e-4));
        let forces = |body: &Discretization, d: &[f64]| {
            let [with, without] =
                [body, &bare].map(|body| body.restrict(&body.internal_forces(d).unwrap()));
            with.iter()
                .zip(without)
                .map(|(a, b)| a - b)
                .collect::<Vec<f64>>()
        };
        let size = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        // Nothing is exerted before the state of rest is known, and in it.
        assert_eq!(size(&forces(&body, &d)), 0.0, "{direction:?}");
        body.set_tissue_at_rest(&rest);
        assert_eq!(size(&forces(&body, &rest)), 0.0, "{direction:?}");
        let at = |h: f64| -> Vec<f64> { d.iter().zip(&along).map(|(d, e)| d + h * e).collect() };
        let h = 1e-3;
        let power = (body.spring_energy(&at(h)) - body.spring_energy(&at(-h))) / (2.0 * h);
        let here = forces(&body, &d);
        let exact: f64 = here
            .iter()
            .zip(body.restrict(&along))
            .map(|(f, e)| f * e)
            .sum();
        assert!(
            (power / exact - 1.0).abs() < 1e-6,
            "{direction:?}: {power:e} {exact:e}"
        );
        let [low, high] = [-h, h].map(|h| forces(&body, &at(h)));
        let slope: Vec<f64> = (low.iter().zip(&high))
            .map(|(a, b)| (b - a) / (2.0 * h))
            .collect();
        let [with, without] = [&body, &bare].map(|b| b.tangent(&d, None, &[]).unwrap());
        let mut tangent: Vec<f64> = with.iter().zip(without).map(|(a, b)| a - b).collect();
        body.pattern.hold(&mut tangent);
        let (matrix, x) = (body.pattern.matrix(&tangent), body.restrict(&along));
        let mut image = vec![0.0; x.len()];
        for column in 0..x.len() {
            let rows = matrix.symbolic().row_idx_of_col_raw(column).iter();
            for (&row, value) in rows.zip(matrix.val_of_col(column)) {
                image[row] += value * x[column];
                if row != column {
                    image[column] += value * x[row];
                }
            }
        }
        let error: Vec<f64> = image.iter().zip(&slope).map(|(a, b)| a - b).collect();
        let error = size(&error) / size(&slope);
        println!("{direction:?}: {error:e}");
        assert!(error < 1e-6, "{direction:?}: {error:e}");
    }
}

/// A straight artery in tissue under 10 kPa, along x and along a line of points that looks elsewhere: how far a point
/// of its lumen moves away from the axis and along it, m.
fn of_a_line(towards: Option<Vec3>) -> [f64; 2] {
    let folder = tempfile::tempdir().unwrap();
    let axis = towards.unwrap_or(Vec3::x());
    let line = match towards {
        None => "[[vessel.piece]]\npiece = \"line\"\nlength_m = 12e-3\n".to_owned(),
        Some(axis) => {
            let points = (0..7).map(|i| axis * (2e-3 * f64::from(i)));
            let rows: String = points
                .map(|x| format!("{},{},{}\n", x.x, x.y, x.z))
                .collect();
            std::fs::write(folder.path().join("line.csv"), format!("x,y,z\n{rows}")).unwrap();
            String::new()
        }
    };
    let file = match towards {
        None => "",
        Some(_) => "centre_line = \"line.csv\"\nunit = \"m\"\n",
    };
    let text = format!("extends = \"defaults\"\n[vessel]\nradius_m = 3e-3\n{file}{line}{WALL}");
    std::fs::write(folder.path().join("case.toml"), text).unwrap();
    let case = Case::load(folder.path(), Preset::Paper, &[]).unwrap_or_else(|e| panic!("{e}"));
    let model = CoupledModel::new(&case, Workplace::default(), None).unwrap();
    let solid = model.coupling.solid;
    // At the same place of the elements.
    let vessel = fsi_driver::geometry::Vessel::new(case.vessel().unwrap());
    let across = vessel.centre_line().frame(4e-3).first;
    let place = axis * 4e-3 + across * 3e-3;
    let moved = solid.accepted_displacement(&solid.locate(&[place]).unwrap())[0];
    [moved.dot(&across), moved.dot(&axis)]
}

const WALL: &str = r#"
[[vessel.section]]
name = "artery"
layers = ["wall"]
thicknesses_m = [0.6e-3]
[[vessel.material]]
name = "wall"
material = "neo_hooke"
mu_Pa = 5e4
kappa_Pa = 1e7
[initial]
start = "equilibrium"
[windkessel]
initial_pressure_Pa = 1e4
[surroundings]
spring_Pa_m = 1e7
axial_spring_Pa_m = 2e7
pressure_Pa = 3e3
stations_m = [0.0, 12e-3]
shares = [0.5, 1.5]
[structure]
axial_per_section = 2
circumferential = 4
[fluid]
solver = "native"
[fluid.native]
degree = 3
core = 1
axial_extension = 1
axial_per_section = 2
[coupling]
surrogate = "none"
"#;

#[test]
fn tissue_follows_the_centre_line_wherever_it_leads() {
    let along_x = of_a_line(None);
    let elsewhere = of_a_line(Some(Vec3::new(0.3, 0.8, -0.5).normalize()));
    println!("{along_x:?} {elsewhere:?}");
    // It moves outwards, and towards the inlet, where the tissue is softer.
    assert!(along_x[0] > 1e-5 && along_x[1].abs() > 1e-7, "{along_x:?}");
    for (a, b) in along_x.iter().zip(elsewhere) {
        assert!((a / b - 1.0).abs() < 1e-6, "{along_x:?} {elsewhere:?}");
    }
}
