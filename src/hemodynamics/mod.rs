//! Wall shear stress measures, lumen volumes and periodicity; does not know where the fields came from.
//!
//! A [`WetSurface`] is the wet surface as a list of faces; [`WindowStatistics`] grow step by step over a window of
//! time; [`HemodynamicsSummary`] says what is largest, where, and what the mean is, in each [`Region`] of the vessel.

pub mod cross_section;
pub(crate) mod monitor;
pub(crate) mod periodicity;
pub(crate) mod phases;
mod place;
pub(crate) mod region;
pub mod resolution;
pub(crate) mod rings;
pub(crate) mod shear;
pub(crate) mod statistics;
pub mod steadiness;
pub(crate) mod summary;
pub(crate) mod wall;

pub use cross_section::{BranchOpening, CrossSection, CrossSectionPlace, SweptVolumes};
pub use monitor::{Monitor, RegionStep, WallStress};
pub use periodicity::Agreement;
pub use place::Place;
pub use region::{Region, RegionExtent, RegionName};
pub use resolution::{FlowNumbers, Resolution, ResolutionFinding};
pub use rings::Rings;
pub use shear::ShearStatistics;
pub use statistics::WindowStatistics;
pub use steadiness::{Steadiness, SteadyMeasure};
pub use summary::HemodynamicsSummary;
pub use wall::{WallState, WetSurface};
