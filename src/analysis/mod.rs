//! Analyses of tubes under internal pressure, without a fluid: what `fsi-driver solid` computes.
//!
//! [`solid_file`] reads the description of a tube, [`tube`] inflates it and measures, [`motion`] lets the pressure vary in
//! time.

pub mod motion;
pub mod solid_file;
pub mod tube;
pub mod wall;
pub mod windkessel;
