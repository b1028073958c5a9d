//! The structure in motion: natural frequencies, conservation of energy, damping, repeatability.

use crate::pfem_support::artery;
use fsi_driver::Vec3;
use fsi_driver::case::Material;
use fsi_driver::geometry::tube_mesh;
use fsi_driver::pfem::discretization::Options;
use fsi_driver::pfem::element::surface::LoadKind;
use fsi_driver::pfem::solution::newton::NewtonOptions;
use fsi_driver::pfem::solution::structure::State;
use fsi_driver::pfem::solution::time_scheme::TimeScheme;
use fsi_driver::pfem::supports::Support;
use fsi_driver::pfem::{Solid, Space, SpaceKind, Structure, StructureOptions, SurfaceLoad};

fn options(p: usize, damping: f64) -> StructureOptions {
    StructureOptions {
        discretization: Options::new(Space::isotropic(SpaceKind::Trunk, p)),
        density: 1100.0,
        damping,
        time_scheme: TimeScheme::Newmark,
        load: LoadKind::default(),
        newton: NewtonOptions::default(),
        wet_surface: "inner".into(),
        supports: vec![
            Support::Clamped("start".into()),
            Support::Clamped("end".into()),
        ],
        outer_pressure: None,
        gravity: None,
    }
}

/// A short tube of one layer, clamped at both ends.
fn short_tube(p: usize, circumferential: usize, damping: f64) -> Structure {
    tube_with(circumferential, &options(p, damping))
}

fn tube_with(circumferential: usize, options: &StructureOptions) -> Structure {
    let mesh = tube_mesh(5e-3, &[1e-3], 2e-2, 2, circumferential, 1);
    let material = Material::SaintVenantKirchhoff {
        youngs_modulus: 3e5,
        poisson_ratio: 0.3,
        viscosity: None,
    };
    Structure::new(&mesh, &[material], options).unwrap()
}

fn no_load(structure: &Structure) -> SurfaceLoad {
    let n = structure.wet_points().len();
    SurfaceLoad::uniform_pressure(0.0, n)
}

/// Total energy at the start and at the end of a free vibration in the first mode.
fn vibrate(mut structure: Structure, periods: usize) -> (f64, f64, f64) {
    let mode = &structure.natural_modes(1).unwrap()[0];
    let largest = mode.shape.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let d: Vec<f64> = mode.shape.iter().map(|x| 1e-7 * x / largest).collect();
    let omega = mode.angular_frequency;
    let a = d.iter().map(|x| -omega * omega * x).collect();
    structure
        .set_state(State {
            v: vec![0.0; d.len()],
            a,
            d,
        })
        .unwrap();
    let energy = |s: &Structure| {
        let state = s.state();
        s.strain_energy(&state.d, [3; 3]).unwrap() + s.kinetic_energy(&state.v)
    };
    let first = energy(&structure);
    let steps = 24;
    let dt = 2.0 * std::f64::consts::PI / omega / steps as f64;
    let load = no_load(&structure);
    for _ in 0..periods * steps {
        let trial = structure.solve(&load, dt, 1e-9, None).unwrap();
        structure.accept(trial);
    }
    (first, energy(&structure), (periods * steps) as f64 * dt)
}

#[test]
fn energy_of_a_free_vibration_is_conserved() {
    let (first, last, _) = vibrate(short_tube(2, 4, 0.0), 100);
    assert!(
        (last / first - 1.0).abs() < 1e-3,
        "{first:e} J, then {last:e} J"
    );
}

/// With linear elasticity and loads on the reference area, displacements are proportional to the pressure, in
/// equilibrium and in motion; a pressure on the deformed area widens the tube more.
#[test]
fn a_load_on_the_reference_area_leaves_a_linear_wall_linear() {
    let mesh = tube_mesh(5e-3, &[1e-3], 2e-2, 2, 4, 1);
    let material = Material::LinearElastic {
        youngs_modulus: 3e5,
        poisson_ratio: 0.3,
    };
    let states = |load, pressure| {
        let options = StructureOptions {
            load,
            ..options(2, 0.0)
        };
        let mut structure =
            Structure::new(&mesh, std::slice::from_ref(&material), &options).unwrap();
        let at_rest = structure.equilibrium(pressure, None).unwrap();
        let load = SurfaceLoad::uniform_pressure(pressure, structure.wet_points().len());
        for _ in 0..3 {
            let trial = structure.solve(&load, 1e-4, 1e-12, None).unwrap();
            structure.accept(trial);
        }
        [at_rest, structure.state().d.clone()]
    };
    for (kind, measured, within) in [
        (LoadKind::Dead, [0.0, 0.0], 5e-9),
        (LoadKind::Follower, [1.42e-2, 1.62e-3], 5e-5),
    ] {
        let [small, large] = [1.0, 1e3].map(|pressure| states(kind, pressure));
        for ((small, large), measured) in small.iter().zip(large).zip(measured) {
            let size = large.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
            let pairs = small.iter().zip(&large);
            let difference = pairs.map(|(s, l)| (1e3 * s - l).abs() / size);
            let difference = difference.fold(0.0, f64::max);
            println!("{kind}: {size:e} m, {difference:e} of it is not linear");
            assert!(
                (difference - measured).abs() < within,
                "{kind}: {difference:e}"
            );
        }
    }
}

