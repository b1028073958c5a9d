//! From the fluid's faces to the structure's quadrature points, and from the structure to the fluid's points.

use super::interpolation::Interpolation;
use crate::Vec3;
use crate::fluid::FluidInterface;
use crate::geometry::CentreShift;
use crate::pfem::{Solid, SolidError, SurfaceLoad};

/// The two interpolations of equation (13), prepared once in the reference configuration.
#[derive(Debug, Clone)]
pub struct Transfer<L> {
    /// The fluid's wall points on the structure's surface; displacements follow by the shape functions.
    points: Vec<L>,
    /// From face centres to quadrature points.
    to_quadrature: Interpolation,
    wall: FluidInterface,
}

impl<L> Transfer<L> {
    /// Relates the two descriptions of the wet surface.
    ///
    /// # Errors
    /// If a point of the fluid does not lie on the structure's wet surface.
    pub fn new<S: Solid<Location = L>>(
        fluid: &FluidInterface,
        solid: &S,
    ) -> Result<Self, SolidError> {
        let wet: Vec<Vec3> = solid.wet_points().iter().map(|p| p.position).collect();
        Ok(Self {
            points: solid.locate(&fluid.points)?,
            to_quadrature: Interpolation::linear(&fluid.faces, &fluid.face_centres, &wet),
            wall: fluid.clone(),
        })
    }

    /// Load at the structure's quadrature points from the tractions (Pa) at the fluid's faces, whose area vectors are
    /// `areas`.
    ///
    /// A traction is split into the part along the face's normal, which turns with the wall as a pressure does, and
    /// the rest: so the structure's tangent stays symmetric, and the load stays normal to the wall while it rotates
    /// within an iteration.
    pub fn load(&self, tractions: &[Vec3], areas: &[Vec3]) -> SurfaceLoad {
        let mut pressure = Vec::with_capacity(tractions.len());
        let mut shear = Vec::with_capacity(tractions.len());
        for (traction, area) in tractions.iter().zip(areas) {
            let normal = area.normalize();
            let p = traction.dot(&normal);
            pressure.push(p);
            shear.push(traction - p * normal);
        }
        SurfaceLoad {
            pressure: self.to_quadrature.apply(&pressure),
            shear: self.to_quadrature.apply(&shear),
        }
    }

    /// Displacement (m) of the fluid's wall points in the accepted state of the structure.
    pub fn accepted_displacement<S: Solid<Location = L>>(&self, solid: &S) -> Vec<Vec3> {
        solid.accepted_displacement(&self.points)
    }

    /// Displacement (m) of the fluid's wall points after a step of length `dt` (s), where it does not depend on the load.
    pub fn foreseen<S: Solid<Location = L>>(&self, solid: &S, dt: f64) -> Option<Vec<Vec3>> {
        solid.foreseen(dt, &self.points)
    }

    /// Displacement (m) of the fluid's wall points that follows from a trial of the structure.
    pub fn displacement<S: Solid<Location = L>>(&self, solid: &S, trial: &S::Trial) -> Vec<Vec3> {
        solid.displacement(trial, &self.points)
    }

    /// How far the wall has moved aside with this displacement (m) of the fluid's wall points; `None` if it is no tube.
    pub fn centre_shift(&self, displacement: &[Vec3]) -> Option<CentreShift> {
        CentreShift::of(&self.wall.points, displacement)
    }

    /// Centre of a face of the fluid's wall at rest, m; the origin if there is no such face.
    pub fn face_centre(&self, face: usize) -> Vec3 {
        self.wall
            .face_centres
            .get(face)
            .copied()
            .unwrap_or_default()
    }

    /// Area vectors (m², out of the fluid) of the fluid's faces after its wall points have moved by `displacement` (m).
    pub fn face_areas(&self, displacement: &[Vec3]) -> Vec<Vec3> {
        self.wall.face_areas(displacement)
    }
}

/// |resultant of the fluid's load - resultant on the structure| over the sum of the fluid's |load| of all faces.
///
/// `tractions` and `areas` are those of the fluid's faces; `load` acts on the deformed area vectors `wet_areas`
/// (m², out of the solid) of the structure's quadrature points.
pub fn force_mismatch(
    tractions: &[Vec3],
    areas: &[Vec3],
    load: &SurfaceLoad,
    wet_areas: &[Vec3],
) -> f64 {
    let (mut fluid, mut size) = (Vec3::zeros(), 0.0);
    for (traction, area) in tractions.iter().zip(areas) {
        let force = traction * area.norm();
        fluid += force;
        size += force.norm();
    }
    let on_point = |((p, shear), area): ((&f64, &Vec3), &Vec3)| shear * area.norm() - *p * area;
    let structure: Vec3 = load
        .pressure
        .iter()
        .zip(&load.shear)
        .zip(wet_areas)
        .map(on_point)
        .sum();
    if size > 0.0 {
        (fluid - structure).norm() / size
    } else {
        0.0
    }
}
