//! The fluid as a black box: displacement of the wall in, traction on the wall out.
//!
//! [`Fluid`] is all that the coupling knows of a flow solver.

use crate::Vec3;

pub mod openfoam;

/// The wet surface as the fluid's mesh sees it, in the reference configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct FluidInterface {
    /// Reference positions of the wall's mesh points, m.
    pub points: Vec<Vec3>,
    /// Vertices of each wall face as indices into `points`, ordered so that the normal points out of the fluid.
    pub faces: Vec<Vec<u32>>,
    /// Reference positions of the face centres, m.
    pub face_centres: Vec<Vec3>,
}

/// How much work the fluid may spend on one coupling iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluidEffort {
    /// At most this many outer correctors before it answers.
    pub max_correctors: u32,
    /// It answers earlier once the first pressure residual of a corrector is below this.
    pub pressure_residual: f64,
}

/// The fluid's answer to a trial displacement; thrown away when the iteration is repeated.
#[derive(Debug, Clone, PartialEq)]
pub struct FluidTrial {
    /// Load of the fluid on the wall per deformed area at each face of the interface, Pa:
    /// `p n - mu n . dev(2 sym grad u)` with `n` out of the fluid.
    pub tractions: Vec<Vec3>,
    /// Outer correctors that were spent.
    pub correctors: u32,
    /// First pressure residual of the last corrector.
    pub pressure_residual: f64,
}

/// What the fluid reports of an accepted time step.
#[derive(Debug, Clone, PartialEq)]
pub struct FluidStep {
    /// Time at the end of the step, s.
    pub time: f64,
    /// Flow into the domain through the inlet, m³/s.
    pub inflow: f64,
    /// Flow out of the domain through the outlet, m³/s.
    pub outflow: f64,
    /// Area-averaged pressure at the inlet, Pa.
    pub inlet_pressure: f64,
    /// Area-averaged pressure at the outlet (the ramped one that acts on the flow), Pa.
    pub outlet_pressure: f64,
    /// Pressure of the windkessel before the ramp, Pa; equals `outlet_pressure` once the ramp is over.
    pub windkessel_pressure: f64,
    /// Volume of the whole fluid mesh, m³.
    pub volume: f64,
    /// Load on the wall at each face of the interface after the last corrector, Pa.
    pub tractions: Vec<Vec3>,
    /// Its viscous part, `-mu n . dev(2 sym grad u)`: the wall shear stress, as a force of the fluid on the wall, Pa.
    pub wall_shear: Vec<Vec3>,
    /// Largest difference between the fluid's velocity at the wall and the velocity of the wall's mesh, m/s.
    pub wall_velocity_mismatch: f64,
}

/// A flow solver that can repeat a time step with different displacements of the wall.
pub trait Fluid {
    /// The wet surface in the reference configuration.
    fn interface(&self) -> &FluidInterface;

    /// Solves the current time step, `time_step` (s) long, for the trial displacement (m, one vector a point of the
    /// interface). The first call after [`Fluid::accept`] opens the next time step; within a step the length stays.
    fn solve(
        &mut self,
        displacement: &[Vec3],
        time_step: f64,
        effort: FluidEffort,
    ) -> Result<FluidTrial, FluidError>;

    /// Makes the next [`Fluid::solve`] start from the state at the beginning of the step instead of from the last trial:
    /// slower, but the way back from a trial that went astray. Solvers that always do so need not know.
    fn forget_trial(&mut self) {}

    /// Keeps the last trial as the new state. `write` asks the solver to leave its fields on disk.
    fn accept(&mut self, write: bool) -> Result<FluidStep, FluidError>;
}

/// Why a flow solver failed.
#[derive(Debug, thiserror::Error)]
pub enum FluidError {
    /// The solver could not be started, died, did not answer, or spoke wrongly; the text says which, where, and what to do.
    #[error("{0}")]
    Solver(String),
    /// The user ended the run while the solver was at work.
    #[error("interrupted")]
    Interrupted,
}
