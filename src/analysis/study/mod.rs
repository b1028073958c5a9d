//! The convergence study of section 4.1: three tubes, many discretizations, one reference each.
//!
//! [`cases`] holds the tubes, [`plan`] the discretizations of each figure, [`errors`] the measures (15) and (16),
//! [`table`] the rows; this file computes a row.

pub mod cases;
pub mod errors;
pub mod plan;
pub mod table;

use super::tube::{self, Tube};
use crate::pfem::SolidError;
use crate::pfem::statics::StaticOptions;
use crate::pfem::stats::Stats;
use cases::Mesh;
use errors::{Probes, Solution};
use plan::Choice;

/// A choice computed: its solution at the evaluation points and what it cost.
#[derive(Debug, Clone)]
pub struct Computed {
    /// Displacement coefficients, held ones included.
    pub dofs: usize,
    /// Energy and values at the evaluation points.
    pub solution: Solution,
    /// What it cost.
    pub stats: Stats,
}

/// Inflates the tube of a choice.
pub fn compute(choice: &Choice) -> Result<Computed, SolidError> {
    let tube: Tube = choice.case.tube(choice.mesh);
    let options = choice.options();
    let body = tube.discretize(&options)?;
    let found = tube.inflate(&body, &options, &StaticOptions::default())?;
    let energy = tube::measure(&body, &options, &found.displacement)?.energy;
    let probes = Probes::new(&choice.case.tube(Mesh::Initial), &tube)?;
    Ok(Computed {
        dofs: body.coefficients(),
        solution: probes.evaluate(&body, &found.displacement, energy)?,
        stats: found.stats,
    })
}
