//! # fsi-data: what a case is described with
//!
//! From the ground up, each on those before it alone:
//!
//! 1. [`files`]: whole files, read and written at once, their fingerprints, and what is wrong with them.
//! 2. [`interpolation`]: splines and nearest points.
//! 3. [`uncertainty`]: distributions, random fields, polynomial chaos, calibration.
//! 4. [`curve`]: curves in space, with cross-sections swept along them.
//! 5. [`polydata`]: lines and triangles from the files of other programs.
//! 6. [`tabular`]: tables and units as others write them.

pub mod curve;
pub mod files;
pub mod interpolation;
pub mod polydata;
pub mod tabular;
pub mod uncertainty;

use fsi_numerics::{Vec3, quadrature};
