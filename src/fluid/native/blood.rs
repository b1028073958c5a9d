//! Blood in a vessel: the flow with its inlet, its windkessel and its moving wall.

use super::FlowError;
use super::basis::Basis;
use super::clock::SolverPart;
use super::decay::highest_modes;
use super::ends::{Coming, NativeOpening, NativeOpenings, OpeningCondition};
use super::field::field;
use super::flow::{BoundaryConditions, Flow, FlowSettings, FlowSolution, FlowState};
use super::lumen_mesh::LumenMesh;
use super::metric::Metric;
use super::open_inflow::OpenEnd;
use super::probes::probe;
use super::spectral_elements::SpectralElements;
use super::taylor_hood_space::{Boundary, Face};
use super::tree_mesh::TreeMesh;
use super::vessel_mesh::{MeshResolution, VesselMesh};
use super::wall_traction::{WallLoad, wall_loads};
use crate::Vec3;
use crate::case::{Case, FluidTimeScheme, Opening, Rheology, Start, VesselSide};
use crate::fluid::{
    ElementModes, Fluid, FluidCost, FluidEffort, FluidError, FluidInterface, FluidMemory,
    FluidProbe, FluidStep, FluidTrial, FluidUsage, HighestModes, OpeningReport, Wanted,
};
use crate::geometry::Vessel;
use crate::geometry::tree::Tree;
use fsi_numerics::twelve_digits;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Size of the estimated error at which a solution ends, relative to that of the flow and to the change of the
/// displacement at which the coupling ends: smaller than what the coupling takes for converged.
const TOLERANCE: f64 = 1e-2;
/// No solution is less accurate than this: a pressure that is high everywhere makes the flow look larger than it is,
/// and what is left then disturbs the coupling.
const LEAST_ACCURATE: f64 = 1e-7;
/// No solution is more accurate than this.
const MOST_ACCURATE: f64 = 1e-11;
/// Tolerance of the beat before the run. Mean wall shear in after two steps of the run, with 40 before: 0.4088 Pa
/// with 1e-5, 0.4046 with this; 0.4047 with 1e-7 and 25, where 1e-6 leads to 0.4016. With 1e-5 H-0.0, after
/// 1,186 iterations, is not periodic within 1.5 beats (means differ by 1.5e-3, with this by 2.7e-4).
const BEFORE: f64 = 1e-6;
/// Most iterations of a solution.
const MOST_ITERATIONS: usize = 400;

/// What continues from one step to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Memory {
    flow: FlowState,
    /// Pressure of the windkessel at each opening (without one, that downstream; 0 without any pressure) at the end of
    /// the last step and of the one before, Pa.
    downstream: Vec<[f64; 2]>,
}

/// The last trial.
struct NativeTrial {
    solution: FlowSolution,
    /// Loads on the faces of the interface.
    loads: Vec<WallLoad>,
    /// The openings.
    openings: Vec<OpeningReport>,
}

/// Blood by spectral elements.
pub struct NativeFluid {
    mesh: Box<dyn LumenMesh>,
    flow: Flow,
    memory: Memory,
    trial: Option<NativeTrial>,
    ends: NativeOpenings,
    /// Displacement of the wall at t = 0, m.
    initial: Vec<Vec3>,
    /// Faces of the deformable wall.
    wall: Vec<Face>,
    /// Which of them, and which part of it, each face of the interface is.
    parts: Vec<(usize, usize)>,
    rheology: Rheology,
    /// Points whose pressure and velocity are asked for, m.
    watched: Vec<Vec3>,
    /// Volumes of the elements at rest, m³.
    element_volumes: Vec<f64>,
}

/// A lumen in elements, and what is prescribed at its ends.
struct MeshedLumen {
    mesh: Box<dyn LumenMesh>,
    /// With the number of the end of the mesh.
    openings: Vec<(Opening, usize)>,
    /// Pressure of the equilibrium at the start, if there is one, Pa.
    equilibrium: Option<f64>,
    scheme: FluidTimeScheme,
    /// What helps where an element is inside out.
    advice: &'static str,
}

