//! One self-contained page of HTML for a run, or for a study of many: figures with their numbers, maps of the unrolled
//! wall, and a view in three dimensions.

mod along;
mod case_table;
mod cross_check;
mod flow_cut;
mod flow_field;
mod flow_sections;
mod initial_state;
mod junctions;
mod key_figures;
pub(crate) mod maps;
mod measure;
mod openings;
pub(crate) mod page;
mod picture;
mod preview;
pub(crate) mod quantities;
mod refined;
mod resolution;
pub(crate) mod run;
mod samples;
pub(crate) mod scene;
pub(crate) mod study;
pub(crate) mod surface;
mod sweep;
mod table;
mod uncertain_maps;
mod uncertainty;
mod uncertainty_control;
mod uncertainty_export;
mod uncertainty_total;

use super::comparison::Comparison;
use super::refinement::Refined;
use super::results::Results;
pub use page::significant;
pub use preview::Preview;
pub use refined::{RefinementSeries, uncertainty};
pub use samples::distributions;
use std::io;
pub use study::{RefinedPair, Study, agreement, changes, coupling, key_figures};
pub use sweep::table as measures;
pub use table::PageTable;
pub use uncertainty::{SAMPLES, Uncertainty};
pub use uncertainty_control::CONTROL;
pub use uncertainty_export::ExportForm;
pub use uncertainty_total::{MeasuredValue, TOTAL};

/// The page of a run.
pub fn of_run(run: &Results) -> io::Result<String> {
    run::page(run)
}

/// A picture of a run as a text in SVG: the wall cut open, above pressure and flow.
pub fn picture(run: &Results) -> io::Result<String> {
    picture::of_run(run)
}

/// The page of a study.
pub fn of_study(study: &Study) -> io::Result<String> {
    study::page(study)
}

/// The page of named cases that two solvers have computed, some of them on two meshes each.
pub fn of_comparisons(
    compared: &[(String, Comparison)],
    refined: &[(String, Vec<Refined>)],
) -> String {
    cross_check::page(compared, refined)
}
