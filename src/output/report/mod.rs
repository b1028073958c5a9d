//! One self-contained page of HTML for a run, or for a study of many: figures with their numbers, maps of the unrolled
//! wall, a view in three dimensions, and the paper's findings judged from the numbers.

mod findings;
mod flow_cut;
mod flow_field;
mod flow_sections;
mod maps;
mod page;
mod quantities;
mod run;
mod scene;
mod study;
mod surface;

use super::results::Results;
use crate::case::Extension;
use std::io;
pub use study::Study;

/// The page of a run.
pub fn of_run(run: &Results) -> io::Result<String> {
    run::page(run)
}

/// The page of a study.
pub fn of_study(study: &Study) -> io::Result<String> {
    study::page(study)
}

/// Letter of the extension's path.
fn letter(extension: Extension) -> &'static str {
    match extension {
        Extension::Straight => "S",
        Extension::Helix => "H",
        Extension::Arc => "A",
    }
}

/// A model's name as the paper has it, such as `H-0.5`.
fn name_of(run: &Results) -> String {
    let model = &run.case.model;
    let millimetres = (1e6 * model.d_max).round() / 1e3;
    format!("{}-{millimetres:?}", letter(model.extension))
}
