//! Springs and dampers between a part of the boundary and a surrounding at rest: a Winkler foundation.
//!
//! Per reference area they exert the traction `t = -(K u + C v)` on the body, with `K = k n ⊗ n` (normal springs, `n` the
//! normal of the undeformed surface) or `K = k 1` (all directions), and `C` alike. The surrounding keeps its place, so
//! that the springs' directions and the area do not change (Moireau et al., *External tissue support and fluid-structure
//! simulation in blood flows*, Biomech. Model. Mechanobiol. 11, 2012, equation (3)).

use super::super::SolidError;
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
    /// `K` times area, N/m, at each point.
    springs: Vec<Mat3>,
    /// `C` times area, N s/m, at each point.
    dampers: Vec<Mat3>,
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
        let tensors = |profile: &dyn Fn(f64) -> f64| -> Vec<Mat3> {
            let at_point = surface.points.iter().map(|point| {
                let directions = match described.direction {
                    Direction::Normal => point.normal * point.normal.transpose(),
                    Direction::All => Mat3::identity(),
                };
                directions * (profile(point.position.x) * point.area)
            });
            at_point.collect()
        };
        Ok(Self {
            springs: tensors(&|x| described.spring.at(x)),
            dampers: tensors(&|x| described.damping.at(x)),
            surface,
        })
    }

    /// Whether it resists a velocity.
    pub fn damps(&self) -> bool {
        self.dampers.iter().any(|tensor| *tensor != Mat3::zeros())
    }

    /// Places (m) and unit directions that springs hold.
    pub fn held(&self) -> impl Iterator<Item = (Vec3, Mat3)> + '_ {
        let points = self.surface.points.iter().zip(&self.springs);
        let stiff = points.filter(|(_, tensor)| tensor.norm() > 0.0);
        stiff.map(|(point, tensor)| (point.position, tensor / tensor.norm()))
    }

    /// Adds `∫ N K u dA`, N, to `forces`.
    pub fn add_spring_forces(
        &self,
        numbering: &Numbering,
        displacement: &[f64],
        forces: &mut [f64],
    ) {
        self.surface
            .add_products(numbering, displacement, &self.springs, forces);
    }

    /// Adds `∫ N C v dA`, N, to `forces`.
    pub fn add_damper_forces(&self, numbering: &Numbering, velocity: &[f64], forces: &mut [f64]) {
        self.surface
            .add_products(numbering, velocity, &self.dampers, forces);
    }

    /// Energy of the springs, J.
    pub fn energy(&self, numbering: &Numbering, displacement: &[f64]) -> f64 {
        let values = self.surface.values(numbering, displacement);
        let pairs = self.springs.iter().zip(values);
        pairs.map(|(tensor, u)| 0.5 * u.dot(&(tensor * u))).sum()
    }

    /// Adds `∫ N_a (K + slope C) N_b dA` of the faces of one element to its blocks of [`PAIRS`]; `slope` is the
    /// derivative of the velocity by the displacement, 1/s.
    pub fn add_stiffness(&self, element: usize, slope: f64, modes: usize, blocks: &mut [f64]) {
        self.surface.visit(element, |point, functions| {
            let tensor = self.springs[point] + self.dampers[point] * slope;
            for (pair, (i, k)) in PAIRS.into_iter().enumerate() {
                let block = &mut blocks[pair * modes * modes..(pair + 1) * modes * modes];
                for &(b, value_b) in functions {
                    let scale = tensor[(i, k)] * value_b;
                    for &(a, value_a) in functions {
                        block[a + modes * b] += scale * value_a;
                    }
                }
            }
        });
    }
}
