//! Whether the wall of a user-supplied OpenFOAM case is described once and completely.

use super::{Report, material};
use crate::{
    Case, Extrusion, FluidTimeScheme, GivenShape, OwnCase, OwnFluid, OwnRegion, OwnWall, Solver,
    SurrogateModel, TissueDirection, TreeKeys, WallFile, WallMode, WallSupport,
};
use std::path::Path;

/// Directions in which an end of a tree may be held, beside the axes.
const GUIDES: [&str; 2] = ["axial", "tangential"];
/// Kinds of files with hexahedra, by the ends of their names.
pub const MESH_FILES: [&str; 3] = ["msh", "inp", "vtu"];

const BOTH_THICKNESSES: &str =
    "thicknesses are given either in metres or as shares of the radius: leave out one of the two";

pub(super) fn check(case: &Case, own: &OwnCase, report: &mut Report<'_>) {
    let (fluid, wall) = (&own.fluid, &own.wall);
    mesh(case, own, report);
    settings(case, own, report);
    let is_elastic = wall.mode() == WallMode::Elastic;
    if is_elastic {
        described_once(own, report);
    }
    patches(fluid, report);
    regions(fluid, report);
    branch_regions(own, report);
    motion(wall, report);
    if !is_elastic {
        return;
    }
    materials(wall, report);
    if let Some(extrusion) = &wall.extrude {
        extruded(wall, extrusion, report);
        extruded_branches(own, extrusion, report);
    }
    if let Some(file) = &wall.file {
        from_file(wall, file, report);
    }
    supports(own, report);
    gravity(wall, report);
}

fn gravity(wall: &OwnWall, report: &mut Report<'_>) {
    let Some(keys) = &wall.gravity else { return };
    report(
        &["wall.gravity.acceleration_m_s2"],
        keys.acceleration.len() != 3,
        format!(
            "expected three numbers, along x, y and z, found {}",
            keys.acceleration.len()
        ),
    );
    report(
        &[
            "wall.gravity.acceleration_m_s2",
            "wall.initial.pressure_Pa",
        ],
        wall.initial.is_some(),
        "a wall that begins in equilibrium has no weight: leave out [wall.gravity] or [wall.initial]"
            .into(),
    );
}

/// The blood flows in a mesh of OpenFOAM's, or in that of a tree.
fn mesh(case: &Case, own: &OwnCase, report: &mut Report<'_>) {
    let fluid = &own.fluid;
    match &fluid.case {
        Some(folder) => {
            report(
                &["fluid.case"],
                !folder.join("system/controlDict").is_file(),
                format!(
                    "{} is not an OpenFOAM case: expected a folder with system/controlDict, 0 and constant",
                    folder.display()
                ),
            );
            report(
                &["fluid.patches"],
                fluid.patches.is_empty(),
                "which patches does the elastic wall touch? Write their names".into(),
            );
            if let Some(tree) = &own.tree {
                super::tree::check_vessel(tree, report);
                around_own_mesh(own, tree, report);
            }
        }
        None => {
            if let Some(tree) = &own.tree {
                super::tree::check(case, tree, report);
            }
        }
    }
}

/// A tree that is the wall of an OpenFOAM case says nothing of the blood.
fn around_own_mesh(own: &OwnCase, tree: &TreeKeys, report: &mut Report<'_>) {
    report(
        &["tree.opening[0].name"],
        tree.opening.is_some(),
        "what is prescribed at the openings stands in the OpenFOAM case: leave out [[tree.opening]]".into(),
    );
    report(
        &["tree.feature[0]"],
        tree.feature.is_some(),
        "the mesh of the OpenFOAM case says how wide the lumen is: leave out [[tree.feature]]"
            .into(),
    );
    report(
        &["wall.file.mesh"],
        own.wall.file.is_some(),
        "the table [tree] describes the wall: leave out [wall.file], or [tree]".into(),
    );
    let mut regions = own.fluid.region.iter().flatten();
    let of_patch = regions.position(|region| region.patch.is_some());
    report(
        &[&format!("fluid.region[{}].patch", of_patch.unwrap_or(0))],
        of_patch.is_some(),
        "with [tree] each branch is a region of its own; others are parts of branches or boxes: write branch or box_m".into(),
    );
    report(
        &["wall.mode"],
        own.wall.mode() != WallMode::Elastic,
        "only an elastic wall is made from [tree]: leave that table out".into(),
    );
}

