//! Rays to a surface of triangles and nearest places on it, without looking at all triangles.

use super::Surface;
use crate::Vec3;
use rstar::{AABB, PointDistance, RTree, RTreeObject, SelectionFunction};
use std::collections::HashSet;

/// Share of the way from a triangle to the planes through its corners, by the weights of these (Boubekeur and Alexa
/// 2008, "Phong tessellation"): with 1/2 a sphere is round but for the fourth power of a triangle's angle.
const CURVED: f64 = 0.5;
/// A ray passes the edge between two triangles on one of them at least.
const EDGE: f64 = 1e-9;
/// Triangles of a smaller area, relative to the square of their longest edge, are lines: nothing is nearest to them.
const FLAT: f64 = 1e-12;

/// Places along a ray that are nearer to each other, relative to its length, are one.
const SAME: f64 = 1e-3;

/// Triangles in an R*-tree, curved by the normals at their corners.
#[derive(Debug, Clone)]
pub struct SurfaceSearch {
    surface: Surface,
    normals: Vec<Vec3>,
    tree: RTree<Facet>,
    /// Edges, the lower number first, that only one triangle has.
    open: HashSet<[usize; 2]>,
}

/// Where a ray meets a surface first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// Distance from the beginning of the ray, m.
    pub distance: f64,
    /// That of the plane triangle, m.
    flat: f64,
    /// Unit normal.
    pub normal: Vec3,
    /// Number of the triangle.
    pub triangle: usize,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Facet {
    number: usize,
    corners: [Vec3; 3],
}

impl Facet {
    /// The nearest place, in barycentric coordinates (Ericson 2005, Real-time collision detection, 5.1.5).
    fn nearest(&self, x: &Vec3) -> [f64; 3] {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let of = |p: Vec3| [ab.dot(&(x - p)), ac.dot(&(x - p))];
        let [[d1, d2], [d3, d4], [d5, d6]] = [of(a), of(b), of(c)];
        if d1 <= 0.0 && d2 <= 0.0 {
            return [1.0, 0.0, 0.0];
        }
        if d3 >= 0.0 && d4 <= d3 {
            return [0.0, 1.0, 0.0];
        }
        let vc = d1 * d4 - d3 * d2;
        if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            let t = d1 / (d1 - d3);
            return [1.0 - t, t, 0.0];
        }
        if d6 >= 0.0 && d5 <= d6 {
            return [0.0, 0.0, 1.0];
        }
        let vb = d5 * d2 - d1 * d6;
        if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            let t = d2 / (d2 - d6);
            return [1.0 - t, 0.0, t];
        }
        let va = d3 * d6 - d5 * d4;
        if va <= 0.0 && d4 >= d3 && d5 >= d6 {
            let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return [0.0, 1.0 - t, t];
        }
        let whole = va + vb + vc;
        [va / whole, vb / whole, vc / whole]
    }

    /// Whether it is more than a line.
    fn has_area(&self) -> bool {
        let [a, b, c] = self.corners;
        let longest = [b - a, c - b, a - c].map(|edge| edge.norm_squared());
        let longest = longest.into_iter().fold(0.0, f64::max);
        (b - a).cross(&(c - a)).norm() > FLAT * longest
    }

    fn at(&self, [a, b, c]: [f64; 3]) -> Vec3 {
        self.corners[0] * a + self.corners[1] * b + self.corners[2] * c
    }

    /// Distance along a ray, and the place in barycentric coordinates (Möller and Trumbore 1997).
    fn met(&self, from: &Vec3, direction: &Vec3) -> Option<(f64, [f64; 3])> {
        let [a, b, c] = self.corners;
        let (ab, ac) = (b - a, c - a);
        let p = direction.cross(&ac);
        let determinant = ab.dot(&p);
        if determinant == 0.0 {
            return None;
        }
        let arm = from - a;
        let u = arm.dot(&p) / determinant;
        let q = arm.cross(&ab);
        let v = direction.dot(&q) / determinant;
        let t = ac.dot(&q) / determinant;
        let is_within = u >= -EDGE && v >= -EDGE && u + v <= 1.0 + EDGE && t > 0.0;
        is_within.then_some((t, [1.0 - u - v, u, v]))
    }
}

impl RTreeObject for Facet {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        let [a, b, c] = self.corners;
        AABB::from_corners(a.inf(&b).inf(&c).into(), a.sup(&b).sup(&c).into())
    }
}

impl PointDistance for Facet {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let x = Vec3::from(*point);
        (self.at(self.nearest(&x)) - x).norm_squared()
    }
}

