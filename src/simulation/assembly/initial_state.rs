//! The initial state of the wall, and the lumen's mesh in that shape.

use super::domain::WALL;
use super::{Domain, structure};
use crate::Vec3;
use crate::analysis::tube_law::TubeLaw;
use crate::case::{BloodVessel, Case, GivenShape, InitialWall, Problem, WallSupport};
use crate::fluid::polygonal_wall::RoundWall;
use crate::geometry::supports;
use crate::geometry::{HexMesh, PolyMesh, Vessel, WallPolygons};
use crate::pfem::solution::stability::AtBifurcation;
use crate::pfem::solution::statics::StaticOptions;
use crate::pfem::solution::unloaded;
use crate::pfem::{Discretization, Solid, SolidError, Structure};
use crate::tabular::units::MMHG;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;

/// Largest distance (m) between a shape that is given as loaded, and what loading leads to from the unloaded one.
const LARGEST_DISTANCE: f64 = 1e-6;

/// The wall in its initial state.
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
    let Some(initial) = case.initial_wall() else {
        return Ok(UnloadedWall {
            solid,
            moved: None,
            found: None,
        });
    };
    let moved = case.vessel().and_then(|vessel| {
        let shape = Vessel::new(vessel);
        let line = shape.centre_line();
        match supports::is_x_axis(line) {
            true => along_axis(&initial, solid.body(), &domain.solid, on_x_axis),
            false => along_axis(&initial, solid.body(), &domain.solid, |point| {
                line.nearest(point).frame.origin - line.frame(0.0).origin
            }),
        }
    });
    let known = known(case).map(|known| known.unloaded);
    let is_new = known.is_none();
    let (solid, unloaded) = in_state(&initial, solid, moved.as_deref(), known)?;
    let found = unloaded.found.clone();
    if is_new {
        remember(Known {
            case: case.clone(),
            unloaded,
            beginning: None,
        });
    }
    Ok(UnloadedWall {
        solid,
        moved,
        found,
    })
}

/// What the statics of a wall in its unloaded shape have led to.
#[derive(Debug, Clone, Default)]
pub(super) struct Unloaded {
    /// How the shape was found, if it is not the given one.
    pub(super) found: Option<unloaded::Found>,
    /// Pressure (Pa) and displacement (m) in which the tissue is at rest, if that is a loaded state.
    tissue: Option<(f64, Vec<f64>)>,
}

/// What is known of the wall of a case: a command that checks it and then works with it solves its statics once.
#[derive(Debug, Clone)]
struct Known {
    case: Case,
    unloaded: Unloaded,
    /// Displacement (m) of the initial state, and how the unloaded shape was found.
    beginning: Option<(Vec<f64>, Option<Unloading>)>,
}

thread_local! {
    /// The last case of this thread: those that others check at the same time do not take its place.
    static KNOWN: RefCell<Option<Known>> = const { RefCell::new(None) };
}

fn known(case: &Case) -> Option<Known> {
    KNOWN.with_borrow(|known| known.as_ref().filter(|known| known.case == *case).cloned())
}

fn remember(known: Known) {
    KNOWN.replace(Some(known));
}

/// Displacement of the vertices by the axial stretch of a vessel, if it is stretched: at held coefficients those to
/// which they are moved. A cross-section whose centre lies at `centre` (m, from that of the inlet) moves as a whole, by
/// the same share of that vector everywhere, so that an even stretch scales the centre-line and leaves its form.
pub(super) fn along_axis(
    initial: &InitialWall,
    body: &Discretization,
    mesh: &HexMesh,
    centre: impl Fn(&Vec3) -> Vec3,
) -> Option<Vec<f64>> {
    let stretch = initial.stretch;
    if stretch == 1.0 {
        return None;
    }
    let share = match initial.shape {
        GivenShape::Unloaded => stretch - 1.0,
        GivenShape::Loaded => 1.0 - 1.0 / stretch,
    };
    let mut guess = vec![0.0; body.coefficients()];
    for (vertex, &function) in body.numbering.of_vertex.iter().enumerate() {
        let moved = share * centre(&mesh.vertices[vertex]);
        guess[3 * function..][..3].copy_from_slice(moved.as_slice());
    }
    Some(guess)
}

/// Centre (m) of the cross-section of a point on the x-axis.
pub(super) fn on_x_axis(point: &Vec3) -> Vec3 {
    Vec3::new(point.x, 0.0, 0.0)
}

