//! What a case is about: the bodies, their meshes, and what holds the solid. The one place where it is chosen.

use crate::case::{Anastomosis, Case, Flag, Material, Problem};
use crate::geometry::{HexMesh, PolyMesh, Vessel};
use crate::pfem::supports::{self, Profile, Support};
use crate::pfem::{Space, SpaceKind};

/// A fluid and a solid that fit together.
pub struct Domain {
    /// Mesh of the fluid; its patch `wallFsi` is the wet surface.
    pub fluid: PolyMesh,
    /// The first cells of the fluid, whose volume does not count because they are beyond the deformable part.
    pub rigid_cells: usize,
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
    /// Pressure (Pa) around the solid, along x.
    pub outer_pressure: Profile,
}

impl Domain {
    /// The domain of a checked case.
    pub fn new(case: &Case) -> Self {
        let p = case.structure.p;
        match &case.problem {
            Problem::Anastomosis(vessel) => Self::anastomosis(vessel, p),
            Problem::Flag(flag) => Self::flag(flag, p),
        }
    }

    /// The wall of a vessel in its tissue, and the blood within.
    fn anastomosis(keys: &Anastomosis, p: usize) -> Self {
        let (vessel, mesh, wall) = (Vessel::new(keys), &keys.fluid.mesh, &keys.wall);
        let fluid = vessel.fluid_mesh(mesh);
        Self {
            // Cells are numbered cross-section by cross-section, those of the extension first.
            rigid_cells: fluid.cells() / mesh.slices() * mesh.axial_extension,
            fluid,
            solid: vessel.solid_mesh(&keys.structure),
            materials: [&wall.graft, &wall.media, &wall.adventitia]
                .map(Clone::clone)
                .to_vec(),
            space: Space::isotropic(SpaceKind::Trunk, p),
            wet_surface: "inner",
            supports: supports::of_vessel(keys),
            outer_pressure: supports::pressure_around(keys),
        }
    }

    /// A flag, clamped at the cylinder, in plane strain, and the channel around it.
    fn flag(flag: &Flag, p: usize) -> Self {
        Self {
            fluid: flag.fluid_mesh(),
            rigid_cells: 0,
            solid: flag.solid_mesh(),
            materials: vec![flag.solid.clone()],
            space: Space {
                kind: SpaceKind::Trunk,
                degrees: [p, p, 1],
            },
            wet_surface: "wet",
            supports: vec![
                Support::Clamped("start".into()),
                Support::Surface("sides".into(), [false, false, true]),
            ],
            outer_pressure: Profile::default(),
        }
    }
}
