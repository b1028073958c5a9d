//! What holds the wall of a user-supplied case or of a tree.

use super::Branches;
use crate::Vec3;
use crate::case::{OwnCase, TissueDirection, WallSupport};
use crate::curve::{SpaceCurve, nearest_of};
use crate::files::{Fault, fault};
use crate::geometry::supports::axis_point;
use crate::geometry::{HexMesh, is_side, outer_side_of};
use crate::pfem::supports::{Axis, AxisPoint, Direction, Foundation, Profile, Support, guide};
use std::sync::Arc;

/// The lines of branches that are called alike.
#[derive(Debug)]
struct Lines(Vec<SpaceCurve>);

impl Axis for Lines {
    fn nearest(&self, x: &Vec3) -> AxisPoint {
        let nearest = nearest_of(self.0.iter().enumerate(), x);
        let (_, nearest) = nearest.expect("a branch has a line");
        axis_point(&nearest)
    }
}

/// What holds the wall; the rims of one that is extruded are clamped by default.
///
/// # Errors
/// If nothing holds it, or it has no such surface, or that has no axis.
pub fn of(
    own: &OwnCase,
    mesh: &HexMesh,
    branches: Option<&Branches>,
) -> Result<Vec<Support>, Fault> {
    let Some(described) = &own.wall.support else {
        let rims = mesh.surfaces.keys().filter(|name| !is_side(name));
        let supports: Vec<Support> = rims.map(|name| Support::Clamped(name.clone())).collect();
        return match supports.is_empty() {
            true => Err(
                "the wall has no rim, and nothing holds it: add a table [[wall.support]]".into(),
            ),
            false => Ok(supports),
        };
    };
    let mut supports = Vec::new();
    for support in described {
        for name in support.surfaces() {
            if !mesh.surfaces.contains_key(name) {
                let known: Vec<&str> = mesh.surfaces.keys().map(String::as_str).collect();
                return Err(fault!(
                    "the wall has no surface {name:?}; it has \"{}\"",
                    known.join("\", \"")
                ));
            }
            supports.extend(on(own, branches, support, name)?);
        }
    }
    Ok(supports)
}

/// What holds one surface.
fn on(
    own: &OwnCase,
    branches: Option<&Branches>,
    support: &WallSupport,
    name: &str,
) -> Result<Vec<Support>, Fault> {
    let axis = |surface: &str| axis(own, branches, surface);
    Ok(match support {
        WallSupport::Clamped { .. } => vec![Support::Clamped(name.to_owned())],
        WallSupport::Sliding { held, .. } => {
            let is_held = |axis: &str| held.iter().any(|name| name == axis);
            let guides = [
                ("axial", Direction::Axial),
                ("tangential", Direction::Tangential),
            ];
            let guides = guides.into_iter().filter(|(word, _)| is_held(word));
            let guides = guides.map(|(_, direction)| Ok(guide(name, direction, Some(axis(name)?))));
            let mut supports = guides.collect::<Result<Vec<_>, Fault>>()?;
            let components = ["x", "y", "z"].map(is_held);
            if components != [false; 3] {
                supports.push(Support::Surface(name.to_owned(), components));
            }
            supports
        }
        WallSupport::Springs {
            spring,
            damping,
            direction,
            at_rest,
            ..
        } => {
            let described = Foundation {
                surface: name.to_owned(),
                spring: Profile::constant(*spring),
                damping: damping.map_or(Profile::default(), Profile::constant),
                direction: direction.unwrap_or(TissueDirection::All).into(),
                at_rest: at_rest.unwrap_or_default().into(),
                axis: None,
            };
            // All of the outer side has no axis of its own.
            let names = match (described.direction, name, &own.tree) {
                (Direction::All, ..) | (_, _, None) => vec![name.to_owned()],
                (_, "outer", Some(tree)) => {
                    tree.branches().iter().map(|it| outer_side_of(it)).collect()
                }
                _ => vec![name.to_owned()],
            };
            let parts = names.into_iter().map(|surface| {
                let axis = match described.direction {
                    Direction::All => None,
                    _ => Some(axis(&surface)?),
                };
                let described = described.clone();
                Ok(Support::Foundation(Foundation {
                    surface,
                    axis,
                    ..described
                }))
            });
            parts.collect::<Result<_, Fault>>()?
        }
    })
}

/// The line along the part of a tree's wall that a surface belongs to: a rim, or the outer side over a branch.
fn axis(own: &OwnCase, branches: Option<&Branches>, surface: &str) -> Result<Arc<dyn Axis>, Fault> {
    let (Some(tree), Some(branches)) = (&own.tree, branches) else {
        return Err(fault!(
            "directions \"radial\", \"axial\" and \"tangential\" are those of the lines of a tree, and this case has none"
        ));
    };
    let names = tree.branches();
    let is_there = |name: &String| surface == name || surface == outer_side_of(name);
    let Some(place) = names.iter().position(is_there) else {
        return Err(fault!(
            "the surface {surface:?} has no axis: expected \"outer\", \"outer:\" and a branch, or an end, of \"{}\"",
            names.join("\", \"")
        ));
    };
    let patch = &tree.walls()[place];
    let of_branch = branches.lines.iter().filter(|(name, _)| name == patch);
    Ok(Arc::new(Lines(
        of_branch.map(|(_, line)| line.clone()).collect(),
    )))
}
