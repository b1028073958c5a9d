//! The spectral elements for the blood in a rigid tube: Poiseuille's and Womersley's flow, and their wall shear stress.

use fsi_driver::Vec3;
use fsi_driver::case::{Case, Preset, Rheology};
use fsi_driver::fluid::native::lumen_mesh::LumenMesh;
use fsi_driver::fluid::native::metric::Metric;
use fsi_driver::fluid::native::spectral_elements::SpectralElements;
use fsi_driver::fluid::native::taylor_hood_space::Boundary;
use fsi_driver::fluid::native::vessel_mesh::{MeshResolution, VesselMesh};
use fsi_driver::fluid::native::wall_traction::wall_loads;
use fsi_driver::fluid::native::{
    BoundaryConditions, Flow, FlowError, FlowSettings, FlowState, OpenEnd, OpenInflow, TimeScheme,
};
use fsi_driver::geometry::Vessel;
use nalgebra::Complex;
use std::f64::consts::{PI, TAU};

const RADIUS: f64 = 3e-3;
const DENSITY: f64 = 1050.0;
const VISCOSITY: f64 = 3.5e-3;
const BLOOD: Rheology = Rheology::Newtonian {
    viscosity: VISCOSITY,
};

/// A straight circular tube of 15 mm: a rigid part and two deformable ones of 5 mm each, an element long.
fn tube(degree: usize) -> VesselMesh {
    let set = |key: &str, value: &str| (key.to_owned(), value.to_owned());
    let overrides = [
        set("geometry.graft_inner_radius_m", "3e-3"),
        set("geometry.artery_inner_radius_m", "3e-3"),
        set("geometry.graft_length_m", "5e-3"),
        set("geometry.artery_length_m", "5e-3"),
        set("geometry.blend_length_m", "1e-3"),
        set("geometry.extension_length_m", "5e-3"),
    ];
    let case = Case::load("tests/cases/S-0.0".as_ref(), Preset::Demo, &overrides).unwrap();
    let resolution = MeshResolution {
        degree,
        core: 2,
        radial: 1,
        axial_extension: 1,
        axial_per_section: 1,
    };
    VesselMesh::new(&Vessel::new(case.vessel().unwrap()), resolution)
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Method {
    Gradients,
    Reactions,
}

/// Axial velocity prescribed at inlet and outlet's pressure 0; the solution starts as `velocity(r, 0)` everywhere.
struct FluidTube {
    flow: Flow,
    state: FlowState,
    positions: Vec<f64>,
    /// `mu ∂u/∂n` on the wall in the last step, from the forces there.
    reactions: Vec<f64>,
    blood: Rheology,
}

impl FluidTube {
    fn new(degree: usize, scheme: TimeScheme, velocity: impl Fn(f64) -> f64) -> Self {
        Self::with_iterations(300, BLOOD, degree, scheme, velocity)
    }

    fn with_iterations(
        max_iterations: usize,
        blood: Rheology,
        degree: usize,
        scheme: TimeScheme,
        velocity: impl Fn(f64) -> f64,
    ) -> Self {
        let mesh = tube(degree);
        let space = SpectralElements::new(mesh.space().clone()).unwrap();
        let positions = mesh.positions(&vec![Vec3::zeros(); mesh.interface().points.len()]);
        let fixed = space.space.faces_of(|patch| patch != Boundary::End(1));
        let outlet = space.space.faces_of(|patch| patch == Boundary::End(1));
        let settings = FlowSettings {
            density: DENSITY,
            rheology: blood,
            scheme,
            tolerance: 1e-9,
            max_iterations,
        };
        let pressure = vec![0.0; space.space.pressures];
        let open = vec![OpenEnd {
            faces: outlet.clone(),
            inflow: OpenInflow::NoEnergy,
        }];
        let flow = Flow::new(space, settings, &fixed, Vec::new(), open, &positions).unwrap();
        let u = axial(&positions, velocity);
        let state = FlowState {
            time: 0.0,
            before: None,
            positions: [positions.clone(), positions.clone()],
            velocity: [u.clone(), u],
            pressure: [pressure.clone(), pressure],
            preconditioner: None,
        };
        Self {
            flow,
            state,
            positions,
            reactions: Vec::new(),
            blood,
        }
    }

    /// Takes a step, and says how many iterations it took.
    fn step(&mut self, dt: f64, velocity: impl Fn(f64) -> f64) -> usize {
        self.step_to(dt, axial(&self.positions, velocity))
    }

    /// The same with the velocity of the fixed nodes at its end.
    fn step_to(&mut self, dt: f64, velocity: Vec<f64>) -> usize {
        let boundary = BoundaryConditions {
            velocity,
            ..BoundaryConditions::default()
        };
        let positions = self.positions.clone();
        let trial = self
            .flow
            .solve(&self.state, dt, positions, &boundary, None)
            .unwrap();
        self.reactions = self.flow.viscous_reactions(&trial);
        let iterations = trial.iterations;
        self.flow.accept(&mut self.state, trial);
        iterations
    }

    /// Axial component of the wall shear stress on the wall of the deformable part, smallest and largest, Pa: from the
    /// forces on the wall, or from gradients.
    fn wall_shear(&self, method: Method) -> [f64; 2] {
        let faces = self
            .flow
            .space()
            .space
            .faces_of(|patch| patch == Boundary::Mantle(0));
        let [u, p] = [&self.state.velocity[0], &self.state.pressure[0]];
        let loads = wall_loads(
            self.flow.space(),
            &faces[8..],
            &self.blood,
            &self.positions,
            u,
            p,
            (method == Method::Reactions).then_some(&self.reactions[..]),
        );
        let shear = loads.iter().flatten().map(|load| load.shear.x);
        shear.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| {
            [a.min(x), b.max(x)]
        })
    }
}

