//! What is known of a step before it is solved: the geometry at its end, and the equations.

use super::{BoundaryConditions, Flow, FlowState};
use crate::FlowError;
use crate::flux::Flux;
use crate::metric::Metric;
use crate::open_inflow::Moving;
use crate::oseen::Terms;
use crate::rheology::ViscosityField;
use crate::shear_thinning::VariableViscosity;
use crate::time_scheme::{Weights, extrapolation};

/// A step from a state to given positions of the nodes.
pub(super) struct Step<'a> {
    state: &'a FlowState,
    boundary: &'a BoundaryConditions,
    positions: &'a [f64],
    /// Weights of the backward difference.
    pub w: Weights,
    /// The geometry at the end of the step.
    pub metric: Metric,
    /// Velocity of the mesh, m/s.
    mesh_velocity: Vec<f64>,
    /// The flow through each open end.
    pub fluxes: Vec<Flux>,
    /// What each open end sweeps, m³/s.
    pub swept: Vec<f64>,
    /// Pressure at each open end, Pa, and for each unit of flow through it, Pa s/m³.
    pressures: Vec<[f64; 2]>,
    /// Weights of the last two states, extrapolated to the end of the step.
    extrapolation: [f64; 2],
}

impl Step<'_> {
    /// Fields of the last two states, extrapolated to the end of the step.
    pub fn extrapolated(&self, [last, before]: &[Vec<f64>; 2]) -> Vec<f64> {
        let [a, b] = self.extrapolation;
        let pairs = last.iter().zip(before);
        pairs.map(|(last, before)| a * last + b * before).collect()
    }
}

impl Flow {
    pub(super) fn step<'a>(
        &self,
        state: &'a FlowState,
        time_step: f64,
        positions: &'a [f64],
        boundary: &'a BoundaryConditions,
    ) -> Result<Step<'a>, FlowError> {
        let w = self.weights(state, time_step);
        let swept: Vec<f64> = (self.open.iter())
            .map(|end| {
                let faces = end.faces.iter();
                let rates = faces.flat_map(|&face| self.swept_rates(state, w, face, positions));
                rates.sum()
            })
            .collect();
        // What an end that moves along the vessel sweeps does not leave it: p = p_c + R (∫ u·n - swept)
        let pressures = (swept.iter().enumerate())
            .map(|(end, swept)| {
                let [constant, per_flow] = boundary.pressures.get(end).copied().unwrap_or_default();
                [constant - per_flow * swept, per_flow]
            })
            .collect();
        Ok(Step {
            state,
            boundary,
            positions,
            w,
            metric: Metric::new(&self.space, positions)?,
            mesh_velocity: self.mesh_velocity(state, time_step, positions),
            fluxes: (self.open.iter())
                .map(|end| Flux::through(&self.space, &end.faces, positions))
                .collect(),
            swept,
            pressures,
            extrapolation: extrapolation(time_step, state.before),
        })
    }

    /// The terms of the equations, linearized about the extrapolated velocity `guess` (m/s).
    pub(super) fn terms(&self, step: &Step<'_>, guess: &[f64]) -> Terms {
        let (space, density) = (&self.space, self.settings.density);
        let Step { w, metric, .. } = step;
        let nodes = space.space.nodes;
        // The velocity that convects is relative to the mesh: `rho (u - w)·∇u`
        let relative: Vec<f64> = (guess.iter().zip(&step.mesh_velocity))
            .map(|(u, w)| u - w)
            .collect();
        // `rho ∂u/∂t` by backward differences: the new velocity's part on the left, the rest on the right
        let inertia = density * w.new;
        let mut mass: Vec<f64> = metric.mass.iter().map(|m| inertia * m).collect();
        let mut rhs = self.momentum(step);
        rhs.extend(self.swept_sources(step.state, *w, step.positions, &step.mesh_velocity));
        // Fluid that enters at an open end brings a velocity of its own
        let moving = Moving {
            density,
            positions: step.positions,
            relative: &relative,
            mesh: &step.mesh_velocity,
        };
        for (end, flux) in self.open.iter().zip(&step.fluxes) {
            for entry in end.entries(space, flux, &moving) {
                mass[entry.node] += entry.rate;
                for c in 0..3 {
                    rhs[c * nodes + entry.node] += entry.rate * entry.velocity[c];
                }
            }
        }
        // The part of the stress of a variable viscosity that `div(mu ∇u)` leaves out is a force
        let viscosity = match self.settings.rheology.constant() {
            Some(viscosity) => ViscosityField::Constant(viscosity),
            None => {
                let VariableViscosity { at_gauss, force } =
                    VariableViscosity::new(space, metric, &self.settings.rheology, guess);
                rhs.iter_mut().zip(&force).for_each(|(rhs, f)| *rhs += f);
                ViscosityField::AtGauss(at_gauss)
            }
        };
        Terms {
            convection: metric.convection(space, density, &relative),
            viscosity,
            mass,
            rhs,
            resistances: step.pressures.iter().map(|[_, r]| *r).collect(),
        }
    }

    /// Right-hand sides of the equations of momentum: inertia of the earlier states, constant pressures at the open
    /// ends, loads on the nodes.
    fn momentum(&self, step: &Step<'_>) -> Vec<f64> {
        let Step { w, metric, .. } = step;
        let nodes = self.space.space.nodes;
        let [last, before] = &step.state.velocity;
        let mut rhs = vec![0.0; 3 * nodes];
        for (k, rhs) in rhs.iter_mut().enumerate() {
            let earlier = w.old * last[k] + w.older * before[k];
            *rhs = -self.settings.density * metric.mass[k % nodes] * earlier;
        }
        for (flux, [constant, _]) in step.fluxes.iter().zip(&step.pressures) {
            flux.add_force(nodes, -constant, &mut rhs);
        }
        rhs.iter_mut()
            .zip(&step.boundary.load)
            .for_each(|(r, load)| *r += load);
        rhs
    }
}
