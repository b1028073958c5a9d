//! Which input moves an answer, and by how much: points of uncertain inputs, polynomial chaos of what was found there,
//! and Sobol' indices; random fields by a few inputs. Knows no case and no run.
//!
//! The unit interval is where a design places its points; [`Inputs`] maps them to *germs*, independent variables in
//! which the chaos is a polynomial, and to the values of the inputs.

mod basis;
mod calibration;
mod chaos;
mod control;
mod design;
mod distribution;
mod field;
mod field_chaos;

pub use calibration::{Target, calibrated};
pub use chaos::{Chaos, SensitivityIndex};
pub use control::ControlledMean;
pub use design::{Design, sobol_point};
pub use distribution::{Distribution, Inputs, Law};
pub use field::{Covariance, RandomField, Realization};
pub use field_chaos::FieldChaos;
