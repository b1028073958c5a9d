//! A tube as surrogate of blood and wall, for the acceleration ([`Surrogate`](super::acceleration::Surrogate)).

mod stations;
mod tube;

pub use stations::{Axis, NoRings, StationOptions, Stations, SurrogateWall, TubePlace};
pub use tube::{Comb, SurrogateBlood, TubeEnd, TubeSurrogate};
