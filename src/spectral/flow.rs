//! A time step of the incompressible Navier-Stokes equations on a moving mesh.
//!
//! In ALE form, with the mesh's velocity **w**: `rho (∂u/∂t|mesh + (u - w)·∇u) = -∇p + mu Δu`, `div u = 0`. Velocity
//! and pressure of a step are found together, without splitting; convection is linearized by extrapolation in time.

pub mod preconditioner;
mod step;

use super::FlowError;
use super::clock::{Clock, SolverPart};
use super::gmres::Workspace;
use super::local::Local;
use super::metric::Metric;
use super::open_inflow::OpenEnd;
use super::oseen::{EndResponses, Oseen};
use super::patience::Patience;
use super::spectral_elements::SpectralElements;
use super::surface::face_values;
use super::taylor_hood_space::{Boundary, Face};
use super::time_scheme::{self, TimeScheme, Weights};
use crate::Vec3;
use crate::rheology::Rheology;
use preconditioner::{MadeFor, Preconditioner};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The fluid, and how its equations are solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowSettings {
    /// Density, kg/m³.
    pub density: f64,
    /// Viscosity by rate of shear.
    pub rheology: Rheology,
    /// Time integration.
    pub scheme: TimeScheme,
    /// Size of the estimated error at which the iteration ends, relative to that of the solution.
    pub tolerance: f64,
    /// Most iterations of a solution.
    pub max_iterations: usize,
}

/// What the fluid is at the end of a step, and what it was a step earlier. Fields are stored one component after the
/// other.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FlowState {
    /// Time, s.
    pub time: f64,
    /// Length of the last step, if there was one, s.
    pub before: Option<f64>,
    /// Positions of the nodes, the newest first, m.
    pub positions: [Vec<f64>; 2],
    /// Velocities, m/s.
    pub velocity: [Vec<f64>; 2],
    /// Pressures, Pa.
    pub pressure: [Vec<f64>; 2],
    /// What the preconditioner was made for.
    pub preconditioner: Option<MadeFor>,
}

/// Conditions on the boundary during a step.
#[derive(Debug, Clone, Default)]
pub struct BoundaryConditions {
    /// Velocities of which those at fixed nodes count, m/s.
    pub velocity: Vec<f64>,
    /// Pressure at each open end: a constant (Pa) and a part for each unit of flow out of it (Pa s/m³). Zero where
    /// there is none.
    pub pressures: Vec<[f64; 2]>,
    /// Forces on the nodes, N; empty if there are none.
    pub load: Vec<f64>,
}

/// A solution that can be thrown away.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowSolution {
    /// Length of the step, s.
    pub time_step: f64,
    /// Positions of the nodes, m.
    pub positions: Vec<f64>,
    /// Velocity, m/s.
    pub velocity: Vec<f64>,
    /// Pressure, Pa.
    pub pressure: Vec<f64>,
    /// Forces that hold the velocity of the fixed nodes, `∫ v_i·(mu ∂u/∂n - p n)` over the boundary, N.
    pub reactions: Vec<f64>,
    /// Flow out of each open end relative to its motion, m³/s.
    pub outflows: Vec<f64>,
    /// Volume of the mesh, m³.
    pub volume: f64,
    /// Iterations that were spent.
    pub iterations: usize,
    /// Estimated error in the end, relative to the size of the solution.
    pub residual: f64,
}

/// Solves the steps.
pub struct Flow {
    space: SpectralElements,
    settings: FlowSettings,
    fixed: Vec<bool>,
    fixed_faces: Vec<Face>,
    moving_walls: Vec<Face>,
    open: Vec<OpenEnd>,
    /// Twice the volume over the area of the boundary with prescribed velocity: the radius of a tube, m.
    width: f64,
    preconditioner: Option<Preconditioner>,
    /// Made in the first trial of a step, for all of them.
    ends: Option<EndResponses>,
    workspace: Workspace,
    local: Local,
    clock: Clock,
    patience: Patience,
}

