//! Aneurysms among the ends of a tree: they are no openings, and may be no branches either.

use super::ends::names;
use super::{ProposalError, ProposalInput};
use crate::case::LengthUnit;

/// The input with the ends closed that lie within a sac of the surface; and what is to be said of them.
///
/// # Errors
/// If the names do not fit the lines.
pub(super) fn closed(
    input: &ProposalInput,
    unit: LengthUnit,
) -> Result<(ProposalInput, Vec<String>), ProposalError> {
    let mut input = input.clone();
    let mut keys = input.tree_keys(unit);
    if input.lumen.is_none() || keys.read().is_err() {
        return Ok((input, Vec::new()));
    }
    keys.lumen.clone_from(&input.lumen);
    keys.lumen_unit = input.lumen_unit;
    let names = names(&input, &keys)?;
    let mut sacs: Vec<String> = (keys.sacs().into_iter())
        .map(|line| names[1 + line].clone())
        .collect();
    sacs.retain(|name| !input.leave_out.contains(name) && !input.closed.contains(name));
    let remarks = sacs.iter().map(|name| {
        format!(
            "sac       \"{name}\" lies behind a neck, where the surface is closed and round: no opening (tree.closed; cut the surface \
             off there if it is one)"
        )
    });
    let remarks = remarks.collect();
    input.closed.append(&mut sacs);
    Ok((input, remarks))
}

/// The input without lines of its own for sacs, which a surface has as bulges of its branches; none if it has none.
pub(super) fn as_bulges(input: &ProposalInput) -> Option<ProposalInput> {
    let mut input = input.clone();
    input.leave_out.append(&mut input.closed.clone());
    let is_any = input.lumen.is_some() && !input.closed.is_empty();
    input.closed.clear();
    is_any.then_some(input)
}
