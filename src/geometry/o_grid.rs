//! The fluid's mesh: an O-grid of hexahedra, swept along the centre-line.
//!
//! A cross-section has a square of `core × core` cells in the middle, its sides bulging towards the wall, and around
//! it `radial` rings of `4 core` cells that grow thinner towards the wall. Everything scales with the lumen's radius in
//! the direction of the point, so that the grid follows the imperfection.

use super::poly_mesh::{PatchFaces, PolyMesh};
use super::vessel::{Span, Vessel};
use crate::Vec3;
use crate::case::{BloodVessel, FluidMesh};
use fsi_numerics::Layers;
use fsi_pfem::mesh::equal_stations;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use std::ops::Range;

/// Distance of the core's corners from the centre, relative to the lumen's radius.
pub(super) const CORNER: f64 = 0.56;
/// Shape of the core's sides: 0 straight, 1 arcs of a circle.
pub(super) const BULGE: f64 = 0.4;

/// Widths of cells as shares of the radius: of those in the middle, and of those at the wall where they are widest.
pub fn cell_widths(mesh: &FluidMesh) -> [f64; 2] {
    let side = CORNER * ((1.0 - BULGE) * FRAC_PI_4.cos() + BULGE);
    let rings = CrossSection::new(mesh).rings;
    let previous = rings.len().checked_sub(2).map_or(0.0, |i| rings[i]);
    [
        2.0 * side / mesh.core as f64,
        (1.0 - side) * (1.0 - previous),
    ]
}

/// Distance from the core (0) to the wall (1) of the points of so many rings, whose thicknesses shrink geometrically
/// from `grading` to 1.
pub(super) fn rings(radial: usize, grading: f64) -> Vec<f64> {
    let ratio = if radial > 1 {
        grading.powf(-1.0 / (radial - 1) as f64)
    } else {
        1.0
    };
    let total: f64 = (0..radial).map(|k| ratio.powi(k as i32)).sum();
    let mut rings: Vec<f64> = (0..radial)
        .map(|ring| (0..=ring).map(|k| ratio.powi(k as i32)).sum::<f64>() / total)
        .collect();
    *rings.last_mut().expect("a case has at least one ring") = 1.0;
    rings
}

/// Point `a` around ring `ring` of an O-grid with so many intervals along a side of its core: points of the core come
/// first, row by row, then ring by ring. Ring 0 is the border of the core. Counted from its corner at -45°,
/// counter-clockwise.
pub(crate) fn ring_point(side: usize, ring: usize, a: usize) -> usize {
    let (n, around) = (side, 4 * side);
    let a = a % around;
    if ring > 0 {
        return (n + 1).pow(2) + (ring - 1) * around + a;
    }
    let (along, core_point) = (a % n, |i: usize, j: usize| j * (n + 1) + i);
    match a / n {
        0 => core_point(n, along),
        1 => core_point(n - along, n),
        2 => core_point(0, n - along),
        _ => core_point(along, 0),
    }
}

/// Numbering of the points and cells of one cross-section.
struct CrossSection<'a> {
    mesh: &'a FluidMesh,
    /// Distance from the core (0) to the wall (1) of the rings' points.
    rings: Vec<f64>,
}

impl<'a> CrossSection<'a> {
    fn new(mesh: &'a FluidMesh) -> Self {
        let rings = rings(mesh.radial, mesh.wall_grading);
        Self { mesh, rings }
    }

    fn around(&self) -> usize {
        4 * self.mesh.core
    }

    fn points(&self) -> usize {
        (self.mesh.core + 1).pow(2) + self.around() * self.mesh.radial
    }

    fn core_point(&self, i: usize, j: usize) -> usize {
        j * (self.mesh.core + 1) + i
    }

    /// Point `a` around ring `ring`; ring 0 is the border of the core. Counted from the corner at -45° (core point
    /// (core, 0)) counter-clockwise.
    fn ring_point(&self, ring: usize, a: usize) -> usize {
        ring_point(self.mesh.core, ring, a)
    }

    fn angle(&self, a: usize) -> f64 {
        -FRAC_PI_4 + FRAC_PI_2 * a as f64 / self.mesh.core as f64
    }

