//! Ends of a tree that are left out, since the others have a mesh without them.

use super::ends::Ends;
use super::smoothing::Smoothing;
use super::{ProposalError, ProposalInput};
use crate::case::{LengthUnit, listed};
use crate::geometry::tree::Tree;
use crate::pfem::solution::listener::Work;
use fsi_numerics::quadrature::Rule;

/// Lines are smoothed more if that keeps so much more of the flow ...
const WORTH: f64 = 0.02;
/// ... or makes the worst cell better, up to this scaled Jacobian, which counts as so much of the flow.
const GOOD: f64 = 0.25;
const OF_QUALITY: f64 = 0.3;
/// Points of an element of usual degree along each direction.
const NODES: usize = 5;
/// Most ends that are named in a refusal.
const NAMED: usize = 6;
/// With more ends a refusal does not search for those to leave out: that would take minutes.
const SEARCHED: usize = 12;

/// Ends of a tree that are left out.
pub(super) struct Impossible {
    /// Names of the ends, their shares of the flow, their radii (m), and why.
    ends: Vec<(String, f64, f64, String)>,
    /// How the lines are smoothed.
    pub smoothing: Smoothing,
    /// The smallest scaled Jacobian of what is left.
    worst: f64,
}

/// Finds what has to be left out: of the lines as they are or smoothed, whichever keeps more of the flow.
///
/// # Errors
/// If less than two ends would be left.
pub(super) fn of(
    input: &ProposalInput,
    unit: LengthUnit,
    ends: &Ends,
) -> Result<Impossible, ProposalError> {
    let _work = Work::begin("looking for ends without which the others have a mesh");
    let mut best: Option<Impossible> = None;
    let mut first = None;
    for smoothing in Smoothing::tried(input, ends) {
        match with(input, unit, ends, smoothing) {
            Ok(found) => {
                let worth = |best: &Impossible| found.value() >= best.value() + WORTH;
                if best.as_ref().is_none_or(worth) {
                    best = Some(found);
                }
            }
            // What is wrong with smoother lines may come from that.
            Err(reason) => {
                first.get_or_insert(reason);
            }
        }
        if (best.as_ref()).is_some_and(|best| best.share() < WORTH && best.worst > GOOD) {
            break;
        }
    }
    best.ok_or_else(|| first.unwrap_or_else(|| "no line is left".into()))
}

/// As [`of`], with lines that are smoothed so.
fn with(
    input: &ProposalInput,
    unit: LengthUnit,
    ends: &Ends,
    smoothing: Smoothing,
) -> Result<Impossible, ProposalError> {
    let mut keys = ends.keys(input, unit);
    smoothing.put_into(&mut keys);
    keys.lumen.clone_from(&input.lumen);
    keys.lumen_unit = input.lumen_unit;
    // The mesh of the preset that comes first.
    (keys.core, keys.radial, keys.length) = (Some(4), Some(3), Some(0.6));
    let failed =
        |reason: String| ProposalError::Input(format!("--from {}: {reason}", input.shown_lines()));
    keys.read().map_err(|(_, reason)| failed(reason))?;
    let nodes = Rule::gauss_lobatto(NODES).points;
    let flows = ends.lines.iter().map(|(_, share, _)| *share).collect();
    let found = Tree::impossible_ends(&keys, flows, &nodes);
    let (found, worst) = found.map_err(|mistake| {
        failed(format!(
            "{mistake}; there are no ends without which the others have a mesh"
        ))
    })?;
    let left_out = found.into_iter().filter_map(|(name, reason)| {
        let (_, share, radius) = ends.lines.iter().find(|(other, ..)| *other == name)?;
        Some((name, *share, *radius, reason.briefly()))
    });
    Ok(Impossible {
        ends: left_out.collect(),
        smoothing,
        worst,
    })
}

/// What a refusal says of it, if it helps.
pub(super) fn advice(input: &ProposalInput, unit: LengthUnit, ends: &Ends) -> String {
    if input.leaves_impossible_out {
        return String::new();
    }
    if ends.lines.len() > SEARCHED {
        return "; --leave-out-impossible finds ends without which the others have a mesh, if there are such".into();
    }
    match of(input, unit, ends) {
        Ok(found) if !found.ends.is_empty() => {
            let names: Vec<String> = found.ends.iter().map(|(name, ..)| name.clone()).collect();
            format!(
                "; --leave-out-impossible leaves out {} of the {} ends ({}), {:.1} % of the flow, and says why of each",
                found.ends.len(),
                ends.lines.len(),
                listed(&names, NAMED),
                100.0 * found.share()
            )
        }
        _ => String::new(),
    }
}

impl Impossible {
    /// What it is worth: the share of the flow that is kept, and the quality.
    fn value(&self) -> f64 {
        OF_QUALITY * self.worst.min(GOOD) - self.share()
    }

    /// Share of the flow that is left out.
    fn share(&self) -> f64 {
        self.ends.iter().map(|(_, share, ..)| share).sum()
    }

    /// What is to be said of it.
    pub fn remarks(&self, count: usize) -> Vec<String> {
        if self.ends.is_empty() {
            return Vec::new();
        }
        let whole = format!(
            "left out  {} of {count} ends, with {:.1} % of the flow, since the others have a mesh without them:",
            self.ends.len(),
            100.0 * self.share()
        );
        let each = self.ends.iter().map(|(name, share, radius, reason)| {
            format!(
                "          {name} ({:.1} %, radius {:.2} mm): {reason}",
                100.0 * share,
                1e3 * radius
            )
        });
        [whole].into_iter().chain(each).collect()
    }

    /// Leaves them out.
    pub fn put_into(&self, input: &mut ProposalInput, ends: &Ends) {
        if !input.split.is_empty() {
            let kept = ends.names[1..].iter().zip(&input.split);
            let kept = kept.filter(|(name, _)| !self.ends.iter().any(|(other, ..)| other == *name));
            let kept: Vec<f64> = kept.map(|(_, share)| *share).collect();
            let sum: f64 = kept.iter().sum();
            input.split = kept.into_iter().map(|share| share / sum).collect();
        }
        let names = self.ends.iter().map(|(name, ..)| name.clone());
        input.leave_out.extend(names);
    }
}