/// What such a case does not choose.
fn settings(case: &Case, own: &OwnCase, report: &mut Report<'_>) {
    let solver = case.fluid.solver;
    report(
        &["fluid.solver"],
        own.fluid.case.is_some() && solver != Solver::OpenFoam,
        "a case of OpenFOAM is for OpenFOAM: expected \"openfoam\", or leave fluid.case out".into(),
    );
    report(
        &["fluid.solver"],
        own.fluid.case.is_none() && solver == Solver::External,
        "the blood in a tree is computed by OpenFOAM or by the driver's own solver: expected \"openfoam\" or \"native\""
            .into(),
    );
    report(
        &["time.scheme"],
        case.has_own_openfoam() && case.time.scheme == FluidTimeScheme::Bdf2,
        "your own case sets its time scheme in system/fvSchemes, ddtSchemes { default backward; }: write it there, and \
         leave this key out"
            .into(),
    );
    report(
        &["wall.initial.shape"],
        solver != Solver::Native && case.initial_wall().is_some_and(|wall| wall.shape == GivenShape::Unloaded),
        "OpenFOAM's mesh is that of the given shape, in which the run starts: expected \"loaded\", or fluid.solver = \"native\"".into(),
    );
    report(
        &["wall.initial.axial_stretch"],
        case.prestretch() != 1.0 && case.initial_wall().is_some_and(|wall| wall.shape == GivenShape::Unloaded),
        "a wall whose pieces are stretched is in equilibrium in the loaded shape: expected wall.initial.shape = \"loaded\"".into(),
    );
    report(
        &["coupling.surrogate"],
        !matches!(
            case.coupling.surrogate,
            SurrogateModel::None | SurrogateModel::Potential
        ),
        "this surrogate is a single tube, which this case is not: write \"potential\" or \"none\""
            .into(),
    );
}

/// The wall comes from one place.
fn described_once(own: &OwnCase, report: &mut Report<'_>) {
    let (extrude, file) = (own.wall.extrude.is_some(), own.wall.file.is_some());
    report(
        &["wall.file.mesh", "wall.extrude.layers"],
        extrude && file,
        "the wall is either extruded from the patches or read from a file: leave out one of the tables [wall.extrude] and \
         [wall.file]"
            .into(),
    );
    report(
        &[own.tree.as_ref().map_or("fluid.case", super::tree::origin)],
        !extrude && !file,
        "it has no wall yet: add a table [wall.extrude] with layers and thicknesses_m, or [wall.file] with a mesh; or wall.mode = \"rigid\""
            .into(),
    );
}

/// Names of patches and openings.
fn patches(fluid: &OwnFluid, report: &mut Report<'_>) {
    for (key, names) in [
        ("fluid.patches", &fluid.patches),
        ("fluid.openings", &fluid.openings),
    ] {
        let twice = (names.iter().enumerate()).find(|(i, name)| names[..*i].contains(name));
        report(
            &[key],
            twice.is_some(),
            format!("{:?} is listed twice", twice.map_or("", |(_, name)| name)),
        );
    }
    let common = (fluid.openings.iter()).find(|name| fluid.patches.contains(name));
    report(
        &["fluid.openings", "fluid.patches"],
        common.is_some(),
        format!(
            "{:?} cannot be an opening and a wall: leave it out of one of the two",
            common.map_or("", String::as_str)
        ),
    );
}

