//! The fluid as a black box: displacement of the wall in, traction on the wall out.
//!
//! [`Fluid`] is all that the coupling and a simulation know of a flow solver: its wall ([`Fluid::interface`]), a verb
//! for a coupling iteration ([`Fluid::solve`]), one for the end of a step ([`Fluid::accept`]), and two for a checkpoint
//! ([`Fluid::memory`], [`Fluid::recall`]).

pub use field::FluidField;

use crate::Vec3;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

pub mod conversation;
pub mod external;
pub(crate) mod field;
pub(crate) mod inlet_velocity;
pub(crate) mod lagrange_cell;
pub mod native;
pub mod openfoam;
pub mod polygonal_wall;

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

impl FluidInterface {
    /// Area vectors (m², out of the fluid) of the faces whose points have moved by `displacement` (m).
    pub fn face_areas(&self, displacement: &[Vec3]) -> Vec<Vec3> {
        face_areas(&self.faces, |point| {
            self.points[point] + displacement[point]
        })
    }
}

/// Area vectors (m²) of faces whose points have these positions (m).
fn face_areas(faces: &[Vec<u32>], position: impl Fn(usize) -> Vec3) -> Vec<Vec3> {
    let area = |face: &Vec<u32>| {
        let first = position(face[0] as usize);
        let edge = |i: usize| position(face[i] as usize) - first;
        (1..face.len() - 1)
            .map(|i| 0.5 * edge(i).cross(&edge(i + 1)))
            .sum()
    };
    faces.iter().map(area).collect()
}

/// How much work the fluid may spend on one coupling iteration. A *sweep* is one pass over the solver's equations: an
/// outer corrector of PIMPLE, an iteration of Newton's or Picard's method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluidEffort {
    /// At most this many sweeps before it answers.
    pub max_sweeps: u32,
    /// It answers earlier once the relative residual with which a sweep began is below this.
    pub residual: f64,
    /// It starts from the state at the beginning of the step instead of from the last trial: slower, but the way back
    /// from a trial that went astray. Solvers that always do so need not look.
    pub from_old_state: bool,
}

/// The work that the fluid did spend.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FluidCost {
    /// Sweeps over its equations.
    pub sweeps: u32,
    /// Relative residual with which the last one began; OpenFOAM's is the first one of the pressure.
    pub residual: f64,
}

/// The fluid's answer to a trial displacement; thrown away when the iteration is repeated.
#[derive(Debug, Clone, PartialEq)]
pub struct FluidTrial {
    /// Load of the fluid on the wall per deformed area at each face of the interface, Pa:
    /// `p n - mu n . dev(2 sym grad u)` with `n` out of the fluid.
    pub tractions: Vec<Vec3>,
    /// What the answer cost.
    pub cost: FluidCost,
}

/// Where the fluid enters or leaves its domain.
#[derive(Debug, Clone, PartialEq)]
pub struct OpeningReport {
    /// Its name: that of the patch, for a solver with a mesh.
    pub name: String,
    /// Flow into the domain, m³/s; negative where the fluid leaves it.
    pub flow: f64,
    /// Pressure, mean over its area, Pa.
    pub mean_pressure: f64,
    /// Pressure that the model downstream of it holds (that of a windkessel, before any ramp), Pa; none without such a
    /// model.
    pub model_pressure: Option<f64>,
}

/// What is wanted of an accepted step beyond the figures that every one has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The state, so that [`Fluid::memory`] may be called.
    pub state: bool,
    /// The flow in the whole domain, for the user: on disk, or as [`FluidStep::field`].
    pub field: bool,
}

impl Wanted {
    /// Whether a solver that keeps state and fields in the same files has to write them.
    pub fn anything(self) -> bool {
        self.state || self.field
    }
}