/// A field of velocities along x that depend on the distance from the axis; zero on the wall.
fn axial(positions: &[f64], velocity: impl Fn(f64) -> f64) -> Vec<f64> {
    let nodes = positions.len() / 3;
    let at = |i: usize| {
        let r = positions[nodes + i].hypot(positions[2 * nodes + i]);
        if r > RADIUS * (1.0 - 1e-9) {
            0.0
        } else {
            velocity(r)
        }
    };
    (0..3 * nodes)
        .map(|k| if k < nodes { at(k) } else { 0.0 })
        .collect()
}

#[test]
fn the_mesh_has_the_volume_of_the_tube() {
    let error = |degree: usize| {
        let mesh = tube(degree);
        let space = SpectralElements::new(mesh.space().clone()).unwrap();
        let still = vec![Vec3::zeros(); mesh.interface().points.len()];
        let metric = Metric::new(&space, &mesh.positions(&still)).unwrap();
        (metric.volume / (PI * RADIUS * RADIUS * 15e-3) - 1.0).abs()
    };
    let errors = [3, 4, 5].map(error);
    assert!(
        (2e-6..4e-6).contains(&errors[0]) && (5e-9..1e-8).contains(&errors[1]),
        "{errors:?}"
    );
    assert!(errors[2] < 2e-11, "{errors:?}");
}

#[test]
fn poiseuilles_wall_shear_converges_spectrally() {
    let error = |method: Method, degree: usize| {
        let mean = 0.2;
        let velocity = |r: f64| 2.0 * mean * (1.0 - (r / RADIUS).powi(2));
        let mut tube = FluidTube::new(degree, TimeScheme::ImplicitEuler, velocity);
        for _ in 0..3 {
            tube.step(0.03, velocity);
        }
        let exact = 4.0 * VISCOSITY * mean / RADIUS;
        tube.wall_shear(method)
            .map(|found| (found / exact - 1.0).abs())
            .into_iter()
            .fold(0.0, f64::max)
    };
    for (method, expected) in [
        (Method::Gradients, [1.4e-3, 1.65e-4, 2.7e-5]),
        (Method::Reactions, [1.06e-3, 9.9e-5, 1.28e-5]),
    ] {
        let errors = [3, 4, 5].map(|degree| error(method, degree));
        for (error, expected) in errors.into_iter().zip(expected) {
            assert!(
                (0.7 * expected..1.3 * expected).contains(&error),
                "{method:?}: {errors:?}"
            );
        }
    }
}

