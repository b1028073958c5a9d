//! What a case is about: the bodies, their meshes, and what holds the solid. The one place where it is chosen.

pub(super) mod own;
mod supports;

use crate::Vec3;
use crate::case::{BloodVessel, Case, Flag, Material, Problem};
use crate::curve::SpaceCurve;
use crate::geometry::flag;
use crate::geometry::supports as vessel_supports;
use crate::geometry::tree::Lumen;
use crate::geometry::{HexMesh, PolyMesh, Vessel, WallPolygons, elastic_pieces};
use crate::pfem::solution::listener::Work;
use crate::pfem::supports::{PressureAround, Support};
use crate::pfem::{PrescribedMotion, Space, SpaceKind};
use std::ops::Range;

/// A fluid and a solid that fit together.
pub struct Domain {
    /// Mesh of the fluid.
    pub fluid: PolyMesh,
    /// What is known of a vessel that branches beyond its mesh.
    pub branches: Option<Branches>,
    /// Patches of it that make up the wet surface.
    pub wet_patches: Vec<String>,
    /// The cells of the fluid whose volume counts because they are in the deformable part.
    pub elastic_cells: Range<usize>,
    /// Mesh of the solid.
    pub solid: HexMesh,
    /// Materials by region of the solid's mesh.
    pub materials: Vec<Material>,
    /// Space of the solid's displacement.
    pub space: Space,
    /// Surface of the solid's mesh that the fluid touches.
    pub wet_surface: &'static str,
    /// What holds the solid.
    pub supports: Vec<Support>,
    /// Pressure around the solid.
    pub outer_pressure: Option<PressureAround>,
    /// The motion of the solid, where it is prescribed.
    pub motion: Option<PrescribedMotion>,
}

/// A vessel that branches.
pub struct Branches {
    /// A mesh of its lumen with the corners of the wall's faces on the surface itself. That of the blood, if it is the
    /// driver's, has them outside, as its faces are plane.
    pub surface: PolyMesh,
    /// The lumen that this is a mesh of.
    pub lumen: Lumen,
    /// Centre-lines of the branches, each with the patch of its wall.
    pub lines: Vec<(String, SpaceCurve)>,
    /// What is known of the blood's mesh, if it is the driver's.
    pub meshed: Option<RoundLumen>,
    /// What a user should know of its junctions and its wall, in sentences.
    pub notes: Vec<String>,
}

impl Branches {
    /// Where a place (m) is, in words.
    pub fn told(&self, x: &Vec3) -> String {
        let near = self.lines.iter().map(|(wall, line)| {
            let [begin, end] = line.ends();
            let s = line.nearest(x).s.clamp(begin, end);
            ((line.frame(s).origin - x).norm(), s - begin, wall)
        });
        let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, s, wall) = nearest.expect("a tree has branches");
        let branch = wall.strip_prefix("wallFsi_").unwrap_or("between");
        format!(
            "{:.1} mm along the branch \"{branch}\", near ({:.4e}, {:.4e}, {:.4e}) m",
            1e3 * s,
            x.x,
            x.y,
            x.z
        )
    }
}

/// A lumen whose wall is round, while the faces of its mesh are plane.
pub struct RoundLumen {
    /// Which corners of the wall's faces are those of a cross-section.
    pub polygons: WallPolygons,
    /// The smallest scaled Jacobian of a cell, and where that is, m.
    pub worst: (f64, Vec3),
}

/// Why there is no domain: a file that a case names cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct DomainError {
    /// The key to blame.
    pub key: &'static str,
    /// What is wrong, and what to do.
    pub reason: String,
}

impl DomainError {
    pub(super) fn new(key: &'static str, reason: impl std::fmt::Display) -> Self {
        Self {
            key,
            reason: reason.to_string(),
        }
    }
}

/// The wet patch of meshes that are made here.
pub(super) const WALL: &str = "wallFsi";

impl Domain {
    /// The mesh of the fluid with the corners of its wall on the surface itself, where that is known beforehand.
    pub fn surface(&self) -> &PolyMesh {
        let meshed = self.branches.as_ref();
        let meshed = meshed.filter(|branches| branches.meshed.is_some());
        meshed.map_or(&self.fluid, |branches| &branches.surface)
    }

    /// The mesh whose patches are regions of the wall.
    pub fn of_regions(&self) -> &PolyMesh {
        let branches = self.branches.as_ref();
        branches.map_or(&self.fluid, |branches| &branches.surface)
    }

    /// The domain of a checked case.
    ///
    /// # Errors
    /// If a mesh that the case names cannot be used; those that are made here always can.
    pub fn new(case: &Case) -> Result<Self, DomainError> {
        let _work = Work::begin("meshing lumen and wall");
        let p = case.structure.p;
        match &case.problem {
            Problem::Vessel(vessel) => Ok(Self::vessel(vessel, p)),
            Problem::Flag(flag) => Ok(Self::flag(flag, p)),
            Problem::UserCase(own) => own::domain(case, own),
        }
    }

    /// The wall of a vessel in its tissue, and the blood within.
    fn vessel(keys: &BloodVessel, p: usize) -> Self {
        let (vessel, mesh) = (Vessel::new(keys), &keys.fluid.mesh);
        let mut fluid = vessel.fluid_mesh(mesh);
        for (name, opening) in ["inlet", "outlet"].into_iter().zip(keys.opening_keys()) {
            let mut patches = fluid.patches.iter_mut();
            if let Some(patch) = patches.find(|patch| patch.name == name) {
                patch.name = opening.name().into();
            }
        }
        let per_slice = fluid.cells() / vessel.slices(mesh);
        let elastic = elastic_pieces(&vessel.spans(mesh));
        Self {
            // Cells are numbered cross-section by cross-section.
            elastic_cells: elastic.start * per_slice..elastic.end * per_slice,
            fluid,
            branches: None,
            wet_patches: vec![WALL.into()],
            solid: vessel.solid_mesh(&keys.structure),
            materials: vessel.materials().to_vec(),
            space: Space::isotropic(SpaceKind::Trunk, p),
            wet_surface: "inner",
            supports: vessel_supports::of_vessel(keys, vessel.centre_line()),
            outer_pressure: vessel_supports::pressure_around(keys, vessel.centre_line()),
            motion: None,
        }
    }

    /// A flag, clamped at the cylinder, in plane strain, and the channel around it.
    fn flag(flag: &Flag, p: usize) -> Self {
        let fluid = flag::fluid_mesh(flag);
        let held: &[&str] = match flag.rigid {
            true => &["start", "wet"],
            false => &["start"],
        };
        let clamped = held.iter().map(|name| Support::Clamped((*name).into()));
        let plane = Support::Surface("sides".into(), [false, false, true]);
        Self {
            elastic_cells: 0..fluid.cells(),
            fluid,
            branches: None,
            wet_patches: vec![WALL.into()],
            solid: flag::solid_mesh(flag),
            materials: vec![flag.solid.clone()],
            space: Space {
                kind: SpaceKind::Trunk,
                degrees: [p, p, 1],
            },
            wet_surface: "wet",
            supports: clamped.chain([plane]).collect(),
            outer_pressure: None,
            motion: None,
        }
    }
}
