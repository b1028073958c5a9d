//! How large a case with user-supplied meshes is, and how well its wall fits the fluid's patches.

use super::initial_state::{InitialState, initial_state};
use super::{AssemblyError, Domain, own, preflight, transfer};
use crate::Vec3;
use crate::case::{Case, Solver};
use crate::coupling::common_refinement::CommonRefinement;
use crate::fluid::Fluid;
use crate::fluid::native::NativeFluid;
use crate::pfem::Solid;

/// Sizes of both meshes, and what lies between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Cells of the fluid, or its elements.
    pub cells: usize,
    /// The smallest scaled Jacobian of the blood's mesh in a tree, and where that is, m.
    pub worst: Option<(f64, Vec3)>,
    /// What a user should know of the junctions of a tree and of its wall, in sentences.
    pub notes: Vec<String>,
    /// Two opposite corners (m) of a box around the fluid's mesh.
    pub bounds: [Vec3; 2],
    /// Openings of the fluid, with their hydraulic diameters (m) where they have one.
    pub openings: Vec<(String, Option<f64>)>,
    /// Faces of the fluid on the wet surface.
    pub faces: usize,
    /// Degrees of freedom of the wall, the held ones not included.
    pub degrees_of_freedom: usize,
    /// Bytes that the wall takes in a run, at most.
    pub wall_memory: f64,
    /// Largest distance (m) of a point of the fluid's wet patches from the wall's surface.
    pub distance: f64,
    /// Share of the wall's wet surface that has no face of the fluid next to it, and carries no load.
    pub uncovered: f64,
    /// Two corners (m) of a box around such faces of the wall, if there are any.
    pub bare: Option<[Vec3; 2]>,
}

impl Fit {
    /// Of a case whose meshes can be built.
    ///
    /// # Errors
    /// If the structure is not well posed or the meshes lie apart.
    pub fn of(case: &Case, domain: &Domain) -> Result<Self, AssemblyError> {
        let InitialState { solid, .. } = initial_state(case, domain).map_err(|none| none.error)?;
        let branches = domain.branches.as_ref();
        let round = branches.and_then(|branches| branches.meshed.as_ref());
        let (cells, worst, interface) = match case.fluid.solver {
            Solver::Native => {
                let fluid = NativeFluid::new(case)?;
                let worst = fluid.worst_element();
                (fluid.elements(), worst, fluid.interface().clone())
            }
            Solver::OpenFoam | Solver::External => {
                let worst = round.map(|round| round.worst);
                (domain.fluid.cells(), worst, preflight::interface(domain))
            }
        };
        let (_, common) = transfer(case, &interface, &solid)?;
        let places = solid.locate(&interface.points)?;
        let openings = case
            .own()
            .map(|own| own::files(case, own).openings(&domain.fluid));
        let sized = |name: String| {
            let (_, diameter) = domain.fluid.opening_size(&name);
            (name, diameter)
        };
        Ok(Self {
            cells,
            worst,
            notes: branches.map_or_else(Vec::new, |branches| branches.notes.clone()),
            bounds: domain.fluid.bounds(),
            openings: openings.into_iter().flatten().map(sized).collect(),
            faces: interface.faces.len(),
            degrees_of_freedom: solid.body().degrees_of_freedom(),
            wall_memory: solid.body().memory(),
            distance: places
                .iter()
                .map(|place| place.distance)
                .fold(0.0, f64::max),
            uncovered: common.as_ref().map_or(0.0, CommonRefinement::uncovered),
            bare: common.as_ref().and_then(CommonRefinement::bare_place),
        })
    }
}
