//! A tube, or potential flow in a lumen of any shape, as surrogate of blood and wall, for the acceleration
//! ([`Surrogate`](super::acceleration::Surrogate)).

mod potential;
mod shapes;
mod stations;
mod tube;

pub use potential::{PotentialBlood, PotentialError, PotentialSurrogate, PressureEnd};
pub use shapes::{BranchShapes, PressureShapes, SurfaceShapes};
pub use stations::{Axis, NoRings, StationOptions, Stations, SurrogateWall, TubePlace};
pub use tube::{Comb, SurrogateBlood, TubeEnd, TubeSurrogate};