#[test]
fn damping_takes_energy_at_its_rate() {
    // Mass-proportional damping α takes α of the energy per time: half of it is kinetic on average.
    let (first, last, time) = vibrate(short_tube(2, 4, 0.01), 100);
    let rate = (first / last).ln() / time;
    assert!((rate / 0.01 - 1.0).abs() < 0.02, "{rate}");
}

#[test]
fn a_viscous_wall_damps_at_the_rate_of_kelvin_and_voigt() {
    // Without Poisson's effect S = E E_Y, so that S_v = η Ė is the elastic stress of the velocity times η/E_Y: damping
    // proportional to the stiffness, which takes η ω²/E_Y of the energy per time.
    let mesh = tube_mesh(5e-3, &[1e-3], 2e-2, 2, 4, 1);
    let (youngs_modulus, viscosity) = (3e5, 0.4);
    let material = Material::SaintVenantKirchhoff {
        youngs_modulus,
        poisson_ratio: 0.0,
        viscosity: Some(viscosity),
    };
    let structure = Structure::new(&mesh, &[material], &options(2, 0.0)).unwrap();
    let omega = structure.natural_modes(1).unwrap()[0].angular_frequency;
    let (first, last, time) = vibrate(structure, 20);
    let rate = (first / last).ln() / time / (viscosity * omega * omega / youngs_modulus);
    println!("{rate} of the rate, {} of the energy is left", last / first);
    // Measured: 0.987.
    assert!((0.982..0.992).contains(&rate), "{rate}");
    assert!(last < 0.9 * first);
}

#[test]
fn implicit_euler_damps_a_vibration_as_theory_says() {
    // Each step divides the energy of x'' = -omega² x by 1 + (omega dt)²: 24 steps per period.
    let options = StructureOptions {
        time_scheme: TimeScheme::ImplicitEuler,
        ..options(2, 0.0)
    };
    let (first, last, _) = vibrate(tube_with(4, &options), 1);
    let angle = 2.0 * std::f64::consts::PI / 24.0;
    let expected = (1.0 + angle * angle).powi(-24);
    assert!(
        (last / first / expected - 1.0).abs() < 1e-4,
        "{} instead of {expected}",
        last / first
    );
}

#[test]
fn damped_newmark_damps_a_vibration_as_one_degree_of_freedom() {
    let options = StructureOptions {
        time_scheme: TimeScheme::DampedNewmark,
        ..options(2, 0.0)
    };
    let (first, last, _) = vibrate(tube_with(4, &options), 1);
    // x'' = -x, beta = 0.3025, gamma = 0.6, solved for the acceleration.
    let (mut x, mut v, mut a, dt) = (1.0_f64, 0.0, -1.0, std::f64::consts::TAU / 24.0);
    for _ in 0..24 {
        let (x_ahead, v_ahead) = (x + dt * v + dt * dt * 0.1975 * a, v + dt * 0.4 * a);
        a = -x_ahead / (1.0 + 0.3025 * dt * dt);
        (x, v) = (x_ahead + 0.3025 * dt * dt * a, v_ahead + 0.6 * dt * a);
    }
    let expected = x * x + v * v;
    println!("{expected} of the energy is left");
    assert!(
        (last / first / expected - 1.0).abs() < 1e-4,
        "{}",
        last / first
    );
}

