//! The wall of a case for commands that put it under pressure without blood.

use crate::analysis::wall::InflatableWall;
use crate::case::Case;
use crate::geometry::Vessel;
use crate::pfem::SolidError;
use crate::simulation::assembly::{Domain, unloaded_wall};

/// What `use_it` finds with the wall of a vessel, or of a tree, in its unloaded shape.
///
/// # Errors
/// If the wall is not well posed, or `use_it` fails.
pub fn with_wall<T>(
    case: &Case,
    use_it: impl FnOnce(&InflatableWall) -> Result<T, SolidError>,
) -> Result<T, SolidError> {
    let domain = Domain::new(case).map_err(|e| SolidError::Model(e.reason))?;
    let wall = unloaded_wall(case, &domain)?;
    let branches = domain.branches.as_ref();
    let of_tree = branches.and_then(|branches| branches.lines.first());
    let line = match case.vessel() {
        Some(vessel) => Some(Vessel::new(vessel).centre_line().clone()),
        None => of_tree.map(|(_, line)| line.clone()),
    };
    let line = line.ok_or_else(|| SolidError::Model("the case has no vessel".into()))?;
    use_it(&InflatableWall {
        solid: &wall.solid,
        mesh: &domain.solid,
        moved: wall.moved.as_deref(),
        line: &line,
    })
}