/// Bessel functions J0 and J1 by their series.
fn bessel(z: Complex<f64>) -> [Complex<f64>; 2] {
    let q = -0.25 * z * z;
    let (mut term, mut sums) = (Complex::new(1.0, 0.0), [Complex::new(0.0, 0.0); 2]);
    for k in 0..60 {
        sums[0] += term;
        sums[1] += term * 0.5 * z / (k as f64 + 1.0);
        term *= q / ((k as f64 + 1.0) * (k as f64 + 1.0));
    }
    sums
}

/// Largest errors of the wall shear stress, from gradients and from forces on the wall, over a third of a period,
/// relative to its amplitude. In discrete time d/dt becomes a complex number, and Womersley's solution holds with it:
/// what is left is the error in space.
fn womersley(degree: usize, scheme: TimeScheme) -> [f64; 2] {
    let (dt, omega, gradient) = (0.02, TAU * 2.0, 2000.0);
    let back = Complex::new(0.0, -omega * dt).exp();
    let rate = match scheme {
        TimeScheme::ImplicitEuler => (1.0 - back) / dt,
        TimeScheme::Bdf2 => (1.5 - 2.0 * back + 0.5 * back * back) / dt,
    };
    let lambda = (-rate * DENSITY / VISCOSITY).sqrt();
    let [wall, slope] = bessel(lambda * RADIUS);
    let phase = |t: f64| Complex::new(0.0, omega * t).exp();
    let strength = gradient / (DENSITY * rate);
    let velocity = |r: f64, t: f64| (strength * (1.0 - bessel(lambda * r)[0] / wall) * phase(t)).re;
    let amplitude = VISCOSITY * strength * lambda * slope / wall;
    let mut tube = FluidTube::new(degree, scheme, |r| velocity(r, 0.0));
    tube.state.before = Some(dt);
    tube.state.velocity[1] = axial(&tube.positions, |r| velocity(r, -dt));
    let mut worst = [0.0f64; 2];
    for k in 1..=8 {
        let t = k as f64 * dt;
        tube.step(dt, |r| velocity(r, t));
        // On the wall: minus viscosity times ∂u/∂r, with J0' = -J1
        let exact = -(amplitude * phase(t)).re;
        for (worst, method) in worst.iter_mut().zip([Method::Gradients, Method::Reactions]) {
            for found in tube.wall_shear(method) {
                *worst = worst.max((found - exact).abs() / amplitude.norm());
            }
        }
    }
    worst
}

#[test]
fn womersleys_wall_shear_is_that_of_the_time_scheme() {
    for (degree, scheme, expected) in [
        (3, TimeScheme::ImplicitEuler, [5.5e-2, 2.25e-3]),
        (4, TimeScheme::ImplicitEuler, [8.1e-3, 1.86e-4]),
        (4, TimeScheme::Bdf2, [8.7e-3, 2.31e-4]),
        (5, TimeScheme::Bdf2, [1.02e-3, 1.96e-5]),
    ] {
        let found = womersley(degree, scheme);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (0.8 * expected..1.2 * expected).contains(&found),
                "degree {degree}, {scheme}: {found:e}"
            );
        }
    }
}

