//! Whether the meshes and the time step of a run resolve its flow, and whether laminar flow is what there would be.
//!
//! [`FlowNumbers`] are known before a run; [`Resolution`] adds what its solution shows. A [`ResolutionFinding`] is a
//! sentence about what is doubtful. All limits were measured against finer meshes: `docs/resolution.md`.

mod flow_numbers;
mod solution;

pub use flow_numbers::{FlowNumbers, FlowSetting, Jet, PointSpacing};
pub use solution::{Resolution, jumps};

use serde::{Deserialize, Serialize};

/// What a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Doubt {
    /// Laminar flow.
    Laminar,
    /// The layer at the wall in which pulses are felt.
    Layer,
    /// The jet downstream of a narrow place.
    Jet,
    /// The length of a time step.
    Step,
    /// The polynomials of the fluid's elements at the wall.
    ElementsAtWall,
    /// Those of all elements.
    Elements,
    /// The wall shear of faces side by side.
    Jumps,
}

/// Why the results of a run are doubtful.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResolutionFinding {
    /// What it is about.
    pub doubt: Doubt,
    /// What was found.
    #[serde(with = "crate::numbers")]
    pub value: f64,
    /// What it should not pass.
    #[serde(with = "crate::numbers")]
    pub limit: f64,
    /// What that means, and which key to change.
    pub text: String,
}
