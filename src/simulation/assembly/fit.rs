//! How large a case with meshes of the user's own is, and how well its wall fits the fluid's patches.

use super::initial_state::{InitialState, initial_state};
use super::{Domain, preflight};
use crate::Vec3;
use crate::case::Case;
use crate::fluid::FluidInterface;
use crate::pfem::{Solid, SolidError, Structure};

/// A face of the fluid counts for a point of the wall within so many times the distance from its middle to its corners.
const REACH: f64 = 1.5;

/// Sizes of both meshes, and what lies between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Cells of the fluid.
    pub cells: usize,
    /// Faces of the fluid on the wet surface.
    pub faces: usize,
    /// Degrees of freedom of the wall, the held ones not included.
    pub degrees_of_freedom: usize,
    /// Largest distance (m) of a point of the fluid's wet patches from the wall's surface.
    pub distance: f64,
    /// Share of the points of the wall's wet surface beside which there is no face of the fluid, so that the load there is
    /// that of a face farther away.
    pub uncovered: f64,
}

impl Fit {
    /// Of a case whose meshes can be built.
    ///
    /// # Errors
    /// If the structure is not well posed or the meshes lie apart.
    pub fn of(case: &Case, domain: &Domain) -> Result<Self, SolidError> {
        let InitialState { solid, .. } = initial_state(case, domain)?;
        let interface = preflight::interface(domain);
        let places = solid.locate(&interface.points)?;
        Ok(Self {
            cells: domain.fluid.cells(),
            faces: interface.faces.len(),
            degrees_of_freedom: solid.body().degrees_of_freedom(),
            distance: places
                .iter()
                .map(|place| place.distance)
                .fold(0.0, f64::max),
            uncovered: uncovered(&interface, &solid),
        })
    }
}

fn uncovered(fluid: &FluidInterface, solid: &Structure) -> f64 {
    let size = |(face, centre): (&Vec<u32>, &Vec3)| {
        let corners = face
            .iter()
            .map(|&p| (fluid.points[p as usize] - centre).norm());
        corners.fold(0.0, f64::max)
    };
    let sizes: Vec<f64> = fluid
        .faces
        .iter()
        .zip(&fluid.face_centres)
        .map(size)
        .collect();
    let covered = |x: &Vec3| {
        let mut faces = fluid.face_centres.iter().zip(&sizes);
        faces.any(|(centre, size)| (x - centre).norm() <= REACH * size)
    };
    let wet = solid.wet_points();
    let lonely = wet.iter().filter(|point| !covered(&point.position)).count();
    lonely as f64 / wet.len().max(1) as f64
}