impl Flow {
    /// With prescribed velocity on the faces of `fixed`; where these are among `moving_walls` as well the velocity is
    /// the wall's, and the fluid makes room for what it sweeps to the last digit. The rest of the boundary is open:
    /// under the pressures of the `open` ends, and without any where it belongs to none.
    pub fn new(
        space: SpectralElements,
        settings: FlowSettings,
        fixed: &[Face],
        moving_walls: Vec<Face>,
        open: Vec<OpenEnd>,
        positions: &[f64],
    ) -> Result<Self, FlowError> {
        let mut is_fixed = vec![false; space.space.nodes];
        for node in space.space.nodes_of(fixed) {
            is_fixed[node] = true;
        }
        let area: f64 = (fixed.iter())
            .flat_map(|&face| space.face_points(face, positions).areas)
            .map(|area| area.norm())
            .sum();
        let width = 2.0 * Metric::new(&space, positions)?.volume / area;
        Ok(Self {
            local: Local::new(&space),
            space,
            settings,
            fixed: is_fixed,
            fixed_faces: fixed.to_vec(),
            moving_walls,
            open,
            width,
            preconditioner: None,
            ends: None,
            workspace: Workspace::default(),
            clock: Clock::default(),
            patience: Patience::default(),
        })
    }

    /// Seconds of wall-clock time by part of the work.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// For those who have more to add.
    pub fn clock_mut(&mut self) -> &mut Clock {
        &mut self.clock
    }

    /// Solutions that take long are given up once this flag is set.
    pub fn give_up_at(&mut self, interrupt: Arc<AtomicBool>) {
        self.patience = Patience::until(interrupt);
    }

    /// Sets the tolerance of the solutions; gives the one before.
    pub fn set_tolerance(&mut self, tolerance: f64) -> f64 {
        std::mem::replace(&mut self.settings.tolerance, tolerance)
    }

    /// The elements.
    pub fn space(&self) -> &SpectralElements {
        &self.space
    }

    /// Weights of the backward difference over the coming step.
    pub fn weights(&self, state: &FlowState, time_step: f64) -> Weights {
        time_scheme::weights(self.settings.scheme, time_step, state.before)
    }

    /// Velocity (m/s) of a mesh that comes to lie at `positions` (m).
    pub fn mesh_velocity(&self, state: &FlowState, time_step: f64, positions: &[f64]) -> Vec<f64> {
        let w = self.weights(state, time_step);
        let [last, before] = &state.positions;
        (positions.iter().zip(last).zip(before))
            // Differences, so that a mesh at rest has no velocity at all
            .map(|((new, last), before)| w.new * (new - last) - w.older * (last - before))
            .collect()
    }

    /// `mu ∂u/∂n` (Pa) at the nodes of the mantle, one component after the other and zero elsewhere, from the forces
    /// that hold the velocity there: consistent with the equations of momentum, and more accurate than the gradient of
    /// the velocity (Gresho, Lee, Sani, Maslanik and Eaton 1987). The nodes' own rule spreads the forces over the wall.
    pub fn viscous_reactions(&self, solution: &FlowSolution) -> Vec<f64> {
        let (space, positions) = (&self.space, &solution.positions);
        let mut forces = solution.reactions.clone();
        let values = &space.basis.pressure_to_gauss;
        let of_faces: Vec<(Vec<usize>, Vec<Vec3>, Vec<f64>)> = (self.fixed_faces.par_iter())
            .map(|&face| {
                let points = space.face_points(face, positions);
                let nodal = space.face_pressures(face).into_iter();
                let nodal: Vec<f64> = nodal.map(|i| solution.pressure[i]).collect();
                let pressures = face_values(values, values, &nodal).into_iter();
                let loads = points.areas.iter().zip(pressures);
                let loads = loads.map(|(area, p)| area * p).collect();
                let areas = match face.patch {
                    Boundary::Mantle(_) => space.face_node_areas(face, positions),
                    _ => Vec::new(),
                };
                (points.nodes, loads, areas)
            })
            .collect();
        let nodes = space.space.nodes;
        let mut areas = vec![0.0; nodes];
        for (of_face, loads, node_areas) in &of_faces {
            space.add_face_load(of_face, loads, &mut forces);
            let node_areas = of_face.iter().zip(node_areas);
            node_areas.for_each(|(&node, area)| areas[node] += area);
        }
        for (k, force) in forces.iter_mut().enumerate() {
            let area = areas[k % nodes];
            *force = if area > 0.0 { *force / area } else { 0.0 };
        }
        forces
    }

