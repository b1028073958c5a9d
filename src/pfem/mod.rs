//! The structural solver: p-version finite elements for large deformations. It does not know that a fluid exists.

pub mod solid;

pub use solid::{Solid, SolidError, SurfaceLoad, SurfacePoint};
