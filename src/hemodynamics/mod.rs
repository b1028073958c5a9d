//! Wall shear stress measures, lumen volumes and periodicity; does not know where the fields came from.
//!
//! A [`Wall`] is the wet surface as a list of faces; [`WindowStatistics`] grow step by step over a window of time;
//! [`Summary`] says what is largest, where, and what the mean is, in each [`Region`] of the vessel.

pub mod monitor;
pub mod periodicity;
pub mod phases;
pub mod region;
pub mod rings;
pub mod shear;
pub mod statistics;
pub mod summary;
pub mod wall;

pub use monitor::{Monitor, RegionStep, WallStress};
pub use region::{Region, RegionName};
pub use rings::Rings;
pub use shear::ShearStatistics;
pub use statistics::WindowStatistics;
pub use summary::Summary;
pub use wall::{Place, Wall, WallState};
