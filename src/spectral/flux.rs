//! The flow through some faces as a linear function of the velocity.

use super::Vec3;
use super::spectral_elements::SpectralElements;
use super::surface::face_integrals;
use super::taylor_hood_space::Face;
use std::collections::BTreeMap;

/// `∫ v_i · n` over some faces, of their nodes alone: of all nodes it would grow with the mesh for each open end.
#[derive(Debug, Clone)]
pub struct Flux {
    /// Nodes in ascending order, each with its share of the area, which points out of the fluid, m².
    shares: Vec<(usize, Vec3)>,
}

impl Flux {
    /// Through `faces`, with the nodes at `positions` (m).
    pub fn through(space: &SpectralElements, faces: &[Face], positions: &[f64]) -> Self {
        let mut shares: BTreeMap<usize, Vec3> = BTreeMap::new();
        for &face in faces {
            let points = space.face_points(face, positions);
            let sums = face_integrals(&space.basis.to_gauss, &points.areas);
            for (node, sum) in points.nodes.into_iter().zip(sums) {
                *shares.entry(node).or_default() += sum;
            }
        }
        Self {
            shares: shares.into_iter().collect(),
        }
    }

    /// The share of a node in the area (m²), zero beyond the faces.
    pub fn share(&self, node: usize) -> Vec3 {
        let found = self.shares.binary_search_by_key(&node, |(node, _)| *node);
        found.map_or(Vec3::zeros(), |i| self.shares[i].1)
    }

    /// The flow (m³/s) of a velocity at this many nodes, one component after the other.
    pub fn of(&self, nodes: usize, velocity: &[f64]) -> f64 {
        let flow = |(node, share): &(usize, Vec3)| {
            (0..3)
                .map(|c| share[c] * velocity[c * nodes + node])
                .sum::<f64>()
        };
        self.shares.iter().map(flow).sum()
    }

    /// Adds the force of a pressure (Pa) on the faces to `forces` (N) on this many nodes, one component after the other.
    pub fn add_force(&self, nodes: usize, pressure: f64, forces: &mut [f64]) {
        for (node, share) in &self.shares {
            (0..3).for_each(|c| forces[c * nodes + node] += pressure * share[c]);
        }
    }
}
