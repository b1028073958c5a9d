//! The state of the wall when time begins, and the lumen's mesh in that shape.

use super::domain::WALL;
use super::{Domain, structure};
use crate::Vec3;
use crate::case::{BloodVessel, Case, GivenShape};
use crate::fluid::polygonal_wall::RoundWall;
use crate::geometry::{PolyMesh, WallPolygons};
use crate::pfem::solution::unloaded;
use crate::pfem::supports::Profile;
use crate::pfem::{Solid, SolidError, Structure};
use serde::{Deserialize, Serialize};

/// Largest distance (m) between a shape that is given as loaded, and what loading leads to from the unloaded one.
const LARGEST_DISTANCE: f64 = 1e-6;

/// The wall in the state in which time begins.
pub struct InitialState {
    /// The structure.
    pub solid: Structure,
    /// Where its unloaded shape comes from, if it is not the given one.
    pub unloading: Option<Unloading>,
}

/// How the unloaded shape of a wall was found whose loaded one is given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct Unloading {
    /// Pressure in the given shape.
    pub pressure_Pa: f64,
    /// Iterations of the inverse problem, in all steps of the load.
    pub iterations: usize,
    /// Largest distance of a point of the wet surface between the given shape and the unloaded one.
    pub largest_displacement_m: f64,
    /// Largest distance of a point of the wet surface between the given shape and what loading the unloaded one leads to.
    pub distance_after_loading_m: f64,
}

/// The wall of a case in its unloaded shape, to be put under pressure.
pub struct UnloadedWall {
    /// The structure, at rest.
    pub solid: Structure,
    /// Displacement whose values at held coefficients the ends are moved to, if they are; the others are a guess.
    pub moved: Option<Vec<f64>>,
    /// How the shape was found, if it is not the given one.
    found: Option<unloaded::Found>,
}

/// The wall of a case in its unloaded shape, and how its ends are moved.
///
/// # Errors
/// If the structure is not well posed, or no unloaded shape is found.
pub fn unloaded_wall(case: &Case, domain: &Domain) -> Result<UnloadedWall, SolidError> {
    let solid = structure(case, domain)?;
    let Some(vessel) = case.vessel() else {
        return Ok(UnloadedWall {
            solid,
            moved: None,
            found: None,
        });
    };
    let stretch = vessel.axial_stretch();
    // By how much an even stretch moves the vertices, as a share of the given x.
    let share = match vessel.given_shape() {
        GivenShape::Unloaded => stretch - 1.0,
        GivenShape::Loaded => 1.0 - 1.0 / stretch,
    };
    let body = solid.body();
    let mut guess = vec![0.0; body.coefficients()];
    for (vertex, &function) in body.numbering.of_vertex.iter().enumerate() {
        guess[3 * function] = share * domain.solid.vertices[vertex].x;
    }
    let moved = (stretch != 1.0).then_some(guess);
    let (solid, found) = match vessel.given_shape() {
        GivenShape::Unloaded => (solid, None),
        GivenShape::Loaded => {
            let found = solid.unloaded_shape(vessel.equilibrium_pressure(), moved.as_deref())?;
            (solid.before(found.displacement.clone())?, Some(found))
        }
    };
    Ok(UnloadedWall {
        solid,
        moved,
        found,
    })
}

/// The structure of a case in the state in which time begins: unloaded, or in static equilibrium.
///
/// # Errors
/// If the structure is not well posed, or there is no stable equilibrium; the text says what helps.
pub fn initial_state(case: &Case, domain: &Domain) -> Result<InitialState, SolidError> {
    let at_rest = |solid| InitialState {
        solid,
        unloading: None,
    };
    let vessel = case.vessel();
    let pressure = vessel.map_or(0.0, BloodVessel::equilibrium_pressure);
    let stretch = vessel.map_or(1.0, BloodVessel::axial_stretch);
    let is_pressed = pressure != 0.0 || domain.outer_pressure != Profile::default();
    if stretch == 1.0 && !is_pressed {
        return Ok(at_rest(structure(case, domain)?));
    }
    let refused = |error: SolidError| {
        SolidError::Model(format!(
            "there is no state for time to begin in under {:.1} kPa (windkessel.initial_pressure_Pa or outlet.pressure_Pa; \
             after a ramped start the windkessel's is far above what the vessel will see): {error}. If the pressure is \
             right, what keeps arteries straight is missing or too weak: prestretch (initial.axial_stretch, here {stretch:?}) or tissue around them (surroundings.spring_Pa_m)",
            1e-3 * pressure
        ))
    };
    let UnloadedWall {
        mut solid,
        moved,
        found,
    } = unloaded_wall(case, domain)?;
    // The way back decides: only a stable equilibrium is a state for time to begin in.
    let loaded = (solid.equilibrium(pressure, moved.as_deref())).map_err(refused)?;
    let Some(found) = found else {
        solid.set_at_rest(loaded)?;
        return Ok(at_rest(solid));
    };
    let wet: Vec<Vec3> = solid.wet_points().iter().map(|p| p.position).collect();
    let places = solid.locate(&wet)?;
    let largest = |moved: Vec<Vec3>| moved.iter().map(|u| u.norm()).fold(0.0, f64::max);
    let largest_displacement_m = largest(solid.accepted_displacement(&places));
    solid.set_at_rest(loaded)?;
    let distance_after_loading_m = largest(solid.accepted_displacement(&places));
    if distance_after_loading_m > LARGEST_DISTANCE {
        return Err(SolidError::Model(format!(
            "the unloaded shape that was found leads, loaded, to a shape {distance_after_loading_m:.1e} m away from the given \
             one: another equilibrium, since the wall is close to buckling; more prestretch (initial.axial_stretch) or tissue \
             (surroundings.spring_Pa_m) keeps it straight"
        )));
    }
    solid.set_at_rest(found.displacement)?;
    Ok(InitialState {
        solid,
        unloading: Some(Unloading {
            pressure_Pa: pressure,
            iterations: found.iterations,
            largest_displacement_m,
            distance_after_loading_m,
        }),
    })
}

/// The mesh of a vessel's lumen in the shape of its wall, and how the two are related.
///
/// # Errors
/// If a point of its wall does not lie on that of the structure.
pub fn fitted_lumen(
    vessel: &BloodVessel,
    grid: &PolyMesh,
    solid: &Structure,
) -> Result<(PolyMesh, RoundWall), SolidError> {
    let mut numbers: Vec<usize> = grid.patch_faces(WALL).concat();
    numbers.sort_unstable();
    numbers.dedup();
    let unloaded: Vec<Vec3> = numbers.iter().map(|&i| grid.points[i]).collect();
    let displacement = solid.accepted_displacement(&solid.locate(&unloaded)?);
    let mut on_wall = grid.points.clone();
    for (&i, u) in numbers.iter().zip(displacement) {
        on_wall[i] += u;
    }
    let polygons = WallPolygons::of(grid, &vessel.fluid.mesh);
    let mut fitted = grid.clone();
    fitted.points = polygons.fit(grid, &vessel.fluid.mesh, &on_wall);
    let wall = RoundWall {
        unloaded,
        in_mesh: numbers.iter().map(|&i| fitted.points[i]).collect(),
        polygons: polygons.renumbered(|point| numbers.binary_search(&point).ok()),
    };
    Ok((fitted, wall))
}
