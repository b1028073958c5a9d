//! A tube, or potential flow in a lumen of any shape, as surrogate of blood and wall, for the acceleration
//! ([`Surrogate`](super::acceleration::Surrogate)).

mod potential;
mod stations;
mod tube;

pub use potential::{
    PotentialBlood, PotentialError, PotentialSurrogate, PressureEnd, PressureShapes,
};
pub use stations::{Axis, NoRings, StationOptions, Stations, SurrogateWall, TubePlace};
pub use tube::{Comb, SurrogateBlood, TubeEnd, TubeSurrogate};