/// A solution that does not converge is told from one that is lost and both name the place.
#[test]
fn failed_and_lost_solutions_name_the_place() {
    let velocity = |r: f64| 1.0 - (r / RADIUS).powi(2);
    let solve = |tube: &mut FluidTube| {
        let boundary = BoundaryConditions {
            velocity: axial(&tube.positions, |r| 3.0 * velocity(r)),
            ..BoundaryConditions::default()
        };
        let positions = tube.positions.clone();
        (tube.flow).solve(&tube.state, 2e-3, positions, &boundary, None)
    };
    let tube = |iterations: usize| {
        FluidTube::with_iterations(iterations, BLOOD, 4, TimeScheme::ImplicitEuler, velocity)
    };
    let Err(FlowError::NotSolved {
        iterations: 2,
        residual,
        position,
    }) = solve(&mut tube(2))
    else {
        panic!("two iterations are too few")
    };
    assert!(residual > 1e-9 && residual < 1.0, "{residual:e}");
    let inside = |x: [f64; 3]| x[1].hypot(x[2]) < RADIUS && (-6e-3..=11e-3).contains(&x[0]);
    assert!(inside(position), "{position:?}");

    let mut tube = tube(300);
    assert!(solve(&mut tube).is_ok());
    let nodes = tube.flow.space().space.nodes;
    let at = |i: usize| [0, 1, 2].map(|c| tube.positions[c * nodes + i]);
    let node = (0..nodes).find(|&i| at(i)[0] > 1e-3 && at(i)[1].hypot(at(i)[2]) < 1e-3);
    let (node, position) = (node.unwrap(), at(node.unwrap()));
    tube.state.velocity[0][2 * nodes + node] = f64::NAN;
    assert_eq!(solve(&mut tube), Err(FlowError::NotFinite { position }));
}

/// A generalized Newtonian fluid in a tube, with its developed flow under a wall shear stress of [`SHEAR`].
struct Developed {
    blood: Rheology,
    /// Velocity (m/s) in equal distances from the axis to the wall.
    table: Vec<f64>,
}

/// Wall shear stress, Pa.
const SHEAR: f64 = 1.5;
/// Intervals of the tables.
const PIECES: usize = 4000;

impl Developed {
    /// Stress rises linearly from the axis to the wall; the rate of shear at a stress follows from the model by
    /// bisection, and the velocity by the trapezoidal rule.
    fn of(blood: Rheology) -> Self {
        let stress = |i: usize| SHEAR * i as f64 / PIECES as f64;
        let rate = |i: usize| {
            let (mut low, mut high) = (0.0, 1e5);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                let less = blood.viscosity(middle) * middle < stress(i);
                *(if less { &mut low } else { &mut high }) = middle;
            }
            low
        };
        let mut table = vec![0.0; PIECES + 1];
        let mut outer = rate(PIECES);
        for i in (0..PIECES).rev() {
            let inner = rate(i);
            table[i] = table[i + 1] + 0.5 * (inner + outer) * RADIUS / PIECES as f64;
            outer = inner;
        }
        Self { blood, table }
    }

    fn velocity(&self, r: f64) -> f64 {
        let place = (r / RADIUS * PIECES as f64).min(PIECES as f64 - 1e-6);
        let (i, share) = (place as usize, place.fract());
        (1.0 - share) * self.table[i] + share * self.table[i + 1]
    }

    /// Errors after eight steps of 20 ms from the exact velocity: the largest of the velocity, relative to that on the
    /// axis, and those of the pressure drop and of the wall shear stress from forces (the largest) relative to
    /// themselves; and the iterations of all steps.
    fn errors(&self, degree: usize) -> ([f64; 3], usize) {
        let velocity = |r: f64| self.velocity(r);
        let scheme = TimeScheme::ImplicitEuler;
        let mut tube = FluidTube::with_iterations(300, self.blood, degree, scheme, velocity);
        let boundary = axial(&tube.positions, velocity);
        let steps = (0..8).map(|_| tube.step_to(0.02, boundary.clone()));
        let iterations = steps.sum();
        let exact = axial(&tube.positions, velocity);
        let found = &tube.state.velocity[0];
        let of_velocity = found.iter().zip(&exact).map(|(u, v)| (u - v).abs());
        // The outlet's is 0, and that of the inlet the largest.
        let drop = tube.state.pressure[0].iter().copied().fold(0.0, f64::max);
        let shears = tube.wall_shear(Method::Reactions);
        let of_shear = shears.map(|found| (found / SHEAR - 1.0).abs());
        let errors = [
            of_velocity.fold(0.0, f64::max) / self.table[0],
            (drop / (2.0 * SHEAR / RADIUS * 15e-3) - 1.0).abs(),
            of_shear.into_iter().fold(0.0, f64::max),
        ];
        (errors, iterations)
    }
}