/// Boxes that a ray passes through.
struct OnRay {
    from: Vec3,
    direction: Vec3,
}

impl SelectionFunction<Facet> for OnRay {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 3]>) -> bool {
        let (low, high) = (envelope.lower(), envelope.upper());
        let (mut near, mut far) = (0.0f64, f64::INFINITY);
        for c in 0..3 {
            let (x, d) = (self.from[c], self.direction[c]);
            if d == 0.0 {
                if x < low[c] || x > high[c] {
                    return false;
                }
                continue;
            }
            let [a, b] = [low[c], high[c]].map(|edge| (edge - x) / d);
            (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
        }
        // Flat boxes are met in spite of rounding.
        near <= far + 1e-12 * far.abs()
    }
}

impl SurfaceSearch {
    /// Sorts the triangles.
    pub fn new(surface: Surface) -> Self {
        let facets = surface.corners().enumerate();
        let facets = facets.map(|(number, corners)| Facet { number, corners });
        let mut open = HashSet::new();
        for edge in (0..surface.triangles()).flat_map(|number| edges(surface.triangle(number))) {
            // The second triangle closes it.
            if !open.remove(&edge) {
                open.insert(edge);
            }
        }
        Self {
            tree: RTree::bulk_load(facets.filter(Facet::has_area).collect()),
            normals: surface.normals(),
            surface,
            open,
        }
    }

    /// What is searched.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    fn normal(&self, facet: &Facet, weights: [f64; 3]) -> Vec3 {
        let corners = self.surface.triangle(facet.number);
        let sum: Vec3 = (0..3).map(|i| self.normals[corners[i]] * weights[i]).sum();
        let [a, b, c] = facet.corners;
        // Where neighbours are wound against each other there is no mean.
        let own = || (b - a).cross(&(c - a)).normalize();
        sum.try_normalize(0.1).unwrap_or_else(own)
    }

    /// From a place on a triangle to the curved surface.
    fn bulge(&self, facet: &Facet, weights: [f64; 3]) -> Vec3 {
        let x = facet.at(weights);
        let corners = self.surface.triangle(facet.number);
        let towards = |i: usize| {
            let normal = self.normals[corners[i]];
            normal * ((facet.corners[i] - x).dot(&normal) * weights[i] * CURVED)
        };
        (0..3).map(towards).sum()
    }

    /// Where a ray along a unit vector meets the curved surface first.
    pub fn ray(&self, from: &Vec3, direction: &Vec3) -> Option<RayHit> {
        let boxes = OnRay {
            from: *from,
            direction: *direction,
        };
        let candidates = self.tree.locate_with_selection_function(boxes);
        let met = candidates.filter_map(|facet| {
            let (distance, weights) = facet.met(from, direction)?;
            Some((distance, weights, facet))
        });
        let (distance, weights, facet) = met.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let normal = self.normal(facet, weights);
        let slope = direction.dot(&normal);
        let bulge = self.bulge(facet, weights).dot(&normal);
        // Along the ray, unless that grazes.
        let more = if slope.abs() > 0.2 {
            bulge / slope
        } else {
            0.0
        };
        Some(RayHit {
            distance: distance + more,
            flat: distance,
            normal,
            triangle: facet.number,
        })
    }

    /// How often a ray meets the plane triangles within a distance (m): those of one place once.
    pub fn crossings(&self, from: &Vec3, direction: &Vec3, reach: f64) -> usize {
        let boxes = OnRay {
            from: *from,
            direction: *direction,
        };
        let candidates = self.tree.locate_with_selection_function(boxes);
        let met = candidates.filter_map(|facet| facet.met(from, direction));
        let mut distances: Vec<f64> = met.map(|(distance, _)| distance).collect();
        distances.retain(|distance| *distance < reach);
        distances.sort_by(f64::total_cmp);
        distances.dedup_by(|b, a| *b - *a < SAME * reach);
        distances.len()
    }

    /// How the straight way between two places meets the surface first, and where, m.
    pub fn between(&self, from: &Vec3, to: &Vec3) -> Option<(RayHit, Vec3)> {
        let direction = (to - from).try_normalize(0.0)?;
        let hit = self.ray(from, &direction)?;
        // One of two ways that follow each other meets a triangle.
        (hit.flat <= (to - from).norm()).then(|| (hit, from + direction * hit.distance))
    }

    /// The nearest place (m) of the curved surface.
    pub fn nearest(&self, x: &Vec3) -> Vec3 {
        let (facet, weights) = self.nearest_facet(x);
        facet.at(weights) + self.bulge(facet, weights)
    }

    /// As [`SurfaceSearch::nearest`]; none where that is an edge at which the surface ends, so that the place may lie
    /// beyond it.
    pub fn nearest_within(&self, x: &Vec3) -> Option<Vec3> {
        let (facet, weights) = self.nearest_facet(x);
        let edges = edges(self.surface.triangle(facet.number));
        let at_end = (0..3).any(|i| weights[(i + 2) % 3] == 0.0 && self.open.contains(&edges[i]));
        (!at_end).then(|| facet.at(weights) + self.bulge(facet, weights))
    }

    fn nearest_facet(&self, x: &Vec3) -> (&Facet, [f64; 3]) {
        let facet = self.tree.nearest_neighbor((*x).into());
        let facet = facet.expect("a surface has a triangle");
        (facet, facet.nearest(x))
    }
}