impl MeshedLumen {
    /// That of a case.
    fn new(case: &Case) -> Result<Self, FluidError> {
        let failed = |e: &dyn std::fmt::Display| FluidError::Died(e.to_string());
        let period = case.time.period;
        if let Some(tree) = case.tree() {
            let elements = tree.elements();
            let degree = elements.degree();
            let nodes = Basis::new(degree).nodes.points;
            let meshed = Tree::of_elements(tree, &nodes).map_err(|error| failed(&error))?;
            let openings = tree.openings(period).map_err(|error| failed(&error))?;
            let names = tree.names();
            return Ok(Self {
                mesh: Box::new(TreeMesh::new(meshed, degree)),
                openings: openings
                    .into_iter()
                    .filter_map(|opening| {
                        let end = names.iter().position(|name| *name == opening.name)?;
                        Some((opening, end))
                    })
                    .collect(),
                equilibrium: case.initial_wall().map(|initial| initial.pressure),
                scheme: case.fluid_time_scheme(),
                advice: "shorter elements (tree.native.length)",
            });
        }
        let Some(vessel) = case.vessel() else {
            let reason = "the driver's own solver is for vessels, and this is a flag in a channel";
            return Err(FluidError::Died(reason.into()));
        };
        let numbers = &vessel.fluid.native;
        let resolution = MeshResolution {
            degree: numbers.degree,
            core: numbers.core,
            radial: numbers.radial,
            axial_extension: numbers.axial_extension,
            axial_per_section: numbers.axial_per_section,
        };
        let openings = vessel.openings(period).map_err(|error| failed(&error))?;
        let end = |opening: &Opening| match opening.end {
            VesselSide::Start => 0,
            VesselSide::End => 1,
        };
        Ok(Self {
            mesh: Box::new(VesselMesh::new(&Vessel::new(vessel), resolution)),
            openings: (openings.into_iter())
                .map(|opening| {
                    let end = end(&opening);
                    (opening, end)
                })
                .collect(),
            equilibrium: (vessel.start() == Start::Equilibrium)
                .then(|| vessel.equilibrium_pressure()),
            scheme: case.fluid_time_scheme(),
            advice: "more elements along it (fluid.native.axial_per_section)",
        })
    }
}

impl NativeFluid {
    /// At rest in the vessel of a case.
    ///
    /// # Errors
    /// If the vessel cannot be meshed so, or the curve of a flow or a pressure cannot be read.
    pub fn new(case: &Case) -> Result<Self, FluidError> {
        let failed = |e: &dyn std::fmt::Display| FluidError::Died(e.to_string());
        let MeshedLumen {
            mesh,
            openings,
            equilibrium,
            scheme,
            advice,
        } = MeshedLumen::new(case)?;
        let space = SpectralElements::new(mesh.space().clone()).map_err(|error| failed(&error))?;
        let still = vec![Vec3::zeros(); mesh.interface().points.len()];
        let positions = mesh.positions(&still);
        let faces = |wanted: fn(Boundary) -> bool| space.space.faces_of(wanted);
        let walls = faces(|patch| matches!(patch, Boundary::Mantle(_)));
        let wall = mesh.moving_walls();
        let ends = NativeOpenings::new(case, openings, equilibrium, &space, &walls, &positions);
        let open: Vec<OpenEnd> = ends.openings.iter().filter_map(|end| end.open()).collect();
        let is_open = |face: &Face| open.iter().any(|end| end.faces.contains(face));
        let mut fixed = faces(|_| true);
        fixed.retain(|face| !is_open(face));
        let settings = FlowSettings {
            density: case.blood.density,
            rheology: case.blood.rheology(),
            scheme,
            tolerance: (TOLERANCE * case.coupling.e_rel).clamp(MOST_ACCURATE, LEAST_ACCURATE),
            max_iterations: MOST_ITERATIONS,
        };
        let (velocities, pressures) = (3 * space.space.nodes, space.space.pressures);
        let metric = Metric::new(&space, &positions).map_err(|error| match error {
            FlowError::Inverted {
                element,
                position: [x, y, z],
                ..
            } => failed(&format!(
                "element {element} of its mesh is inside out at ({x:.4e}, {y:.4e}, {z:.4e}) m: the vessel bends or narrows too sharply there; \
                 gentler bends or {advice} help"
            )),
            error => failed(&error),
        })?;
        let flow = Flow::new(space, settings, &fixed, wall.clone(), open, &positions)
            .map_err(|error| failed(&error))?;
        let zeros = |n: usize| [vec![0.0; n], vec![0.0; n]];
        Ok(Self {
            memory: Memory {
                flow: FlowState {
                    time: 0.0,
                    before: None,
                    positions: [positions.clone(), positions],
                    velocity: zeros(velocities),
                    pressure: zeros(pressures),
                    preconditioner: None,
                },
                downstream: ends.downstream_at_start(),
            },
            parts: mesh.parts(),
            mesh,
            flow,
            trial: None,
            ends,
            initial: still,
            element_volumes: metric.volumes,
            wall,
            rheology: case.blood.rheology(),
            watched: case
                .output
                .fluid_probes
                .iter()
                .map(|x| (*x).into())
                .collect(),
        })
    }