    /// Coordinates of all points in the plane, for a lumen of the radius `radius(phi)`.
    fn positions(&self, radius: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
        let n = self.mesh.core;
        let mut at = vec![[0.0; 2]; self.points()];
        for a in 0..self.around() {
            let phi = self.angle(a);
            let from_middle_of_side = FRAC_PI_4 * (2.0 * (a % n) as f64 / n as f64 - 1.0);
            let straight = FRAC_PI_4.cos() / from_middle_of_side.cos();
            let wall = radius(phi);
            let core = wall * CORNER * ((1.0 - BULGE) * straight + BULGE);
            for ring in 0..=self.mesh.radial {
                let t = if ring == 0 { 0.0 } else { self.rings[ring - 1] };
                let r = core * (1.0 - t) + wall * t;
                at[self.ring_point(ring, a)] = [r * phi.cos(), r * phi.sin()];
            }
        }
        // Inside the core: Coons' transfinite interpolation of its four sides.
        for j in 1..n {
            for i in 1..n {
                let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
                let blend = |c: usize| {
                    let p = |i, j| at[self.core_point(i, j)][c];
                    let sides =
                        (1.0 - t) * p(i, 0) + t * p(i, n) + (1.0 - s) * p(0, j) + s * p(n, j);
                    let corners = (1.0 - s) * ((1.0 - t) * p(0, 0) + t * p(0, n))
                        + s * ((1.0 - t) * p(n, 0) + t * p(n, n));
                    sides - corners
                };
                at[self.core_point(i, j)] = [blend(0), blend(1)];
            }
        }
        at
    }

    /// How the points of a cross-section, which lie `at`, follow those of its wall: all go with their mean, and with
    /// what is beyond that the less the nearer they are to the middle. Places around the wall with their shares, by
    /// point.
    fn shares(&self, at: &[Vec3]) -> Vec<Vec<(usize, f64)>> {
        let n = self.mesh.core;
        let on_wall = |a| at[self.ring_point(self.mesh.radial, a)];
        let middle = (0..self.around()).map(on_wall).sum::<Vec3>() / self.around() as f64;
        let mut shares = vec![Vec::new(); at.len()];
        for a in 0..self.around() {
            for ring in 0..=self.mesh.radial {
                let point = self.ring_point(ring, a);
                let share = (at[point] - middle).norm() / (on_wall(a) - middle).norm();
                shares[point] = vec![(a, share)];
            }
        }
        // Inside the core: Coons' transfinite interpolation of its four sides.
        for j in 1..n {
            for i in 1..n {
                let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
                let [(s0, s1), (t0, t1)] = [(1.0 - s, s), (1.0 - t, t)];
                let sides = [(i, 0, t0), (i, n, t1), (0, j, s0), (n, j, s1)];
                let corners = [
                    (0, 0, -s0 * t0),
                    (n, 0, -s1 * t0),
                    (0, n, -s0 * t1),
                    (n, n, -s1 * t1),
                ];
                let of_border = |(i, j, weight): (usize, usize, f64)| {
                    let (a, share) = shares[self.core_point(i, j)][0];
                    (a, weight * share)
                };
                shares[self.core_point(i, j)] =
                    sides.into_iter().chain(corners).map(of_border).collect();
            }
        }
        shares
    }

    /// Points of each cell of the cross-section, counter-clockwise.
    fn quads(&self) -> Vec<[usize; 4]> {
        let n = self.mesh.core;
        let core = (0..n * n).map(|cell| {
            let (i, j) = (cell % n, cell / n);
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.core_point(i, j))
        });
        let rings = (0..self.mesh.radial * self.around()).map(|cell| {
            let (ring, a) = (cell / self.around(), cell % self.around());
            [(ring, a), (ring + 1, a), (ring + 1, a + 1), (ring, a + 1)]
                .map(|(ring, a)| self.ring_point(ring, a))
        });
        core.chain(rings).collect()
    }
}

/// The cross-sections of a vessel's wall as an O-grid has them: polygons.
///
/// One whose corners lie on a circle encloses less than it, by 1.6 % with twenty sides, and the flow, its pressure drop
/// and the wall shear stress are off by as much and more. So the corners of a polygon stand a little outside, where it
/// encloses what the round wall does.
#[derive(Debug, Clone, PartialEq)]
pub struct WallPolygons {
    polygons: Vec<Polygon>,
    /// How much farther from the middle the corners are than the wall.
    growth: f64,
}

/// A cross-section of the wall, or all that meet at a junction.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Its points.
    pub corners: Vec<usize>,
    /// Points with whose mean the middle goes.
    pub middle_of: Vec<usize>,
    /// Where the middle is from there, m.
    pub off: Vec3,
}

