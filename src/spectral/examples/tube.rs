//! Seconds, memory and iterations in a round tube whose wall moves, by the number of elements:
//! `cargo run --release -p fsi-spectral --example tube -- CORE RADIAL LAYERS [STEPS [DEGREE [LENGTH [STEP]]]]`.
//!
//! A section has CORE x CORE elements in its middle and RADIAL x 4 CORE around them; LAYERS of them are 81 mm long, or
//! LENGTH m. The radius is 3 mm, the inflow that of an artery; the wall breathes by a tenth of the radius. Each step of
//! 2 ms, or STEP s, has two trials whose walls differ by a hundredth of the motion, as in a coupled run. Seconds are
//! those of the processors.

use fsi_spectral::spectral_elements::SpectralElements;
use fsi_spectral::taylor_hood_space::{Boundary, Plane, Side, TaylorHoodSpace};
use fsi_spectral::{
    BoundaryConditions, Flow, FlowError, FlowSettings, FlowState, OpenEnd, OpenInflow, Rheology,
    TimeScheme, Vec3,
};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_4, PI, TAU};

const RADIUS: f64 = 3e-3; // m

fn main() -> Result<(), FlowError> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, default: usize| -> usize {
        (words.get(i)).map_or(default, |word| word.parse().expect("a number"))
    };
    let (core, radial, layers) = (number(0, 2), number(1, 1), number(2, 27));
    let (steps, degree) = (number(3, 6), number(4, 4));
    let real = |i: usize, default: f64| -> f64 {
        (words.get(i)).map_or(default, |word| {
            word.parse().expect("a length in m, or a time in s")
        })
    };
    let (length, step) = (real(5, 0.081), real(6, 2e-3));
    let tube = Tube::new(core, radial, degree);

    // 1. The unknowns, and where they are at rest: places across a section in units of the radius, along it in m.
    let pressure = Tube::new(core, radial, degree - 1);
    let space = TaylorHoodSpace::swept(&tube.plane, &pressure.plane, degree, layers);
    let space = SpectralElements::new(space)?;
    let along = fsi_numerics::subdivided(layers, &space.basis.nodes.points);
    let places: Vec<Vec3> = (along.iter())
        .flat_map(|z| (tube.places.iter()).map(move |[x, y]| Vec3::new(*x, *y, z * length)))
        .collect();
    let size = Size {
        elements: space.space.elements,
        nodes: space.space.nodes,
        pressures: space.space.pressures,
    };

    // 2. The boundary: a flow with a profile of fourth order in, an open end with a resistance out.
    let open = space.space.faces_of(|patch| patch == Boundary::End(1));
    let fixed = space.space.faces_of(|patch| patch != Boundary::End(1));
    let wall = space
        .space
        .faces_of(|patch| matches!(patch, Boundary::Mantle(_)));
    let inlet = (space.space.faces_of(|patch| patch == Boundary::End(0))).to_vec();
    let vessel = Vessel {
        inlet: space.space.nodes_of(&inlet),
        places,
        length,
    };
    let settings = FlowSettings {
        density: 1060.0,
        rheology: Rheology::Newtonian { viscosity: 3.7e-3 },
        scheme: TimeScheme::ImplicitEuler,
        tolerance: 1e-7,
        max_iterations: 400,
    };
    let end = OpenEnd {
        faces: open,
        inflow: OpenInflow::NoEnergy,
    };
    let rest = vessel.positions(0.0, 0.0);
    let flow = Flow::new(space, settings, &fixed, wall, vec![end], &rest)?;
    vessel.run(flow, &size, steps, step)
}

/// Numbers of unknowns.
struct Size {
    elements: usize,
    nodes: usize,
    pressures: usize,
}

/// The tube in motion.
struct Vessel {
    /// Of the nodes at rest: across the section in units of the radius, along it in m.
    places: Vec<Vec3>,
    inlet: Vec<usize>,
    length: f64,
}

