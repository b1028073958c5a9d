//! Analyses of tubes under internal pressure, without a fluid: what `fsi-driver solid` and `fsi-driver convergence`
//! compute.
//!
//! [`solid_file`] reads the description of a tube, [`tube`] inflates it and measures, [`motion`] lets the pressure vary in
//! time, [`study`] repeats the inflation with many discretizations and compares.

pub mod motion;
pub mod solid_file;
pub mod study;
pub mod tube;
