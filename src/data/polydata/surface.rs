//! Surfaces of triangles, and what planes cut out of them.

use super::PolyData;
use crate::Vec3;
use crate::files::{Fault, fault};
use std::collections::{HashMap, HashSet};

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
    /// Component of the triangle's unit normal perpendicular to the plane: 0 where the surface stands upright on it, 1
    /// where it lies in it.
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
    /// Area (m²) that they enclose: the magnitude of its vector.
    pub area: f64,
}

/// Points closer to each other than this share of the surface's size are one.
const WELD: f64 = 1e-5;

/// Number of the point that stands for each point, and these points: the first of those that lie together.
fn weld(points: &[[f64; 3]]) -> (Vec<usize>, Vec<[f64; 3]>) {
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for point in points {
        for c in 0..3 {
            bounds[0][c] = bounds[0][c].min(point[c]);
            bounds[1][c] = bounds[1][c].max(point[c]);
        }
    }
    let size = (0..3)
        .map(|c| (bounds[1][c] - bounds[0][c]).powi(2))
        .sum::<f64>()
        .sqrt();
    let reach = WELD * size;
    // Cells of twice the reach: what is within reach lies in this one or in one next to it.
    let cell = |x: f64| {
        if reach > 0.0 {
            (x / (2.0 * reach)).floor() as i64
        } else {
            0
        }
    };
    let mut known: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut kept: Vec<[f64; 3]> = Vec::new();
    let numbers = points.iter().map(|point| {
        let around = |c: usize| {
            [
                cell(point[c] - reach - bounds[0][c]),
                cell(point[c] + reach - bounds[0][c]),
            ]
        };
        let [xs, ys, zs] = [around(0), around(1), around(2)];
        for x in xs[0]..=xs[1] {
            for y in ys[0]..=ys[1] {
                for z in zs[0]..=zs[1] {
                    let near = known.get(&[x, y, z]).into_iter().flatten();
                    let is_near = |i: &&usize| {
                        let squares = (0..3).map(|c| (kept[**i][c] - point[c]).powi(2));
                        squares.sum::<f64>() <= reach * reach
                    };
                    if let Some(i) = near.into_iter().find(is_near) {
                        return *i;
                    }
                }
            }
        }
        let own = [0, 1, 2].map(|c| cell(point[c] - bounds[0][c]));
        known.entry(own).or_default().push(kept.len());
        kept.push(*point);
        kept.len() - 1
    });
    (numbers.collect(), kept)
}

impl Surface {
    /// The triangles of a file whose lengths are to be multiplied by `metres`. Points closer to each other than a
    /// hundred-thousandth of the surface's size become one, so that hairline cracks close, and triangles without area
    /// are left out.
    ///
    /// # Errors
    /// If there are none, in words.
    pub fn new(data: &PolyData, metres: f64) -> Result<Self, Fault> {
        let (numbers, points) = weld(&data.points);
        let points = points
            .iter()
            .map(|point| Vec3::from(*point) * metres)
            .collect();
        let triangles = data.triangles.iter().map(|three| three.map(|i| numbers[i]));
        let triangles: Vec<[usize; 3]> = triangles
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        if triangles.is_empty() {
            return Err("the file has no triangles".into());
        }
        Ok(Self { points, triangles })
    }

    /// Points (m), and the numbers of the three of each triangle.
    ///
    /// # Errors
    /// If a number is that of no point, or there are no triangles.
    pub fn of_points(points: Vec<Vec3>, triangles: Vec<[usize; 3]>) -> Result<Self, Fault> {
        let count = points.len();
        match triangles.iter().flatten().find(|i| **i >= count) {
            Some(i) => Err(fault!(
                "a triangle has the point {i}, counted from 0, and there are {count}"
            )),
            None if triangles.is_empty() => Err("there are no triangles".into()),
            None => Ok(Self { points, triangles }),
        }
    }

    /// The triangles for whose number and corners (m) it holds.
    ///
    /// # Errors
    /// If it does for none.
    pub fn filtered(&self, holds: impl Fn(usize, [Vec3; 3]) -> bool) -> Result<Self, Fault> {
        let mut places = vec![usize::MAX; self.points.len()];
        let mut points = Vec::new();
        let mut triangles = self.triangles.clone();
        let mut all = self.corners().enumerate();
        triangles.retain(|_| all.next().is_some_and(|(i, corners)| holds(i, corners)));
        for i in triangles.iter_mut().flatten() {
            if places[*i] == usize::MAX {
                places[*i] = points.len();
                points.push(self.points[*i]);
            }
            *i = places[*i];
        }
        Self::of_points(points, triangles)
    }

    /// A triangle, and those for whose corners (m) it holds that are connected with it by such.
    pub fn connected(&self, first: usize, holds: impl Fn([Vec3; 3]) -> bool) -> HashSet<usize> {
        let mut at_point = vec![Vec::new(); self.points.len()];
        for (number, corners) in self.triangles.iter().enumerate() {
            corners.iter().for_each(|i| at_point[*i].push(number));
        }
        let mut found = HashSet::from([first]);
        let mut next = vec![first];
        while let Some(number) = next.pop() {
            for neighbour in self.triangles[number].iter().flat_map(|i| &at_point[*i]) {
                let corners = self.triangles[*neighbour].map(|i| self.points[i]);
                if holds(corners) && found.insert(*neighbour) {
                    next.push(*neighbour);
                }
            }
        }
        found
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        self.triangles.len()
    }

    /// Points, m.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Numbers of the points of a triangle.
    pub fn triangle(&self, number: usize) -> [usize; 3] {
        self.triangles[number]
    }