const POWER_LAW: Rheology = Rheology::PowerLaw {
    high: 1e-5,
    at_rest: 10.0,
    k: 0.017,
    n: 0.708,
};

/// With a largest viscosity of 100 times the one at high rates, as if nothing were said of it.
const CASSON: Rheology = Rheology::Casson {
    high: 3.5e-3,
    at_rest: 0.35,
    yield_stress: 0.05,
};

#[test]
fn developed_flows_in_closed_form_are_those_of_the_table() {
    // Bird, Stewart and Lightfoot 2002
    let (k, n) = (0.017, 0.708);
    let of_power_law = |r: f64| {
        let m = (n + 1.0) / n;
        (SHEAR / (k * RADIUS)).powf(1.0 / n) / m * (RADIUS.powf(m) - r.powf(m))
    };
    // Fung 1993, without the largest viscosity: within the core the stress does not reach the yield stress.
    let (high, yield_stress) = (3.5e-3, 0.05);
    let of_casson = |r: f64| {
        let r = r.max(yield_stress / SHEAR * RADIUS);
        let stress = SHEAR / RADIUS;
        (0.5 * stress * (RADIUS * RADIUS - r * r)
            - 4.0 / 3.0 * (yield_stress * stress).sqrt() * (RADIUS.powf(1.5) - r.powf(1.5))
            + yield_stress * (RADIUS - r))
            / high
    };
    let compare = |blood: Rheology, exact: &dyn Fn(f64) -> f64, within: f64| {
        let developed = Developed::of(blood);
        for i in 0..30 {
            let r = RADIUS * f64::from(i) / 30.0;
            let error = (developed.velocity(r) - exact(r)).abs() / exact(0.0);
            assert!(error < within, "{blood:?}, r = {r}: {error:e}");
        }
    };
    compare(POWER_LAW, &of_power_law, 1e-6);
    compare(CASSON, &of_casson, 1e-4);
}

#[test]
fn developed_flow_of_shear_thinning_blood_is_that_of_its_model() {
    let carreau = Rheology::CarreauYasuda {
        high: 3.45e-3,
        at_rest: 0.056,
        time: 3.313,
        n: 0.3568,
        a: 2.0,
    };
    // Casson's core without shear is as hard for the polynomials as for the linear solver. Steps of 20 ms, in which
    // viscosity outweighs inertia, are hard for the solver as well: 150 to 250 iterations each.
    for (name, blood, degree, expected, most) in [
        ("power law", POWER_LAW, 4, [1.59e-4, 2.25e-5, 7.63e-5], 2100),
        ("power law", POWER_LAW, 5, [3.91e-5, 1.68e-4, 1.06e-5], 1500),
        ("Casson", CASSON, 4, [1.07e-3, 3.47e-4, 9.53e-5], 1300),
        ("Casson", CASSON, 5, [1.73e-4, 1.04e-3, 9.35e-6], 1600),
        ("Carreau", carreau, 4, [2.47e-4, 3.07e-6, 9.34e-5], 1350),
        ("Carreau", carreau, 5, [1.05e-4, 1.97e-5, 1.17e-5], 1400),
    ] {
        let (found, iterations) = Developed::of(blood).errors(degree);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (0.8 * expected..1.2 * expected).contains(&found),
                "{name}, degree {degree}: {found:e}"
            );
        }
        assert!(iterations < most, "{name}, degree {degree}: {iterations}");
    }
}
