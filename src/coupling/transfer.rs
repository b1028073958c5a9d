//! From the fluid's faces to the structure's quadrature points, and from the structure to the fluid's points.

use super::common_refinement::CommonRefinement;
use super::interpolation::{Interpolation, Sources};
use crate::Vec3;
use crate::fluid::FluidInterface;
use crate::geometry::CentreShift;
use crate::pfem::{Solid, SolidError, SurfaceLoad};

/// With a smaller share of the wall's wet surface next to the fluid, the two meshes are taken for a mistake.
const LEAST_COVERED: f64 = 0.1;
/// Most of the fluid's wetted area, as a share, that may have no wall next to it.
const MOST_LOST: f64 = 1e-3;
/// Meshes are of different units, not of the same wall, if one is so many times as large as the other.
const OTHER_UNIT: f64 = 5.0;

/// Why the two meshes of the wet surface cannot be related.
#[derive(Debug, thiserror::Error)]
pub enum TransferError {
    /// A point of the fluid does not lie on the wall.
    #[error(transparent)]
    Solid(#[from] SolidError),
    /// They are of different sizes: diagonals (m) of the boxes around them.
    #[error("the wall's wet surface is {wall:.3e} m large and the fluid's patches there are {fluid:.3e} m, {}", times(*.wall, *.fluid))]
    Size {
        /// Of the wall's wet surface.
        wall: f64,
        /// Of the fluid's faces on it.
        fluid: f64,
    },
    /// Most of the wall has no fluid next to it, this share of its area.
    #[error(
        "{:.1} % of the wall's wet surface has no face of the fluid next to it: the surfaces that the fluid touches are others, or face the other way",
        1e2 * .0
    )]
    Uncovered(f64),
    /// A part of the fluid's wetted area has no wall next to it, this share.
    #[error(
        "{:.1} % of the area of the fluid's wetted patches has no face of the wall next to it, so its load would be lost: the wall's wet surface must reach as far as these patches and face them",
        1e2 * .0
    )]
    Lost(f64),
}

/// Whether two sizes can be those of the same thing.
fn is_alike(a: f64, b: f64) -> bool {
    a < OTHER_UNIT * b && b < OTHER_UNIT * a
}

/// How many times as long as a metre the units are that explain such a ratio of sizes, and their name.
pub fn likely_unit(ratio: f64) -> Option<(f64, &'static str)> {
    let units = [
        (1e3, "millimetres"),
        (1e2, "centimetres"),
        (1e6, "micrometres"),
        (39.37, "inches"),
    ];
    let near = |(unit, _): &&(f64, &str)| (ratio.max(ratio.recip()) / unit).ln().abs() < 0.4;
    units.iter().find(near).copied()
}

/// How the size of the wall compares to that of the fluid, with the units that would explain it.
fn times(wall: f64, fluid: f64) -> String {
    let ratio = wall / fluid;
    let (first, second) = match ratio > 1.0 {
        true => ("wall", "fluid"),
        false => ("fluid", "wall"),
    };
    let cause = likely_unit(ratio).map_or(String::new(), |(_, unit)| {
        format!(": the {first} seems to be in {unit}, the {second} in metres")
    });
    let factor = ratio.max(ratio.recip());
    format!("so the {first} is {factor:.0} times as large as the {second}{cause}")
}

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
    /// Relates two meshes that were made for each other: what is between them is the interpolation's error, of second
    /// order.
    ///
    /// # Errors
    /// If a point of the fluid does not lie on the structure's wet surface.
    pub fn new<S: Solid<Location = L>>(
        fluid: &FluidInterface,
        solid: &S,
    ) -> Result<Self, TransferError> {
        Ok(Self {
            points: solid.locate(&fluid.points)?,
            to_quadrature: Sources::made(fluid).linear(solid.wet_points()),
            wall: fluid.clone(),
        })
    }

    /// Relates any two meshes: the wall gets the fluid's force, whatever they look like. Parts of the wall without the
    /// fluid next to them carry no load.
    ///
    /// # Errors
    /// If the two meshes do not describe the same wall.
    pub fn conserving<S: Solid<Location = L>>(
        fluid: &FluidInterface,
        solid: &S,
    ) -> Result<(Self, CommonRefinement), TransferError> {
        let wet = solid.wet_points();
        let sizes = || {
            let on_wall: Vec<Vec3> = wet.iter().map(|point| point.position).collect();
            [diagonal(&on_wall), diagonal(&fluid.points)]
        };
        let apart = |error: SolidError| match sizes() {
            [wall, fluid] if is_alike(wall, fluid) => error.into(),
            [wall, fluid] => TransferError::Size { wall, fluid },
        };
        let points = solid.locate(&fluid.points).map_err(apart)?;
        let sources = Sources::any(fluid);
        let common = CommonRefinement::new(fluid, &sources, &solid.wet_faces(), wet);
        if 1.0 - common.uncovered() < LEAST_COVERED {
            let [wall, fluid] = sizes();
            return Err(match is_alike(wall, fluid) {
                true => TransferError::Uncovered(common.uncovered()),
                false => TransferError::Size { wall, fluid },
            });
        }
        if common.lost() > MOST_LOST {
            return Err(TransferError::Lost(common.lost()));
        }
        let pointwise = sources.linear(wet);
        let transfer = Self {
            points,
            to_quadrature: common.conserving(&pointwise, fluid, &sources, wet),
            wall: fluid.clone(),
        };
        Ok((transfer, common))
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

    /// Displacement (m) of the fluid's wall points after a step of length `dt` (s), where it does not depend on the
    /// load.
    pub fn foreseen<S: Solid<Location = L>>(&self, solid: &S, dt: f64) -> Option<Vec<Vec3>> {
        solid.foreseen(dt, &self.points)
    }

    /// Displacement (m) of the fluid's wall points that follows from a trial of the structure.
    pub fn displacement<S: Solid<Location = L>>(&self, solid: &S, trial: &S::Trial) -> Vec<Vec3> {
        solid.displacement(trial, &self.points)
    }

    /// How far the wall has moved sideways with this displacement (m) of the fluid's wall points; `None` if it is no
    /// tube with the fluid inside.
    pub fn centre_shift(&self, displacement: &[Vec3]) -> Option<CentreShift> {
        let still = vec![Vec3::zeros(); displacement.len()];
        let count = self.wall.face_centres.len() as f64;
        let middle = self.wall.face_centres.iter().sum::<Vec3>() / count;
        let faces = self.wall.face_centres.iter().zip(self.face_areas(&still));
        let outward: f64 = faces.map(|(x, area)| (x - middle).dot(&area)).sum();
        (outward > 0.0)
            .then(|| CentreShift::of(&self.wall.points, displacement))
            .flatten()
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

/// Diagonal (m) of a box around these points.
fn diagonal(points: &[Vec3]) -> f64 {
    let corner = |pick: fn(f64, f64) -> f64, start: f64| {
        let corner = |corner: Vec3, x: &Vec3| corner.zip_map(x, pick);
        points.iter().fold(Vec3::repeat(start), corner)
    };
    (corner(f64::max, f64::NEG_INFINITY) - corner(f64::min, f64::INFINITY)).norm()
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
