//! Springs and dampers between a part of the boundary and a surrounding at rest: a Winkler foundation.
//!
//! They count from a state of rest of the body: the reference configuration, or another one that is known once the body
//! is in equilibrium there. With the displacement `u` from that state, per area in that state, they exert the traction
//! `t = -(k u + c v)` in all directions, along the vessel's axis, around it (across the radius at rest), or along the
//! radius: with the distance `r` from the axis, `R` at rest, the axis' direction `t` and the direction `e` away from
//! it,
//! ```text
//! energy     k/2 (r - R)²,
//! traction   -k (r - R) e,
//! tangent    k (e ⊗ e + (1 - R/r) a ⊗ a),       a = t × e
//! ```
//! The axis is the x-axis, or the line that touches a curved centre-line next to the point at rest. The direction turns
//! with the point: springs that kept theirs would let a wall under pressure slip around the axis, for the distance
//! along a fixed direction shrinks as a point turns away from it. Dampers act along the direction at rest, `-c (v ·
//! e_0) e_0` (after Moireau et al., *External tissue support and fluid-structure simulation in blood flows*, Biomech.
//! Model. Mechanobiol. 11, 2012).

use super::super::SolidError;
use super::super::supports::{AtRest, Direction, Foundation as Described, arc_length};
use super::PAIRS;
use super::mapping::Mapping;
use super::surface::Surface;
use crate::mesh::HexFace;
use crate::space::Space;
use crate::space::numbering::Numbering;
use crate::{Mat3, Vec3};

/// A foundation at the quadrature points of the surface that it holds.
#[derive(Debug, Clone)]
pub struct Foundation {
    surface: Surface,
    described: Described,
    /// `k` and `c` at the points, Pa/m and Pa s/m.
    strength: Vec<[f64; 2]>,
    /// The state of rest; `None` as long as it is not known: then nothing is exerted.
    rest: Option<Rest>,
}

/// The state in which springs exert nothing, at the points of the surface.
#[derive(Debug, Clone)]
struct Rest {
    /// Displacement from the reference configuration, m; none where it is that one.
    displacement: Option<Vec<Vec3>>,
    places: Vec<AxisPoint>,
    /// `k` times area, N/m.
    springs: Vec<f64>,
    /// `c` times area and directions, N s/m.
    dampers: Vec<Mat3>,
}

/// A point at rest, and the axis next to it.
#[derive(Debug, Clone, Copy)]
struct AxisPoint {
    position: Vec3,
    /// A point of the axis and its direction.
    foot: Vec3,
    tangent: Vec3,
}

impl AxisPoint {
    /// The axis next to a point at rest.
    fn new(described: &Described, position: Vec3) -> Self {
        let (foot, tangent) = match &described.axis {
            None => (Vec3::zeros(), Vec3::x()),
            Some(line) => {
                let nearest = line.nearest(&position);
                (nearest.position, nearest.tangent)
            }
        };
        Self {
            position,
            foot,
            tangent,
        }
    }

    /// Distance of a point from the axis, m, and the direction away from it.
    fn radius(&self, x: &Vec3) -> (f64, Vec3) {
        let arm = x - self.foot;
        let off = arm - self.tangent * self.tangent.dot(&arm);
        let distance = off.norm();
        (distance, off / distance)
    }