impl Vessel {
    /// Positions (m) of the nodes at a time (s) with a relative error of the widening, one component after the other.
    fn positions(&self, t: f64, error: f64) -> Vec<f64> {
        let widening = 0.05 * (1.0 - (20.0 * t).cos()) * (1.0 + error);
        components(self.places.iter().map(|x| {
            let radius = RADIUS * (1.0 + widening * (PI * x.z / self.length).sin().powi(2));
            Vec3::new(radius * x.x, radius * x.y, x.z)
        }))
    }

    /// The mesh's velocity on the wall, and the flow at the inlet.
    fn boundary(&self, mut velocity: Vec<f64>, t: f64) -> BoundaryConditions {
        for &node in &self.inlet {
            let r2 = self.places[node].xy().norm_squared();
            let mean = 0.3 * (1.0 - (20.0 * t).cos()) * 0.5;
            velocity[2 * self.places.len() + node] = 1.5 * mean * (1.0 - r2 * r2);
        }
        BoundaryConditions {
            velocity,
            pressures: vec![[1000.0, 1e8]],
            load: Vec::new(),
        }
    }

    /// Steps of this length (s) of two trials each, and what they take.
    fn run(&self, mut flow: Flow, size: &Size, steps: usize, length: f64) -> Result<(), FlowError> {
        let Size {
            elements,
            nodes,
            pressures,
        } = size;
        let rest = self.positions(0.0, 0.0);
        let zeros = |n: usize| [vec![0.0; n], vec![0.0; n]];
        let mut state = FlowState {
            time: 0.0,
            before: None,
            positions: [rest.clone(), rest],
            velocity: zeros(3 * nodes),
            pressure: zeros(*pressures),
            preconditioner: None,
        };
        println!(
            "{elements} elements, {nodes} nodes, {pressures} pressures, {:.2} GB",
            gigabytes()
        );
        let (mut seconds, mut iterations) = (0.0, 0);
        for step in 1..=steps {
            let t = step as f64 * length;
            let mut trial = None;
            let (begin, then, mut spent) =
                (processor_seconds(), flow.clock().by_part(), Vec::new());
            for error in [1e-2, 1e-4] {
                let positions = self.positions(t, error);
                let velocity = flow.mesh_velocity(&state, length, &positions);
                let boundary = self.boundary(velocity, t);
                let solution = flow.solve(&state, length, positions, &boundary, trial.as_ref())?;
                spent.push(solution.iterations);
                trial = Some(solution);
            }
            let trial = trial.expect("two trials");
            let used = processor_seconds() - begin;
            let parts: Vec<String> = (flow.clock().by_part().iter().zip(&then))
                .map(|((name, now), (_, then))| format!("{name} {:.3}", now - then))
                .collect();
            println!(
                "step {step}: {used:.2} s, iterations {spent:?}; {}; outflow {:.9e} m³/s, pressure at the inlet {:.9e} Pa",
                parts.join(", "),
                trial.outflows[0],
                trial.pressure[0]
            );
            flow.accept(&mut state, trial);
            // The first ones make the preconditioner, and know no states to extrapolate
            if step > 2 {
                seconds += used;
                iterations += spent.iter().sum::<usize>();
            }
        }
        let trials = 2.0 * (steps as f64 - 2.0);
        println!(
            "{elements} elements, {nodes} nodes: {:.3} s and {:.1} iterations per trial, {:.2} µs per node, {:.2} GB",
            seconds / trials,
            iterations as f64 / trials,
            1e6 * seconds / trials / *nodes as f64,
            gigabytes()
        );
        Ok(())
    }
}

/// A section of a round tube: an O-grid, its nodes in units of the radius.
struct Tube {
    plane: Plane,
    places: Vec<[f64; 2]>,
}

