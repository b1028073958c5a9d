//! A cross-section of a branch, plane or folded: an O-grid of four quadrants.
//!
//! A quadrant depends on the centre and on its own quarter of the rim alone. So cross-sections that are folded along a
//! line through their centre share the half on one side of it with one neighbour and the other half with another, which
//! is how the branches of a tree meet.

use crate::Vec3;
use crate::geometry::o_grid::{BULGE, CORNER, growth_of_polygon, ring_point, rings};
use fsi_numerics::{lagrange, subdivided};
use nalgebra::UnitQuaternion;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

/// A cross-section: its centre and points of the wall around it (m), from the middle of one side of the core on.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSection {
    /// Centre.
    pub centre: Vec3,
    /// Points of the wall, counter-clockwise about the flow.
    pub rim: Vec<Vec3>,
    /// From the centre, the directions of the core's points with the wall's distances, where those to the wall's points
    /// would distort it.
    pub inner: Option<Vec<Vec3>>,
    /// Where the core lies from there, the rings less and less: a cross-section that is a bowl.
    pub lift: Vec3,
}

impl CrossSection {
    /// One whose core lies in the directions of the wall's points.
    pub fn new(centre: Vec3, rim: Vec<Vec3>) -> Self {
        Self {
            centre,
            rim,
            inner: None,
            lift: Vec3::zeros(),
        }
    }

    /// The same one at another centre, turned from the first direction (a unit vector across it) to the second.
    pub fn moved(&self, centre: Vec3, [from, to]: [&Vec3; 2]) -> Self {
        // Rotation3 would be no number where rounding makes the cosine of equal directions more than 1.
        let turn = UnitQuaternion::rotation_between(from, to).unwrap_or_default();
        let rim = self.rim.iter();
        Self::new(
            centre,
            rim.map(|x| centre + turn * (x - self.centre)).collect(),
        )
    }
}

/// What a cross-section is divided into: cells, or elements and their nodes.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionGrid {
    /// Intervals between points along a side of the core, an even number.
    pub core: usize,
    /// Places of the points from the middle of a side (0) to its end (1).
    half_side: Vec<f64>,
    /// Distance from the core (0) to the wall (1) of the rings' points.
    pub rings: Vec<f64>,
    /// Where the nodes of an element lie in [-1, 1]; those of a cell are its ends.
    nodes: Vec<f64>,
    /// Derivatives of the nodal functions at each node.
    slopes: Vec<Vec<f64>>,
    /// The number of elements along a branch is a multiple of this.
    group: usize,
}

impl SectionGrid {
    /// Cells. Rings grow thinner towards the wall: the innermost is `grading` times as thick as that at the wall.
    /// Along a branch lie a multiple of half as many as along a side of the core, so that the wall's faces can be
    /// grouped into elements, eight of them around.
    pub fn of_cells(core: usize, radial: usize, grading: f64) -> Self {
        Self {
            group: core / 2,
            ..Self::of_elements(core, radial, grading, &[-1.0, 1.0])
        }
    }

    /// Elements whose nodes lie at `nodes` in [-1, 1].
    pub fn of_elements(core: usize, radial: usize, grading: f64, nodes: &[f64]) -> Self {
        assert!(
            core.is_multiple_of(2) && core > 0 && radial > 0,
            "an even core, one ring"
        );
        let mut points = Vec::new();
        let mut from = 0.0;
        for to in rings(radial, grading) {
            let within = subdivided(1, nodes).into_iter().skip(1);
            points.extend(within.map(|t| if t == 1.0 { to } else { from + (to - from) * t }));
            from = to;
        }
        Self {
            core: core * (nodes.len() - 1),
            half_side: subdivided(core / 2, nodes),
            rings: points,
            nodes: nodes.to_vec(),
            slopes: nodes
                .iter()
                .map(|x| lagrange::derivatives(nodes, *x))
                .collect(),
            group: 1,
        }
    }

    /// Intervals between points along each direction of an element: its degree.
    pub fn degree(&self) -> usize {
        self.nodes.len() - 1
    }