    /// A step that takes long is given up once this flag is set.
    pub fn give_up_at(&mut self, interrupt: Arc<AtomicBool>) {
        self.flow.give_up_at(interrupt);
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.flow.space().space.elements
    }

    /// The smallest scaled Jacobian at a node of its elements at rest, and where that is, m.
    pub fn worst_element(&self) -> Option<(f64, Vec3)> {
        let positions = &self.memory.flow.positions[0];
        self.flow.space().worst_element(positions)
    }

    /// Iterations of the linear solver in the last trial.
    pub fn iterations(&self) -> usize {
        (self.trial.as_ref()).map_or(0, |trial| trial.solution.iterations)
    }

    /// Pressure and velocity at the points that are watched, at the end of the last accepted step.
    pub fn probes(&self) -> Vec<FluidProbe> {
        self.at(&self.watched)
    }

    /// Velocity (m/s) at points (m), at the end of the last accepted step; zero outside the fluid.
    pub fn velocities(&self, points: &[Vec3]) -> Vec<Vec3> {
        let velocities = self.at(points).into_iter().map(|probe| probe.velocity);
        velocities
            .map(|u| if u.x.is_nan() { Vec3::zeros() } else { u })
            .collect()
    }

    /// Pressure and velocity at points (m), at the end of the last accepted step; NaN outside the fluid.
    fn at(&self, points: &[Vec3]) -> Vec<FluidProbe> {
        let FlowState {
            positions,
            velocity,
            pressure,
            ..
        } = &self.memory.flow;
        let [positions, velocity] = [&positions[0], &velocity[0]];
        probe(self.flow.space(), positions, velocity, &pressure[0], points)
    }

    /// How well the elements resolve the flow at the end of the last accepted step.
    fn element_modes(&self) -> ElementModes {
        let by_element = highest_modes(self.flow.space(), &self.memory.flow.velocity[0]);
        let volume: f64 = self.element_volumes.iter().sum();
        let mut domain = HighestModes::default();
        for (modes, part) in by_element.iter().zip(&self.element_volumes) {
            domain.add(modes, part / volume);
        }
        let at_wall = (self.parts.iter()).map(|&(face, _)| by_element[self.wall[face].element]);
        ElementModes {
            at_wall: at_wall.collect(),
            domain,
        }
    }

    /// Begins with the wall displaced (m), and at rest there. For a fluid that has taken no step.
    pub fn begin_at(&mut self, displacement: Vec<Vec3>) {
        let positions = self.mesh.positions(&displacement);
        self.memory.flow.positions = [positions.clone(), positions];
        self.initial = displacement;
    }

    /// Begins as the blood is after a beat of `period` (s) between walls at rest, from rest in so many steps; tells the
    /// share that is done. For a fluid that has taken no step.
    ///
    /// # Errors
    /// If a step cannot be solved.
    pub fn begin_after_a_beat(
        &mut self,
        period: f64,
        steps: usize,
        tell: impl Fn(f64),
    ) -> Result<(), FluidError> {
        let start = self.memory.clone();
        let (at_rest, time_step) = (self.initial.clone(), period / steps as f64);
        let effort = FluidEffort {
            max_sweeps: 1,
            residual: 0.0,
            from_old_state: false,
        };
        // Between such walls the level of a single pressure has no effect, but the tolerance would be relative to it.
        let is_open = |end: &NativeOpening| end.open().is_some();
        if self.ends.openings.iter().filter(|end| is_open(end)).count() == 1 {
            self.memory.downstream.fill([0.0; 2]);
        }
        let tolerance = self.flow.set_tolerance(BEFORE);
        for step in 1..=steps {
            self.solve(&at_rest, time_step, effort)?;
            self.accept(Wanted::default())?;
            // Implicit Euler, and convection by the flow at the beginning of a step: stable in steps of any length.
            self.memory.flow.before = None;
            tell(step as f64 / steps as f64);
        }
        self.flow.set_tolerance(tolerance);
        let after = std::mem::replace(&mut self.memory, start).flow;
        let [velocity, _] = after.velocity;
        self.memory.flow.velocity = [velocity.clone(), velocity];
        Ok(())
    }