/// The wall of a case, which is given in the shape of that, in its unloaded one, with its tissue at rest where it
/// is to be; and what led there, which may be `known`.
///
/// # Errors
/// If no unloaded shape is found, or no equilibrium for the tissue to be at rest in.
pub(super) fn in_state(
    initial: &InitialWall,
    mut solid: Structure,
    moved: Option<&[f64]>,
    known: Option<Unloaded>,
) -> Result<(Structure, Unloaded), SolidError> {
    let mut unloaded = known.unwrap_or_default();
    if initial.shape == GivenShape::Loaded {
        let shape = match unloaded.found {
            Some(found) => found,
            None => solid.unloaded_shape(initial.image_pressure, moved)?,
        };
        solid = solid.unloaded_by(shape.displacement.clone())?;
        unloaded.found = Some(shape);
    }
    if initial.tissue_rests_loaded {
        let (pressure, displacement) = match (unloaded.tissue, &unloaded.found) {
            (Some(known), _) => known,
            (None, Some(found)) => (initial.image_pressure, found.displacement.clone()),
            (None, None) => {
                let pressure = initial.pressure;
                // Whether it is stable is asked once the tissue is there.
                let options = StaticOptions {
                    at_bifurcation: AtBifurcation::Continue,
                    ..StaticOptions::default()
                };
                let bare = solid.inflate(pressure, moved, &options)?;
                (pressure, bare.displacement)
            }
        };
        solid.set_tissue_at_rest(pressure, displacement.clone())?;
        unloaded.tissue = Some((pressure, displacement));
    }
    Ok((solid, unloaded))
}

/// Why there is no state for time to begin in.
#[derive(Debug, thiserror::Error)]
#[error("{error}")]
pub struct NoInitialState {
    /// The key to blame, if changing it is the cure.
    pub key: Option<String>,
    /// What is wrong, and what helps.
    pub error: SolidError,
}

/// A wall that cannot be built, or not be held.
fn not_built(case: &Case, domain: &Domain, error: SolidError) -> NoInitialState {
    let (key, advice) = match (&case.problem, &error) {
        (Problem::UserCase(own), SolidError::Inverted { .. }) if own.wall.file.is_some() => {
            (Some("wall.file.mesh"), "")
        }
        (Problem::UserCase(_), SolidError::Inverted { .. }) if domain.branches.is_some() => {
            return not_grown(case, domain, &error);
        }
        (Problem::Vessel(_), SolidError::Inverted { .. }) => (
            None,
            ": the vessel bends or changes too sharply there for its wall; gentler bends, a thinner wall, or more elements \
             (structure.axial_per_section, structure.circumferential) help",
        ),
        _ => (None, ""),
    };
    NoInitialState {
        key: key.map(str::to_owned),
        error: SolidError::Model(format!("the wall cannot be built: {error}{advice}")),
    }
}

/// A wall of a tree that is inside out, without load or under it.
fn not_grown(case: &Case, domain: &Domain, error: &SolidError) -> NoInitialState {
    let extrusion = case.own().and_then(|own| own.wall.extrude.as_ref());
    let place = domain.wall_inside_out(case);
    let place = place.zip(domain.branches.as_ref());
    let is_chosen = extrusion.is_some_and(|it| it.smoothing.is_some());
    let key = match extrusion.is_some_and(|it| it.shares.is_empty()) {
        true => "wall.extrude.thicknesses_m",
        false => "wall.extrude.thicknesses",
    };
    let reason = match (place, is_chosen) {
        (Some((x, branches)), true) => format!(
            "the wall would be inside out {}: no wall.extrude.smoothing (as many averages of the normals as it takes are tried \
             then), a thinner wall ({key}) or more cells of the lumen (tree.core) help",
            branches.told(&x)
        ),
        (Some((x, branches)), false) => format!(
            "the wall would be inside out {}, with 256 averages of the normals as well: a thinner wall ({key}), more cells of the \
             lumen (tree.core) or smoother lines (tree.smoothing_m) help",
            branches.told(&x)
        ),
        (None, _) => format!(
            "the wall cannot be built: {error}, under load alone: a thinner wall ({key}), smoother lines (tree.smoothing_m) or more \
             averages of the normals (wall.extrude.smoothing = 64) help"
        ),
    };
    NoInitialState {
        key: place.map(|_| key.into()),
        error: SolidError::Model(reason),
    }
}