    /// Places from 0 to 1 of the points along what is so many elements long.
    pub fn divided(&self, elements: f64) -> Vec<f64> {
        let pieces = self.group * (elements / self.group as f64).round().max(1.0) as usize;
        subdivided(pieces, &self.nodes)
    }

    /// Angle (rad) of point `a` around.
    pub fn angle(&self, a: usize) -> f64 {
        let half = self.core / 2;
        let (eighth, i) = (a / half, a % half);
        // Points lie symmetrically within a half.
        (eighth as f64 + self.half_side[i]) * FRAC_PI_4
    }

    /// Points around.
    pub fn around(&self) -> usize {
        4 * self.core
    }

    /// Points of a cross-section.
    pub fn points(&self) -> usize {
        (self.core + 1).pow(2) + self.around() * self.rings.len()
    }

    /// Point of the core, counted from its corner at -135° along its sides.
    pub fn core_point(&self, i: usize, j: usize) -> usize {
        j * (self.core + 1) + i
    }

    /// Point `a` around the core (ring 0) or a ring, counter-clockwise from the middle of the side i = core.
    pub fn ring_point(&self, ring: usize, a: usize) -> usize {
        match ring {
            // The border of the core is numbered from its corner on.
            0 => ring_point(self.core, ring, a + self.core / 2),
            _ => ring_point(self.core, ring, a),
        }
    }

    /// Place from 0 to 1 of a point along a side of the core.
    pub fn place(&self, i: usize) -> f64 {
        let h = self.core / 2;
        match i < h {
            true => 0.5 - 0.5 * self.half_side[h - i],
            false => 0.5 + 0.5 * self.half_side[i - h],
        }
    }

    /// Share of a point of the rim in the mean over the angle.
    pub fn share(&self, a: usize) -> f64 {
        let n = self.around();
        let (from, to) = (self.angle((a + n - 1) % n), self.angle((a + 1) % n));
        0.5 * (to - from).rem_euclid(TAU) / TAU
    }

    /// Which point around the core one of its points is, if it lies on its border.
    pub fn around_core(&self, i: usize, j: usize) -> Option<usize> {
        let n = self.core;
        let from_corner = match (i, j) {
            (i, j) if i == n => j,
            (i, j) if j == n => n + n - i,
            (0, j) => 2 * n + n - j,
            (i, 0) => 3 * n + i,
            _ => return None,
        };
        Some((from_corner + self.around() - n / 2) % self.around())
    }

    /// Points of a cross-section that are the nodes of each element in it, fastest along ξ, which points outward in the
    /// rings; η turns counter-clockwise about the flow.
    pub fn elements(&self) -> Vec<Vec<usize>> {
        let degree = self.degree();
        let core = self.core / degree;
        let nodes = |at: &dyn Fn(usize, usize) -> usize| -> Vec<usize> {
            let n = degree + 1;
            (0..n * n).map(|k| at(k % n, k / n)).collect()
        };
        let mut quads = Vec::new();
        for element in 0..core * core {
            let (x, y) = (element % core * degree, element / core * degree);
            quads.push(nodes(&|i, j| self.core_point(x + i, y + j)));
        }
        for element in 0..self.rings.len() / degree * 4 * core {
            let (ring, a) = (element / (4 * core) * degree, element % (4 * core) * degree);
            quads.push(nodes(&|i, j| self.ring_point(ring + i, a + j)));
        }
        quads
    }

    /// Points of each cell, counter-clockwise.
    pub fn quads(&self) -> Vec<[usize; 4]> {
        let n = self.core;
        let core = (0..n * n).map(|cell| {
            let (i, j) = (cell % n, cell / n);
            [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.core_point(i, j))
        });
        let rings = (0..self.rings.len() * self.around()).map(|cell| {
            let (ring, a) = (cell / self.around(), cell % self.around());
            [(ring, a), (ring + 1, a), (ring + 1, a + 1), (ring, a + 1)]
                .map(|(ring, a)| self.ring_point(ring, a))
        });
        core.chain(rings).collect()
    }