    /// Volume (m³) of the mesh at t = 0, and of its parts with a rigid wall.
    pub fn volumes(&self) -> Result<[f64; 2], FluidError> {
        let positions = self.mesh.positions(&self.initial);
        let metric = Metric::new(self.flow.space(), &positions)
            .map_err(|error| FluidError::NotSolved(error.to_string()))?;
        let elastic = self.mesh.elastic_elements();
        let sum = |volumes: &[f64]| volumes.iter().sum::<f64>();
        let rigid = sum(&metric.volumes[..elastic.start]) + sum(&metric.volumes[elastic.end..]);
        Ok([metric.volume, rigid])
    }

    /// Load per area of each face of the displaced interface, Pa. The pressure acts along the normal of the face, not
    /// along that of the curved part in its middle: a pressure would otherwise pull along the face by the sine of the
    /// angle between them, and uniform pressures, which hold a wall in equilibrium, would move it.
    fn tractions(&self, displacement: &[Vec3], loads: &[WallLoad]) -> Vec<Vec3> {
        let FluidInterface { points, faces, .. } = self.mesh.interface();
        let at = |i: u32| points[i as usize] + displacement[i as usize];
        let faces = faces.iter().zip(loads);
        faces
            .map(|(face, load)| {
                let [a, b] = [at(face[2]) - at(face[0]), at(face[3]) - at(face[1])];
                load.pressure * a.cross(&b).normalize() + load.shear
            })
            .collect()
    }

    /// The load on the parts of the wall, in the order of the interface's faces.
    fn loads(&self, trial: &FlowSolution) -> Vec<WallLoad> {
        let FlowSolution {
            positions,
            velocity,
            pressure,
            ..
        } = trial;
        let space = self.flow.space();
        let by_element = wall_loads(
            space,
            &self.wall,
            &self.rheology,
            positions,
            velocity,
            pressure,
            Some(&self.flow.viscous_reactions(trial)),
        );
        let parts = self.parts.iter();
        parts.map(|&(face, part)| by_element[face][part]).collect()
    }

    /// The openings at the end of a trial, at the time `t` (s).
    fn openings(
        &self,
        t: f64,
        prescribed: &[OpeningCondition],
        trial: &FlowSolution,
    ) -> Vec<OpeningReport> {
        let mut outflows = trial.outflows.iter();
        let ends = self.ends.openings.iter().zip(prescribed);
        ends.map(|(end, prescribed)| {
            let (flow, model_pressure) = match prescribed {
                OpeningCondition::Flow(flow) => (*flow, None),
                OpeningCondition::Downstream(downstream) => {
                    let out = *outflows.next().expect("each open end has a flow");
                    (-out, Some(downstream[0] + downstream[1] * out))
                }
            };
            let exact = model_pressure.and_then(|p| self.ends.pressure_at(end, t, p, -flow));
            OpeningReport {
                name: end.name.clone(),
                flow,
                mean_pressure: exact.unwrap_or_else(|| self.mean_pressure(&end.faces, trial)),
                model_pressure,
            }
        })
        .collect()
    }

    /// Pressure (Pa), mean over faces of an opening.
    fn mean_pressure(&self, faces: &[Face], trial: &FlowSolution) -> f64 {
        let space = self.flow.space();
        let (mut force, mut area) = (0.0, 0.0);
        for &face in faces {
            let points = space.face_points(face, &trial.positions);
            let p: Vec<f64> = space
                .face_pressures(face)
                .into_iter()
                .map(|i| trial.pressure[i])
                .collect();
            let rows = &space.basis.pressure_to_gauss;
            let p = super::surface::face_values(rows, rows, &p);
            for (p, a) in p.iter().zip(&points.areas) {
                force += p * a.norm();
                area += a.norm();
            }
        }
        force / area
    }
}

impl Fluid for NativeFluid {
    fn interface(&self) -> &FluidInterface {
        self.mesh.interface()
    }