    /// Solves a step of the length `time_step` (s) from `state`, with the nodes at `positions` (m) in the end. `start`
    /// is an earlier trial of this step to start the iteration from.
    ///
    /// # Errors
    /// If the mesh is inside out, the pressure is not fixed by any outlet, the equations are not solved to the
    /// tolerance, or the solution is given up.
    pub fn solve(
        &mut self,
        state: &FlowState,
        time_step: f64,
        positions: Vec<f64>,
        boundary: &BoundaryConditions,
        start: Option<&FlowSolution>,
    ) -> Result<FlowSolution, FlowError> {
        // As one task of the pool of threads: a loop that is begun from outside wakes every thread, and then the caller
        rayon::scope(|_| self.solve_here(state, time_step, positions, boundary, start))
    }

    fn solve_here(
        &mut self,
        state: &FlowState,
        time_step: f64,
        positions: Vec<f64>,
        boundary: &BoundaryConditions,
        start: Option<&FlowSolution>,
    ) -> Result<FlowSolution, FlowError> {
        if start.is_none() || self.preconditioner.is_none() {
            let begin = Instant::now();
            self.prepare(state, self.weights(state, time_step).new)?;
            self.clock.add(SolverPart::Factorization, begin);
        }
        let begin = Instant::now();
        let step = self.step(state, time_step, &positions, boundary)?;
        let guess = step.extrapolated(&state.velocity);
        let terms = self.terms(&step, &guess);
        let weights = self.norm_weights(&step.metric, step.w.new);
        let preconditioner = self.preconditioner.as_ref().expect("it has been made");
        let nodes = self.fixed.len();
        let mut x = start.map_or(guess, |trial| trial.velocity.clone());
        for (k, x) in x.iter_mut().enumerate() {
            if self.fixed[k % nodes] {
                *x = boundary.velocity[k];
            }
        }
        x.extend(start.map_or_else(
            || step.extrapolated(&state.pressure),
            |trial| trial.pressure.clone(),
        ));
        let mut system = Oseen {
            inverse_diagonal: (preconditioner.made_for).inverse_diagonal(&self.fixed, &terms.mass),
            terms,
            fixed: &self.fixed,
            fluxes: &step.fluxes,
            schur: &preconditioner.schur,
            scale: step.w.new / preconditioner.made_for.weight,
            weights,
            ends: self.ends.take().filter(|_| start.is_some()),
            local: &mut self.local,
            metric: &step.metric,
            space: &self.space,
            clock: &mut self.clock,
            patience: &self.patience,
        };
        system.clock.add(SolverPart::Geometry, begin);
        let until = (self.settings.tolerance, self.settings.max_iterations);
        let outcome = system.solve(&mut x, &positions, until, &mut self.workspace)?;
        let reactions = system.reactions(&x);
        self.ends = system.ends;
        let pressure = x.split_off(3 * nodes);
        Ok(FlowSolution {
            time_step,
            outflows: (step.fluxes.iter().zip(&step.swept))
                .map(|(flux, swept)| flux.of(nodes, &x) - swept)
                .collect(),
            volume: step.metric.volume,
            positions,
            velocity: x,
            pressure,
            reactions,
            iterations: outcome.iterations,
            residual: outcome.residual,
        })
    }

    /// Makes a trial the state from which the next step starts.
    pub fn accept(&self, state: &mut FlowState, trial: FlowSolution) {
        state.time += trial.time_step;
        state.before = Some(trial.time_step);
        for (fields, new) in [
            (&mut state.positions, trial.positions),
            (&mut state.velocity, trial.velocity),
            (&mut state.pressure, trial.pressure),
        ] {
            fields.swap(0, 1);
            fields[0] = new;
        }
        if let Some(preconditioner) = &self.preconditioner {
            state.preconditioner = Some(preconditioner.made_for.clone());
        }
    }