    /// The smallest scaled Jacobian at a node of an element (the triple product of unit vectors along its axes), and
    /// where that is (m); of a cell, at its corners. The nodes' positions (m) are given fastest along ξ.
    pub fn quality(&self, x: &[Vec3]) -> (f64, Vec3) {
        let (worst, node) = lagrange::worst_scaled_jacobian(&self.slopes, x);
        (worst, x[node])
    }

    /// See [`growth_of_polygon`].
    pub fn growth_of_polygon(&self) -> f64 {
        growth_of_polygon(self.around())
    }

    /// Positions (m) of all points of a cross-section whose rim's distances from the centre are multiplied by `growth`.
    pub fn positions(&self, section: &CrossSection, growth: f64) -> Vec<Vec3> {
        let centre = section.centre;
        let arms = section.rim.iter().map(|x| (x - centre) * growth);
        let mut at = vec![centre + section.lift; self.points()];
        for (a, arm) in arms.enumerate() {
            let from_middle = self.angle(a) - FRAC_PI_2 * (self.angle(a) / FRAC_PI_2).round();
            let straight = FRAC_PI_4.cos() / from_middle.cos();
            let core = CORNER * ((1.0 - BULGE) * straight + BULGE);
            for ring in 0..=self.rings.len() {
                let t = if ring == 0 { 0.0 } else { self.rings[ring - 1] };
                at[self.ring_point(ring, a)] = match &section.inner {
                    None => centre + arm * (core * (1.0 - t) + t) + section.lift * (1.0 - t),
                    Some(inner) => {
                        let of_core = inner[a] * (growth * core) + section.lift;
                        centre + of_core * (1.0 - t) + arm * t
                    }
                };
            }
        }
        for quadrant in 0..4 {
            self.fill(quadrant, &mut at);
        }
        at
    }

    /// Core points of a quadrant: Coons' transfinite interpolation between its two sides on the core's border and the
    /// two straight ones to the centre.
    fn fill(&self, quadrant: usize, at: &mut [Vec3]) {
        let h = self.core / 2;
        // In the first quadrant, i and j count from the centre towards the points 0 and `core` of the rim.
        let point = |i: usize, j: usize| {
            let (x, y) = match quadrant {
                0 => (h + i, h + j),
                1 => (h - j, h + i),
                2 => (h - i, h - j),
                _ => (h + j, h - i),
            };
            self.core_point(x, y)
        };
        let centre = at[point(0, 0)];
        for k in 1..h {
            let t = self.half_side[k];
            at[point(k, 0)] = centre + (at[point(h, 0)] - centre) * t;
            at[point(0, k)] = centre + (at[point(0, h)] - centre) * t;
        }
        for j in 1..h {
            for i in 1..h {
                let [s, t] = [i, j].map(|k| self.half_side[k]);
                let p = |i: usize, j: usize| at[point(i, j)];
                let sides = p(i, 0) * (1.0 - t) + p(i, h) * t + p(0, j) * (1.0 - s) + p(h, j) * s;
                let corners = (p(0, 0) * (1.0 - t) + p(0, h) * t) * (1.0 - s)
                    + (p(h, 0) * (1.0 - t) + p(h, h) * t) * s;
                at[point(i, j)] = sides - corners;
            }
        }
    }
}

/// The smallest scaled Jacobian of the cells or elements between consecutive cross-sections; if that is less than
/// `least`, the first such one.
pub fn worst_between(grid: &SectionGrid, sections: &[CrossSection], least: f64) -> f64 {
    let quads = grid.elements();
    let growth = match grid.degree() {
        1 => grid.growth_of_polygon(),
        _ => 1.0,
    };
    let points: Vec<Vec<Vec3>> = sections
        .iter()
        .map(|section| grid.positions(section, growth))
        .collect();
    let mut worst = f64::INFINITY;
    for first in (0..sections.len() - 1).step_by(grid.degree()) {
        let rows = &points[first..=first + grid.degree()];
        for quad in &quads {
            let at = rows.iter().flat_map(|row| quad.iter().map(|&i| row[i]));
            worst = worst.min(grid.quality(&at.collect::<Vec<Vec3>>()).0);
            if worst < least {
                return worst;
            }
        }
    }
    worst
}
