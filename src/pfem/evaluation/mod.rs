//! What a deformed body shows: stresses, strains and displacements at points, and their extreme values.

pub mod extremes;
pub mod locate;
pub mod samples;
pub mod stress;