fn regions(fluid: &OwnFluid, report: &mut Report<'_>) {
    let regions: Vec<&OwnRegion> = fluid.region.iter().flatten().collect();
    for (i, region) in regions.iter().enumerate() {
        let key = |name: &str| format!("fluid.region[{i}].{name}");
        report(
            &[&key("name")],
            regions[..i].iter().any(|other| other.name == region.name),
            "another region has this name: choose a different one".into(),
        );
        let kinds = [
            !region.corners.is_empty(),
            region.patch.is_some(),
            region.branch.is_some(),
        ];
        let count = kinds.into_iter().filter(|kind| *kind).count();
        let first = match kinds[0] {
            true => key("box_m"),
            false => key("patch"),
        };
        report(
            &[&first, &key("branch")],
            count > 1,
            "a region is a box, a patch or a part of a branch: leave out the others".into(),
        );
        report(
            &[&key("name")],
            count == 0,
            "where is it? Write box_m = [[0.0, -1.0, -1.0], [0.1, 1.0, 1.0]], two opposite corners, or patch, one of \
             fluid.patches, or in a tree branch with from_m and to_m"
                .into(),
        );
        report(
            &[&key("box_m")],
            !matches!(region.corners.len(), 0 | 2),
            "expected two opposite corners, such as [[0.0, -1.0, -1.0], [0.1, 1.0, 1.0]]".into(),
        );
        let unknown = region.patch.as_ref();
        report(
            &[&key("patch"), "fluid.patches"],
            unknown.is_some_and(|patch| !fluid.patches.contains(patch)),
            format!(
                "expected one of fluid.patches, \"{}\"",
                fluid.patches.join("\", \"")
            ),
        );
    }
}

/// Whether regions along branches, and their names, are known ones and new ones.
fn branch_regions(own: &OwnCase, report: &mut Report<'_>) {
    let branches = own.tree.as_ref().map_or_else(Vec::new, TreeKeys::branches);
    let ends = own.tree.as_ref().map_or_else(Vec::new, TreeKeys::names);
    for (i, region) in own.fluid.region.iter().flatten().enumerate() {
        let key = |name: &str| format!("fluid.region[{i}].{name}");
        report(
            &[&key("name")],
            branches.contains(&region.name),
            "the branch of this name is a region already: choose another name".into(),
        );
        report(
            &[&key("branch")],
            (region.branch.as_ref()).is_some_and(|branch| !ends.contains(branch)),
            match ends.is_empty() {
                true => "this case has no branches: write box_m or patch".into(),
                false => format!(
                    "expected a branch with an end of its own, one of \"{}\"",
                    ends.join("\", \"")
                ),
            },
        );
        for (name, length) in [("from_m", region.from), ("to_m", region.to)] {
            report(
                &[&key(name)],
                region.branch.is_none() && length.is_some(),
                "arc lengths are along a branch: write branch as well".into(),
            );
        }
        report(
            &[&key("to_m")],
            (region.to).is_some_and(|to| to <= region.from.unwrap_or(0.0)),
            format!("expected more than from_m, {}", region.from.unwrap_or(0.0)),
        );
    }
}

fn motion(wall: &OwnWall, report: &mut Report<'_>) {
    let is_prescribed = wall.mode() == WallMode::Prescribed;
    report(
        &["wall.mode"],
        is_prescribed && wall.motion.is_none(),
        "how does it move? Add a table [wall.motion] with displacements and factors, two CSV files"
            .into(),
    );
    if let Some(motion) = wall.motion.as_ref().filter(|_| is_prescribed) {
        is_file("wall.motion.displacements", &motion.displacements, report);
        is_file("wall.motion.factors", &motion.factors, report);
    }
}

fn materials(wall: &OwnWall, report: &mut Report<'_>) {
    for (i, named) in wall.materials().iter().enumerate() {
        material(&format!("wall.material[{i}]"), &named.material, report);
        let twice = wall.materials()[..i].iter().any(|m| m.name == named.name);
        report(
            &[&format!("wall.material[{i}].name")],
            twice,
            "another material has this name: choose a different one".into(),
        );
    }
}

