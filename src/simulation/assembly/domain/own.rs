//! The domain of a user-supplied OpenFOAM case: its mesh as it is, and a wall on its patches.

use super::{Branches, Domain, DomainError, RoundLumen, supports};
use crate::Vec3;
use crate::case::{
    Case, Extrusion, FibreAxis, OwnCase, OwnWall, PatchLayers, StructureSettings, SurrogateModel,
    TreeKeys, WallFile, WallMode, WallMotion,
};
use crate::files::{Fault, FileError, fault};
use crate::fluid::openfoam::own_case::{OwnCaseFiles, PatchMotion};
use crate::geometry::tree::{Lumen, Tree};
use crate::geometry::{self, Growth, HexMesh, Patch, PolyMesh, RIGID_MATERIAL, WET, WetQuads};
use crate::pfem::element::mapping::{Mapping, MappingKind};
use crate::pfem::supports::{Profile, Support};
use crate::pfem::{PrescribedMotion, Space, SpaceKind};
use crate::tabular::{Sheet, units};
use fsi_numerics::quadrature::Rule;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Averages of the normals of a tree's wall: the first with which nothing is inside out. Without any, a wall of a
/// quarter of the radius is inside out at an apex of the examples, with two it is not; vessels of others need more.
const SMOOTHING_OF_TREES: [usize; 4] = [4, 16, 64, 256];
/// An element is nearly inside out, and may be so in the unloaded shape, where its Jacobian is less than this share of
/// its largest one.
const NEARLY: f64 = 0.05;
/// Most cells in which the surrogate's pressure is solved for directly.
const MOST_CELLS_OF_SURROGATE: usize = 200_000;

/// Whether potential flow in the cells of a mesh can be the surrogate.
fn surrogate_is_possible(case: &Case, own: &OwnCase, mesh: &PolyMesh) -> Result<(), DomainError> {
    let refused = |reason: String| Err(DomainError::new("coupling.surrogate", reason));
    if mesh.cells() > MOST_CELLS_OF_SURROGATE {
        return refused(format!(
            "\"potential\" solves for the pressure in all cells at once, at most {MOST_CELLS_OF_SURROGATE} of them, and the mesh \
             has {}: write \"none\"",
            mesh.cells()
        ));
    }
    if files(case, own).pressures(mesh).is_empty() {
        return refused(
            "\"potential\" asks for a patch where the pressure is given or answers to the flow, and the field p has no \
             such condition that is plain to see: write \"none\""
                .into(),
        );
    }
    Ok(())
}

/// What the driver adds to the case.
pub fn files<'a>(case: &Case, own: &'a OwnCase) -> OwnCaseFiles<'a> {
    OwnCaseFiles {
        folder: own.fluid.case.as_deref().unwrap_or(Path::new("")),
        keys: &own.fluid,
        density: case.blood.density,
        time_step: case.time.step,
        ranks: case.fluid.ranks,
        moving: BTreeMap::new(),
    }
}

/// The same where the wall is known.
pub fn own_case_files<'a>(case: &Case, own: &'a OwnCase, domain: &Domain) -> OwnCaseFiles<'a> {
    OwnCaseFiles {
        moving: moving_patches(own, domain),
        ..files(case, own)
    }
}

/// Whether flow and pressure are recorded wherever the fluid may enter or leave the domain.
pub fn all_openings_are_known(own: &OwnCase, mesh: &PolyMesh) -> bool {
    let keys = &own.fluid;
    let is_closed = |patch: &Patch| patch.kind != "patch" || keys.patches.contains(&patch.name);
    let is_known = |patch: &Patch| is_closed(patch) || keys.openings.contains(&patch.name);
    keys.openings.is_empty() || mesh.patches.iter().all(is_known)
}

