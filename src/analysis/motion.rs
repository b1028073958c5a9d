//! A tube under a pressure that varies in time.

use super::tube::Tube;
use crate::pfem::discretization::Options;
use crate::pfem::element::surface::LoadKind;
use crate::pfem::solution::newton::NewtonOptions;
use crate::pfem::solution::statics::StaticOptions;
use crate::pfem::solution::structure::State;
use crate::pfem::solution::time_scheme::TimeScheme;
use crate::pfem::supports::PressureAround;
use crate::pfem::{Solid, SolidError, Structure, StructureOptions, SurfaceLoad};
use serde::Serialize;

/// Relative residual at which Newton's method ends in each step.
const TOLERANCE: f64 = 1e-8;

/// Inertia and the course of the load.
#[derive(Debug, Clone, PartialEq)]
pub struct Dynamics {
    /// Density of the reference configuration, kg/m³.
    pub density: f64,
    /// Mass-proportional damping, 1/s.
    pub damping: f64,
    /// Time step, s.
    pub step: f64,
    /// Number of time steps.
    pub steps: usize,
    /// Times (s) at which the load is given, ascending.
    pub times: Vec<f64>,
    /// Share of the full pressure at these times; linear in between, constant before and after.
    pub factors: Vec<f64>,
}

impl Dynamics {
    /// Share of the full pressure at time `t` (s).
    pub fn factor(&self, t: f64) -> f64 {
        let next = self.times.partition_point(|&time| time <= t);
        match next {
            0 => self.factors[0],
            n if n == self.times.len() => self.factors[n - 1],
            n => {
                let share = (t - self.times[n - 1]) / (self.times[n] - self.times[n - 1]);
                (1.0 - share) * self.factors[n - 1] + share * self.factors[n]
            }
        }
    }
}

/// A row of `history.csv`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct Moment {
    /// Time.
    pub time_s: f64,
    /// Pressure.
    pub pressure_Pa: f64,
    /// Mean radial displacement of the inner surface at mid-length.
    pub inner_radial_displacement_m: f64,
    /// Mean radial displacement of the outer surface at mid-length.
    pub outer_radial_displacement_m: f64,
    /// Strain energy.
    pub strain_energy_J: f64,
    /// Kinetic energy.
    pub kinetic_energy_J: f64,
    /// Newton iterations of the step.
    pub newton_iterations: usize,
    /// Relative residual that they reached.
    pub residual: f64,
}

/// A tube in motion, in the beginning at rest in equilibrium without the pressure inside.
pub struct TubeMotion<'a> {
    tube: &'a Tube,
    dynamics: &'a Dynamics,
    energy_points: [usize; 3],
    structure: Structure,
    steps_done: usize,
}

impl<'a> TubeMotion<'a> {
    /// The tube at rest.
    pub fn new(
        tube: &'a Tube,
        options: &Options,
        dynamics: &'a Dynamics,
    ) -> Result<Self, SolidError> {
        let mut structure = Structure::new(
            &tube.mesh,
            &tube.materials,
            &StructureOptions {
                discretization: *options,
                density: dynamics.density,
                damping: dynamics.damping,
                time_scheme: TimeScheme::default(),
                load: LoadKind::default(),
                newton: NewtonOptions::default(),
                wet_surface: "inner".into(),
                supports: tube.supports.clone(),
                outer_pressure: match tube.outer_pressure {
                    0.0 => None,
                    pressure => Some(PressureAround::constant(pressure)),
                },
                gravity: None,
            },
        )?;
        let rest = tube.rest(structure.body(), options, &StaticOptions::default())?;
        let still = vec![0.0; rest.len()];
        structure.set_state(State {
            d: rest,
            v: still.clone(),
            a: still,
        })?;
        Ok(Self {
            tube,
            dynamics,
            energy_points: super::tube::fine_rule(options),
            structure,
            steps_done: 0,
        })
    }

    /// The structure with its present state.
    pub fn structure(&self) -> &Structure {
        &self.structure
    }

    /// One time step.
    pub fn advance(&mut self) -> Result<Moment, SolidError> {
        self.steps_done += 1;
        let time = self.steps_done as f64 * self.dynamics.step;
        let pressure = self.dynamics.factor(time) * self.tube.pressure;
        let points = self.structure.wet_points().len();
        let load = SurfaceLoad::uniform_pressure(pressure, points);
        let trial = self
            .structure
            .solve(&load, self.dynamics.step, TOLERANCE, None)?;
        let newton_iterations = trial.stats.iterations;
        let residual = trial.residuals.last().copied().unwrap_or(0.0);
        self.structure.accept(trial);
        let state = self.structure.state();
        let body = self.structure.body();
        let radial = self.tube.radial_displacement(body, &state.d);
        Ok(Moment {
            time_s: time,
            pressure_Pa: pressure,
            inner_radial_displacement_m: radial[0],
            outer_radial_displacement_m: radial[radial.len() - 1],
            strain_energy_J: self.structure.strain_energy(&state.d, self.energy_points)?,
            kinetic_energy_J: self.structure.kinetic_energy(&state.v),
            newton_iterations,
            residual,
        })
    }
}
