//! What is known of a case without a coupled run: its sizes, [its regions](regions()), [the sizes of its
//! flow](flow_numbers()), its plausibility; and tubes under internal pressure, without a fluid, what `fsi-driver solid` computes.
//!
//! [`solid_file`] reads the description of a tube, [`tube`] inflates it and measures, [`motion`] lets the pressure vary
//! in time.

pub(crate) mod case_figures;
mod deviation;
mod expected_pressures;
mod flow_numbers;
pub(crate) mod motion;
pub mod plausibility;
pub mod random_lumen;
mod regions;
pub mod size;
pub mod solid_file;
pub(crate) mod three_elements;
pub(crate) mod tube;
pub(crate) mod tube_law;
pub(crate) mod wall;
pub(crate) mod windkessel;

pub use deviation::Deviation;
pub use flow_numbers::{flow_numbers, flow_numbers_of};
pub use regions::{
    ARTERY, BYPASS, MID_ARTERY, cross_sections, middle_of_artery, regions, wet_surface,
};
pub use size::{centre_line, wall_memory};