/// Whether all that enters or leaves the blood passes an end of the tree that is its wall, so that the openings beyond
/// a cross-section are known.
///
/// # Errors
/// The patch that is not known, and what to do.
pub fn flows_are_known(case: &Case, own: &OwnCase, mesh: &PolyMesh) -> Result<(), DomainError> {
    let ends = (own.tree.as_ref()).map_or_else(Vec::new, TreeKeys::open_names);
    let openings = files(case, own).openings(mesh);
    let missing = ends.iter().find(|name| !openings.contains(name));
    if let Some(name) = missing {
        let reason = format!(
            "the flow through a cross-section is that of the openings beyond it, so all ends of the tree are needed here: add \
             {name:?}"
        );
        return Err(DomainError::new("fluid.openings", reason));
    }
    let is_open = |patch: &&Patch| {
        patch.kind == "patch" && patch.size > 0 && !own.fluid.patches.contains(&patch.name)
    };
    let mut open = mesh.patches.iter().filter(is_open);
    match open.find(|patch| !ends.contains(&patch.name)) {
        Some(patch) => Err(DomainError::new(
            "output.section[0].branch",
            format!(
                "the flow through a cross-section is that of the openings beyond it, and no line of the tree ends at the patch \
                 {:?}, where the blood may leave: let one end there, or make it a wall (type wall) in the OpenFOAM case",
                patch.name
            ),
        )),
        None => Ok(()),
    }
}

/// The patches at which a wall ends whose rim moves there: that of an extruded wall unless it is held, that of a
/// prescribed motion where it moves. Those of a wall from a file are not known.
pub fn moving_patches(own: &OwnCase, domain: &Domain) -> BTreeMap<String, PatchMotion> {
    let mesh = &domain.fluid;
    let others = mesh
        .patches
        .iter()
        .filter(|patch| !own.fluid.patches.contains(&patch.name));
    let motion = |patch: &Patch| match &domain.motion {
        Some(motion) => {
            let (inner, _) = domain
                .solid
                .vertices
                .split_at(domain.solid.vertices.len() / 2);
            let bits = |x: &Vec3| [x.x, x.y, x.z].map(f64::to_bits);
            let on_patch: BTreeSet<_> = (mesh.patch_faces(&patch.name).iter().flatten())
                .map(|&point| bits(&mesh.points[point]))
                .collect();
            let rim = inner.iter().zip(&motion.displacement);
            let rim = rim
                .filter(|(x, _)| on_patch.contains(&bits(x)))
                .map(|(_, u)| u);
            let moved: Vec<&Vec3> = rim.filter(|u| **u != Vec3::zeros()).collect();
            let within = |n: Vec3| moved.iter().all(|u| u.dot(&n).abs() <= 1e-9 * u.norm());
            (!moved.is_empty()).then(|| plane_normal(mesh, patch).is_some_and(within))
        }
        None => {
            domain
                .solid
                .surfaces
                .get(&patch.name)
                .filter(|_| own.wall.is_extruded())?;
            let (mut held, mut in_plane) = ([false; 3], false);
            for support in &domain.supports {
                match support {
                    Support::Clamped(name) if *name == patch.name => held = [true; 3],
                    Support::Surface(name, more) if *name == patch.name => {
                        held = std::array::from_fn(|i| held[i] || more[i]);
                    }
                    Support::Foundation(guide) if guide.surface == patch.name => {
                        in_plane |= guide.keeps_in_plane();
                    }
                    _ => {}
                }
            }
            let across = |n: Vec3| (0..3).all(|i| held[i] || n[i].abs() < 1e-6);
            (held != [true; 3])
                .then(|| plane_normal(mesh, patch).is_some_and(|n| in_plane || across(n)))
        }
    };
    let motion = |patch: &Patch| {
        let kind = match motion(patch)? {
            true => PatchMotion::InPlane,
            false => PatchMotion::Free,
        };
        Some((patch.name.clone(), kind))
    };
    others.filter_map(motion).collect()
}

/// The unit normal of a patch that is plane.
fn plane_normal(mesh: &PolyMesh, patch: &Patch) -> Option<Vec3> {
    let faces = patch.start..patch.start + patch.size;
    let mut normals = faces.map(|face| mesh.face_geometry(face).1.normalize());
    let first = normals.next()?;
    normals.all(|n| n.dot(&first) > 1.0 - 1e-9).then_some(first)
}

