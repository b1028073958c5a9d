//! The parts of a case's vessel, or of another wet surface, that are evaluated one by one.

use super::centre_line;
use crate::Vec3;
use crate::case::{BloodVessel, Case, OutputSection, OwnCase, OwnRegion, Problem, Shape, TreeKeys};
use crate::curve::SpaceCurve;
use crate::geometry::{PolyMesh, Section, Vessel};
use crate::hemodynamics::{BranchOpening, CrossSectionPlace, Region, RegionExtent, WetSurface};

/// The graft of the paper's vessels.
pub const BYPASS: &str = "bypass";
/// The artery behind it.
pub const ARTERY: &str = "artery";
/// The artery without the influence of joint and outlet; the paper's 0.03375 m to 0.05625 m.
pub const MID_ARTERY: &str = "mid_artery";

/// Where the middle of the paper's artery begins and ends (m), if the case has one.
pub fn middle_of_artery(case: &Case) -> Option<[f64; 2]> {
    let regions = regions(case).into_iter();
    regions
        .filter(|region| region.name.as_str() == MID_ARTERY)
        .find_map(|region| match region.extent {
            RegionExtent::Along { from_m, to_m } => Some([from_m, to_m]),
            _ => None,
        })
}

/// The elastic sections of a vessel and what its case names besides, or bypass, artery and its middle. The last of
/// these begins where the blend of the cross-sections ends, and ends as far from the outlet; there is none if the
/// artery is too short for it. Those of a user-supplied OpenFOAM case are boxes and patches, or its whole wall; those
/// of a tree are its branches, and what its case names besides. A flag is not a vessel and has no regions.
pub fn regions(case: &Case) -> Vec<Region> {
    match &case.problem {
        Problem::Vessel(vessel) => of_vessel(vessel),
        Problem::Flag(_) => Vec::new(),
        Problem::UserCase(own) => of_own(own),
    }
}

/// The cross-sections that a case watches.
pub fn cross_sections(case: &Case) -> Vec<CrossSectionPlace> {
    let tree = case.own().and_then(|own| own.tree.as_ref());
    let openings = tree.map_or_else(Vec::new, branch_openings);
    let patch = |keys: &OutputSection| {
        let tree = tree?;
        let mut pairs = tree.branches().into_iter().zip(tree.walls());
        let found = pairs.find(|(name, _)| Some(name) == keys.branch.as_ref());
        found.map(|(_, patch)| patch)
    };
    let place = |keys: &OutputSection| CrossSectionPlace {
        name: keys.name.clone(),
        patch: patch(keys),
        at: keys.at,
        openings: openings.clone(),
    };
    case.output.section.iter().flatten().map(place).collect()
}

/// The openings of a tree, the inlet first; a line that is closed has none.
fn branch_openings(tree: &TreeKeys) -> Vec<BranchOpening> {
    let pairs = tree.names().into_iter().zip(tree.walls());
    let open = pairs.filter(|(name, _)| !tree.closed.contains(name));
    open.map(|(name, patch)| BranchOpening { name, patch })
        .collect()
}

/// The wet surface of a case, with these points (m) and faces: around its centre-line, or on the patches of its `mesh`
/// and around the lines of its branches.
pub fn wet_surface(
    case: &Case,
    points: &[Vec3],
    faces: &[Vec<u32>],
    mesh: Option<&PolyMesh>,
    branches: &[(String, SpaceCurve)],
) -> WetSurface {
    let wall = WetSurface::new(points.to_vec(), faces.to_vec()).around(centre_line(case));
    match (mesh, case.own()) {
        (Some(mesh), Some(own)) => wall
            .on_patches(mesh, &own.wall_patches())
            .along_branches(branches),
        _ => wall,
    }
}

fn of_vessel(vessel: &BloodVessel) -> Vec<Region> {
    let geometry = match &vessel.shape {
        Shape::Anastomosis(vessel) => &vessel.geometry,
        Shape::Vessel(keys) => {
            let vessel = Vessel::new(vessel);
            let region = |section: &Section| {
                Region::along(section.name.clone().into(), section.from, section.to)
            };
            let own = keys.region.iter().flatten();
            let own = own.map(|own| Region::along(own.name.clone().into(), own.from, own.to));
            return vessel.elastic_sections().map(region).chain(own).collect();
        }
    };
    let joint = geometry.graft_length;
    let end = joint + geometry.artery_length;
    let margin = 0.5 * geometry.blend_length;
    let regions = [
        (BYPASS, 0.0, joint),
        (ARTERY, joint, end),
        (MID_ARTERY, joint + margin, end - margin),
    ];
    let some = regions.into_iter().filter(|(_, from, to)| from < to);
    some.map(|(name, from, to)| Region::along(name.into(), from, to))
        .collect()
}

fn of_own(own: &OwnCase) -> Vec<Region> {
    let named = own.fluid.region.iter().flatten();
    let branches: Vec<(String, String)> = match &own.tree {
        Some(tree) => tree.branches().into_iter().zip(tree.walls()).collect(),
        None => Vec::new(),
    };
    let along = |keys: &OwnRegion, branch: &String| {
        let found = branches.iter().find(|(name, _)| name == branch);
        RegionExtent::Branch {
            patch: found.map_or_else(String::new, |(_, patch)| patch.clone()),
            from_m: keys.from.unwrap_or(0.0),
            to_m: keys.to,
        }
    };
    let region = |keys: &OwnRegion| Region {
        name: keys.name.clone().into(),
        extent: match (&keys.branch, &keys.patch, &keys.corners[..]) {
            (Some(branch), ..) => along(keys, branch),
            (None, None, [a, b]) => RegionExtent::Box { box_m: [*a, *b] },
            (None, patch, _) => RegionExtent::Patch {
                patch: patch.clone().unwrap_or_default(),
            },
        },
    };
    let of_branch = |(name, patch): &(String, String)| Region {
        name: name.clone().into(),
        extent: RegionExtent::Patch {
            patch: patch.clone(),
        },
    };
    let regions: Vec<Region> = branches
        .iter()
        .map(of_branch)
        .chain(named.map(region))
        .collect();
    match regions.is_empty() {
        false => regions,
        true => vec![Region {
            name: "wall".to_owned().into(),
            extent: RegionExtent::Whole {},
        }],
    }
}