/// And as one degree of freedom of 24 and of 48 steps per period: second order.
#[test]
fn bossaks_method_damps_a_vibration_as_one_degree_of_freedom() {
    let options = StructureOptions {
        time_scheme: TimeScheme::Bossak,
        ..options(2, 0.0)
    };
    let (first, last, _) = vibrate(tube_with(4, &options), 1);
    // (4/3 a - 1/3 a_old) + x = 0, beta = 4/9, gamma = 5/6, solved for the acceleration.
    let after_a_period = |steps: i32| {
        let dt = std::f64::consts::TAU / f64::from(steps);
        let (mut x, mut v, mut a) = (1.0_f64, 0.0, -1.0);
        for _ in 0..steps {
            let x_ahead = x + dt * v + dt * dt * (1.0 / 18.0) * a;
            let v_ahead = v + dt * (1.0 / 6.0) * a;
            a = (a / 3.0 - x_ahead) / (4.0 / 3.0 + dt * dt * 4.0 / 9.0);
            (x, v) = (
                x_ahead + dt * dt * (4.0 / 9.0) * a,
                v_ahead + dt * (5.0 / 6.0) * a,
            );
        }
        [x, v]
    };
    let [x, v] = after_a_period(24);
    let expected = x * x + v * v;
    println!("{expected} of the energy is left");
    assert!(
        (last / first / expected - 1.0).abs() < 1e-4,
        "{}",
        last / first
    );
    let error = |steps| {
        let [x, v] = after_a_period(steps);
        (x - 1.0).hypot(v)
    };
    let ratio = error(48) / error(96);
    assert!((3.9..4.1).contains(&ratio), "{ratio}");
}

#[test]
fn frequencies_agree_with_a_refined_reference() {
    // The corners of the clamped ends are singular: convergence is algebraic, and from above.
    let coarse = short_tube(6, 4, 0.0).natural_modes(4).unwrap();
    let fine = short_tube(7, 6, 0.0).natural_modes(4).unwrap();
    for (coarse, fine) in coarse.iter().zip(&fine) {
        let ratio = coarse.angular_frequency / fine.angular_frequency;
        assert!(ratio > 1.0 && ratio < 1.01, "{ratio}");
    }
}

#[test]
fn a_step_can_be_repeated_and_a_run_resumed_bit_by_bit() {
    let mesh = tube_mesh(2.35e-3, &[4.5e-4, 4.5e-4], 7.5e-3, 2, 4, 1);
    let new = || Structure::new(&mesh, &artery(), &options(3, 0.01)).unwrap();
    let mut structure = new();
    let load = |s: &Structure, t: f64| SurfaceLoad {
        pressure: s
            .wet_points()
            .iter()
            .map(|p| 2e5 * t * (1.0 + 20.0 * p.position.x))
            .collect(),
        shear: vec![Vec3::new(1.0, 0.0, 0.0); s.wet_points().len()],
    };
    let dt = 2e-3;
    for step in 1..=8 {
        let (far, right) = (
            load(&structure, 4.0 * step as f64 * dt),
            load(&structure, step as f64 * dt),
        );
        structure.solve(&far, dt, 1e-8, None).unwrap();
        let warm = structure.solve(&right, dt, 1e-8, None).unwrap();
        let again = structure.solve(&right, dt, 1e-8, Some(&warm)).unwrap();
        let largest = warm.state.d.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let worst = (warm.state.d.iter().zip(&again.state.d)).map(|(a, b)| (a - b).abs());
        assert!(worst.fold(0.0, f64::max) < 1e-7 * largest);
        structure.accept(again);
    }
    // From here on twice: by a structure with a history, and by a new one with its state.
    let stored = structure.state().clone();
    structure.refresh();
    let mut resumed = new();
    resumed.set_state(stored).unwrap();
    for step in 9..=12 {
        let load = load(&structure, step as f64 * dt);
        for s in [&mut structure, &mut resumed] {
            let trial = s.solve(&load, dt, 1e-8, None).unwrap();
            s.accept(trial);
        }
        assert_eq!(structure.state(), resumed.state());
    }
}

/// Forty steps of an artery under a growing, pulsating pressure, the last ones after the memory was handed over to a
/// new structure if `resume`.
fn pulsate(newton: NewtonOptions, resume: bool) -> (Structure, usize) {
    pulsate_to(newton, 1e-8, 1.0, resume.then_some(33))
}

/// The same with solutions to this relative residual, next to a fluid of so many seconds, handed over before the step
/// `resumed`.
fn pulsate_to(
    newton: NewtonOptions,
    tolerance: f64,
    fluid: f64,
    resumed: Option<usize>,
) -> (Structure, usize) {
    let mesh = tube_mesh(2.35e-3, &[4.5e-4, 4.5e-4], 7.5e-3, 2, 4, 1);
    let options = StructureOptions {
        newton,
        ..options(3, 0.01)
    };
    let new = || {
        Structure::new(&mesh, &artery(), &options)
            .unwrap()
            .with_background_seconds(fluid)
    };
    let mut structure = new();
    let mut factorizations = 0;
    for step in 1..=40 {
        if resumed == Some(step) {
            let memory = structure.memory();
            structure = new();
            structure.recall(memory).unwrap();
        }
        let t = step as f64 / 40.0;
        let pressure = 4e2 * t + 2e1 * (20.0 * t).sin();
        let load = SurfaceLoad::uniform_pressure(pressure, structure.wet_points().len());
        let trial = structure.solve(&load, 2e-3, tolerance, None).unwrap();
        factorizations += trial.stats.factorizations;
        structure.accept(trial);
    }
    (structure, factorizations)
}