/// Reads the mesh and puts the wall on it.
///
/// # Errors
/// What is wrong with the mesh, the patches or the wall.
pub fn domain(case: &Case, own: &OwnCase) -> Result<Domain, DomainError> {
    let given = (own.fluid.case.as_ref()).map(|_| files(case, own).mesh());
    let given = given.transpose();
    let given = given.map_err(|e| DomainError::new("fluid.case", e))?;
    let vessel = own
        .tree
        .as_ref()
        .map(|tree| branching(tree, given.is_none()));
    let (fluid, mut branches) = match (given, vessel.transpose()?) {
        (Some(fluid), Some((_, branches))) => {
            ends_are_patches(own, &fluid)?;
            (fluid, Some(branches))
        }
        (None, Some((fluid, branches))) => (fluid, Some(branches)),
        (Some(fluid), None) => (fluid, None),
        (None, None) => unreachable!("the check of the case asks for a mesh or a tree"),
    };
    if case.has_own_openfoam() && case.coupling.surrogate == SurrogateModel::Potential {
        surrogate_is_possible(case, own, &fluid)?;
    }
    let wall = &own.wall;
    if wall.mode() != WallMode::Elastic {
        return rigid_domain(own, fluid);
    }
    let (solid, wet_surface) = match (&wall.extrude, &wall.file) {
        (Some(extrusion), _) => {
            let known = branches.as_ref();
            let surface = known.map_or(&fluid, |branches| &branches.surface);
            let lumen = known.map(|branches| &branches.lumen);
            let (wall, notes) = extruded(case, own, extrusion, (surface, lumen))?;
            if let Some(branches) = &mut branches {
                branches.notes.extend(notes);
            }
            (wall, "inner")
        }
        (None, Some(file)) => (from_file(wall, file)?, WET),
        (None, None) => unreachable!("the check of the case asks for a wall"),
    };
    let supports = supports::of(own, &solid, branches.as_ref());
    let supports = supports.map_err(|e| DomainError::new("wall.support", e))?;
    Ok(Domain {
        elastic_cells: 0..fluid.cells(),
        fluid,
        branches,
        solid,
        wet_patches: own.fluid.patches.clone(),
        materials: (wall.materials().iter())
            .map(|named| named.material.clone())
            .collect(),
        space: Space::isotropic(SpaceKind::Trunk, case.structure.p),
        wet_surface,
        supports,
        outer_pressure: None,
        motion: None,
    })
}

/// The mesh of a vessel that branches, and what else is known of it.
fn branching(keys: &TreeKeys, is_meshed: bool) -> Result<(PolyMesh, Branches), DomainError> {
    let meshes = Tree::meshes(keys).map_err(|e| DomainError::new(e.key(), e))?;
    let round = RoundLumen {
        polygons: meshes.polygons,
        worst: meshes.worst,
    };
    let branches = Branches {
        notes: meshes.notes,
        lumen: meshes.lumen,
        surface: meshes.surface,
        lines: meshes.lines,
        meshed: is_meshed.then_some(round),
    };
    Ok((meshes.outside, branches))
}

/// Whether the ends of a tree are patches of the OpenFOAM case whose wall it is: rims move with them.
fn ends_are_patches(own: &OwnCase, mesh: &PolyMesh) -> Result<(), DomainError> {
    let names = own
        .tree
        .as_ref()
        .map_or_else(Vec::new, TreeKeys::open_names);
    let is_patch = |name: &String| mesh.patches.iter().any(|patch| patch.name == *name);
    let Some(place) = names.iter().position(|name| !is_patch(name)) else {
        return Ok(());
    };
    let others = mesh.patches.iter().map(|patch| patch.name.as_str());
    let others = others.filter(|name| !own.fluid.patches.iter().any(|wet| wet == name));
    Err(DomainError::new(
        match place {
            0 => "tree.inlet",
            _ => "tree.outlets",
        },
        format!(
            "the wall ends at {:?}, which is no patch of the OpenFOAM case: call each end as the patch there, one of \"{}\"",
            names[place],
            others.collect::<Vec<_>>().join("\", \"")
        ),
    ))
}

