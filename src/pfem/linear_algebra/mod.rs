//! Symmetric sparse matrices, their order of elimination, their factors.

pub mod factor;
pub(super) mod ordering;
pub mod sparse;
mod substitution;