/// That the wall of a branch, as a long tube, does not carry the pressure in the given shape, however narrow it was
/// without load: the search for the unloaded shape would take long to find none.
fn too_weak(case: &Case, initial: &InitialWall) -> Option<NoInitialState> {
    let (own, pressure) = (case.own()?, initial.image_pressure);
    let (tree, extrusion) = (own.tree.as_ref()?, own.wall.extrude.as_ref()?);
    if initial.shape != GivenShape::Loaded || pressure <= 0.0 {
        return None;
    }
    let radii = || tree.line.iter().flatten().flat_map(|line| &line.radii);
    let narrowest = radii().copied().fold(f64::INFINITY, f64::min);
    let widest = radii().copied().fold(0.0, f64::max);
    let of_support = |support: &WallSupport| match support {
        WallSupport::Springs { spring, .. } => *spring,
        _ => 0.0,
    };
    let springs: f64 = own.wall.support.iter().flatten().map(of_support).sum();
    let thickness = |wall: &str, branch: &str| {
        let layers = extrusion.layers_of(wall, Some(branch));
        let of_metres = layers.thicknesses.iter().map(|size| size / narrowest);
        let thicknesses = layers.shares.iter().copied().chain(of_metres);
        let materials = layers
            .materials
            .iter()
            .filter_map(|name| own.wall.region(name));
        let materials = materials.map(|region| &own.wall.materials()[region].material);
        let layers: Vec<_> = materials.zip(thicknesses).collect();
        let tube = TubeLaw::of_layers(&layers, case.prestretch(), springs * widest);
        let ratio = tube.thickness_ratio();
        tube.unloaded(pressure).is_none().then_some(ratio)
    };
    let mut branches = tree.walls().into_iter().zip(tree.branches());
    let (ratio, branch) =
        branches.find_map(|(wall, branch)| Some((thickness(&wall, &branch)?, branch)))?;
    Some(NoInitialState {
        key: Some(initial.key_of_image.clone()),
        error: SolidError::Model(format!(
            "the wall of the branch {branch:?}, {ratio:.2} of the radius thick, does not carry {:.1} kPa ({:.0} mmHg), however narrow it \
             was without load: lower the pressure, or make the wall thicker (wall.extrude.thicknesses) or stiffer \
             (wall.material)",
            1e-3 * pressure,
            pressure / MMHG
        )),
    })
}

/// What keeps an artery straight that would move sideways under a pressure (Pa) that is right.
fn buckled(initial: &InitialWall, key: &str, pressure: f64, error: &SolidError) -> NoInitialState {
    let from_ramp = match key.ends_with(".initial_pressure_Pa") {
        true => "; before a ramp it is far above what the vessel will see",
        false => "",
    };
    NoInitialState {
        key: Some(key.into()),
        error: SolidError::Model(format!(
            "there is no state for time to begin in under {:.1} kPa ({key}{from_ramp}): {error}. If the pressure is right, what \
             keeps arteries straight is missing or too weak: {}",
            1e-3 * pressure,
            what_keeps_straight(initial)
        )),
    }
}

fn what_keeps_straight(initial: &InitialWall) -> String {
    match initial.key_of_shape {
        "wall.initial.shape" => {
            "thicker or stiffer layers, springs on the outer surface (wall.support), or prestretch (wall.initial.axial_stretch)".into()
        }
        _ => format!(
            "prestretch (initial.axial_stretch, here {:?}) or tissue around them (surroundings.spring_Pa_m)",
            initial.stretch
        ),
    }
}

