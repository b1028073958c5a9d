//! Kovasznay's flow behind a grid: `cargo run --release -p fsi-spectral --example kovasznay`.
//!
//! An exact solution of the steady Navier-Stokes equations (Kovasznay 1948), at a Reynolds number of 40:
//! ```text
//! u = 1 - e^(λx) cos 2πy,   v = λ/2π e^(λx) sin 2πy,   p = (1 - e^(2λx))/2,   λ = Re/2 - sqrt(Re²/4 + 4π²)
//! ```
//! The program takes it for the start of a run with elements of rising degree on one mesh of 3 × 4 elements, one thick,
//! and lets it settle to what the elements make of it. The errors fall by about ten with each degree, on average.

use fsi_spectral::spectral_elements::SpectralElements;
use fsi_spectral::taylor_hood_space::{Boundary, Plane, TaylorHoodSpace};
use fsi_spectral::{
    BoundaryConditions, Flow, FlowError, FlowSettings, FlowState, Rheology, TimeScheme, Vec3,
};
use std::f64::consts::{PI, TAU};

const REYNOLDS: f64 = 40.0;
const CELLS: [usize; 2] = [3, 4];
const STEPS: usize = 5;
const STEP: f64 = 0.4; // s

fn main() -> Result<(), FlowError> {
    println!("degree   unknowns   iterations   error of the velocity");
    let mut last: f64 = 1.0;
    for degree in 3..=8 {
        let (unknowns, iterations, error) = kovasznay(degree)?;
        println!("{degree:>6}{unknowns:>11}{iterations:>13}{error:>24.1e}");
        assert!(error < 0.5 * last, "{error:e} after {last:e}");
        last = error;
    }
    Ok(())
}

fn lambda() -> f64 {
    0.5 * REYNOLDS - (0.25 * REYNOLDS.powi(2) + 4.0 * PI.powi(2)).sqrt()
}

fn velocity(x: Vec3) -> Vec3 {
    let grown = (lambda() * x.x).exp();
    let (sin, cos) = (TAU * x.y).sin_cos();
    Vec3::new(1.0 - grown * cos, lambda() / TAU * grown * sin, 0.0)
}

/// Unknowns, iterations of the linear solver, and the root mean square error of the velocity (m/s) at the nodes.
fn kovasznay(degree: usize) -> Result<(usize, usize, f64), FlowError> {
    // 1. The unknowns: a plane grid with the nodes of velocity and of pressure, swept over one layer.
    let plane = |degree| Plane::grid(CELLS, degree);
    let space = TaylorHoodSpace::swept(&plane(degree), &plane(degree - 1), degree, 1);
    let space = SpectralElements::new(space)?;
    let (nodes, pressures) = (space.space.nodes, space.space.pressures);

    // 2. Places of the nodes: x from -0.5 to 1, y from -0.5 to 1.5, z from 0 to 0.5.
    let mut places = vec![Vec3::zeros(); nodes];
    let n = degree + 1;
    for element in 0..space.space.elements {
        let cell = [element % CELLS[0], element / CELLS[0]];
        for (i, &node) in space.space.element(element).iter().enumerate() {
            let share = |local: usize| 0.5 * (1.0 + space.basis.nodes.points[local]);
            let along = |d: usize, local| (cell[d] as f64 + share(local)) / CELLS[d] as f64;
            places[node as usize] = Vec3::new(
                1.5 * along(0, i % n) - 0.5,
                2.0 * along(1, i / n % n) - 0.5,
                0.5 * share(i / n / n),
            );
        }
    }

    // 3. Boundary: the exact velocity, but on the side x = 1, which is left open under the exact traction.
    let is_open = |patch| patch == Boundary::Mantle(1);
    let fixed = space.space.faces_of(|patch| !is_open(patch));
    let positions = components(places.iter().copied());
    let mut load = vec![0.0; 3 * nodes];
    for face in space.space.faces_of(is_open) {
        let points = space.face_points(face, &positions);
        let forces: Vec<Vec3> = (points.positions.iter().zip(&points.areas))
            .map(|(&x, area)| traction(x) * area.norm())
            .collect();
        space.add_face_load(&points.nodes, &forces, &mut load);
    }
    let exact = components(places.iter().map(|&x| velocity(x)));

    // 4. Steps of implicit Euler until the flow is steady.
    let settings = FlowSettings {
        density: 1.0,
        rheology: Rheology::Newtonian {
            viscosity: 1.0 / REYNOLDS,
        },
        scheme: TimeScheme::ImplicitEuler,
        tolerance: 1e-10,
        max_iterations: 400,
    };
    let mut flow = Flow::new(space, settings, &fixed, Vec::new(), Vec::new(), &positions)?;
    let still = vec![0.0; pressures];
    let mut state = FlowState {
        time: 0.0,
        before: None,
        positions: [positions.clone(), positions.clone()],
        velocity: [exact.clone(), exact.clone()],
        pressure: [still.clone(), still],
        preconditioner: None,
    };
    let mut iterations = 0;
    for _ in 0..STEPS {
        let boundary = BoundaryConditions {
            velocity: exact.clone(),
            pressures: Vec::new(),
            load: load.clone(),
        };
        let trial = flow.solve(&state, STEP, positions.clone(), &boundary, None)?;
        iterations += trial.iterations;
        flow.accept(&mut state, trial);
    }
    let squares = state.velocity[0]
        .iter()
        .zip(&exact)
        .map(|(u, v)| (u - v).powi(2));
    let error = (squares.sum::<f64>() / nodes as f64).sqrt();
    Ok((3 * nodes + pressures, iterations, error))
}

/// `mu ∂u/∂x - p n` on a side with the normal along x, Pa.
fn traction(x: Vec3) -> Vec3 {
    let grown = (lambda() * x.x).exp();
    let (sin, cos) = (TAU * x.y).sin_cos();
    let slope = lambda() * grown * Vec3::new(-cos, lambda() / TAU * sin, 0.0);
    let pressure = 0.5 * (1.0 - grown * grown);
    slope / REYNOLDS - pressure * Vec3::x()
}

/// Fields are stored one component after the other.
fn components(vectors: impl Iterator<Item = Vec3> + Clone) -> Vec<f64> {
    (0..3)
        .flat_map(|c| vectors.clone().map(move |v| v[c]))
        .collect()
}