    /// The projection onto the directions that are resisted at rest.
    fn held_directions(&self, direction: Direction) -> Mat3 {
        let onto = |v: Vec3| v * v.transpose();
        match direction {
            Direction::All => Mat3::identity(),
            Direction::Axial => onto(self.tangent),
            Direction::Radial => onto(self.radius(&self.position).1),
            Direction::Tangential => onto(self.tangent.cross(&self.radius(&self.position).1)),
        }
    }
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
        let strength = given.points.iter().map(|point| {
            let at = arc_length(described.axis.as_ref(), &point.position);
            [described.spring.at(at), described.damping.at(at)]
        });
        let strength = strength.collect();
        Ok(Self::with(surface, strength, described.clone()))
    }

    fn with(surface: Surface, strength: Vec<[f64; 2]>, described: Described) -> Self {
        let mut foundation = Self {
            surface,
            described,
            strength,
            rest: None,
        };
        if foundation.described.at_rest == AtRest::Reference {
            let points = foundation.surface.points.iter();
            let (places, areas) = points.map(|p| (p.position, p.area)).unzip();
            foundation.rest = Some(foundation.rest(None, places, areas));
        }
        foundation
    }

    fn rest(&self, displacement: Option<Vec<Vec3>>, at: Vec<Vec3>, areas: Vec<f64>) -> Rest {
        let place = |position| AxisPoint::new(&self.described, position);
        let places: Vec<AxisPoint> = at.into_iter().map(place).collect();
        let strength = || self.strength.iter().zip(&areas);
        let direction = self.described.direction;
        let dampers = strength().zip(&places);
        let dampers =
            dampers.map(|(([_, c], area), place)| place.held_directions(direction) * (c * area));
        Rest {
            displacement,
            springs: strength().map(|([k, _], area)| k * area).collect(),
            dampers: dampers.collect(),
            places,
        }
    }

    /// Springs whose state of rest was not known yet exert nothing where the body has this displacement (m, all
    /// coefficients).
    pub fn set_at_rest(&mut self, numbering: &Numbering, displacement: &[f64]) {
        if self.described.at_rest == AtRest::Reference {
            return;
        }
        let moved = self.surface.values(numbering, displacement);
        let points = self.surface.points.iter().zip(&moved);
        let places = points.map(|(point, u)| point.position + u).collect();
        let areas = self.surface.deformed_areas(numbering, displacement);
        let areas = areas.iter().map(Vec3::norm).collect();
        self.rest = Some(self.rest(Some(moved), places, areas));
    }

    /// The same around a body of another shape, before or after a displacement.
    pub fn reshaped(
        &self,
        numbering: &Numbering,
        space: &Space,
        mapping: &Mapping,
    ) -> Result<Self, SolidError> {
        let surface = self.surface.reshaped(numbering, space, mapping)?;
        let (strength, described) = (self.strength.clone(), self.described.clone());
        Ok(Self::with(surface, strength, described))
    }

    /// Whether it resists a velocity.
    pub fn damps(&self) -> bool {
        let dampers = self.rest.iter().flat_map(|rest| &rest.dampers);
        dampers.into_iter().any(|tensor| *tensor != Mat3::zeros())
    }

    /// Places (m) and directions that springs hold, as projections onto them.
    pub fn held(&self) -> impl Iterator<Item = (Vec3, Mat3)> + '_ {
        let rest = self.rest.iter();
        let points = rest.flat_map(|rest| rest.places.iter().zip(&rest.springs));
        let stiff = points.filter(|(_, spring)| **spring > 0.0);
        let direction = self.described.direction;
        stiff.map(move |(place, _)| (place.position, place.held_directions(direction)))
    }

    /// Displacement from the state of rest at the points, m.
    fn since_rest(&self, rest: &Rest, numbering: &Numbering, displacement: &[f64]) -> Vec<Vec3> {
        let mut values = self.surface.values(numbering, displacement);
        let before = rest.displacement.iter().flatten();
        (values.iter_mut().zip(before)).for_each(|(u, before)| *u -= before);
        values
    }

    /// Resistance of the springs at the points, N; none without a state of rest.
    fn resistance(&self, numbering: &Numbering, displacement: &[f64]) -> Vec<Vec3> {
        let Some(rest) = &self.rest else {
            return Vec::new();
        };
        let values = self.since_rest(rest, numbering, displacement);
        let points = rest.places.iter().zip(values).zip(&rest.springs);
        let resistance = points.map(|((place, u), spring)| match self.described.direction {
            Direction::All | Direction::Axial | Direction::Tangential => {
                place.held_directions(self.described.direction) * u * *spring
            }
            Direction::Radial => {
                let before = place.radius(&place.position).0;
                let (now, e) = place.radius(&(place.position + u));
                e * (spring * (now - before))
            }
        });
        resistance.collect()
    }

    /// Adds the resistance of the springs, N, to `forces`.
    pub fn add_spring_forces(
        &self,
        numbering: &Numbering,
        displacement: &[f64],
        forces: &mut [f64],
    ) {
        let resistance = self.resistance(numbering, displacement);
        self.surface
            .add_point_forces(numbering, &resistance, forces);
    }

    /// The surface that it holds.
    pub fn surface(&self) -> &str {
        &self.described.surface
    }

    /// Force (N) with which the springs press their surface inwards, summed over the points.
    pub fn inward_force(&self, numbering: &Numbering, displacement: &[f64]) -> f64 {
        let resistance = self.resistance(numbering, displacement);
        let pairs = resistance.iter().zip(&self.surface.points);
        pairs.map(|(force, point)| force.dot(&point.normal)).sum()
    }

    /// Adds the resistance of the dampers, N, to `forces`.
    pub fn add_damper_forces(&self, numbering: &Numbering, velocity: &[f64], forces: &mut [f64]) {
        let Some(rest) = &self.rest else {
            return;
        };
        let values = self.surface.values(numbering, velocity);
        let pairs = rest.dampers.iter().zip(values);
        let resistance: Vec<Vec3> = pairs.map(|(tensor, v)| tensor * v).collect();
        self.surface
            .add_point_forces(numbering, &resistance, forces);
    }

    /// Energy of the springs, J.
    pub fn energy(&self, numbering: &Numbering, displacement: &[f64]) -> f64 {
        let Some(rest) = &self.rest else {
            return 0.0;
        };
        let values = self.since_rest(rest, numbering, displacement);
        let points = rest.places.iter().zip(values).zip(&rest.springs);
        let energy = points.map(|((place, u), spring)| {
            let squared = match self.described.direction {
                Direction::All | Direction::Axial | Direction::Tangential => {
                    (place.held_directions(self.described.direction) * u).norm_squared()
                }
                Direction::Radial => {
                    let [now, before] =
                        [place.position + u, place.position].map(|x| place.radius(&x).0);
                    (now - before).powi(2)
                }
            };
            0.5 * spring * squared
        });
        energy.sum()
    }

    /// Derivative of the resistance by the displacement at each point, N/m; `slope` is that of the velocity, 1/s. None
    /// without a state of rest.
    pub fn tangents(&self, numbering: &Numbering, displacement: &[f64], slope: f64) -> Vec<Mat3> {
        let Some(rest) = &self.rest else {
            return Vec::new();
        };
        let values = self.since_rest(rest, numbering, displacement);
        let points = rest.places.iter().zip(values);
        let tangents = points.zip(&rest.springs).zip(&rest.dampers);
        tangents
            .map(|(((place, u), spring), damper)| {
                let springs = match self.described.direction {
                    Direction::All | Direction::Axial | Direction::Tangential => {
                        place.held_directions(self.described.direction)
                    }
                    Direction::Radial => {
                        let before = place.radius(&place.position).0;
                        let (now, e) = place.radius(&(place.position + u));
                        let around = place.tangent.cross(&e);
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
        if tangents.is_empty() {
            return;
        }
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