/// The structure of a case in its initial state: unloaded, or in static equilibrium.
///
/// # Errors
/// If the structure is not well posed, or there is no stable equilibrium; the text says what helps.
pub fn initial_state(case: &Case, domain: &Domain) -> Result<InitialState, NoInitialState> {
    let of_mesh = |error| not_built(case, domain, error);
    let at_rest = |solid| InitialState {
        solid,
        unloading: None,
    };
    let Some(initial) = case.initial_wall() else {
        return structure(case, domain).map(at_rest).map_err(of_mesh);
    };
    let (pressure, image, stretch) = (initial.pressure, initial.image_pressure, initial.stretch);
    let is_pressed = pressure != 0.0 || image != 0.0 || domain.outer_pressure.is_some();
    let stretch = stretch * case.prestretch();
    if stretch == 1.0 && !is_pressed && !initial.tissue_rests_loaded {
        return structure(case, domain).map(at_rest).map_err(of_mesh);
    }
    if let Some(refused) = too_weak(case, &initial) {
        return Err(refused);
    }
    let InitialWall {
        key, key_of_image, ..
    } = &initial;
    let UnloadedWall {
        mut solid,
        moved,
        found,
    } = unloaded_wall(case, domain).map_err(|error| match error {
        SolidError::NoUnloadedShape(_) | SolidError::NoEquilibrium(_)
            if initial.shape == GivenShape::Loaded =>
        {
            let key = Some(initial.key_of_shape.into());
            NoInitialState { key, error }
        }
        SolidError::NoEquilibrium(_) => buckled(&initial, key, pressure, &error),
        error => of_mesh(error),
    })?;
    if let Some(Known {
        beginning: Some((displacement, unloading)),
        ..
    }) = known(case)
    {
        solid.set_at_rest(displacement).map_err(of_mesh)?;
        return Ok(InitialState { solid, unloading });
    }
    let begins = |displacement: &[f64], unloading: Option<Unloading>| {
        if let Some(known) = known(case) {
            let beginning = Some((displacement.to_vec(), unloading));
            remember(Known { beginning, ..known });
        }
    };
    let equilibrium = |solid: &Structure, key: &str, pressure| {
        let found = solid.equilibrium(pressure, moved.as_deref());
        found.map_err(|error| buckled(&initial, key, pressure, &error))
    };
    let Some(found) = found else {
        let loaded = equilibrium(&solid, key, pressure)?;
        begins(&loaded, None);
        solid.set_at_rest(loaded).map_err(of_mesh)?;
        return Ok(at_rest(solid));
    };
    // The way back decides: only a stable equilibrium is a state of a wall.
    let loaded = equilibrium(&solid, key_of_image, image)?;
    let mut reached = back_to_given(&mut solid, loaded, image).map_err(of_mesh)?;
    reached.iterations = found.iterations;
    if reached.distance_after_loading_m > LARGEST_DISTANCE {
        return Err(elsewhere(&initial, reached.distance_after_loading_m));
    }
    let beginning = match pressure == image {
        true => found.displacement,
        false => equilibrium(&solid, key, pressure)?,
    };
    let unloading = Some(reached);
    begins(&beginning, unloading);
    solid.set_at_rest(beginning).map_err(of_mesh)?;
    Ok(InitialState { solid, unloading })
}

/// Loads the unloaded shape that was found, and says how far it was and how near the given shape it comes.
fn back_to_given(
    solid: &mut Structure,
    loaded: Vec<f64>,
    pressure: f64,
) -> Result<Unloading, SolidError> {
    let wet: Vec<Vec3> = solid.wet_points().iter().map(|p| p.position).collect();
    let places = solid.locate(&wet)?;
    let largest = |moved: &[Vec3]| moved.iter().map(|u| u.norm()).fold(0.0, f64::max);
    let before = solid.accepted_displacement(&places);
    let squares: f64 = before.iter().map(|u| u.norm_squared()).sum();
    solid.set_at_rest(loaded)?;
    Ok(Unloading {
        pressure_Pa: pressure,
        iterations: 0,
        largest_displacement_m: largest(&before),
        rms_displacement_m: (squares / before.len() as f64).sqrt(),
        distance_after_loading_m: largest(&solid.accepted_displacement(&places)),
    })
}

