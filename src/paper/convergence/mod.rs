//! The convergence study of section 4.1: three tubes, many discretizations, one reference each.
//!
//! [`cases`] holds the tubes, [`plan`] the discretizations of each figure, [`errors`] the measures (15) and (16),
//! [`table`] the rows, [`figures`] draws them; this file computes a row.

pub mod cases;
pub(crate) mod computation;
pub(crate) mod errors;
pub(crate) mod figures;
pub mod plan;
pub mod table;

use crate::analysis::tube::{self, Tube};
use crate::pfem::solution::stability::AtBifurcation;
use crate::pfem::solution::statics::{Equilibrated, StaticOptions};
use crate::pfem::solution::stats::Stats;
use crate::pfem::space::prolongation::prolong;
use crate::pfem::{Discretization, SolidError};
use cases::Mesh;
use errors::{ErrorProbes, EvaluatedSolution};
use plan::Choice;

/// Lowest degree whose solution starts from that of a lower one.
const DIRECT: usize = 5;

/// A choice computed: its solution at the evaluation points and what it cost.
#[derive(Debug, Clone)]
pub struct Computed {
    /// Displacement coefficients, held ones included.
    pub dofs: usize,
    /// Energy and values at the evaluation points.
    pub solution: EvaluatedSolution,
    /// What it cost.
    pub stats: Stats,
}

/// Inflates the tube of a choice. From degree `DIRECT` on, Newton's method starts from the solution of a degree two
/// lower, and so on down; what that costs is not counted.
pub fn compute(choice: &Choice) -> Result<Computed, SolidError> {
    let tube = choice.case.tube(choice.mesh);
    let options = choice.options();
    let body = tube.discretize(&options)?;
    let start = start(&tube, choice, &body);
    let found = tube.inflate(&body, &options, &statics(1e-10), start)?;
    let found = found.complete()?;
    let energy = tube::measure(&body, &options, &found.displacement)?.energy;
    let probes = ErrorProbes::new(&choice.case.tube(Mesh::Initial), &tube)?;
    Ok(Computed {
        dofs: body.coefficients(),
        solution: probes.evaluate(&body, &found.displacement, energy)?,
        stats: found.stats,
    })
}

/// Walls that lock buckle from element to element, which the study shows as an error like any other: the symmetric
/// solution is followed to the end.
fn statics(tolerance: f64) -> StaticOptions {
    StaticOptions {
        tolerance,
        at_bifurcation: AtBifurcation::Continue,
        ..Default::default()
    }
}

/// The solution of a lower degree in the space of `choice`; none where load steps are as good, or where that fails.
fn start(tube: &Tube, choice: &Choice, body: &Discretization) -> Option<Vec<f64>> {
    if choice.p < DIRECT {
        return None;
    }
    let p = choice.p - 2;
    let lower = Choice {
        p,
        p_thickness: choice.p_thickness.min(p),
        ..*choice
    };
    let options = lower.options();
    let smaller = tube.discretize(&options).ok()?;
    let begin = start(tube, &lower, &smaller);
    let found = tube.inflate(&smaller, &options, &statics(1e-6), begin);
    let found = found.and_then(Equilibrated::complete).ok()?;
    Some(prolong(
        &smaller.numbering,
        &body.numbering,
        &found.displacement,
    ))
}