impl WallPolygons {
    /// Those of a vessel's O-grid; its points by their numbers.
    pub fn of(grid: &PolyMesh, mesh: &FluidMesh) -> Self {
        let section = CrossSection::new(mesh);
        let size = section.points();
        let polygon = |slice: usize| {
            let point = |a| slice * size + section.ring_point(mesh.radial, a);
            let corners: Vec<usize> = (0..section.around()).map(point).collect();
            Polygon {
                middle_of: corners.clone(),
                corners,
                off: Vec3::zeros(),
            }
        };
        let slices = 0..grid.points.len() / size;
        Self::new(slices.map(polygon).collect(), section.around())
    }

    /// Of polygons with so many corners around.
    pub fn new(polygons: Vec<Polygon>, around: usize) -> Self {
        Self {
            polygons,
            growth: growth_of_polygon(around),
        }
    }

    /// The same with other numbers of the points; those without a number are left out, and polygons that lose one.
    pub fn renumbered(&self, number: impl Fn(usize) -> Option<usize>) -> Self {
        let numbers = |points: &[usize]| -> Option<Vec<usize>> {
            points.iter().map(|&point| number(point)).collect()
        };
        let polygon = |polygon: &Polygon| {
            Some(Polygon {
                corners: numbers(&polygon.corners)?,
                middle_of: numbers(&polygon.middle_of)?,
                off: polygon.off,
            })
        };
        Self {
            polygons: self.polygons.iter().filter_map(polygon).collect(),
            growth: self.growth,
        }
    }

    /// Moves points on the wall (m) to the corners of the polygons.
    pub fn widen(&self, points: &mut [Vec3]) {
        for polygon in &self.polygons {
            let around = &polygon.middle_of;
            let middle = around.iter().map(|&i| points[i]).sum::<Vec3>() / around.len() as f64;
            let middle = middle + polygon.off;
            for &i in &polygon.corners {
                points[i] = middle + (points[i] - middle) * self.growth;
            }
        }
    }

    /// How the points of the O-grid that these polygons are of follow its wall.
    pub fn blend(&self, grid: &PolyMesh, mesh: &FluidMesh) -> MotionBlend {
        let section = CrossSection::new(mesh);
        let slices = grid.points.chunks_exact(section.points());
        let of_slice = |(number, at): (usize, &[Vec3])| {
            let shares = section.shares(at).into_iter();
            shares
                .map(move |shares| (number, shares))
                .collect::<Vec<_>>()
        };
        MotionBlend {
            rings: (self.polygons.iter())
                .map(|polygon| polygon.corners.clone())
                .collect(),
            points: slices.enumerate().flat_map(of_slice).collect(),
        }
    }

    /// The points (m) of the O-grid that these polygons are of, whose wall then goes through the points `on_wall` (m,
    /// by number; those of other points do not matter).
    pub fn fit(&self, grid: &PolyMesh, mesh: &FluidMesh, on_wall: &[Vec3]) -> Vec<Vec3> {
        let mut corners = on_wall.to_vec();
        self.widen(&mut corners);
        let displacement = self
            .blend(grid, mesh)
            .spread(|i| corners[i] - grid.points[i]);
        let points = grid.points.iter().zip(displacement);
        points.map(|(x, u)| x + u).collect()
    }
}

/// What the distance of a polygon's corners from the middle is multiplied by so that it encloses what a round wall
/// does: n/2 r² sin(2π/n) = π r² for a circle of the radius 1.
pub fn growth_of_polygon(around: usize) -> f64 {
    let angle = TAU / around as f64;
    (angle / angle.sin()).sqrt()
}

/// How the points of a mesh follow those of its wall: each goes with the mean of one ring of them, and by shares with
/// what points of it do beyond that.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionBlend {
    /// Points of the wall, ring by ring.
    pub rings: Vec<Vec<usize>>,
    /// For each point of the mesh its ring, and places in it with their shares.
    pub points: Vec<(usize, Vec<(usize, f64)>)>,
}

