//! Tissue around a vessel: values that vary along it, and springs that hold all directions.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset};
use fsi_driver::pfem::Solid;
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
