//! The domain of an OpenFOAM case of the user's own: its mesh as it is, and a wall on its patches.

use super::domain::{Domain, DomainError};
use crate::Vec3;
use crate::case::{Case, Extrusion, FibreAxis, OwnCase, OwnWall, WallFile, WallSupport};
use crate::fluid::openfoam::own_case::OwnCaseFiles;
use crate::geometry::{self, Growth, HexMesh, PolyMesh, WET, WetQuads};
use crate::pfem::supports::{Direction, Foundation, Profile, Support};
use crate::pfem::{Space, SpaceKind};

/// What the driver adds to the case.
pub(super) fn files<'a>(case: &Case, own: &'a OwnCase) -> OwnCaseFiles<'a> {
    OwnCaseFiles {
        keys: &own.fluid,
        density: case.blood.density,
        time_step: case.time.step,
        ranks: case.fluid.ranks,
    }
}

/// Reads the mesh and puts the wall on it.
///
/// # Errors
/// What is wrong with the mesh, the patches or the wall.
pub(super) fn domain(case: &Case, own: &OwnCase) -> Result<Domain, DomainError> {
    let wrong = |key| move |reason: String| DomainError { key, reason };
    let fluid = files(case, own).mesh();
    let fluid = fluid.map_err(|e| wrong("fluid.case")(e.to_string()))?;
    let wall = &own.wall;
    let (solid, wet_surface) = match (&wall.extrude, &wall.file) {
        (Some(extrusion), _) => (extruded(case, own, extrusion, &fluid)?, "inner"),
        (None, Some(file)) => (from_file(wall, file)?, WET),
        (None, None) => unreachable!("the check of the case asks for a wall"),
    };
    let supports = supports(wall, &solid).map_err(wrong("wall.support"))?;
    Ok(Domain {
        elastic_cells: 0..fluid.cells(),
        fluid,
        solid,
        wet_patches: own.fluid.patches.clone(),
        materials: wall
            .material
            .iter()
            .map(|named| named.material.clone())
            .collect(),
        space: Space::isotropic(SpaceKind::Trunk, case.structure.p),
        wet_surface,
        supports,
        outer_pressure: Profile::default(),
    })
}

fn extruded(
    case: &Case,
    own: &OwnCase,
    extrusion: &Extrusion,
    fluid: &PolyMesh,
) -> Result<HexMesh, DomainError> {
    let wall = &own.wall;
    let surface = WetQuads::new(fluid, &own.fluid.patches);
    let surface = surface.map_err(|e| DomainError::new("fluid.patches", e))?;
    let normals = surface.normals(extrusion.smoothing.unwrap_or(0));
    let points = &surface.quads.points;
    let factors = match &extrusion.factors {
        None => vec![1.0; points.len()],
        Some(path) => factors(path, points).map_err(|reason| DomainError {
            key: "wall.extrude.factors",
            reason,
        })?,
    };
    let thicknesses: Vec<Vec<f64>> = if extrusion.shares.is_empty() {
        let layer = |thickness: &f64| factors.iter().map(|factor| thickness * factor).collect();
        extrusion.thicknesses.iter().map(layer).collect()
    } else {
        let radii = surface.radii(&normals);
        if let Some(flat) = radii.iter().position(|radius| !radius.is_finite()) {
            let x = points[flat];
            return Err(DomainError {
                key: "wall.extrude.thicknesses",
                reason: format!(
                    "the surface has no radius at ({:.4e}, {:.4e}, {:.4e}) m, where it encloses nothing: give \
                     wall.extrude.thicknesses_m",
                    x.x, x.y, x.z
                ),
            });
        }
        let thickness = |share: &f64| {
            let pairs = radii.iter().zip(&factors);
            pairs
                .map(|(radius, factor)| share * radius * factor)
                .collect()
        };
        extrusion.shares.iter().map(thickness).collect()
    };
    let region = |name: &String| {
        wall.region(name)
            .expect("the check of the case knows all layers")
    };
    let growth = Growth {
        faces: extrusion.faces,
        elements_per_layer: extrusion.elements.unwrap_or(1),
        thicknesses,
        regions: extrusion.layers.iter().map(region).collect(),
        axes: axes(case, own, extrusion, fluid, &surface, &normals)?,
        normals,
    };
    let mesh = surface.wall(&growth);
    mesh.map_err(|e| DomainError::new("wall.extrude.faces_per_element", e))
}