/// The edges of a triangle, edge i from corner i to the next one, the lower number first.
fn edges([a, b, c]: [usize; 3]) -> [[usize; 2]; 3] {
    [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polydata::PolyData;

    /// An octahedron, each triangle of which is divided into four so many times, on the unit sphere.
    fn sphere(times: usize) -> SurfaceSearch {
        let mut triangles: Vec<[Vec3; 3]> = Vec::new();
        for x in [Vec3::x(), -Vec3::x()] {
            for y in [Vec3::y(), -Vec3::y()] {
                for z in [Vec3::z(), -Vec3::z()] {
                    let is_right = x.cross(&y).dot(&z) > 0.0;
                    triangles.push(if is_right { [x, y, z] } else { [y, x, z] });
                }
            }
        }
        for _ in 0..times {
            let four = |[a, b, c]: &[Vec3; 3]| {
                let [d, e, f] = [a + b, b + c, c + a].map(|x| x.normalize());
                [[*a, d, f], [d, *b, e], [f, e, *c], [d, e, f]]
            };
            triangles = triangles.iter().flat_map(four).collect();
        }
        let data = PolyData {
            points: triangles.iter().flatten().map(|x| (*x).into()).collect(),
            triangles: (0..triangles.len())
                .map(|i| [3 * i, 3 * i + 1, 3 * i + 2])
                .collect(),
            ..PolyData::default()
        };
        SurfaceSearch::new(Surface::new(&data, 1.0).unwrap())
    }

    fn directions() -> impl Iterator<Item = Vec3> {
        (0..300).map(|i| {
            let z = -0.995 + 1.99 * f64::from(i) / 299.0;
            let (sin, cos) = (2.4 * f64::from(i)).sin_cos();
            let across = (1.0 - z * z).sqrt();
            Vec3::new(across * cos, across * sin, z)
        })
    }

    /// Curved triangles lie within 2e-3 of the sphere, where plane ones are up to 1.5e-2 inside.
    #[test]
    fn rays_meet_a_sphere_and_nearest_places_lie_on_it() {
        let sphere = sphere(3);
        let from = Vec3::new(0.1, -0.2, 0.15);
        for direction in directions() {
            let hit = sphere.ray(&from, &direction).unwrap();
            let x = from + direction * hit.distance;
            assert!((x.norm() - 1.0).abs() < 2e-3, "{x}");
            assert!(hit.normal.dot(&x.normalize()) > 0.999);
            let near = sphere.nearest(&(direction * 1.1));
            assert!((near - direction).norm() < 0.02, "{near} {direction}");
            assert!((near.norm() - 1.0).abs() < 2e-3, "{near}");
        }
        assert!(sphere.ray(&Vec3::new(2.0, 0.0, 0.0), &Vec3::x()).is_none());
        assert!(sphere.ray(&Vec3::new(2.0, 0.0, 0.0), &-Vec3::x()).is_some());
    }

    /// Two triangles side by side, and a third one that is a line between them.
    #[test]
    fn places_beyond_the_end_and_flat_triangles_are_not_near() {
        let points = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let points = points.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        let triangles = vec![[0, 1, 2], [0, 2, 3], [0, 2, 0]];
        let surface = Surface::of_points(points, triangles).unwrap();
        let search = SurfaceSearch::new(surface);
        let above = Vec3::new(1.0, 1.0, 0.5);
        assert_eq!(search.nearest(&above), Vec3::new(1.0, 1.0, 0.0));
        assert!(search.nearest_within(&above).is_some());
        let beyond = Vec3::new(1.0, -0.5, 0.5);
        assert_eq!(search.nearest(&beyond), Vec3::new(1.0, 0.0, 0.0));
        assert_eq!(search.nearest_within(&beyond), None);
    }
}