    /// Sees to a preconditioner that depends on `state` alone: that of the state if it is near enough, or a new one.
    fn prepare(&mut self, state: &FlowState, weight: f64) -> Result<(), FlowError> {
        let made_for = MadeFor::choose(&self.space, &self.settings, self.width, state, weight)?;
        let there = self.preconditioner.as_ref();
        if there.is_none_or(|there| there.made_for != made_for) {
            let density = self.settings.density;
            let preconditioner = Preconditioner::new(&self.space, density, &self.fixed, made_for)?;
            self.preconditioner = Some(preconditioner);
        }
        Ok(())
    }

    /// Sources at the moving walls, m³/s, that make up for the difference between the rate at which they sweep volume
    /// and the flow of the mesh's velocity through them in the end: so outflow less inflow is the change of the volume.
    fn swept_sources(
        &self,
        state: &FlowState,
        w: Weights,
        positions: &[f64],
        mesh_velocity: &[f64],
    ) -> Vec<f64> {
        let of_faces: Vec<Vec<f64>> = (self.moving_walls.par_iter())
            .map(|&face| {
                let end = self.space.face_points(face, positions);
                let velocity = self.space.face_field(&end.nodes, mesh_velocity);
                let rates = self.swept_rates(state, w, face, positions).into_iter();
                let points = rates.zip(velocity.iter().zip(&end.areas));
                points.map(|(rate, (u, area))| rate - u.dot(area)).collect()
            })
            .collect();
        let mut sources = vec![0.0; self.space.space.pressures];
        for (&face, at_points) in self.moving_walls.iter().zip(&of_faces) {
            self.space.add_face_source(face, at_points, &mut sources);
        }
        sources
    }

    /// Rate (m³/s) at which the walls and the open ends make room for the fluid, in a step that ends with the nodes at
    /// `positions` (m).
    pub fn growth(&self, state: &FlowState, time_step: f64, positions: &[f64]) -> f64 {
        let w = self.weights(state, time_step);
        let open = self.open.iter().flat_map(|end| &end.faces);
        let faces = self.moving_walls.iter().chain(open);
        let rates = faces.flat_map(|&face| self.swept_rates(state, w, face, positions));
        rates.sum()
    }

    /// Rates (m³/s) at which the surroundings of a face's Gauss points sweep volume at the end of the step.
    fn swept_rates(
        &self,
        state: &FlowState,
        w: Weights,
        face: Face,
        positions: &[f64],
    ) -> Vec<f64> {
        let [last, before] = &state.positions;
        let mut rates = self.swept(face, last, positions);
        rates.iter_mut().for_each(|rate| *rate *= w.new);
        if w.older != 0.0 {
            let earlier = self.swept(face, before, last);
            rates
                .iter_mut()
                .zip(earlier)
                .for_each(|(rate, v)| *rate -= w.older * v);
        }
        rates
    }

    /// Volumes (m³) that the surroundings of a face's Gauss points sweep on straight ways, by Simpson's rule, which is
    /// exact.
    fn swept(&self, face: Face, from: &[f64], to: &[f64]) -> Vec<f64> {
        let space = &self.space;
        let nodes = space.face_nodes(face);
        let [from, to] =
            [from, to].map(|field| nodes.iter().map(|&i| space.vector(field, i)).collect());
        let (from, to): (Vec<Vec3>, Vec<Vec3>) = (from, to);
        let middle: Vec<Vec3> = from.iter().zip(&to).map(|(a, b)| 0.5 * (a + b)).collect();
        let [first, half, last] =
            [from, middle, to].map(|places| space.points_between(nodes.clone(), &places));
        (0..first.areas.len())
            .map(|q| {
                let area = (first.areas[q] + 4.0 * half.areas[q] + last.areas[q]) / 6.0;
                (last.positions[q] - first.positions[q]).dot(&area)
            })
            .collect()
    }

    /// Weights of a norm in which pressures count by the velocities that they cause in a step.
    fn norm_weights(&self, metric: &Metric, weight: f64) -> Vec<f64> {
        let pressures = self.space.space.pressures;
        let share = metric.volume / pressures as f64;
        let scale = 1.0 / (self.settings.density * weight * self.width);
        let velocity = [&metric.mass[..]; 3].concat();
        let pressure = std::iter::repeat_n(share * scale * scale, pressures);
        velocity.into_iter().chain(pressure).collect()
    }
}