#[test]
fn kept_tangents_save_factorizations_and_lead_to_the_same_state() {
    let full = NewtonOptions {
        tangent_cost: None,
        ..NewtonOptions::default()
    };
    let (_, many) = pulsate(full, false);
    // Full steps end where the residual is round-off, a hundred-millionth of this displacement away.
    let (reference, _) = pulsate_to(full, 1e-11, 1.0, None);
    let (structure, few) = pulsate(NewtonOptions::default(), false);
    assert!(3 * few < many, "{few} factorizations instead of {many}");
    // 221 with the pressure as an unknown of its own.
    let iterations = structure.stats().iterations;
    assert!((200..240).contains(&iterations), "{iterations} iterations");
    let (d, expected) = (&structure.state().d, &reference.state().d);
    let largest = expected.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let worst = d.iter().zip(expected).map(|(a, b)| (a - b).abs());
    let worst = worst.fold(0.0, f64::max);
    assert!(worst < 1e-8 * largest, "{worst:e} of {largest:e}");
}

#[test]
fn what_a_kept_tangent_has_learnt_is_resumed_to_the_last_bit() {
    let (straight, _) = pulsate(NewtonOptions::default(), false);
    let (resumed, _) = pulsate(NewtonOptions::default(), true);
    assert_eq!(straight.memory(), resumed.memory());
}

#[test]
fn a_renewal_of_several_steps_is_resumed_to_the_last_bit() {
    // Beside a fluid that takes no time a tangent is given two steps, and is used twice as long.
    let run = |resumed| pulsate_to(NewtonOptions::default(), 1e-8, 0.0, resumed).0;
    let straight = run(None);
    for step in 30..36 {
        assert_eq!(straight.memory(), run(Some(step)).memory(), "{step}");
    }
    let often = pulsate(NewtonOptions::default(), false).0;
    let [few, many] = [&straight, &often].map(|s| s.stats().factorizations);
    assert!(
        (12..=14).contains(&few) && (16..=19).contains(&many),
        "{few}, {many}"
    );
}

/// Forty steps of the same artery from rest to a pressure of `peak` (Pa), handed over before the step `resumed`.
fn inflate(peak: f64, newton: NewtonOptions, tolerance: f64, resumed: Option<usize>) -> Structure {
    let mesh = tube_mesh(2.35e-3, &[4.5e-4, 4.5e-4], 7.5e-3, 2, 4, 1);
    let options = StructureOptions {
        newton,
        time_scheme: TimeScheme::ImplicitEuler,
        ..options(3, 0.01)
    };
    let new = || Structure::new(&mesh, &artery(), &options).unwrap();
    let mut structure = new();
    for step in 1..=40 {
        if resumed == Some(step) {
            let memory = structure.memory();
            structure = new();
            structure.recall(memory).unwrap();
        }
        let pressure = peak * step as f64 / 40.0;
        let load = SurfaceLoad::uniform_pressure(pressure, structure.wet_points().len());
        let trial = structure.solve(&load, 2e-3, tolerance, None).unwrap();
        structure.accept(trial);
    }
    structure
}

/// One that moves twice as fast has its tangent renewed within the step all the same.
#[test]
fn a_wall_that_inflates_gets_its_tangent_ahead_of_a_step() {
    let counts = |peak| {
        let stats = inflate(peak, NewtonOptions::default(), 1e-6, None).stats();
        (stats.iterations, stats.factorizations)
    };
    // 188 and 40 with tangents of accepted states.
    let (iterations, factorizations) = counts(2.4e3);
    assert!((105..=115).contains(&iterations), "{iterations}");
    assert!((39..=43).contains(&factorizations), "{factorizations}");
    // 168 and 58 with those ahead.
    let (iterations, factorizations) = counts(4.8e3);
    assert!((235..=260).contains(&iterations), "{iterations}");
    assert!((41..=45).contains(&factorizations), "{factorizations}");
}

