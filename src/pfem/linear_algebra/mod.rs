//! Symmetric sparse matrices, their order of elimination, their factors.

pub mod factor;
pub mod gmres;
pub(super) mod ordering;
pub mod sparse;
mod substitution;
