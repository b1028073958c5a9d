//! The inner side of a wall's elements on a lumen whose surface is known between the points of the faces as well.
//!
//! The interpolation of a few points leaves the surface where that bends sharply, at the apex of a junction by a sixth
//! of the radius. There a mesh with other points on it, that of the driver's own elements, would lie next to the wall.

use super::{Group, Layers, WetQuads};
use crate::Vec3;
use crate::geometry::tree::Lumen;
use crate::lagrange;
use fsi_numerics::quadrature::Rule;
use rayon::prelude::*;

/// The least degree of the inner side: that of the driver's own elements by default.
const DEGREE: usize = 4;
/// Points are not moved by more than this share of the distance between the ends of their group's diagonal: what is
/// found farther away is another part of the surface.
const FARTHEST: f64 = 0.25;

/// By how much (m) elements are moved so that their inner side lies on the surface, all layers alike.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    /// Gauss-Lobatto points along a side.
    nodes: Vec<f64>,
    /// The displacement of each group at the lattice of these.
    moves: Vec<Vec<Vec3>>,
}

impl Fit {
    /// That of the elements over these groups. Corners stay, and rims stay in their planes.
    pub(super) fn new(
        surface: &WetQuads,
        groups: &[Group],
        faces: usize,
        layers: &Layers,
        lumen: &Lumen,
    ) -> Self {
        let normals = surface.normals(0);
        let nodes = Rule::gauss_lobatto(layers.n.max(DEGREE) + 1).points;
        let planes = surface.rim_normals();
        let of = |(number, group): (usize, &Group)| {
            let held = surface.rims_of(group, faces).into_iter();
            let held: Vec<(Vec3, u8, bool)> = held
                .filter_map(|(patch, axis, upper)| Some((*planes.get(patch)?, axis, upper)))
                .collect();
            let corner = |v: usize| group.points[(v & 1) * faces + (v >> 1) * faces * (faces + 1)];
            let corners: [usize; 4] = std::array::from_fn(corner);
            let farthest = FARTHEST
                * (surface.quads.points[corners[3]] - surface.quads.points[corners[0]]).norm();
            let near = lumen.near_wall(&layers.inner(number, [0.0; 2]));
            let n = nodes.len();
            let last = n - 1;
            let at = |k: usize| {
                let place = [k % n, k / n];
                if place.iter().all(|i| [0, last].contains(i)) {
                    return Vec3::zeros();
                }
                let xi = place.map(|i| nodes[i]);
                let x = layers.inner(number, xi);
                let share = xi.map(|x| 0.5 * (1.0 + x));
                let normal = (0..4).fold(Vec3::zeros(), |sum, v| {
                    let weight = [0, 1].map(|d| match v >> d & 1 {
                        0 => 1.0 - share[d],
                        _ => share[d],
                    });
                    sum + normals[corners[v]] * (weight[0] * weight[1])
                });
                let found = near.along(&x, &normal.normalize(), farthest);
                let move_ = found.map_or(Vec3::zeros(), |found| found - x);
                held.iter().fold(move_, |move_, (plane, axis, upper)| {
                    match place[usize::from(*axis)] == if *upper { last } else { 0 } {
                        true => move_ - plane * plane.dot(&move_),
                        false => move_,
                    }
                })
            };
            (0..n * n).map(at).collect()
        };
        let moves = groups.par_iter().enumerate().map(of).collect();
        Self { nodes, moves }
    }

    /// The displacement of a place of a group, m.
    pub(super) fn at(&self, group: usize, xi: [f64; 2]) -> Vec3 {
        let [along, across] = xi.map(|x| lagrange::values(&self.nodes, x));
        let n = self.nodes.len();
        let moves = self.moves[group].iter().enumerate();
        moves.fold(Vec3::zeros(), |sum, (k, move_)| {
            sum + move_ * (along[k % n] * across[k / n])
        })
    }
}
