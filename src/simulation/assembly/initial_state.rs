//! The state of the wall when time begins, and the lumen's mesh in that shape.

use super::{Domain, structure};
use crate::Vec3;
use crate::case::Case;
use crate::geometry::PolyMesh;
use crate::geometry::o_grid::moved_points;
use crate::pfem::supports::Profile;
use crate::pfem::{Solid, SolidError, Structure};
use std::collections::BTreeMap;

/// The structure of a case in the state in which time begins: unloaded, or in static equilibrium.
///
/// # Errors
/// If the structure is not well posed, or there is no stable equilibrium; the text says what helps.
pub fn solid(case: &Case, domain: &Domain) -> Result<Structure, SolidError> {
    let mut solid = structure(case, domain, &domain.outer_pressure)?;
    let Some(vessel) = case.anastomosis() else {
        return Ok(solid);
    };
    let (stretch, pressure) = (vessel.axial_stretch(), vessel.equilibrium_pressure());
    let is_pressed = pressure != 0.0 || domain.outer_pressure != Profile::default();
    if stretch == 1.0 && !is_pressed {
        return Ok(solid);
    }
    let body = solid.body();
    let mut guess = vec![0.0; body.coefficients()];
    for (vertex, &function) in body.numbering.of_vertex.iter().enumerate() {
        guess[3 * function] = (stretch - 1.0) * domain.solid.vertices[vertex].x;
    }
    let moved = (stretch != 1.0).then_some(&guess[..]);
    let found = solid.equilibrium(pressure, moved).map_err(|error| {
        SolidError::Model(format!(
            "there is no state for time to begin in: {error}. What keeps arteries straight is missing or too weak: \
             prestretch (initial.axial_stretch, here {stretch:?}) or tissue around them (surroundings.spring_Pa_m)"
        ))
    })?;
    solid.set_at_rest(found)?;
    Ok(solid)
}

/// A structure without load for the surrogate to probe, if `solid` is not at rest without one.
///
/// # Errors
/// If the structure is not well posed.
pub fn unloaded(
    case: &Case,
    domain: &Domain,
    solid: &Structure,
) -> Result<Option<Structure>, SolidError> {
    let is_unloaded = solid.state().d.iter().all(|&d| d == 0.0);
    if is_unloaded && domain.outer_pressure == Profile::default() {
        return Ok(None);
    }
    structure(case, domain, &Profile::default()).map(Some)
}

/// The lumen's mesh with its wall in the state of the structure, and the points of the wall before and after, m.
///
/// # Errors
/// If a point of its wall does not lie on that of the structure.
pub fn moved_lumen(
    case: &Case,
    unloaded: &PolyMesh,
    solid: &Structure,
) -> Result<(PolyMesh, Vec<(Vec3, Vec3)>), SolidError> {
    let mut moved = unloaded.clone();
    let Some(vessel) = case.anastomosis() else {
        return Ok((moved, Vec::new()));
    };
    let mut numbers: Vec<usize> = unloaded.patch_faces("wallFsi").concat();
    numbers.sort_unstable();
    numbers.dedup();
    let points: Vec<Vec3> = numbers.iter().map(|&i| unloaded.points[i]).collect();
    let displacement = solid.accepted_displacement(&solid.locate(&points)?);
    let of_point: BTreeMap<usize, Vec3> = numbers.iter().copied().zip(displacement).collect();
    let still = Vec3::zeros();
    moved.points = moved_points(unloaded, &vessel.fluid.mesh, |i| {
        *of_point.get(&i).unwrap_or(&still)
    });
    let pair = |&i: &usize| (unloaded.points[i], moved.points[i]);
    let wall = numbers.iter().map(pair).collect();
    Ok((moved, wall))
}