impl Tube {
    fn new(core: usize, radial: usize, degree: usize) -> Self {
        let nodes = fsi_numerics::quadrature::Rule::gauss_lobatto(degree + 1).points;
        let [along, rings] = [core, radial].map(|count| fsi_numerics::subdivided(count, &nodes));
        // A square whose sides bulge by half
        let edge = |angle: f64| 0.7 * (0.5 * FRAC_PI_4.cos() / angle.cos() + 0.5);
        let middle = |s: f64, t: f64| -> [f64; 2] {
            let side = |turn: f64, share: f64| {
                let angle = FRAC_PI_4 * (2.0 * share - 1.0);
                let r = edge(angle);
                [r * (turn + angle).cos(), r * (turn + angle).sin()]
            };
            let quarter = TAU / 4.0;
            let [right, left] = [side(0.0, t), side(2.0 * quarter, 1.0 - t)];
            let [upper, lower] = [side(quarter, 1.0 - s), side(3.0 * quarter, s)];
            let corner = |a: f64, b: f64| [a, b].map(|x| x * edge(FRAC_PI_4) * FRAC_PI_4.cos());
            let corners = [
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(-1.0, 1.0),
                corner(1.0, 1.0),
            ];
            std::array::from_fn(|c| {
                left[c] * (1.0 - s) + right[c] * s + lower[c] * (1.0 - t) + upper[c] * t
                    - (corners[0][c] * (1.0 - s) + corners[1][c] * s) * (1.0 - t)
                    - (corners[2][c] * (1.0 - s) + corners[3][c] * s) * t
            })
        };
        let mut known: HashMap<[i64; 2], usize> = HashMap::new();
        let mut places: Vec<[f64; 2]> = Vec::new();
        let mut node = |x: [f64; 2]| {
            let key = x.map(|x| (x * 1e7).round() as i64);
            // Neighbours of the rounded place are the same node
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                if let Some(&node) = known.get(&[key[0] + dx, key[1] + dy]) {
                    return node;
                }
            }
            known.insert(key, places.len());
            places.push(x);
            places.len() - 1
        };
        let (mut quads, mut edges) = (Vec::new(), Vec::new());
        let n = degree + 1;
        for (y, x) in (0..core).flat_map(|y| (0..core).map(move |x| (y, x))) {
            let at = |k: usize| middle(along[x * degree + k % n], along[y * degree + k / n]);
            quads.push((0..n * n).map(|k| node(at(k))).collect());
        }
        for (ring, a) in (0..radial).flat_map(|ring| (0..4 * core).map(move |a| (ring, a))) {
            if ring + 1 == radial {
                let outer = Side {
                    axis: 0,
                    upper: true,
                };
                edges.push((quads.len(), outer, 0));
            }
            let at = |k: usize| -> [f64; 2] {
                let (i, j) = (ring * degree + k % n, a % core * degree + k / n);
                let angle = FRAC_PI_4 * (2.0 * along[j] - 1.0);
                let r = edge(angle) * (1.0 - rings[i]) + rings[i];
                let turned = TAU / 4.0 * (a / core) as f64 + angle;
                [r * turned.cos(), r * turned.sin()]
            };
            quads.push((0..n * n).map(|k| node(at(k))).collect());
        }
        let plane = Plane {
            nodes: places.len(),
            quads,
            edges,
        };
        Self { plane, places }
    }
}

/// Fields are stored one component after the other.
fn components(vectors: impl Iterator<Item = Vec3> + Clone) -> Vec<f64> {
    (0..3)
        .flat_map(|c| vectors.clone().map(move |v| v[c]))
        .collect()
}

/// Seconds of the processors that all threads of this process have taken.
fn processor_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").expect("Linux");
    let nanoseconds = |task: std::fs::DirEntry| -> Option<f64> {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse().ok()
    };
    tasks.flatten().filter_map(nanoseconds).sum::<f64>() * 1e-9
}

/// The most memory that this process has had, GB.
fn gigabytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|line| line.trim().trim_end_matches(" kB").trim().parse().ok());
    kilobytes.unwrap_or(0.0_f64) * 1024e-9
}
