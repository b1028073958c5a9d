//! The state of the wall when time begins, and the lumen's mesh in that shape.

use super::domain::WALL;
use super::{Domain, structure};
use crate::Vec3;
use crate::case::{BloodVessel, Case, GivenShape, OutletCondition};
use crate::fluid::polygonal_wall::RoundWall;
use crate::geometry::{HexMesh, PolyMesh, WallPolygons};
use crate::pfem::solution::stability::AtBifurcation;
use crate::pfem::solution::statics::StaticOptions;
use crate::pfem::solution::unloaded;
use crate::pfem::supports::Profile;
use crate::pfem::{Discretization, Solid, SolidError, Structure};
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
    /// Root mean square of that distance.
    pub rms_displacement_m: f64,
    /// Largest distance of a point of the wet surface between the given shape and what loading the unloaded one leads
    /// to.
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
    let moved = along_axis(vessel, solid.body(), &domain.solid);
    let (solid, found) = in_state(vessel, solid, moved.as_deref())?;
    Ok(UnloadedWall {
        solid,
        moved,
        found,
    })
}

/// Displacement of the vertices by the axial stretch of a vessel, evenly along x, if it is stretched: at held
/// coefficients those to which they are moved.
pub(super) fn along_axis(
    vessel: &BloodVessel,
    body: &Discretization,
    mesh: &HexMesh,
) -> Option<Vec<f64>> {
    let stretch = vessel.axial_stretch();
    // By how much an even stretch moves the vertices, as a share of the given x.
    let share = match vessel.given_shape() {
        GivenShape::Unloaded => stretch - 1.0,
        GivenShape::Loaded => 1.0 - 1.0 / stretch,
    };
    let mut guess = vec![0.0; body.coefficients()];
    for (vertex, &function) in body.numbering.of_vertex.iter().enumerate() {
        guess[3 * function] = share * mesh.vertices[vertex].x;
    }
    (stretch != 1.0).then_some(guess)
}

/// The wall of a vessel, which is given in the shape of the case, in its unloaded one, with its tissue at rest where it
/// is to be; and how the shape was found, if it is not the given one.
///
/// # Errors
/// If no unloaded shape is found, or no equilibrium for the tissue to be at rest in.
pub(super) fn in_state(
    vessel: &BloodVessel,
    mut solid: Structure,
    moved: Option<&[f64]>,
) -> Result<(Structure, Option<unloaded::Found>), SolidError> {
    let mut found = None;
    if vessel.given_shape() == GivenShape::Loaded {
        let shape = solid.unloaded_shape(vessel.image_pressure(), moved)?;
        solid = solid.before(shape.displacement.clone())?;
        found = Some(shape);
    }
    if vessel.tissue_rests_loaded() {
        let (pressure, displacement) = match &found {
            Some(found) => (vessel.image_pressure(), found.displacement.clone()),
            None => {
                let pressure = vessel.equilibrium_pressure();
                // Whether it is stable is asked once the tissue is there.
                let options = StaticOptions {
                    at_bifurcation: AtBifurcation::Continue,
                    ..StaticOptions::default()
                };
                let bare = solid.inflate(pressure, moved, &options)?;
                (pressure, bare.displacement)
            }
        };
        solid.set_tissue_at_rest(pressure, displacement)?;
    }
    Ok((solid, found))
}

/// Why there is no state for time to begin in.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct NoInitialState {
    /// The key to blame.
    pub key: &'static str,
    /// What is wrong, and what helps.
    pub error: SolidError,
}

/// What keeps an artery straight that would move aside under a pressure (Pa) that is right.
fn buckled(key: &'static str, pressure: f64, stretch: f64, error: &SolidError) -> NoInitialState {
    let from_ramp = match key {
        WINDKESSEL => "; before a ramp it is far above what the vessel will see",
        _ => "",
    };
    NoInitialState {
        key,
        error: SolidError::Model(format!(
            "there is no state for time to begin in under {:.1} kPa ({key}{from_ramp}): {error}. If the pressure is right, what \
             keeps arteries straight is missing or too weak: prestretch (initial.axial_stretch, here {stretch:?}) or tissue around \
             them (surroundings.spring_Pa_m)",
            1e-3 * pressure
        )),
    }
}

