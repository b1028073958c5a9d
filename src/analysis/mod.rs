//! Analyses of tubes under internal pressure, without a fluid: what `fsi-driver solid` computes.
//!
//! [`solid_file`] reads the description of a tube, [`tube`] inflates it and measures, [`motion`] lets the pressure vary
//! in time.

pub(crate) mod case_figures;
pub(crate) mod motion;
pub mod plausibility;
pub mod solid_file;
pub(crate) mod three_elements;
pub(crate) mod tube;
pub(crate) mod tube_law;
pub(crate) mod wall;
pub(crate) mod windkessel;