/// A rigid wall: a thin layer whose wet side holds, or moves as prescribed.
fn rigid_domain(own: &OwnCase, fluid: PolyMesh) -> Result<Domain, DomainError> {
    let solid = fluid.lining(&own.fluid.patches);
    let solid = solid.map_err(|e| DomainError::new("fluid.patches", e))?;
    let motion = match (own.wall.mode(), &own.wall.motion) {
        (WallMode::Prescribed, Some(keys)) => Some(motion(keys, &solid)?),
        _ => None,
    };
    Ok(Domain {
        elastic_cells: 0..fluid.cells(),
        fluid,
        branches: None,
        wet_patches: own.fluid.patches.clone(),
        materials: vec![RIGID_MATERIAL],
        // Points of the fluid's patches are vertices of it: they move exactly as it does.
        space: Space::isotropic(SpaceKind::Trunk, 1),
        wet_surface: "inner",
        supports: vec![Support::Clamped("inner".into())],
        outer_pressure: None,
        motion,
        solid,
    })
}

/// The motion that two files prescribe to the vertices of a lining.
fn motion(keys: &WallMotion, solid: &HexMesh) -> Result<PrescribedMotion, DomainError> {
    let found: Vec<[f64; 6]> = rows(&keys.displacements, &["x", "y", "z", "ux", "uy", "uz"])
        .map_err(|reason| DomainError::new("wall.motion.displacements", reason))?;
    let (places, displacements): (Vec<Vec3>, Vec<Vec3>) = (found.iter())
        .map(|[x, y, z, ux, uy, uz]| (Vec3::new(*x, *y, *z), Vec3::new(*ux, *uy, *uz)))
        .unzip();
    let (inner, _) = solid.vertices.split_at(solid.vertices.len() / 2);
    let inner: Vec<Vec3> = (inner.iter().map(|x| displacements[nearest(&places, x)])).collect();
    let factor = factor_over_time(&keys.factors)
        .map_err(|reason| DomainError::new("wall.motion.factors", reason))?;
    Ok(PrescribedMotion {
        // What is above a point goes with it.
        displacement: [&inner[..], &inner].concat(),
        factor,
    })
}

/// A factor over time, of a file with the columns `time_s,factor`, 0 at t = 0.
fn factor_over_time(path: &Path) -> Result<Profile, FileError> {
    let found: Vec<[f64; 2]> = rows(path, &["time_s", "factor"])?;
    let wrong = |what: Fault| Err(FileError::new(path, what));
    if found[0] != [0.0, 0.0] {
        let [t, factor] = found[0];
        return wrong(fault!(
            "the first row is {t:?},{factor:?}: expected 0,0, since the wall is at rest in the mesh of the case at t = 0"
        ));
    }
    let mut pairs = found.iter().zip(&found[1..]);
    if let Some((a, b)) = pairs.find(|(a, b)| b[0] <= a[0]) {
        return wrong(fault!(
            "times must increase, and {:?} s follows {:?} s",
            b[0],
            a[0]
        ));
    }
    Ok(Profile(
        found.into_iter().map(|[t, factor]| (t, factor)).collect(),
    ))
}