const WINDKESSEL: &str = "windkessel.initial_pressure_Pa";

/// The keys that say the pressure inside when time begins, and that in a given shape that is loaded.
fn pressure_keys(vessel: &BloodVessel) -> [&'static str; 2] {
    let beginning = match vessel.outlet_condition() {
        OutletCondition::Windkessel => WINDKESSEL,
        OutletCondition::Resistance | OutletCondition::Pressure => "outlet.pressure_Pa",
    };
    match vessel.initial.as_ref().and_then(|initial| initial.pressure) {
        Some(_) => [beginning, "initial.pressure_Pa"],
        None => [beginning; 2],
    }
}

/// The structure of a case in the state in which time begins: unloaded, or in static equilibrium.
///
/// # Errors
/// If the structure is not well posed, or there is no stable equilibrium; the text says what helps.
pub fn initial_state(case: &Case, domain: &Domain) -> Result<InitialState, NoInitialState> {
    let of_mesh = |error| NoInitialState {
        key: "structure.p",
        error,
    };
    let at_rest = |solid| InitialState {
        solid,
        unloading: None,
    };
    let Some(vessel) = case.vessel() else {
        return structure(case, domain).map(at_rest).map_err(of_mesh);
    };
    let (pressure, image) = (vessel.equilibrium_pressure(), vessel.image_pressure());
    let stretch = vessel.axial_stretch();
    let is_pressed = pressure != 0.0 || image != 0.0 || domain.outer_pressure != Profile::default();
    if stretch == 1.0 && !is_pressed && !vessel.tissue_rests_loaded() {
        return structure(case, domain).map(at_rest).map_err(of_mesh);
    }
    let [key, key_of_image] = pressure_keys(vessel);
    let UnloadedWall {
        mut solid,
        moved,
        found,
    } = unloaded_wall(case, domain).map_err(|error| NoInitialState {
        key: match (vessel.given_shape(), &error) {
            (GivenShape::Loaded, SolidError::NoEquilibrium(_)) => "initial.shape",
            _ => "structure.p",
        },
        error,
    })?;
    let equilibrium = |solid: &Structure, key, pressure| {
        let found = solid.equilibrium(pressure, moved.as_deref());
        found.map_err(|error| buckled(key, pressure, stretch, &error))
    };
    let Some(found) = found else {
        let loaded = equilibrium(&solid, key, pressure)?;
        solid.set_at_rest(loaded).map_err(of_mesh)?;
        return Ok(at_rest(solid));
    };
    // The way back decides: only a stable equilibrium is a state of a wall.
    let loaded = equilibrium(&solid, key_of_image, image)?;
    let wet: Vec<Vec3> = solid.wet_points().iter().map(|p| p.position).collect();
    let places = solid.locate(&wet).map_err(of_mesh)?;
    let largest = |moved: &[Vec3]| moved.iter().map(|u| u.norm()).fold(0.0, f64::max);
    let before = solid.accepted_displacement(&places);
    let squares: f64 = before.iter().map(|u| u.norm_squared()).sum();
    solid.set_at_rest(loaded).map_err(of_mesh)?;
    let distance_after_loading_m = largest(&solid.accepted_displacement(&places));
    if distance_after_loading_m > LARGEST_DISTANCE {
        return Err(NoInitialState {
            key: "initial.shape",
            error: SolidError::Model(format!(
                "the unloaded shape that was found leads, loaded, to a shape {distance_after_loading_m:.1e} m away from the given \
                 one: another equilibrium, since the wall is close to buckling; more prestretch (initial.axial_stretch) or tissue \
                 (surroundings.spring_Pa_m) keeps it straight"
            )),
        });
    }
    let beginning = match pressure == image {
        true => found.displacement,
        false => equilibrium(&solid, key, pressure)?,
    };
    solid.set_at_rest(beginning).map_err(of_mesh)?;
    Ok(InitialState {
        solid,
        unloading: Some(Unloading {
            pressure_Pa: image,
            iterations: found.iterations,
            largest_displacement_m: largest(&before),
            rms_displacement_m: (squares / before.len() as f64).sqrt(),
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