fn extruded(wall: &OwnWall, extrusion: &Extrusion, report: &mut Report<'_>) {
    are_materials("wall.extrude.layers", wall, &extrusion.layers, report);
    let (sizes, shares) = (&extrusion.thicknesses, &extrusion.shares);
    let layers = extrusion.layers.len();
    report(
        &["wall.extrude.thicknesses_m", "wall.extrude.thicknesses"],
        !sizes.is_empty() && !shares.is_empty(),
        BOTH_THICKNESSES.into(),
    );
    report(
        &[
            "wall.extrude.layers",
            "wall.extrude.thicknesses_m",
            "wall.extrude.thicknesses",
        ],
        sizes.is_empty() && shares.is_empty(),
        "how thick are they? Write wall.extrude.thicknesses_m, a number for each".into(),
    );
    for (key, found) in [
        ("wall.extrude.thicknesses_m", sizes),
        ("wall.extrude.thicknesses", shares),
    ] {
        report(
            &[key, "wall.extrude.layers"],
            !found.is_empty() && found.len() != layers,
            format!(
                "expected a number for each of the {layers} wall.extrude.layers, found {}",
                found.len()
            ),
        );
    }
    if let Some(path) = &extrusion.factors {
        is_file("wall.extrude.factors", path, report);
    }
}

/// Whether the layers of branches fit to those of the whole wall.
fn extruded_branches(own: &OwnCase, extrusion: &Extrusion, report: &mut Report<'_>) {
    let known = match &own.tree {
        Some(tree) => tree.branches(),
        None => own.fluid.patches.clone(),
    };
    let branches = extrusion.branch.as_deref().unwrap_or_default();
    for (i, branch) in branches.iter().enumerate() {
        let key = |key: &str| format!("wall.extrude.branch[{i}].{key}");
        report(
            &[&key("name")],
            !known.contains(&branch.name),
            format!(
                "the wall has no part {:?}; it has \"{}\"",
                branch.name,
                known.join("\", \"")
            ),
        );
        report(
            &[&key("name")],
            branches[..i].iter().any(|other| other.name == branch.name),
            "another table has this name: leave out one of the two".into(),
        );
        are_materials(&key("layers"), &own.wall, &branch.layers, report);
        report(
            &[&key("thicknesses_m"), &key("thicknesses")],
            !branch.thicknesses.is_empty() && !branch.shares.is_empty(),
            BOTH_THICKNESSES.into(),
        );
        for (name, found) in [
            ("layers", branch.layers.len()),
            ("thicknesses_m", branch.thicknesses.len()),
            ("thicknesses", branch.shares.len()),
        ] {
            report(
                &[&key(name), "wall.extrude.layers"],
                found != 0 && found != extrusion.layers.len(),
                format!(
                    "a branch has as many layers as the wall, {}: expected one for each, found {found}",
                    extrusion.layers.len()
                ),
            );
        }
    }
}

/// Reports a layer whose material there is not.
fn are_materials(key: &str, wall: &OwnWall, layers: &[String], report: &mut Report<'_>) {
    let known: Vec<&str> = wall.materials().iter().map(|m| m.name.as_str()).collect();
    let unknown = layers.iter().find(|layer| wall.region(layer).is_none());
    report(
        &[key],
        unknown.is_some(),
        format!(
            "no [[wall.material]] is called {:?}; there is {}",
            unknown.map_or("", String::as_str),
            match known.is_empty() {
                true => "none".into(),
                false => format!("\"{}\"", known.join("\", \"")),
            }
        ),
    );
}

