//! The spectral elements for the blood against exact solutions: a free stream, Kovasznay, Ethier and Steinman,
//! Poiseuille, Womersley.

use fsi_spectral::spectral_elements::SpectralElements;
use fsi_spectral::taylor_hood_space::{Boundary, Face, Plane, TaylorHoodSpace};
use fsi_spectral::{BoundaryConditions, Flow, FlowSettings, FlowState, Rheology, TimeScheme, Vec3};
use nalgebra::Matrix3;

/// A problem in a box that is bent and moves, with an exact solution.
trait Exact {
    fn velocity(&self, x: Vec3, t: f64) -> Vec3;
    fn pressure(&self, x: Vec3, t: f64) -> f64;
    /// `∂u_i/∂x_j`.
    fn gradient(&self, x: Vec3, t: f64) -> Matrix3<f64> {
        let h = 1e-5;
        let column = |j: usize| {
            let mut e = Vec3::zeros();
            e[j] = h;
            (self.velocity(x + e, t) - self.velocity(x - e, t)) / (2.0 * h)
        };
        Matrix3::from_columns(&[column(0), column(1), column(2)])
    }
}

struct Box3 {
    flow: Flow,
    settings: FlowSettings,
    state: FlowState,
    /// Places of the nodes in the unit cube.
    reference: Vec<Vec3>,
    open: Vec<Face>,
    shape: fn(Vec3, f64) -> Vec3,
}

fn field(vectors: impl Iterator<Item = Vec3> + Clone) -> Vec<f64> {
    (0..3)
        .flat_map(|c| vectors.clone().map(move |v| v[c]))
        .collect()
}

impl Box3 {
    /// `cells` elements of the unit cube, which `shape` maps into space; all sides have the exact velocity but the one
    /// at ξ = 1, which has the exact traction.
    fn new(
        cells: [usize; 3],
        degree: usize,
        settings: FlowSettings,
        shape: fn(Vec3, f64) -> Vec3,
        exact: &dyn Exact,
    ) -> Self {
        let [nx, ny, nz] = cells;
        let plane = |degree| Plane::grid([nx, ny], degree);
        let space = TaylorHoodSpace::swept(&plane(degree), &plane(degree - 1), degree, nz);
        let space = SpectralElements::new(space).unwrap();
        let nodes = &space.basis.nodes.points;
        let mut reference = vec![Vec3::zeros(); space.space.nodes];
        for e in 0..space.space.elements {
            let corner = [e % nx, e / nx % ny, e / nx / ny];
            let n = degree + 1;
            for (i, &node) in space.space.element(e).iter().enumerate() {
                let local = [i % n, i / n % n, i / n / n];
                reference[node as usize] = Vec3::from_fn(|c, _| {
                    (corner[c] as f64 + 0.5 * (1.0 + nodes[local[c]])) / cells[c] as f64
                });
            }
        }
        let open = space.space.faces_of(|patch| patch == Boundary::Mantle(1));
        let fixed = space.space.faces_of(|patch| patch != Boundary::Mantle(1));
        let at = |t: f64| field(reference.iter().map(|&x| shape(x, t)));
        let velocity = |t: f64| field(reference.iter().map(|&x| exact.velocity(shape(x, t), t)));
        let zeros = vec![0.0; space.space.pressures];
        let state = FlowState {
            time: 0.0,
            before: None,
            positions: [at(0.0), at(0.0)],
            velocity: [velocity(0.0), velocity(0.0)],
            pressure: [zeros.clone(), zeros],
            preconditioner: None,
        };
        let flow = Flow::new(space, settings, &fixed, Vec::new(), Vec::new(), &at(0.0)).unwrap();
        Self {
            flow,
            settings,
            state,
            reference,
            open,
            shape,
        }
    }

    fn positions(&self, t: f64) -> Vec<f64> {
        field(self.reference.iter().map(|&x| (self.shape)(x, t)))
    }

    fn step(&mut self, dt: f64, exact: &dyn Exact) -> usize {
        let t = self.state.time + dt;
        let positions = self.positions(t);
        let space = self.flow.space();
        let mut load = vec![0.0; 3 * space.space.nodes];
        for &face in &self.open {
            let points = space.face_points(face, &positions);
            let forces: Vec<Vec3> = (points.positions.iter().zip(&points.areas))
                .map(|(&x, area)| {
                    self.settings.rheology.viscosity(0.0) * exact.gradient(x, t) * area
                        - exact.pressure(x, t) * area
                })
                .collect();
            space.add_face_load(&points.nodes, &forces, &mut load);
        }
        let boundary = BoundaryConditions {
            velocity: field(
                self.reference
                    .iter()
                    .map(|&x| exact.velocity((self.shape)(x, t), t)),
            ),
            pressures: Vec::new(),
            load,
        };
        let trial = self
            .flow
            .solve(&self.state, dt, positions, &boundary, None)
            .unwrap();
        let iterations = trial.iterations;
        self.flow.accept(&mut self.state, trial);
        iterations
    }