/// The wall on the surface, and what is unusual about it.
fn extruded(
    case: &Case,
    own: &OwnCase,
    extrusion: &Extrusion,
    (fluid, lumen): (&PolyMesh, Option<&Lumen>),
) -> Result<(HexMesh, Vec<String>), DomainError> {
    let surface = WetQuads::new(fluid, &own.wall_patches());
    let surface = surface.map_err(|e| DomainError::new("fluid.patches", e))?;
    let along = potential(case, own, extrusion, fluid, &surface)?;
    // What a stenosis narrows thickens the wall inward: it grows from where it would without, and its outer side stays.
    let of_features = lumen.filter(|lumen| lumen.has_features());
    let healthy = of_features.map(|lumen| {
        let mut healthy = surface.clone();
        let points = healthy.quads.points.par_iter_mut();
        points.for_each(|x| *x = lumen.without_narrowing(x));
        healthy
    });
    let surfaces = [&surface, healthy.as_ref().unwrap_or(&surface)];
    let with =
        |lumen, passes| extruded_with(own, extrusion, (surfaces, lumen), along.as_deref(), passes);
    let given = extrusion.smoothing.map(|given| vec![given]);
    let averages = match (given, &own.tree) {
        (Some(given), _) => given,
        (None, None) => return Ok((with(None, 0)?, Vec::new())),
        (None, Some(_)) => SMOOTHING_OF_TREES.to_vec(),
    };
    let (wall, found) = fitted(&averages, case, lumen, with)?;
    let mut notes = Vec::new();
    if let Some((passes, is_on_lumen)) = found {
        if passes > averages[0] {
            notes.push(format!(
                "the normals of its wall are averaged {passes} times: with fewer, elements would be inside out where \
                 branches part, or nearly so (wall.extrude.smoothing)"
            ));
        }
        if lumen.is_some() && !is_on_lumen {
            notes.push(
                "its wall lies on the lumen at the corners of the cells alone: elements that followed the lumen between \
                 them would be inside out; a thinner wall may follow it (wall.extrude.thicknesses)"
                    .into(),
            );
        }
    }
    Ok((wall, notes))
}

/// The first wall of which nothing is inside out, or nearly so if there is another, with its averages of the normals
/// and whether it is on the lumen between the points of the faces too, or else on these alone. If there is none, the
/// first one: the check of the wall says where.
fn fitted<'l>(
    averages: &[usize],
    case: &Case,
    lumen: Option<&'l Lumen>,
    with: impl Fn(Option<&'l Lumen>, usize) -> Result<HexMesh, DomainError>,
) -> Result<(HexMesh, Option<(usize, bool)>), DomainError> {
    let mut first = None;
    let ways = [lumen, None]
        .into_iter()
        .take(1 + usize::from(lumen.is_some()));
    for lumen in ways {
        let mut possible = None;
        for &passes in averages {
            let wall = with(lumen, passes)?;
            let is_whole = |share| inside_out(&wall, &case.structure, share).is_none();
            let found = Some((passes, lumen.is_some()));
            if is_whole(NEARLY) {
                return Ok((wall, found));
            }
            match is_whole(0.0) {
                true => drop(possible.get_or_insert((wall, found))),
                false => drop(first.get_or_insert(wall)),
            }
        }
        if let Some(possible) = possible {
            return Ok(possible);
        }
    }
    Ok((first.expect("one was tried"), None))
}

/// Where an element is (m), or has less than this share of its largest Jacobian, at a point where the solver integrates
/// or its results are drawn: at no others, so that no wall that can be computed is refused.
fn inside_out(wall: &HexMesh, settings: &StructureSettings, share: f64) -> Option<Vec3> {
    let p = settings.p;
    let mapping = Mapping::new(wall, MappingKind::Blended(settings.p_geometry.unwrap_or(p)));
    let integrated = Rule::gauss_legendre(settings.quadrature_points.unwrap_or(p + 1)).points;
    let steps = p.max(1);
    let drawn: Vec<f64> = (0..=steps)
        .map(|i| 2.0 * i as f64 / steps as f64 - 1.0)
        .collect();
    (0..wall.hexes.len())
        .into_par_iter()
        .find_map_first(|element| {
            [&integrated, &drawn].into_iter().find_map(|axis| {
                let points = mapping.at_lattice(element, [axis; 3]);
                let volumes = points.iter().map(|x| x.jacobian.determinant());
                let least = share * volumes.fold(0.0, f64::max);
                let inverted = points.iter().find(|x| x.jacobian.determinant() <= least);
                inverted.map(|x| x.position)
            })
        })
}

