//! Springs and dampers between a part of the boundary and a surrounding at rest: a Winkler foundation.
//!
//! Per reference area they exert the traction `t = -(k u + c v)` on the body in all directions, around the x-axis (across
//! the radius of the undeformed body), or along the radius of a vessel around the x-axis: with the distance `r` from the axis, `R` before, and the direction `e` away from it,
//! ```text
//! energy     k/2 (r - R)²,
//! traction   -k (r - R) e,
//! tangent    k (e ⊗ e + (1 - R/r) a ⊗ a),       a = e_x × e
//! ```
//! The direction turns with the point: springs that kept theirs would let a wall under pressure slip around the axis, for
//! the distance along a fixed direction shrinks as a point turns away from it. Dampers act along the direction before,
//! `-c (v · e_0) e_0` (after Moireau et al., *External tissue support and fluid-structure simulation in blood flows*,
//! Biomech. Model. Mechanobiol. 11, 2012).

use super::super::SolidError;
use super::super::solid::SurfacePoint;
use super::super::supports::{Direction, Foundation as Described};
use super::PAIRS;
use super::mapping::Mapping;
use super::surface::Surface;
use crate::geometry::HexFace;
use crate::pfem::space::Space;
use crate::pfem::space::numbering::Numbering;
use crate::{Mat3, Vec3};

/// A foundation at the quadrature points of the surface that it holds.
#[derive(Debug, Clone)]
pub struct Foundation {
    surface: Surface,
    described: Described,
    /// `k` times area, N/m, at each point.
    springs: Vec<f64>,
    /// `c` times area and directions, N s/m, at each point.
    dampers: Vec<Mat3>,
}

/// Distance of a point from the x-axis, m, and the direction away from it.
fn radius(x: &Vec3) -> (f64, Vec3) {
    let off = Vec3::new(0.0, x.y, x.z);
    let distance = off.norm();
    (distance, off / distance)
}

impl Foundation {
    /// Prepares a foundation with `points` × `points` Gauss points on each face.
    pub fn new(
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
        faces: &[(usize, HexFace)],
        points: usize,
        described: &Described,
    ) -> Result<Self, SolidError> {
        let surface = Surface::new(numbering, space, mapping, faces, points)?;
        let given = Surface::new(numbering, space, mapping.given(), faces, points)?;
        let places = given.points.iter().map(|point| point.position.x);
        let pairs = || surface.points.iter().zip(places.clone());
        let damper = |(point, x): (&SurfacePoint, f64)| {
            let directions = held_directions(described.direction, &point.position);
            directions * (described.damping.at(x) * point.area)
        };
        let spring = |(point, x): (&SurfacePoint, f64)| described.spring.at(x) * point.area;
        Ok(Self {
            springs: pairs().map(spring).collect(),
            dampers: pairs().map(damper).collect(),
            described: described.clone(),
            surface,
        })
    }

    /// The same around a body of another shape, before or after a displacement.
    pub fn reshaped(
        &self,
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
    ) -> Result<Self, SolidError> {
        let (faces, points) = (&self.surface.faces, self.surface.points_along());
        Self::new(numbering, space, mapping, faces, points, &self.described)
    }

    /// Whether it resists a velocity.
    pub fn damps(&self) -> bool {
        self.dampers.iter().any(|tensor| *tensor != Mat3::zeros())
    }