/// Directions along the vessel, as the case asks for them.
fn axes(
    case: &Case,
    own: &OwnCase,
    extrusion: &Extrusion,
    fluid: &PolyMesh,
    surface: &WetQuads,
    normals: &[Vec3],
) -> Result<Option<Vec<Vec3>>, DomainError> {
    if extrusion.axis == Some(FibreAxis::Mesh) {
        return Ok(None);
    }
    let openings = files(case, own).openings(fluid);
    let Some((first, others)) = openings.split_first() else {
        return Ok(None);
    };
    let axes = surface.axes(std::slice::from_ref(first), others, normals);
    match (axes, extrusion.axis) {
        (None, Some(FibreAxis::Flow)) => Err(DomainError {
            key: "wall.extrude.axis",
            reason: format!(
                "the wall does not end both at the first opening, {first:?}, and at another one: write \"mesh\", or give \
                 fluid.openings, the inlet first"
            ),
        }),
        (axes, _) => Ok(axes),
    }
}

/// The hexahedra of a file. Its regions are of the materials of their names; if there is a single material, all are of it.
fn from_file(wall: &OwnWall, keys: &WallFile) -> Result<HexMesh, DomainError> {
    let wrong = |reason: String| DomainError {
        key: "wall.file.mesh",
        reason,
    };
    let file = geometry::WallFile::read(&keys.mesh).map_err(|e| wrong(e.to_string()))?;
    let material = |name: &str| match wall.region(name) {
        Some(region) => Ok(region),
        None if wall.material.len() == 1 => Ok(0),
        None => Err(format!(
            "no [[wall.material]] is called as the region {name:?} of the file; its regions are \"{}\"",
            file.regions.join("\", \"")
        )),
    };
    let mesh = file.mesh(keys.unit.unwrap_or(1.0), &keys.wet, material);
    mesh.map_err(|reason| wrong(format!("{}: {reason}", keys.mesh.display())))
}

/// The factor of the row nearest to each point, of a file with the columns `x,y,z,factor` (m).
fn factors(path: &std::path::Path, points: &[Vec3]) -> Result<Vec<f64>, String> {
    let failed = |e: csv::Error| format!("{}: {e}", path.display());
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(failed)?;
    let rows: Result<Vec<[f64; 4]>, csv::Error> = reader.deserialize().collect();
    let rows = rows.map_err(failed)?;
    if rows.is_empty() || rows.iter().any(|row| !(row[3] > 0.0 && row[3] < 1e3)) {
        return Err(format!(
            "{}: expected rows x,y,z,factor, with factors above 0",
            path.display()
        ));
    }
    let factor = |x: &Vec3| {
        let distance = |row: &&[f64; 4]| (Vec3::new(row[0], row[1], row[2]) - x).norm_squared();
        let nearest = rows
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or(1.0, |row| row[3])
    };
    Ok(points.iter().map(factor).collect())
}

/// What holds the wall; the rims of one that is extruded are clamped where nothing else is said.
fn supports(wall: &OwnWall, mesh: &HexMesh) -> Result<Vec<Support>, String> {
    let Some(described) = &wall.support else {
        let rims = mesh
            .surfaces
            .keys()
            .filter(|name| !["inner", "outer"].contains(&name.as_str()));
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
                return Err(format!(
                    "the wall has no surface {name:?}; it has \"{}\"",
                    known.join("\", \"")
                ));
            }
            supports.push(match support {
                WallSupport::Clamped { .. } => Support::Clamped(name.clone()),
                WallSupport::Sliding { held, .. } => {
                    let is_held = |axis: &str| held.iter().any(|name| name == axis);
                    Support::Surface(name.clone(), ["x", "y", "z"].map(is_held))
                }
                WallSupport::Springs {
                    spring, damping, ..
                } => Support::Foundation(Foundation {
                    surface: name.clone(),
                    spring: Profile::constant(*spring),
                    damping: damping.map_or(Profile::default(), Profile::constant),
                    direction: Direction::All,
                }),
            });
        }
    }
    Ok(supports)
}
