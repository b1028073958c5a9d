//! What a run leaves: VTU/PVD for ParaView, CSV and JSON for everything else, figures, and the line of progress.

pub mod beats;
pub(crate) mod comparison;
mod field_series;
pub(crate) mod figure;
pub(crate) mod fluid_fields;
mod function_object;
pub(crate) mod marked_text;
pub(crate) mod opening_summary;
pub(crate) mod phases;
mod place_histories;
pub(crate) mod probes;
pub mod progress;
pub mod record;
pub(crate) mod refinement;
pub(crate) mod report;
pub mod results;
pub mod run_files;
pub(crate) mod stress_fields;
pub(crate) mod tables;
pub(crate) mod terminal;
mod time_statistics;
pub(crate) mod tube_results;
pub(crate) mod validation;
pub mod vtu;
pub(crate) mod wall_fields;
pub mod wall_history;
pub(crate) mod wall_record;

pub use crate::files::{sync_folder, write_atomically};
