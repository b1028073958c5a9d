//! What the blood asks of a mesh of its lumen, whatever its shape.

use super::taylor_hood_space::{Face, TaylorHoodSpace};
use crate::Vec3;
use crate::fluid::FluidInterface;
use std::ops::Range;

/// Elements that follow a wall. That is known by a lattice of points on it: as many equal parts per element and
/// direction as the degree, so that a polynomial of this degree is known by its values there.
pub trait LumenMesh: Send + Sync {
    /// Numbering of the unknowns.
    fn space(&self) -> &TaylorHoodSpace;

    /// The deformable wall as a lattice.
    fn interface(&self) -> &FluidInterface;

    /// The elements' faces that make up the deformable wall.
    fn moving_walls(&self) -> Vec<Face>;

    /// For each face of the interface which of these it is a part of, and which part of it, fastest along the first of
    /// the side's axes.
    fn parts(&self) -> Vec<(usize, usize)>;

    /// The elements whose wall deforms.
    fn elastic_elements(&self) -> Range<usize>;

    /// Positions (m, one component after the other) of all nodes for a displacement (m) of the lattice's points.
    fn positions(&self, displacement: &[Vec3]) -> Vec<f64>;
}