    /// One linear system, however many sweeps it may spend: velocity and pressure are found together.
    fn solve(
        &mut self,
        displacement: &[Vec3],
        time_step: f64,
        effort: FluidEffort,
    ) -> Result<FluidTrial, FluidError> {
        if effort.from_old_state {
            self.trial = None;
        }
        let not_finite = |u: &Vec3| !u.iter().all(|c| c.is_finite());
        if let Some(i) = displacement.iter().position(not_finite) {
            let place = self.mesh.interface().points[i];
            return Err(FluidError::NotSolved(format!(
                "the trial displacement of point {i} of the wall, at {:?} m, is not a finite number",
                <[f64; 3]>::from(place)
            )));
        }
        let begin = Instant::now();
        let state = &self.memory.flow;
        let t = state.time + time_step;
        let positions = self.mesh.positions(displacement);
        // The wall's velocity, everywhere: what is not on a wall has none or is not prescribed.
        let mut velocity = self.flow.mesh_velocity(state, time_step, &positions);
        let prescribed = self.ends.prescribed(&Coming {
            time: t,
            weights: self.flow.weights(state, time_step),
            downstream: &self.memory.downstream,
            growth: &|| self.flow.growth(state, time_step, &positions),
        });
        let pressures = self.ends.apply(&prescribed, t, &mut velocity);
        let boundary = BoundaryConditions {
            velocity,
            pressures,
            load: Vec::new(),
        };
        let start = self.trial.as_ref().map(|trial| &trial.solution);
        let start = start.filter(|trial| trial.time_step == time_step);
        self.flow.clock_mut().add(SolverPart::Geometry, begin);
        let trial = (self.flow)
            .solve(&self.memory.flow, time_step, positions, &boundary, start)
            .map_err(|error: FlowError| match error {
                FlowError::Interrupted => FluidError::Interrupted,
                error => FluidError::NotSolved(error.to_string()),
            })?;
        let begin = Instant::now();
        let loads = self.loads(&trial);
        let tractions = self.tractions(displacement, &loads);
        self.flow.clock_mut().add(SolverPart::Loads, begin);
        let cost = FluidCost {
            sweeps: 1,
            residual: trial.residual,
        };
        self.trial = Some(NativeTrial {
            openings: self.openings(t, &prescribed, &trial),
            solution: trial,
            loads,
        });
        Ok(FluidTrial { tractions, cost })
    }

    fn accept(&mut self, wanted: Wanted) -> Result<FluidStep, FluidError> {
        let Some(trial) = self.trial.take() else {
            return Err(FluidError::NotSolved("there is no trial to accept".into()));
        };
        let NativeTrial {
            solution: trial,
            loads,
            openings,
        } = trial;
        let time = self.memory.flow.time + trial.time_step;
        let downstream = openings.iter().map(|opening| opening.model_pressure);
        for (memory, downstream) in self.memory.downstream.iter_mut().zip(downstream) {
            *memory = [downstream.unwrap_or(0.0), memory[0]];
        }
        let (volume, wall_shear) = (trial.volume, loads.iter().map(|load| load.shear));
        self.flow.accept(&mut self.memory.flow, trial);
        Ok(FluidStep {
            time: twelve_digits(time),
            openings,
            volume,
            wall_shear: wall_shear.collect(),
            wall_velocity_mismatch: 0.0, // prescribed at every node
            probes: self.probes(),
            field: (wanted.field).then(|| field(self.flow.space(), &self.memory.flow)),
            element_modes: Some(self.element_modes()),
            usage: FluidUsage::default(),
            seconds_by_part: self.flow.clock().by_part(),
        })
    }

    fn memory(&mut self, _: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError> {
        let state = postcard::to_stdvec(&self.memory)
            .map_err(|error| FluidError::Storage(error.to_string()))?;
        Ok(FluidMemory {
            state,
            files: Vec::new(),
        })
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        let memory: Memory = postcard::from_bytes(&memory.state).map_err(|error| {
            FluidError::Storage(format!(
                "the state of the native fluid cannot be read: {error}"
            ))
        })?;
        let sizes = |state: &FlowState| {
            let FlowState {
                positions,
                velocity,
                pressure,
                ..
            } = state;
            [positions, velocity, pressure].map(|[a, b]| [a.len(), b.len()])
        };
        if sizes(&memory.flow) != sizes(&self.memory.flow) {
            return Err(FluidError::Storage(
                "the state of the native fluid belongs to another mesh".into(),
            ));
        }
        self.memory = memory;
        self.trial = None;
        Ok(())
    }
}