#[test]
fn an_inflating_wall_is_exact_and_resumed_to_the_last_bit() {
    let full = NewtonOptions {
        tangent_cost: None,
        ..NewtonOptions::default()
    };
    let reference = inflate(2.4e3, full, 1e-11, None);
    let structure = inflate(2.4e3, NewtonOptions::default(), 1e-6, None);
    let (d, expected) = (&structure.state().d, &reference.state().d);
    let largest = expected.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    let worst = (d.iter().zip(expected)).fold(0.0, |a: f64, (d, e)| a.max((d - e).abs()));
    println!("{worst:e} of {largest:e}");
    assert!(worst < 1e-6 * largest, "{worst:e} of {largest:e}");
    for step in [2, 17, 40] {
        let resumed = inflate(2.4e3, NewtonOptions::default(), 1e-6, Some(step));
        assert_eq!(structure.memory(), resumed.memory(), "{step}");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let states: Vec<State> = [1, 2, 3]
        .into_iter()
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let mesh = tube_mesh(2.35e-3, &[4.5e-4, 4.5e-4], 1.5e-2, 4, 8, 1);
                let mut structure = Structure::new(&mesh, &artery(), &options(3, 0.01)).unwrap();
                let load = SurfaceLoad::uniform_pressure(1e3, structure.wet_points().len());
                for _ in 0..3 {
                    let trial = structure.solve(&load, 2e-3, 1e-8, None).unwrap();
                    structure.accept(trial);
                }
                structure.state().clone()
            })
        })
        .collect();
    assert_eq!(states[0], states[1]);
    assert_eq!(states[0], states[2]);
}

#[test]
fn located_points_lie_where_they_are_and_move_with_the_wall() {
    let mesh = tube_mesh(5e-3, &[1e-3], 2e-2, 2, 4, 1);
    let material = Material::SaintVenantKirchhoff {
        youngs_modulus: 3e5,
        poisson_ratio: 0.3,
        viscosity: None,
    };
    let mut structure = Structure::new(&mesh, &[material], &options(4, 0.0)).unwrap();
    let points: Vec<Vec3> = (0..200)
        .map(|i| {
            let (x, phi) = (2e-2 * (i as f64 * 0.618).fract(), i as f64 * 0.377);
            Vec3::new(x, 5e-3 * phi.cos(), 5e-3 * phi.sin())
        })
        .collect();
    let located = structure.locate(&points).unwrap();
    // The edges of degree 4 leave the circle by 9e-5 of the radius.
    assert!(located.iter().all(|l| l.distance < 1e-4 * 5e-3));
    let load = SurfaceLoad::uniform_pressure(1e3, structure.wet_points().len());
    let trial = structure.solve(&load, 1.0, 1e-9, None).unwrap();
    let moved = structure.displacement(&trial, &located);
    for (x, u) in points.iter().zip(&moved) {
        let inside = x.x > 1e-6 && x.x < 2e-2 - 1e-6;
        assert!((x.y * u.y + x.z * u.z > 0.0) == inside || u.norm() < 1e-9);
    }
    let areas: f64 = structure
        .deformed_areas(&trial)
        .iter()
        .map(|a| a.norm())
        .sum();
    let reference: f64 = structure.wet_points().iter().map(|p| p.area).sum();
    assert!((reference / (2.0 * std::f64::consts::PI * 5e-3 * 2e-2) - 1.0).abs() < 1e-5);
    assert!(areas > 1.005 * reference);
    let error = structure
        .locate(&[Vec3::new(1e-2, 0.0, 1e-3)])
        .unwrap_err()
        .to_string();
    assert!(error.contains("do not describe the same wall"), "{error}");
}

#[test]
fn impossible_loads_are_explained() {
    let mut structure = short_tube(2, 4, 0.0);
    let mut load = no_load(&structure);
    load.pressure.pop();
    assert!(
        structure
            .solve(&load, 1e-3, 1e-6, None)
            .unwrap_err()
            .to_string()
            .contains("quadrature points")
    );
    load.pressure.push(f64::NAN);
    assert!(
        structure
            .solve(&load, 1e-3, 1e-6, None)
            .unwrap_err()
            .to_string()
            .contains("not finite")
    );
    load.pressure.fill(1e9);
    assert!(structure.solve(&load, 1e-3, 1e-6, None).is_err());
    // The failure has left no traces.
    load.pressure.fill(10.0);
    let after = structure.solve(&load, 1e-3, 1e-10, None).unwrap();
    let fresh = short_tube(2, 4, 0.0)
        .solve(&load, 1e-3, 1e-10, None)
        .unwrap();
    let difference = after
        .state
        .d
        .iter()
        .zip(&fresh.state.d)
        .map(|(a, b)| (a - b).abs());
    assert!(difference.fold(0.0, f64::max) < 1e-12);
}
