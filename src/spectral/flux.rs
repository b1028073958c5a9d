//! The flow through some faces as a linear function of the velocity.

use super::Vec3;
use super::spectral_elements::SpectralElements;
use super::surface::face_integrals;
use super::taylor_hood_space::Face;
use std::collections::BTreeMap;

/// `∫ v_i · n` over some faces. Only their nodes are kept, so that an open end does not cost as much as the whole mesh.
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

    /// Adds the force of a pressure (Pa) on the faces to `forces` (N) on this many nodes, one component after the
    /// other.
    pub fn add_force(&self, nodes: usize, pressure: f64, forces: &mut [f64]) {
        for (node, share) in &self.shares {
            (0..3).for_each(|c| forces[c * nodes + node] += pressure * share[c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::taylor_hood_space::{Boundary, Plane, TaylorHoodSpace};

    /// The flow of the velocity `y²` along x through the end x = 1 of a unit cube is 1/3. The work of a pressure's
    /// forces is the pressure times the flow.
    #[test]
    fn a_flow_is_that_through_the_faces_and_forces_do_its_work() {
        let plane = |degree| Plane::grid([2, 1], degree);
        let space = TaylorHoodSpace::swept(&plane(3), &plane(2), 3, 2);
        let space = SpectralElements::new(space).unwrap();
        let nodes = space.space.nodes;
        let points = &space.basis.nodes.points;
        let mut positions = vec![0.0; 3 * nodes];
        for e in 0..space.space.elements {
            let corner = [e % 2, 0, e / 2];
            for (i, &node) in space.space.element(e).iter().enumerate() {
                let local = [i % 4, i / 4 % 4, i / 16];
                for c in 0..3 {
                    let cells = [2.0, 1.0, 2.0][c];
                    positions[c * nodes + node as usize] =
                        (corner[c] as f64 + 0.5 * (1.0 + points[local[c]])) / cells;
                }
            }
        }
        let end = space.space.faces_of(|patch| patch == Boundary::Mantle(1));
        let flux = Flux::through(&space, &end, &positions);
        let on_end = |node: &usize| (positions[*node] - 1.0).abs() < 1e-12;
        let within = (0..nodes).find(|node| !on_end(node)).unwrap();
        assert_eq!(flux.share(within), Vec3::zeros());
        let area: Vec3 = (0..nodes).map(|node| flux.share(node)).sum();
        assert!((area - Vec3::x()).norm() < 1e-12, "{area}");

        let mut velocity = vec![0.0; 3 * nodes];
        for node in 0..nodes {
            velocity[node] = positions[nodes + node].powi(2);
            velocity[nodes + node] = 7.0; // along the end
        }
        let flow = flux.of(nodes, &velocity);
        assert!((flow - 1.0 / 3.0).abs() < 1e-12, "{flow}");
        let mut forces = vec![0.0; 3 * nodes];
        flux.add_force(nodes, 20.0, &mut forces);
        let work: f64 = forces.iter().zip(&velocity).map(|(f, u)| f * u).sum();
        assert!((work - 20.0 * flow).abs() < 1e-12, "{work}");
    }
}