    /// Largest errors of velocity and pressure at the nodes; the pressure's nodes that are no nodes of the velocity are
    /// left out.
    fn errors(&self, exact: &dyn Exact) -> [f64; 2] {
        let space = self.flow.space();
        let t = self.state.time;
        let u = (0..space.space.nodes).map(|i| {
            let x = (self.shape)(self.reference[i], t);
            (space.vector(&self.state.velocity[0], i) - exact.velocity(x, t)).norm()
        });
        // Corners of the elements
        let n = space.space.degree + 1;
        let corner =
            |n: usize| (0..8).map(move |k| (k % 2 + (k / 2 % 2) * n + (k / 4) * n * n) * (n - 1));
        let mut p = 0.0f64;
        for e in 0..space.space.elements {
            for (i, j) in corner(n).zip(corner(n - 1)) {
                let x = (self.shape)(self.reference[space.space.element(e)[i] as usize], t);
                let at = self.state.pressure[0][space.space.element_pressures(e)[j] as usize];
                p = p.max((at - exact.pressure(x, t)).abs());
            }
        }
        let n = space.space.nodes as f64;
        [(u.map(|u| u * u).sum::<f64>() / n).sqrt(), p]
    }
}

fn settings(density: f64, viscosity: f64, scheme: TimeScheme) -> FlowSettings {
    FlowSettings {
        density,
        rheology: Rheology::Newtonian { viscosity },
        scheme,
        tolerance: 1e-9,
        max_iterations: 400,
    }
}

/// A cube that is bent and breathes.
fn breathing(x: Vec3, t: f64) -> Vec3 {
    let swing = 0.1 * (1.0 + (3.0 * t).sin());
    Vec3::new(
        x.x + swing * (2.0 * x.y).sin() * x.z,
        x.y + swing * x.x * (1.0 - x.x) + 0.3 * swing * x.z * x.z,
        x.z + 0.5 * swing * (3.0 * x.x).cos() * x.y,
    )
}

struct Uniform;
impl Exact for Uniform {
    fn velocity(&self, _: Vec3, _: f64) -> Vec3 {
        Vec3::new(0.7, -1.1, 0.4)
    }
    fn pressure(&self, _: Vec3, _: f64) -> f64 {
        3.0
    }
}

#[test]
fn a_free_stream_stays_as_it_is_on_a_mesh_that_moves() {
    for scheme in [TimeScheme::ImplicitEuler, TimeScheme::Bdf2] {
        let settings = FlowSettings {
            tolerance: 1e-14,
            ..settings(1.3, 0.01, scheme)
        };
        let mut cube = Box3::new([2, 2, 2], 4, settings, breathing, &Uniform);
        for dt in [0.1, 0.1, 0.05, 0.2] {
            cube.step(dt, &Uniform);
        }
        let [u, p] = cube.errors(&Uniform);
        println!("free stream {scheme:?}: {u:.1e} {p:.1e}");
        assert!(u < 1e-12 && p < 1e-11, "errors {u:e} and {p:e}");
    }
}

/// Ethier and Steinman 1994, with a = π/4, d = π/2 and unit density; `nu` is the viscosity.
struct EthierSteinman {
    nu: f64,
}

impl Exact for EthierSteinman {
    fn velocity(&self, x: Vec3, t: f64) -> Vec3 {
        use std::f64::consts::PI;
        let (a, d) = (PI / 4.0, PI / 2.0);
        let f = |x: f64, y: f64, z: f64| {
            (a * x).exp() * (a * y + d * z).sin() + (a * z).exp() * (a * x + d * y).cos()
        };
        let decay = -a * (-self.nu * d * d * t).exp();
        decay * Vec3::new(f(x.x, x.y, x.z), f(x.y, x.z, x.x), f(x.z, x.x, x.y))
    }

    fn pressure(&self, v: Vec3, t: f64) -> f64 {
        use std::f64::consts::PI;
        let (a, d) = (PI / 4.0, PI / 2.0);
        let [x, y, z] = [v.x, v.y, v.z];
        let pair = |x: f64, y: f64, z: f64| {
            2.0 * (a * x + d * y).sin() * (a * z + d * x).cos() * (a * (y + z)).exp()
        };
        let sum = (2.0 * a * x).exp()
            + (2.0 * a * y).exp()
            + (2.0 * a * z).exp()
            + pair(x, y, z)
            + pair(y, z, x)
            + pair(z, x, y);
        -0.5 * a * a * sum * (-2.0 * self.nu * d * d * t).exp()
    }
}

fn ethier_steinman(scheme: TimeScheme, steps: usize) -> [f64; 2] {
    let exact = EthierSteinman { nu: 0.4 };
    let mut cube = Box3::new([2; 3], 5, settings(1.0, 0.4, scheme), breathing, &exact);
    for _ in 0..steps {
        cube.step(0.4 / steps as f64, &exact);
    }
    let errors = cube.errors(&exact);
    println!("{scheme:?}, {steps} steps: {errors:?}");
    errors
}