    /// Corners (m) of each triangle.
    pub fn corners(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        self.triangles
            .iter()
            .map(|three| three.map(|i| self.points[i]))
    }

    /// Unit normals at the points: of the triangles there, weighted by their angles.
    pub fn normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::zeros(); self.points.len()];
        for (three, corners) in self.triangles.iter().zip(self.corners()) {
            let [a, b, c] = corners;
            let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else {
                continue;
            };
            for i in 0..3 {
                let [p, q] = [1, 2].map(|k| corners[(i + k) % 3] - corners[i]);
                normals[three[i]] += normal * p.angle(&q);
            }
        }
        let unit = |n: Vec3| n.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        normals.into_iter().map(unit).collect()
    }

    /// Without what the triangles bring in: waves of the length `halved` (m) keep half of their height, of three times
    /// that 99 %, as by a smoothing spline. Where the surface ends its points stay.
    ///
    /// `(1 + (halved/2π)⁴ L²) x = x₀` with the Laplacian L of the graph of edges over their mean square length, by
    /// conjugate gradients.
    pub fn smoothed(mut self, halved: f64) -> Self {
        const ACCURACY: f64 = 1e-9;
        const ITERATIONS: usize = 500;
        let mut edges: Vec<[usize; 2]> = (self.triangles.iter())
            .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
            .map(|[a, b]| [*a.min(b), *a.max(b)])
            .collect();
        edges.sort_unstable();
        let mut is_free = vec![true; self.points.len()];
        for group in edges
            .chunk_by(|a, b| a == b)
            .filter(|group| group.len() == 1)
        {
            group[0].iter().for_each(|i| is_free[*i] = false);
        }
        edges.dedup();
        let squares = edges
            .iter()
            .map(|[a, b]| (self.points[*a] - self.points[*b]).norm_squared());
        let mean = squares.sum::<f64>() / edges.len() as f64;
        if halved <= 0.0 {
            return self;
        }
        // Six neighbours at the distance h: the sum of the differences is 3/2 h² times the Laplacian.
        let scale = 1.0 / (1.5 * mean);
        let laplacian = |x: &[Vec3]| {
            let mut sum = vec![Vec3::zeros(); x.len()];
            for [a, b] in &edges {
                let difference = (x[*b] - x[*a]) * scale;
                sum[*a] += difference;
                sum[*b] -= difference;
            }
            sum
        };
        let weight = (halved / std::f64::consts::TAU).powi(4);
        let hold = |mut x: Vec<Vec3>| {
            let held = x.iter_mut().zip(&is_free).filter(|(_, free)| !**free);
            held.for_each(|(x, _)| *x = Vec3::zeros());
            x
        };
        let bent = |x: &[Vec3]| laplacian(&laplacian(x)).into_iter().map(|x| x * weight);
        let system = |x: &[Vec3]| hold(x.iter().zip(bent(x)).map(|(x, b)| x + b).collect());
        let dot = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
        // For the change of the points: A u = -weight L² x₀.
        let mut residual = hold(bent(&self.points).map(|x| -x).collect());
        let mut direction = residual.clone();
        let mut size = dot(&residual, &residual);
        let enough = ACCURACY * ACCURACY * mean * self.points.len() as f64;
        for _ in 0..ITERATIONS {
            if size <= enough {
                break;
            }
            let image = system(&direction);
            let step = size / dot(&direction, &image);
            for i in 0..self.points.len() {
                self.points[i] += direction[i] * step;
                residual[i] -= image[i] * step;
            }
            let before = std::mem::replace(&mut size, dot(&residual, &residual));
            for (d, r) in direction.iter_mut().zip(&residual) {
                *d = r + *d * (size / before);
            }
        }
        self
    }

    /// Median length (m) of an edge.
    pub fn edge(&self) -> f64 {
        let lengths = self
            .corners()
            .flat_map(|[a, b, c]| [(b - a), (c - b), (a - c)]);
        let mut lengths: Vec<f64> = lengths.map(|edge| edge.norm()).collect();
        lengths.sort_by(f64::total_cmp);
        lengths[lengths.len() / 2]
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
        // Each edge as its triangle runs through it, so that they follow each other around.
        let mut along: HashMap<[usize; 2], [usize; 2]> = HashMap::new();
        for [a, b, c] in &self.triangles {
            for [from, to] in [[*a, *b], [*b, *c], [*c, *a]] {
                along.insert([from.min(to), from.max(to)], [from, to]);
            }
        }
        let mut groups: HashMap<usize, Vec<[Vec3; 2]>> = HashMap::new();
        for edge in &open {
            let group = groups.entry(root(&mut parent, edge[0])).or_default();
            group.push(along[edge].map(|i| self.points[i]));
        }
        let of_group = |edges: Vec<[Vec3; 2]>| {
            let count = edges.len();
            let centre = edges.iter().map(|[a, b]| (a + b) * 0.5).sum::<Vec3>() / count as f64;
            let vector: Vec3 = edges
                .iter()
                .map(|[a, b]| (a - centre).cross(&(b - centre)) * 0.5)
                .sum();
            OpenEdge {
                centre,
                edges: count,
                area: vector.norm(),
            }
        };
        let mut all: Vec<OpenEdge> = groups.into_values().map(of_group).collect();
        all.sort_by(|a, b| {
            b.edges
                .cmp(&a.edges)
                .then(a.centre.x.total_cmp(&b.centre.x))
        });
        all
    }

    /// Rays from `origin` (m) in the plane of the unit vectors `first` and `second`, in equal angles from the one to
    /// the other: where each of them meets the surface first.
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
