//! Surfaces of triangles, and what planes cut out of them.

use super::PolyData;
use crate::Vec3;
use std::collections::HashMap;

/// Triangles that share their points, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    points: Vec<Vec3>,
    triangles: Vec<[usize; 3]>,
}

/// Where a ray meets a surface first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Distance from the beginning of the ray, m.
    pub radius: f64,
    /// Component of the triangle's unit normal perpendicular to the plane: 0 where the surface stands upright on it, 1 where
    /// it lies in it.
    pub slant: f64,
    /// Length (m) of what the plane cuts out of the triangle.
    pub chord: f64,
}

/// A closed chain of edges that belong to one triangle only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OpenEdge {
    /// Mean of its points, m.
    pub centre: Vec3,
    /// Number of its edges.
    pub edges: usize,
}

impl Surface {
    /// The triangles of a file whose lengths are to be multiplied by `metres`. Points at the same place become one, and
    /// triangles without area are left out.
    ///
    /// # Errors
    /// If there are none, in words.
    pub fn new(data: &PolyData, metres: f64) -> Result<Self, String> {
        let (mut known, mut points) = (HashMap::new(), Vec::new());
        let mut number = |point: &[f64; 3]| {
            *known
                .entry(point.map(|x| (x + 0.0).to_bits()))
                .or_insert_with(|| {
                    points.push(Vec3::from(*point) * metres);
                    points.len() - 1
                })
        };
        let numbers: Vec<usize> = data.points.iter().map(&mut number).collect();
        let triangles = data.triangles.iter().map(|three| three.map(|i| numbers[i]));
        let triangles: Vec<[usize; 3]> = triangles
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        if triangles.is_empty() {
            return Err("the file has no triangles".into());
        }
        Ok(Self { points, triangles })
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Area, m².
    pub fn area(&self) -> f64 {
        let area = |three: &[usize; 3]| {
            let [a, b, c] = three.map(|i| self.points[i]);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        self.triangles.iter().map(area).sum()
    }

    /// Least and largest coordinates of the triangles, m.
    pub fn bounds(&self) -> [Vec3; 2] {
        let corners = self.triangles.iter().flatten().map(|i| self.points[*i]);
        let start = [f64::INFINITY, f64::NEG_INFINITY].map(Vec3::repeat);
        corners.fold(start, |[low, high], p| [low.inf(&p), high.sup(&p)])
    }

    /// Where the surface ends; none if it is closed.
    pub fn open_edges(&self) -> Vec<OpenEdge> {
        let mut uses: HashMap<[usize; 2], usize> = HashMap::new();
        for [a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *uses.entry([*from.min(to), *from.max(to)]).or_default() += 1;
            }
        }
        // Edges that share a point belong together: union-find.
        let mut parent: HashMap<usize, usize> = HashMap::new();
        fn root(parent: &mut HashMap<usize, usize>, mut i: usize) -> usize {
            loop {
                let above = *parent.entry(i).or_insert(i);
                if above == i {
                    return i;
                }
                let higher = parent[&above];
                parent.insert(i, higher);
                i = above;
            }
        }
        let mut open: Vec<[usize; 2]> = uses
            .into_iter()
            .filter_map(|(edge, count)| (count == 1).then_some(edge))
            .collect();
        open.sort_unstable();
        for [a, b] in &open {
            let (a, b) = (root(&mut parent, *a), root(&mut parent, *b));
            parent.insert(a, b);
        }
        let mut groups: HashMap<usize, (Vec3, usize)> = HashMap::new();
        for [a, b] in &open {
            let group = groups.entry(root(&mut parent, *a)).or_default();
            group.0 += (self.points[*a] + self.points[*b]) * 0.5;
            group.1 += 1;
        }
        let mut all: Vec<OpenEdge> = groups
            .into_values()
            .map(|(sum, edges)| OpenEdge {
                centre: sum / edges as f64,
                edges,
            })
            .collect();
        all.sort_by(|a, b| {
            b.edges
                .cmp(&a.edges)
                .then(a.centre.x.total_cmp(&b.centre.x))
        });
        all
    }

    /// Rays from `origin` (m) in the plane of the unit vectors `first` and `second`, in equal angles from the one to the
    /// other: where each of them meets the surface first.
    pub fn rays(
        &self,
        origin: &Vec3,
        [first, second]: [&Vec3; 2],
        count: usize,
    ) -> Vec<Option<Crossing>> {
        let normal = first.cross(second);
        let heights: Vec<f64> = self
            .points
            .iter()
            .map(|p| (p - origin).dot(&normal))
            .collect();
        let mut nearest: Vec<Option<Crossing>> = vec![None; count];
        for triangle in &self.triangles {
            let above = triangle.map(|i| heights[i] >= 0.0);
            if above[0] == above[1] && above[1] == above[2] {
                continue;
            }
            // The two edges that the plane cuts; the same two ends give the same point, whichever triangle asks.
            let cut = |from: usize, to: usize| {
                let (low, high) = (from.min(to), from.max(to));
                let share = heights[low] / (heights[low] - heights[high]);
                let arm =
                    self.points[low] + (self.points[high] - self.points[low]) * share - origin;
                [arm.dot(first), arm.dot(second)]
            };
            let [a, b, c] = *triangle;
            let edges = [
                ([a, b], above[0] != above[1]),
                ([b, c], above[1] != above[2]),
                ([c, a], above[2] != above[0]),
            ];
            let mut ends = edges
                .iter()
                .filter(|(_, is_cut)| *is_cut)
                .map(|([p, q], _)| cut(*p, *q));
            let (Some(p), Some(q)) = (ends.next(), ends.next()) else {
                continue;
            };
            self.meet(triangle, [p, q], &normal, &mut nearest);
        }
        nearest
    }

    /// Rays that meet a segment `p q` of the plane.
    fn meet(
        &self,
        triangle: &[usize; 3],
        [p, q]: [[f64; 2]; 2],
        normal: &Vec3,
        nearest: &mut [Option<Crossing>],
    ) {
        let count = nearest.len() as f64;
        let place = |p: [f64; 2]| p[1].atan2(p[0]) / std::f64::consts::TAU * count;
        let (from, mut to) = (place(p), place(q));
        // The shorter way around.
        if to - from > 0.5 * count {
            to -= count;
        } else if from - to > 0.5 * count {
            to += count;
        }
        // A margin: whether a ray meets the segment is decided below, alike for neighbours.
        let (low, high) = (from.min(to) - 1e-6, from.max(to) + 1e-6);
        let [a, b, c] = triangle.map(|i| self.points[i]);
        let across = (b - a).cross(&(c - a));
        let slant = (across.dot(normal) / across.norm()).abs();
        let chord = (p[0] - q[0]).hypot(p[1] - q[1]);
        for ray in low.ceil() as i64..=high.floor() as i64 {
            let index = ray.rem_euclid(nearest.len() as i64) as usize;
            let (sin, cos) = (std::f64::consts::TAU * index as f64 / count).sin_cos();
            let side = |p: [f64; 2]| cos * p[1] - sin * p[0];
            let (of_p, of_q) = (side(p), side(q));
            if (of_p >= 0.0) == (of_q >= 0.0) {
                continue;
            }
            let share = of_p / (of_p - of_q);
            let point = [0, 1].map(|c| p[c] + share * (q[c] - p[c]));
            let radius = cos * point[0] + sin * point[1];
            let is_nearer = nearest[index].is_none_or(|known| radius < known.radius);
            if radius > 0.0 && is_nearer {
                nearest[index] = Some(Crossing {
                    radius,
                    slant,
                    chord,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// An open prism of `n` sides around the x-axis, of the radius 2 and the length 10.
    fn prism(n: usize) -> PolyData {
        let corner = |i: usize, x: f64| {
            let phi = TAU * (i % n) as f64 / n as f64;
            [x, 2.0 * phi.cos(), 2.0 * phi.sin()]
        };
        let points = (0..n)
            .flat_map(|i| [corner(i, 0.0), corner(i, 10.0)])
            .collect();
        let triangles = (0..n).flat_map(|i| {
            let (a, b) = (2 * i, 2 * ((i + 1) % n));
            [[a, b, a + 1], [b, b + 1, a + 1]]
        });
        PolyData {
            points,
            triangles: triangles.collect(),
            ..PolyData::default()
        }
    }

    #[test]
    fn rays_meet_a_prism_where_it_is() {
        let surface = Surface::new(&prism(16), 1e-3).unwrap();
        let rays = surface.rays(&Vec3::new(4e-3, 0.0, 0.0), [&Vec3::y(), &Vec3::z()], 64);
        for (i, ray) in rays.iter().enumerate() {
            let ray = ray.unwrap_or_else(|| panic!("ray {i}"));
            let beside = (TAU * i as f64 / 64.0).rem_euclid(TAU / 16.0) - TAU / 32.0;
            let exact = 2e-3 * (TAU / 32.0).cos() / beside.cos();
            assert!(
                (ray.radius - exact).abs() < 1e-15,
                "{i}: {} {exact}",
                ray.radius
            );
            assert!(ray.slant < 1e-12);
        }
        assert!(
            surface
                .rays(&Vec3::new(11e-3, 0.0, 0.0), [&Vec3::y(), &Vec3::z()], 8)
                .iter()
                .all(Option::is_none)
        );
        // From outside, only a few of them.
        let outside = surface.rays(&Vec3::new(4e-3, 4e-3, 0.0), [&Vec3::y(), &Vec3::z()], 64);
        let met = outside.iter().flatten().count();
        assert!((10..12).contains(&met), "{met}");
    }

    #[test]
    fn a_tube_is_open_at_two_ends() {
        let surface = Surface::new(&prism(12), 1.0).unwrap();
        let open = surface.open_edges();
        assert_eq!(open.len(), 2);
        assert!(open.iter().all(|edge| edge.edges == 12));
        assert!((open[0].centre - Vec3::zeros()).norm() < 1e-12);
        assert!((open[1].centre - Vec3::new(10.0, 0.0, 0.0)).norm() < 1e-12);
        assert_eq!(surface.bounds()[1].x, 10.0);
    }
}