impl MotionBlend {
    /// Displacement (m) of all points for that of the points of the wall, by number.
    pub fn spread(&self, on_wall: impl Fn(usize) -> Vec3) -> Vec<Vec3> {
        let rings: Vec<(Vec3, Vec<Vec3>)> = (self.rings.iter())
            .map(|ring| {
                let all: Vec<Vec3> = ring.iter().map(|&point| on_wall(point)).collect();
                (all.iter().sum::<Vec3>() / ring.len() as f64, all)
            })
            .collect();
        let of_point = |(ring, shares): &(usize, Vec<(usize, f64)>)| {
            let (mean, all) = &rings[*ring];
            let beyond = shares.iter().map(|&(a, share)| (all[a] - mean) * share);
            mean + beyond.sum::<Vec3>()
        };
        self.points.iter().map(of_point).collect()
    }
}

impl Vessel {
    /// The O-grid of the lumen: patches `inlet`, `outlet`, `wallRigid` and `wallFsi`, in this order. The points of the
    /// walls lie on the lumen's surface (see [`WallPolygons`] for those of a fluid); cells are numbered cross-section
    /// by cross-section, downstream.
    pub fn fluid_mesh(&self, mesh: &FluidMesh) -> PolyMesh {
        let section = CrossSection::new(mesh);
        let line = self.centre_line();
        let spans = self.spans(mesh);
        let mut stations = vec![spans[0].from];
        for span in &spans {
            stations.extend(&equal_stations(span.from, span.to, span.pieces)[1..]);
        }

        let mut points = Vec::with_capacity(stations.len() * section.points());
        for &s in &stations {
            let frame = line.frame(s);
            let plane = section.positions(|phi| self.lumen_radius(s, phi));
            points.extend(plane.into_iter().map(|[y, z]| frame.point(y, z)));
        }

        let (quads, slices) = (section.quads(), stations.len() - 1);
        let order = Layers {
            each: section.points(),
        };
        let at = |slice: usize, point: usize| order.number(slice, point);
        let cells: Vec<[usize; 8]> = (0..slices)
            .flat_map(|slice| quads.iter().map(move |quad| (slice, quad)))
            .map(|(slice, quad)| std::array::from_fn(|v| at(slice + v / 4, quad[v % 4])))
            .collect();
        let cap = |slice: usize| (quads.iter().map(|quad| quad.map(|p| at(slice, p)))).collect();
        let ring = |slice, a| at(slice, section.ring_point(mesh.radial, a));
        let wall = |slices: &[usize]| {
            (slices.iter())
                .flat_map(|&slice| (0..section.around()).map(move |a| (slice, slice + 1, a, a + 1)))
                .map(|(s, t, a, b)| [ring(s, a), ring(s, b), ring(t, b), ring(t, a)])
                .collect()
        };
        let elastic = elastic_pieces(&spans);
        let (elastic, rigid): (Vec<usize>, Vec<usize>) =
            (0..slices).partition(|slice| elastic.contains(slice));
        let patches = [
            ("inlet", "patch", cap(0)),
            ("outlet", "patch", cap(slices)),
            ("wallRigid", "wall", wall(&rigid)),
            ("wallFsi", "wall", wall(&elastic)),
        ];
        let patches = patches.map(|(name, kind, faces)| PatchFaces { name, kind, faces });
        PolyMesh::from_hexes(points, &cells, &patches)
    }
}

/// Corners (y and z, m) of the cells of a cross-section whose lumen has the radius `radius(φ)` (m).
pub fn section_quads(mesh: &FluidMesh, radius: impl Fn(f64) -> f64) -> Vec<[[f64; 2]; 4]> {
    let section = CrossSection::new(mesh);
    let at = section.positions(radius);
    let quads = section.quads().into_iter();
    quads.map(|quad| quad.map(|point| at[point])).collect()
}

/// Those of the pieces of `spans`, counted downstream, with an elastic wall.
pub fn elastic_pieces(spans: &[Span]) -> Range<usize> {
    let pieces = |of: &[Span]| of.iter().map(|span| span.pieces).sum::<usize>();
    let first = spans.iter().position(|span| span.is_elastic).unwrap_or(0);
    let last = spans
        .iter()
        .rposition(|span| span.is_elastic)
        .map_or(first, |last| last + 1);
    let start = pieces(&spans[..first]);
    start..start + pieces(&spans[first..last])
}

/// The O-grid of a case's lumen; see [`Vessel::fluid_mesh`].
pub fn fluid_mesh(vessel: &BloodVessel) -> PolyMesh {
    Vessel::new(vessel).fluid_mesh(&vessel.fluid.mesh)
}