/// What the fluid reports of an accepted time step. What a solver does not have stays as in `FluidStep::default()`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FluidStep {
    /// Time at the end of the step, s.
    pub time: f64,
    /// The openings: the inlet first, then one or more outlets.
    pub openings: Vec<OpeningReport>,
    /// Volume of the whole domain, m³.
    pub volume: f64,
    /// Viscous part of the load on the wall at each face of the interface, `-mu n . dev(2 sym grad u)`: the wall shear
    /// stress, as a force of the fluid on the wall, Pa.
    pub wall_shear: Vec<Vec3>,
    /// Largest difference between the fluid's velocity at the wall and the velocity of the wall's mesh, m/s.
    pub wall_velocity_mismatch: f64,
    /// Pressure and velocity at the points that the solver was asked to watch.
    pub probes: Vec<FluidProbe>,
    /// The flow in the whole domain, where it was [wanted](Wanted::field); none from a solver that leaves its fields on
    /// disk itself.
    pub field: Option<FluidField>,
    /// How well its elements resolve the flow; none from a solver without polynomials.
    pub element_modes: Option<ElementModes>,
    /// What processes of its own have used so far; nothing for a solver within the driver's own process.
    pub usage: FluidUsage,
    /// Seconds of wall-clock time since the solver was started by named part of its work (`momentum`); empty where it
    /// does not know them, as some do after steps of which nothing was [wanted](Wanted).
    pub seconds_by_part: Vec<(String, f64)>,
}

impl FluidStep {
    /// Flow into the domain through the inlet, m³/s.
    pub fn inflow(&self) -> f64 {
        self.openings.first().map_or(0.0, |inlet| inlet.flow)
    }

    /// The same without what it cost, in which two runs differ.
    pub fn without_costs(self) -> Self {
        Self {
            usage: FluidUsage::default(),
            seconds_by_part: Vec::new(),
            ..self
        }
    }

    /// Flow out of the domain through all outlets, m³/s.
    pub fn outflow(&self) -> f64 {
        (self.openings.iter().skip(1)).fold(0.0, |sum, outlet| sum - outlet.flow)
    }

    /// Mean pressure at the inlet, Pa.
    pub fn inlet_pressure(&self) -> f64 {
        let inlet = self.openings.first();
        inlet.map_or(0.0, |inlet| inlet.mean_pressure)
    }

    /// Mean pressure at the first outlet, Pa.
    pub fn outlet_pressure(&self) -> f64 {
        let outlet = self.openings.get(1);
        outlet.map_or(0.0, |outlet| outlet.mean_pressure)
    }

    /// Pressure of the model downstream of the first outlet, Pa; that of the outlet itself if there is none.
    pub fn outlet_model_pressure(&self) -> f64 {
        let model = (self.openings.get(1)).and_then(|outlet| outlet.model_pressure);
        model.unwrap_or_else(|| self.outlet_pressure())
    }
}

/// The fluid at a point that is watched, at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluidProbe {
    /// Pressure, Pa; NaN if the point does not lie in the fluid.
    pub pressure: f64,
    /// Velocity, m/s; likewise.
    pub velocity: Vec3,
}

/// How much of the velocity stands in the polynomials of the highest degree of a fluid's elements, mean squares, m²/s².
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct HighestModes {
    /// Of that part of the velocity.
    pub highest: f64,
    /// Of the velocity.
    pub all: f64,
}

impl HighestModes {
    /// Adds others, times a weight.
    pub fn add(&mut self, other: &Self, weight: f64) {
        self.highest += weight * other.highest;
        self.all += weight * other.all;
    }

    /// The highest polynomials' part of the velocity, from 0 to about 1: root mean square over that of all; 0 of a
    /// fluid at rest.
    pub fn share(&self) -> f64 {
        match self.all > 0.0 {
            true => (self.highest / self.all).sqrt(),
            false => 0.0,
        }
    }
}

/// How well a fluid's elements resolve the flow.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementModes {
    /// Of the element at each face of the interface.
    pub at_wall: Vec<HighestModes>,
    /// Of the whole domain: mean over its volume.
    pub domain: HighestModes,
}