#[test]
fn the_orders_in_time_are_one_and_two_on_a_bent_and_moving_mesh() {
    for (scheme, ratio) in [(TimeScheme::ImplicitEuler, 2.0), (TimeScheme::Bdf2, 4.0)] {
        let [coarse, fine] = [10, 20].map(|steps| ethier_steinman(scheme, steps));
        for (coarse, fine) in coarse.into_iter().zip(fine) {
            let found = coarse / fine;
            assert!(
                (0.92 * ratio..1.1 * ratio).contains(&found),
                "{scheme:?}: {found}"
            );
        }
    }
}

/// Kovasznay 1948: the flow downstream of a grid at a Reynolds number of 40.
struct Kovasznay;

impl Kovasznay {
    fn lambda() -> f64 {
        20.0 - (400.0 + 4.0 * std::f64::consts::PI.powi(2)).sqrt()
    }
}

impl Exact for Kovasznay {
    fn velocity(&self, x: Vec3, _: f64) -> Vec3 {
        let (l, k) = (Self::lambda(), 2.0 * std::f64::consts::PI);
        let e = (l * x.x).exp();
        Vec3::new(1.0 - e * (k * x.y).cos(), l / k * e * (k * x.y).sin(), 0.0)
    }

    fn pressure(&self, x: Vec3, _: f64) -> f64 {
        0.5 * (1.0 - (2.0 * Self::lambda() * x.x).exp())
    }
}

/// A channel from x = -0.5 to 1 and y = -0.5 to 1.5 with bent sides between the elements.
fn channel(x: Vec3, _: f64) -> Vec3 {
    let bend = 0.1 * x.x * (1.0 - x.x) * (6.0 * x.y).sin();
    Vec3::new(1.5 * x.x - 0.5 + bend, 2.0 * x.y - 0.5 + bend, 0.5 * x.z)
}

/// Errors of the steady flow on a mesh of these cells.
fn kovasznay(cells: [usize; 3], degree: usize) -> [f64; 2] {
    let settings = settings(1.0, 1.0 / 40.0, TimeScheme::ImplicitEuler);
    let mut flow = Box3::new(cells, degree, settings, channel, &Kovasznay);
    for _ in 0..5 {
        flow.step(0.4, &Kovasznay);
    }
    let errors = flow.errors(&Kovasznay);
    println!("degree {degree}, {cells:?}: {errors:?}");
    errors
}

#[test]
fn kovasznays_flow_converges_spectrally() {
    let expected = [
        (4, [1.19e-3, 5.8e-3]),
        (6, [1.02e-5, 2.39e-4]),
        (8, [6.4e-8, 6.9e-6]),
    ];
    for (degree, expected) in expected {
        let found = kovasznay([3, 4, 1], degree);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!(
                (0.8 * expected..1.2 * expected).contains(&found),
                "degree {degree}: {found:e}"
            );
        }
    }
}

#[test]
fn the_order_in_space_is_the_degree_and_one() {
    for (degree, expected) in [(3, [4.37, 4.37]), (4, [4.83, 4.01])] {
        let [coarse, fine] = [[2, 3, 1], [4, 6, 1]].map(|cells| kovasznay(cells, degree));
        let orders = [0, 1].map(|i| (coarse[i] / fine[i]).log2());
        for (found, expected) in orders.into_iter().zip(expected) {
            assert!(
                (found - expected).abs() < 0.2,
                "degree {degree}: orders {orders:?}"
            );
        }
    }
}

/// The preconditioner approximates the pressure's inverse within each element and at the corners of all. Without the
/// corners it takes 37 iterations on the coarse and 84 on the fine mesh of degree 3, 86 and 322 of degree 7.
#[test]
fn iterations_do_not_grow_with_the_mesh() {
    let exact = EthierSteinman { nu: 1e-4 };
    for (degree, expected) in [(3, [24, 19]), (4, [24, 21]), (7, [41, 43])] {
        for (cells, expected) in [2, 5].into_iter().zip(expected) {
            let settings = settings(1.0, exact.nu, TimeScheme::Bdf2);
            let mut cube = Box3::new([cells; 3], degree, settings, breathing, &exact);
            let iterations: usize = (0..3).map(|_| cube.step(2e-3, &exact)).sum();
            println!("degree {degree}, {cells}³ elements: {iterations} iterations");
            assert!(
                iterations.abs_diff(expected) <= 4,
                "expected about {expected}"
            );
        }
    }
}

/// Where the velocity is prescribed all around, the pressure is known up to a constant alone.
#[test]
fn a_closed_box_is_refused() {
    let settings = settings(1.0, 1e-2, TimeScheme::ImplicitEuler);
    let cube = Box3::new([2; 3], 4, settings, breathing, &Uniform);
    let space = SpectralElements::new(cube.flow.space().space.clone()).unwrap();
    let (all, positions) = (space.space.faces_of(|_| true), cube.positions(0.0));
    let mut flow = Flow::new(space, settings, &all, Vec::new(), Vec::new(), &positions).unwrap();
    let boundary = BoundaryConditions {
        velocity: cube.state.velocity[0].clone(),
        ..BoundaryConditions::default()
    };
    let found = flow.solve(&cube.state, 0.1, positions, &boundary, None);
    let told = found.unwrap_err().to_string();
    assert!(told.contains("is there no outlet?"), "{told}");
}
