//! What a run leaves: VTU/PVD for ParaView, CSV and JSON for everything else, figures, and the line of progress.

pub mod comparison;
mod field_series;
pub mod figure;
pub mod phases;
pub mod probes;
pub mod progress;
pub mod record;
pub mod report;
pub mod results;
pub mod run_files;
pub mod stress_fields;
pub mod tables;
pub mod terminal;
pub mod tube_results;
pub mod vtu;
pub mod wall_fields;
pub mod wall_history;
pub mod wall_record;

pub use crate::files::{sync_folder, write_atomically};