    /// Places (m) and directions that springs hold, as projections onto them.
    pub fn held(&self) -> impl Iterator<Item = (Vec3, Mat3)> + '_ {
        let points = self.surface.points.iter().zip(&self.springs);
        let stiff = points.filter(|(_, spring)| **spring > 0.0);
        stiff.map(|(point, _)| {
            let x = point.position;
            (x, held_directions(self.described.direction, &x))
        })
    }

    /// Adds the resistance of the springs, N, to `forces`.
    pub fn add_spring_forces(
        &self,
        numbering: &Numbering,
        displacement: &[f64],
        forces: &mut [f64],
    ) {
        let values = self.surface.values(numbering, displacement);
        let points = self.surface.points.iter().zip(values).zip(&self.springs);
        let resistance = points.map(|((point, u), spring)| match self.described.direction {
            Direction::All | Direction::Tangential => {
                held_directions(self.described.direction, &point.position) * u * *spring
            }
            Direction::Radial => {
                let (before, (now, e)) = (radius(&point.position).0, radius(&(point.position + u)));
                e * (spring * (now - before))
            }
        });
        let resistance: Vec<Vec3> = resistance.collect();
        self.surface
            .add_point_forces(numbering, &resistance, forces);
    }

    /// Adds the resistance of the dampers, N, to `forces`.
    pub fn add_damper_forces(&self, numbering: &Numbering, velocity: &[f64], forces: &mut [f64]) {
        let values = self.surface.values(numbering, velocity);
        let pairs = self.dampers.iter().zip(values);
        let resistance: Vec<Vec3> = pairs.map(|(tensor, v)| tensor * v).collect();
        self.surface
            .add_point_forces(numbering, &resistance, forces);
    }

    /// Energy of the springs, J.
    pub fn energy(&self, numbering: &Numbering, displacement: &[f64]) -> f64 {
        let values = self.surface.values(numbering, displacement);
        let points = self.surface.points.iter().zip(values).zip(&self.springs);
        let energy = points.map(|((point, u), spring)| {
            let squared = match self.described.direction {
                Direction::All | Direction::Tangential => {
                    (held_directions(self.described.direction, &point.position) * u).norm_squared()
                }
                Direction::Radial => {
                    (radius(&(point.position + u)).0 - radius(&point.position).0).powi(2)
                }
            };
            0.5 * spring * squared
        });
        energy.sum()
    }

    /// Derivative of the resistance by the displacement at each point, N/m; `slope` is that of the velocity, 1/s.
    pub fn tangents(&self, numbering: &Numbering, displacement: &[f64], slope: f64) -> Vec<Mat3> {
        let values = self.surface.values(numbering, displacement);
        let points = self.surface.points.iter().zip(values);
        let tangents = points.zip(&self.springs).zip(&self.dampers);
        tangents
            .map(|(((point, u), spring), damper)| {
                let springs = match self.described.direction {
                    Direction::All | Direction::Tangential => {
                        held_directions(self.described.direction, &point.position)
                    }
                    Direction::Radial => {
                        let before = radius(&point.position).0;
                        let (now, e) = radius(&(point.position + u));
                        let around = Vec3::x().cross(&e);
                        e * e.transpose() + around * around.transpose() * (1.0 - before / now)
                    }
                };
                springs * *spring + damper * slope
            })
            .collect()
    }

    /// Adds `∫ N_a T N_b dA` of the faces of one element, with the [tangents](Self::tangents) `T` at all points, to its
    /// blocks of [`PAIRS`].
    pub fn add_stiffness(
        &self,
        element: usize,
        tangents: &[Mat3],
        modes: usize,
        blocks: &mut [f64],
    ) {
        self.surface.visit(element, |point, functions| {
            for (pair, (i, k)) in PAIRS.into_iter().enumerate() {
                let block = &mut blocks[pair * modes * modes..(pair + 1) * modes * modes];
                for &(b, value_b) in functions {
                    let scale = tangents[point][(i, k)] * value_b;
                    for &(a, value_a) in functions {
                        block[a + modes * b] += scale * value_a;
                    }
                }
            }
        });
    }
}

/// The projection onto the directions that are resisted at a point of the undeformed body.
fn held_directions(direction: Direction, x: &Vec3) -> Mat3 {
    match direction {
        Direction::All => Mat3::identity(),
        Direction::Radial => {
            let e = radius(x).1;
            e * e.transpose()
        }
        Direction::Tangential => {
            let around = Vec3::x().cross(&radius(x).1);
            around * around.transpose()
        }
    }
}
