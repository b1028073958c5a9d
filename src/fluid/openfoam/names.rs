//! Names that templates and the files that are written next to them share.

/// The parameter by which templates take the time scheme of the case.
pub(super) const TIME_DERIVATIVE: &str = "timeDerivative";
/// The parameter by which templates take the scheme of convection.
pub(super) const CONVECTION: &str = "convectionScheme";

/// The parameter by which templates tell the adapter the openings.
pub(super) const OPENINGS: &str = "openings";

/// The parameter by which templates tell the adapter the patches of the elastic wall.
pub(super) const WALLS: &str = "wetPatches";

/// The file with the conditions of the openings that a field includes.
pub(super) fn included(field: &str) -> String {
    format!("system/fsiOpenings/{field}")
}

/// The fields with such a file.
pub(super) const FIELDS: [&str; 3] = ["p", "U", "pointDisplacement"];

/// The file with the velocities of the cells with which the blood begins, if it does not begin at rest.
pub(super) const INITIAL_VELOCITY: &str = "system/fsiInitialVelocity";