fn from_file(wall: &OwnWall, file: &WallFile, report: &mut Report<'_>) {
    is_file("wall.file.mesh", &file.mesh, report);
    let end = file.mesh.extension().and_then(|end| end.to_str());
    report(
        &["wall.file.mesh"],
        !end.is_some_and(|end| MESH_FILES.contains(&end.to_ascii_lowercase().as_str())),
        "expected a file of Gmsh (.msh), Abaqus (.inp) or VTK (.vtu)".into(),
    );
    report(
        &["wall.file.mesh"],
        wall.materials().is_empty(),
        "it has no material: add a table [[wall.material]]".into(),
    );
    report(
        &["wall.file.mesh"],
        wall.support.is_none(),
        "nothing holds this wall: add a table [[wall.support]] with support = \"clamped\" and its surfaces".into(),
    );
}

fn supports(own: &OwnCase, report: &mut Report<'_>) {
    let ends = own
        .tree
        .as_ref()
        .map_or_else(Vec::new, TreeKeys::open_names);
    let supports: Vec<&WallSupport> = own.wall.support.iter().flatten().collect();
    for (i, support) in supports.iter().enumerate() {
        held_before(&supports[..=i], report);
        let key = |name: &str| format!("wall.support[{i}].{name}");
        report(
            &[&key("at_rest")],
            support.rests_loaded() && own.wall.initial.is_none(),
            "the wall begins without load: add a table [wall.initial], or write \"unloaded\""
                .into(),
        );
        if let WallSupport::Springs { direction, .. } = support {
            report(
                &[&key("direction")],
                direction.is_some_and(|it| it != TissueDirection::All) && own.tree.is_none(),
                "the axis is that of the lines of a [tree], which this case has not: expected \"all\"".into(),
            );
        }
        let WallSupport::Sliding { held, surfaces } = support else {
            continue;
        };
        report(
            &[&key("held")],
            held.iter()
                .any(|axis| !["x", "y", "z"].contains(&axis.as_str()) && !GUIDES.contains(&axis.as_str())),
            "expected \"x\", \"y\", \"z\", or two of them; for ends of a tree \"axial\", \"tangential\" or both".into(),
        );
        let is_guided = held.iter().any(|axis| GUIDES.contains(&axis.as_str()));
        let other = surfaces.iter().find(|name| !ends.contains(name));
        report(
            &[&key("held"), &key("surfaces")],
            is_guided && other.is_some(),
            format!(
                "\"axial\" and \"tangential\" are for ends of a tree, and {:?} is none of \"{}\"",
                other.map_or("", String::as_str),
                ends.join("\", \"")
            ),
        );
    }
}

/// Whether the last of these supports holds a surface once more, or in vain.
fn held_before(supports: &[&WallSupport], report: &mut Report<'_>) {
    use WallSupport::{Clamped, Springs};
    let Some((last, others)) = supports.split_last() else {
        return;
    };
    let key = format!("wall.support[{}].surfaces", others.len());
    let surfaces = last.surfaces();
    let twice = (surfaces.iter().enumerate()).find(|(i, name)| surfaces[..*i].contains(name));
    report(
        &[&key],
        twice.is_some(),
        format!("{:?} is listed twice", twice.map_or("", |(_, name)| name)),
    );
    let again = |other: &&WallSupport| match (*other, *last) {
        (Clamped { .. }, _) | (_, Clamped { .. }) => {
            Some("what is clamped does not move: leave it out of one of the two")
        }
        (
            Springs {
                direction, at_rest, ..
            },
            Springs {
                direction: along,
                at_rest: when,
                ..
            },
        ) if direction == along && at_rest == when => {
            Some("springs of both add up: write their sum once")
        }
        _ => None,
    };
    let found = others.iter().enumerate().find_map(|(i, other)| {
        let name = surfaces.iter().find(|name| other.surfaces().contains(name));
        Some((i, name?, again(other)?))
    });
    report(
        &[&key],
        found.is_some(),
        found.map_or(String::new(), |(i, name, reason)| {
            format!("wall.support[{i}] holds {name:?} already, and {reason}")
        }),
    );
}

fn is_file(key: &str, path: &Path, report: &mut Report<'_>) {
    report(
        &[key],
        !path.is_file(),
        format!("there is no file {}", path.display()),
    );
}