impl Domain {
    /// Puts the extruded wall of another case of the same vessel that branches on its lumen.
    ///
    /// # Errors
    /// If that wall cannot be made.
    pub fn extrude_again(&mut self, case: &Case) -> Result<(), DomainError> {
        if let Some(own) = case.own()
            && let Some(extrusion) = &own.wall.extrude
            && let Some(Branches { surface, lumen, .. }) = &self.branches
        {
            (self.solid, _) = extruded(case, own, extrusion, (surface, Some(lumen)))?;
        }
        Ok(())
    }

    /// Where an element of the extruded wall of a case is inside out (m), if one is.
    pub fn wall_inside_out(&self, case: &Case) -> Option<Vec3> {
        let is_extruded = (case.own()).is_some_and(|own| own.wall.is_extruded());
        (is_extruded && case.has_elastic_wall())
            .then(|| inside_out(&self.solid, &case.structure, 0.0))
            .flatten()
    }
}

fn extruded_with(
    own: &OwnCase,
    extrusion: &Extrusion,
    ([surface, healthy], lumen): ([&WetQuads; 2], Option<&Lumen>),
    along: Option<&[f64]>,
    passes: usize,
) -> Result<HexMesh, DomainError> {
    let wall = &own.wall;
    let patches = own.wall_patches();
    let normals = healthy.normals(passes);
    let points = &surface.quads.points;
    let factors = match &extrusion.factors {
        None => vec![1.0; points.len()],
        Some(path) => {
            factors(path, points).map_err(|e| DomainError::new("wall.extrude.factors", e))?
        }
    };
    let branches = own.tree.as_ref().map(TreeKeys::branches);
    let numbered = patches.iter().enumerate();
    let layers: Vec<PatchLayers> = numbered
        .map(|(i, patch)| extrusion.layers_of(patch, branches.as_ref().map(|names| &*names[i])))
        .collect();
    let mut radii = Vec::new();
    if layers.iter().any(|layers| !layers.shares.is_empty()) {
        radii = healthy.radii(&normals);
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
    }
    let thickness = |layer: usize| {
        surface.by_patch(|patch, point| {
            let layers = &layers[patch];
            let (size, all) = match layers.shares.get(layer) {
                Some(share) => (share * radii[point], layers.shares),
                None => (layers.thicknesses[layer], layers.thicknesses),
            };
            let lost = (healthy.quads.points[point] - points[point]).norm();
            size * factors[point] + lost * all[layer] / all.iter().sum::<f64>()
        })
    };
    let region = |name: &String| {
        wall.region(name)
            .expect("the check of the case knows all layers")
    };
    let growth = Growth {
        faces: extrusion.faces,
        elements_per_layer: extrusion.elements.unwrap_or(1),
        thicknesses: (0..extrusion.layers.len()).map(thickness).collect(),
        regions: (layers.iter())
            .map(|layers| layers.materials.iter().map(region).collect())
            .collect(),
        parts: branches.unwrap_or(patches),
        axes: along.map(|potential| surface.gradients(potential, &normals)),
        normals,
    };
    let mesh = surface.wall(&growth, lumen);
    mesh.map_err(|e| DomainError::new("wall.extrude.faces_per_element", e))
}

/// A potential that grows along the vessel, where fibres count from its direction.
fn potential(
    case: &Case,
    own: &OwnCase,
    extrusion: &Extrusion,
    fluid: &PolyMesh,
    surface: &WetQuads,
) -> Result<Option<Vec<f64>>, DomainError> {
    if extrusion.axis == Some(FibreAxis::Mesh) {
        return Ok(None);
    }
    let openings = match &own.tree {
        Some(tree) => tree.open_names(),
        None => files(case, own).openings(fluid),
    };
    let Some((first, others)) = openings.split_first() else {
        return Ok(None);
    };
    let found = surface.potential_between(std::slice::from_ref(first), others);
    match (found, extrusion.axis) {
        (None, Some(FibreAxis::Flow)) => Err(DomainError {
            key: "wall.extrude.axis",
            reason: format!(
                "the wall does not end both at the first opening, {first:?}, and at another one: write \"mesh\", or give \
                 fluid.openings, the inlet first"
            ),
        }),
        (found, _) => Ok(found),
    }
}

