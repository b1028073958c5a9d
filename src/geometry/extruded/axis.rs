//! The direction along a vessel at each point of its wall: that in which a potential grows that is 0 where the blood
//! enters, 1 where it leaves, and solves Laplace's equation on the surface in between, as heat would flow. On a tube it
//! is the axis, and at a branching it follows all branches.

use super::WetQuads;
use crate::Vec3;
use std::collections::HashMap;

/// Relative residual at which the potential is known well enough.
const TOLERANCE: f64 = 1e-10;

impl WetQuads {
    /// The potential at each point, 0 on the rims at the patches `from` and 1 on those at the patches `to`; none if the
    /// wall has no rim at some of either.
    pub fn potential_between(&self, from: &[String], to: &[String]) -> Option<Vec<f64>> {
        let mut fixed = vec![None; self.quads.points.len()];
        for (value, patches) in [(0.0, from), (1.0, to)] {
            let mut is_there = false;
            for ((a, b), patch) in &self.rim {
                if patches.contains(patch) {
                    (fixed[*a], fixed[*b]) = (Some(value), Some(value));
                    is_there = true;
                }
            }
            if !is_there {
                return None;
            }
        }
        Some(self.potential(&fixed))
    }

    /// Solves Laplace's equation with the `fixed` values. Fluxes run along edges, each through half of the width of the
    /// faces next to it: exact on rectangles.
    fn potential(&self, fixed: &[Option<f64>]) -> Vec<f64> {
        let points = &self.quads.points;
        let mut weights: HashMap<(usize, usize), f64> = HashMap::new();
        for face in &self.quads.faces {
            let [a, b, c, d] = face.map(|p| points[p]);
            let area = 0.5 * (c - a).cross(&(d - b)).norm();
            for k in 0..4 {
                let (p, q) = (face[k], face[(k + 1) % 4]);
                let length = (points[p] - points[q]).norm_squared();
                *weights.entry((p.min(q), p.max(q))).or_default() += 0.5 * area / length;
            }
        }
        let mut edges: Vec<_> = weights.into_iter().collect();
        edges.sort_unstable_by_key(|(edge, _)| *edge);
        // Of values at all points, those of fixed points being zero in a direction of search.
        let apply = |values: &[f64]| {
            let mut result = vec![0.0; values.len()];
            for ((p, q), weight) in &edges {
                let flux = weight * (values[*p] - values[*q]);
                result[*p] += flux;
                result[*q] -= flux;
            }
            result
                .iter_mut()
                .zip(fixed)
                .filter(|(_, fixed)| fixed.is_some())
                .for_each(|(r, _)| *r = 0.0);
            result
        };
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let mut potential: Vec<f64> = fixed.iter().map(|value| value.unwrap_or(0.5)).collect();
        // Conjugate gradients; a surface has few enough points.
        let mut residual: Vec<f64> = apply(&potential).iter().map(|r| -r).collect();
        let mut direction = residual.clone();
        let mut size = dot(&residual, &residual);
        let limit = TOLERANCE * TOLERANCE * size;
        for _ in 0..10 * points.len() {
            if size <= limit {
                break;
            }
            let image = apply(&direction);
            let step = size / dot(&direction, &image);
            for i in 0..potential.len() {
                potential[i] += step * direction[i];
                residual[i] -= step * image[i];
            }
            let next = dot(&residual, &residual);
            let share = next / size;
            size = next;
            for i in 0..direction.len() {
                direction[i] = residual[i] + share * direction[i];
            }
        }
        potential
    }

    /// Directions of the gradient of a field on the surface, of length 1, by least squares over the faces around each
    /// point.
    pub fn gradients(&self, field: &[f64], normals: &[Vec3]) -> Vec<Vec3> {
        let points = &self.quads.points;
        let mut around: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
        for face in &self.quads.faces {
            for &p in face {
                around[p].extend(face.iter().filter(|&&q| q != p));
            }
        }
        let gradient = |p: usize| {
            let n = normals[p];
            let first = n.cross(&some_other(&n)).normalize();
            let second = n.cross(&first);
            let (mut matrix, mut right) = (nalgebra::Matrix2::zeros(), nalgebra::Vector2::zeros());
            for &q in &around[p] {
                let d: Vec3 = points[q] - points[p];
                let d2 = nalgebra::Vector2::new(d.dot(&first), d.dot(&second));
                let weight = 1.0 / d2.norm_squared().max(f64::MIN_POSITIVE);
                matrix += d2 * d2.transpose() * weight;
                right += d2 * (weight * (field[q] - field[p]));
            }
            let g = matrix
                .try_inverse()
                .map_or(right, |inverse| inverse * right);
            let g = first * g.x + second * g.y;
            g.try_normalize(0.0).unwrap_or(first)
        };
        (0..points.len()).map(gradient).collect()
    }
}

/// A direction that is not that of `n`.
fn some_other(n: &Vec3) -> Vec3 {
    let smallest = n.abs().imin();
    Vec3::from_fn(|i, _| f64::from(i == smallest))
}
