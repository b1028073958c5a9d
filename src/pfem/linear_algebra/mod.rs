//! Symmetric sparse matrices, their order of elimination, their factors.

pub mod factor;
pub mod gmres;
mod multifrontal;
pub(super) mod ordering;
pub mod sparse;
mod substitution;
mod tree;
