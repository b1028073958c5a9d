//! What exists for the paper alone: its twelve models and the page that judges its findings by them, and its
//! convergence study.

pub mod convergence;
pub(crate) mod findings;
pub(crate) mod models;
mod runs;
pub(crate) mod study;

pub use runs::PaperStudy;
