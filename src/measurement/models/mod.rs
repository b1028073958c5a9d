//! Acceleration models compared: on problems with a known answer, and on coupled cases.

mod cases;
mod plot;
pub mod reference;
mod results;
mod variant;

pub use cases::Plan;
pub use variant::Variant;