fn elsewhere(initial: &InitialWall, distance: f64) -> NoInitialState {
    NoInitialState {
        key: Some(initial.key_of_shape.into()),
        error: SolidError::Model(format!(
            "the unloaded shape that was found leads, loaded, to a shape {distance:.1e} m away from the given one: another \
             equilibrium, since the wall is close to buckling. What keeps it straight: {}",
            what_keeps_straight(initial)
        )),
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::Preset;

    /// What is planted where the statics of a case are kept is found there again: they are not solved once more.
    #[test]
    fn the_statics_of_a_case_are_solved_once() {
        let folder = tempfile::tempdir().unwrap();
        let text = "extends = \"defaults\"\n[vessel]\npoints_m = [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0]]\nradius_m = 3e-3\n\
                    [[vessel.section]]\nname = \"artery\"\nlayers = [\"wall\"]\nthicknesses = [0.3]\n[[vessel.material]]\nname = \"wall\"\n\
                    material = \"neo_hooke\"\nmu_Pa = 3e5\nkappa_Pa = 1e7\n[initial]\nstart = \"equilibrium\"\nshape = \"loaded\"\n\
                    pressure_Pa = 1e4\n[windkessel]\ninitial_pressure_Pa = 1.1e4\n[structure]\np = 3\naxial_per_section = 2\n\
                    circumferential = 4\n";
        std::fs::write(folder.path().join("case.toml"), text).unwrap();
        let case = Case::load(folder.path(), Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
        let domain = Domain::new(&case).unwrap();
        let first = initial_state(&case, &domain).unwrap_or_else(|e| panic!("{e}"));
        let mut planted = known(&case).unwrap();
        let iterations = |state: &InitialState| state.unloading.unwrap().iterations;
        assert_eq!(
            planted.beginning.as_ref().unwrap().1.unwrap().iterations,
            iterations(&first)
        );
        planted
            .beginning
            .as_mut()
            .unwrap()
            .1
            .as_mut()
            .unwrap()
            .iterations = 12345;
        planted.unloaded.found.as_mut().unwrap().iterations = 54321;
        remember(planted);
        let again = initial_state(&case, &domain).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(iterations(&again), 12345);
        let wall = unloaded_wall(&case, &domain).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(wall.found.unwrap().iterations, 54321);
        let wet: Vec<Vec3> = first
            .solid
            .wet_points()
            .iter()
            .map(|p| p.position)
            .collect();
        let [a, b] = [&first, &again].map(|state| {
            let places = state.solid.locate(&wet).unwrap();
            state.solid.accepted_displacement(&places)
        });
        assert_eq!(a, b, "to the last digit");

        // Another case has its own.
        let mut other = case.case.clone();
        other.wall.density *= 2.0;
        assert!(known(&other).is_none());
    }

    /// The wall of a loaded vessel 40 mm long whose centre-line has this bend, stretched by 1.2: the centres of its two
    /// ends and of its middle in the unloaded shape (m), and where these lie in the given one.
    fn centres(piece: &str) -> [[Vec3; 3]; 2] {
        let folder = tempfile::tempdir().unwrap();
        let text = format!(
            "extends = \"defaults\"\n[vessel]\nradius_m = 3e-3\n[[vessel.piece]]\nlength_m = 0.04\n{piece}\n[[vessel.section]]\n\
             name = \"artery\"\nlayers = [\"wall\"]\nthicknesses = [0.25]\n[[vessel.material]]\nname = \"wall\"\n\
             material = \"neo_hooke\"\nmu_Pa = 1.5e5\nkappa_Pa = 1e7\n[initial]\nstart = \"equilibrium\"\n\
             shape = \"loaded\"\naxial_stretch = 1.2\n[windkessel]\ninitial_pressure_Pa = 1.1e4\n[structure]\np = 3\n\
             axial_per_section = 6\ncircumferential = 4\n"
        );
        std::fs::write(folder.path().join("case.toml"), text).unwrap();
        let case = Case::load(folder.path(), Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
        let domain = Domain::new(&case).unwrap();
        let state = initial_state(&case, &domain).unwrap_or_else(|e| panic!("{e}"));
        let unloading = state.unloading.unwrap();
        assert!(unloading.distance_after_loading_m < 1e-9, "{unloading:?}");
        let wall = unloaded_wall(&case, &domain).unwrap_or_else(|e| panic!("{e}"));
        let line = Vessel::new(case.vessel().unwrap());
        let frames = [0.0, 0.5, 1.0].map(|share| line.centre_line().frame(share * line.end()));
        let given = frames.map(|frame| frame.origin);
        let unloaded = frames.map(|frame| {
            let across = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
            let ring = across.map(|[y, z]| frame.point(3e-3 * y, 3e-3 * z));
            let places = wall.solid.locate(&ring).unwrap();
            let moved = wall.solid.accepted_displacement(&places);
            let unloaded = ring.iter().zip(&moved).map(|(x, u)| x + u);
            unloaded.sum::<Vec3>() / 4.0
        });
        [unloaded, given]
    }

    /// The ends of a curved vessel come as much nearer to each other as those of a straight one, and between them it
    /// bends more without load than with it, since tension along a curve straightens it. One that is hardly curved is
    /// as good as straight.
    #[test]
    fn curved_vessels_are_stretched_too() {
        let [straight, given] = centres("piece = \"line\"");
        assert!((given[2].x - 0.04).abs() < 1e-12 && (straight[2].x - 0.04 / 1.2).abs() < 1e-9);
        let [hardly, _] = centres("piece = \"arc\"\nbend_radius_m = 1e4");
        for (a, b) in straight.iter().zip(&hardly) {
            assert!((a - b).norm() < 1e-6, "{a} {b}");
        }
        let [unloaded, given] = centres("piece = \"arc\"\nbend_radius_m = 0.08");
        let chord = |ends: &[Vec3; 3]| (ends[2] - ends[0]).norm();
        let rise = |ends: &[Vec3; 3]| (ends[1] - 0.5 * (ends[0] + ends[2])).norm();
        assert!((chord(&given) / chord(&unloaded) - 1.2).abs() < 1e-6);
        // An even stretch would leave the ratio of rise and chord. A slender beam bends by
        // N L²/(48 E I) = 0.96, without the shear of one that is not.
        let bends = rise(&unloaded) / chord(&unloaded) * chord(&given) / rise(&given);
        assert!((2.30..2.45).contains(&bends), "{bends}");
    }
}