/// The state of a fluid between two time steps, in a form that can be stored.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct FluidMemory {
    /// Whatever the solver wants to find again.
    pub state: Vec<u8>,
    /// Files on disk that it stands on, for a solver that keeps its state there; nobody changes them.
    pub files: Vec<PathBuf>,
}

/// What a fluid has used in processes of its own.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FluidUsage {
    /// CPU time so far but for that of their starts, s.
    pub cpu_seconds: f64,
    /// Largest memory so far, bytes.
    pub peak_memory: f64,
}

impl FluidUsage {
    /// Of processes one after the other.
    pub(crate) fn and(self, later: Self) -> Self {
        Self {
            cpu_seconds: self.cpu_seconds + later.cpu_seconds,
            peak_memory: self.peak_memory.max(later.peak_memory),
        }
    }
}

/// A solver in a process of its own would end at a trial that is none; that it never hears of it keeps it alive.
pub(crate) fn require_finite(displacement: &[Vec3]) -> Result<(), FluidError> {
    let is_finite = |u: &Vec3| u.iter().all(|c| c.is_finite());
    match displacement.iter().position(|u| !is_finite(u)) {
        Some(i) => Err(FluidError::NotSolved(format!(
            "the trial displacement of point {i} of the wall is not finite"
        ))),
        None => Ok(()),
    }
}

/// A flow solver that can repeat a time step with different displacements of the wall. No method has a
/// default: a wrapper could forget to pass it on.
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

    /// Keeps the last trial as the new state.
    fn accept(&mut self, wanted: Wanted) -> Result<FluidStep, FluidError>;

    /// The state after the last accepted step, to be stored. It is asked for between two steps, before the first one or
    /// after one that was accepted with [`Wanted::state`]. Then what the solver has left on disk at other times (s)
    /// than those that are `needed` is removed.
    ///
    /// # Errors
    /// If the state is not whole, a full disk for example; the solver itself goes on.
    fn memory(&mut self, needed: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError>;

    /// Goes back (or on) to a state that [`Fluid::memory`] has given, perhaps in an earlier process, and continues from
    /// it to the last digit. A solver that has died comes to life again.
    ///
    /// # Errors
    /// If it cannot; it may be tried again.
    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError>;
}

impl<F: Fluid + ?Sized> Fluid for Box<F> {
    fn interface(&self) -> &FluidInterface {
        (**self).interface()
    }

    fn solve(
        &mut self,
        displacement: &[Vec3],
        time_step: f64,
        effort: FluidEffort,
    ) -> Result<FluidTrial, FluidError> {
        (**self).solve(displacement, time_step, effort)
    }

    fn accept(&mut self, wanted: Wanted) -> Result<FluidStep, FluidError> {
        (**self).accept(wanted)
    }

    fn memory(&mut self, needed: &dyn Fn(f64) -> bool) -> Result<FluidMemory, FluidError> {
        (**self).memory(needed)
    }

    fn recall(&mut self, memory: &FluidMemory) -> Result<(), FluidError> {
        (**self).recall(memory)
    }
}

/// Why a flow solver failed.
#[derive(Debug, thiserror::Error)]
pub enum FluidError {
    /// The solver is not there any more: it could not be started, died, did not answer, or spoke wrongly. Only
    /// [`Fluid::recall`] helps. The text says what happened, where, and what to do.
    #[error("{0}")]
    Died(String),
    /// The same, because its solution grew beyond all bounds: only more care helps.
    #[error("{0}")]
    Diverged(String),
    /// It found no solution for this trial, but lives and still has the state at the beginning of the step: a more
    /// careful attempt may help.
    #[error("{0}")]
    NotSolved(String),
    /// What it keeps on disk could not be written or read; it goes on.
    #[error("{0}")]
    Storage(String),
    /// The user ended the run while the solver was at work.
    #[error("interrupted")]
    Interrupted,
}