/// The hexahedra of a file. Its regions are of the materials of their names; if there is a single material, all are of
/// it.
fn from_file(wall: &OwnWall, keys: &WallFile) -> Result<HexMesh, DomainError> {
    let wrong = |reason: String| DomainError {
        key: "wall.file.mesh",
        reason,
    };
    let file = geometry::WallFile::read(&keys.mesh).map_err(|e| wrong(e.to_string()))?;
    let material = |name: &str| match wall.region(name) {
        Some(region) => Ok(region),
        None if wall.materials().len() == 1 => Ok(0),
        None => Err(fault!(
            "no [[wall.material]] is called as the region {name:?} of the file; its regions are \"{}\"",
            file.regions.join("\", \"")
        )),
    };
    let mesh = file.mesh(keys.unit.unwrap_or(1.0), &keys.wet, material);
    mesh.map_err(|fault| wrong(FileError::new(&keys.mesh, fault).to_string()))
}

/// The factor of the row nearest to each point, of a file with the columns `x,y,z,factor` (m).
fn factors(path: &Path, points: &[Vec3]) -> Result<Vec<f64>, FileError> {
    let rows: Vec<[f64; 4]> = rows(path, &["x", "y", "z", "factor"])?;
    if rows.iter().any(|row| !(row[3] > 0.0 && row[3] < 1e3)) {
        return Err(FileError::new(path, "expected factors above 0"));
    }
    let places: Vec<Vec3> = (rows.iter())
        .map(|row| Vec3::new(row[0], row[1], row[2]))
        .collect();
    Ok(points
        .iter()
        .map(|x| rows[nearest(&places, x)][3])
        .collect())
}

/// The rows of a table with these columns, one at least; all numbers are finite. Lengths count in metres, unless a
/// column's name says another unit.
fn rows<const N: usize>(path: &Path, columns: &[&str; N]) -> Result<Vec<[f64; N]>, FileError> {
    let wrong = |what: Fault| FileError::new(path, what);
    let place = |names: &[String], wanted: &str| {
        let is = |name: &String| {
            let stem = name.split(['(', '[']).next().unwrap_or_default();
            [stem.trim(), name]
                .iter()
                .any(|name| name.eq_ignore_ascii_case(wanted))
        };
        names.iter().position(is)
    };
    let places = |names: &[String]| -> Option<Vec<usize>> {
        columns.iter().map(|wanted| place(names, wanted)).collect()
    };
    let sheet = Sheet::read(path, N, |names| places(names).is_some());
    let sheet = sheet.map_err(wrong)?;
    let names: Vec<String> = sheet
        .columns
        .iter()
        .map(|column| column.name.clone())
        .collect();
    let Some(places) = places(&names) else {
        return Err(wrong(fault!(
            "the columns are {:?}: expected {:?} in the first line",
            names.join(","),
            columns.join(",")
        )));
    };
    let sizes = places
        .iter()
        .map(|place| match sheet.unit(*place, units::LENGTH) {
            Ok(unit) => Ok(unit.map_or(1.0, |unit| unit.size)),
            Err(found) => Err(wrong(fault!(
                "{found:?} is not a unit of length: expected {}",
                units::offered(units::LENGTH)
            ))),
        });
    let sizes = sizes.collect::<Result<Vec<f64>, FileError>>()?;
    let mut rows = Vec::new();
    for row in &sheet.rows {
        let mut numbers = [0.0; N];
        for (number, (place, size)) in numbers.iter_mut().zip(places.iter().zip(&sizes)) {
            *number = size * sheet.number(row, *place).map_err(wrong)?;
        }
        rows.push(numbers);
    }
    match rows.is_empty() {
        true => Err(wrong(fault!("it has no row of {}", columns.join(",")))),
        false => Ok(rows),
    }
}

/// Which of some places is nearest to a point.
fn nearest(places: &[Vec3], x: &Vec3) -> usize {
    let distances = places
        .iter()
        .map(|place| (place - x).norm_squared())
        .enumerate();
    let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1));
    nearest.map_or(0, |(place, _)| place)
}
