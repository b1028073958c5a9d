//! A branch at the side of another one, thin beside it: its O-grid stands on a patch of the other's wall.
//!
//! The patch is as many faces along the parent as around it as the square of a cross-section has, and the columns of
//! the rings below it are taken out. In the hole the branch's O-grid goes on as a plug, and ends as a bowl: its rings
//! are four sides and, bent around, the bottom; the square stays above that. So the wall's points at the corners of the
//! patch have five faces around them, and everything else is as in a tube.

use super::error::TreeError;
use super::junction::{BranchEnd, Slicer, across};
use super::section::{CrossSection, SectionGrid};
use crate::Vec3;
use crate::curve::CentreLine;
use std::f64::consts::{FRAC_PI_4, PI};

/// Distances of the patch's border from the branch's line that are tried, in radii of the branch: the first one at
/// which the lumen ends within so many radii of the parent's.
const FOOT: [f64; 4] = [1.15, 1.25, 1.35, 1.5];
const ABOVE: f64 = 0.6;
/// Length of the parent between the patch and plane cross-sections, in radii of the parent.
const BESIDE: f64 = 0.8;
/// How far the cross-sections of the patch spread on the parent's other side, relative to that of a tube.
const SPREAD: f64 = 0.8;
/// How much the core of the parent's cross-sections stays in that of a tube.
const UPRIGHT: f64 = 0.35;
/// Where their middles lie between the parent's other side (0) and the patch (1).
const NEAR: f64 = 0.9;
/// Height of the bowl's bottom, as a share of the plug's height and of its width at most.
const BOTTOM: [f64; 2] = [0.45, 0.5];
/// Plane cross-sections of the branch begin so far from the patch, in radii of the branch.
const CUT: f64 = 1.0;
/// The smallest sine of the angle between the branch and the parent.
const LEAST_SINE: f64 = 0.4;

/// Where a thin branch begins.
#[derive(Debug, Clone)]
pub struct Side {
    /// On the parent's line, m.
    pub centre: Vec3,
    /// Unit vector from there towards the branch, across the parent.
    pub axis: Vec3,
    /// Unit vector along the parent, across the branch.
    pub flow: Vec3,
    /// The parent, upstream.
    pub parent: BranchEnd,
    /// The parent, downstream, and the branch.
    pub daughters: [BranchEnd; 2],
    /// Cross-sections of the parent from the first one that is not plane to the first one that is again. Their rims
    /// count from `axis` on.
    pub sections: Vec<CrossSection>,
    /// Which of these is the first one of the patch.
    pub first: usize,
}

/// A hole in the rings of a branch, where a side branch begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hole {
    /// Number of the first cross-section.
    pub first: usize,
    /// Point of the rims in the middle of the hole.
    pub middle: usize,
}

/// The border of a hole from its middle, along the parent and around it, point by point of the branch's rim.
pub fn border(n: usize) -> impl Iterator<Item = (isize, isize)> {
    let (n, h) = (n as isize, n as isize / 2);
    (0..4 * n).map(move |b| match (b + h) / n {
        0 => (h, -b),
        1 => (n - b, -h),
        2 => (-h, b - 2 * n),
        3 => (b - 3 * n, h),
        _ => (h, 4 * n - b),
    })
}

/// Positions within a hole from those on its border: Coons' transfinite interpolation. `at` is by place from 0 to n
/// along the parent and around it.
pub fn coons(grid: &SectionGrid, i: usize, j: usize, at: impl Fn(usize, usize) -> Vec3) -> Vec3 {
    let n = grid.core;
    let [s, t] = [grid.place(i), grid.place(j)];
    let sides = at(i, 0) * (1.0 - t) + at(i, n) * t + at(0, j) * (1.0 - s) + at(n, j) * s;
    let corners = (at(0, 0) * (1.0 - t) + at(0, n) * t) * (1.0 - s)
        + (at(n, 0) * (1.0 - t) + at(n, n) * t) * s;
    sides - corners
}

/// The cross-section of a plug that goes through points of its parent, handed out by place from the middle of the hole
/// and ring.
pub fn plug(
    grid: &SectionGrid,
    ring: usize,
    at: impl Fn((isize, isize), usize) -> Vec3,
) -> CrossSection {
    let t = if ring == 0 { 0.0 } else { grid.rings[ring - 1] };
    let middle = |ring: usize| at((0, 0), ring);
    let depth = middle(grid.rings.len()) - middle(0);
    let widths = border(grid.core).map(|place| (at(place, 0) - middle(0)).norm());
    let [of_height, of_width] = BOTTOM;
    let bottom = (of_height * depth.norm()).min(of_width * widths.fold(f64::INFINITY, f64::min));
    CrossSection {
        lift: depth.normalize() * (bottom * (1.0 - t)),
        ..CrossSection::new(
            middle(ring),
            border(grid.core).map(|place| at(place, ring)).collect(),
        )
    }
}

/// The wall of the parent by arc length (m) and angle (rad) from the branch.
struct Around<'a> {
    slicer: &'a Slicer,
    path: &'a CentreLine,
    axis: Vec3,
}

impl Around<'_> {
    /// Centre, and unit vectors towards the angle 0 and a quarter of a turn further.
    fn frame(&self, s: f64) -> (Vec3, Vec3, Vec3) {
        let tangent = self.path.tangent(s);
        let first = across(&self.axis, &tangent);
        (self.path.at(s), first, tangent.cross(&first))
    }

    fn point(&self, [s, phi]: [f64; 2]) -> Result<Vec3, TreeError> {
        let (centre, first, second) = self.frame(s);
        let direction = first * phi.cos() + second * phi.sin();
        let wall = self.slicer.lumen.near(&centre).wall(&centre, &direction);
        wall.ok_or(TreeError::Open(centre))
    }

    fn place(&self, x: &Vec3) -> [f64; 2] {
        let s = self.path.foot(x).s;
        let (centre, first, second) = self.frame(s);
        let arm = x - centre;
        [s, arm.dot(&second).atan2(arm.dot(&first))]
    }
}

impl Side {
    /// The line `branch` on the side of `path`, which `line` is one of.
    ///
    /// # Errors
    /// If it leaves at an angle that is too small, or the surface is open there.
    pub fn new(
        slicer: &Slicer,
        path: &CentreLine,
        line: usize,
        branch: usize,
    ) -> Result<Self, TreeError> {
        let lumen = &slicer.lumen;
        let grid = &slicer.grid;
        let (n, h) = (grid.core, grid.core / 2);
        let thin = &lumen.lines[branch];
        let exit = thin
            .leaves(path)
            .ok_or_else(|| TreeError::Apex(thin.at(thin.length())))?;
        let out = thin.at(exit);
        // Lines become thin on the way.
        let r = neck(thin, exit).max(thin.radius(exit));
        let along = thin.tangent(exit + r);
        let s = path.foot(&out).s;
        let (centre, flow) = (path.at(s), path.tangent(s));
        let axis = across(&(out - centre), &flow);
        let sine = axis.dot(&along);
        if sine < LEAST_SINE {
            return Err(TreeError::Angle(out));
        }
        let around = Around { slicer, path, axis };
        // The patch's border, on rays along the branch.
        let first = across(&flow, &along);
        let second = along.cross(&first);
        let on_border = |b: usize, off: f64| {
            let (sin, cos) = grid.angle(b).sin_cos();
            let beside = out + (first * cos + second * sin) * off;
            let from = beside - along * ((beside - centre).dot(&axis) / sine);
            let wall = lumen.near(&from).wall(&from, &along)?;
            let foot = path.foot(&wall);
            (foot.distance - foot.radius < ABOVE * r).then_some(wall)
        };
        let all_around =
            |off: f64| -> Option<Vec<Vec3>> { (0..4 * n).map(|b| on_border(b, off * r)).collect() };
        let found = FOOT.iter().find_map(|off| Some((*off, all_around(*off)?)));
        let (off, on_border) = found.ok_or(TreeError::Neck(out))?;
        let mut foot = vec![Vec3::zeros(); (n + 1) * (n + 1)];
        let at = |i: usize, j: usize| i + (n + 1) * j;
        for ((i, j), x) in border(n).zip(on_border) {
            let [i, j] = [i, j].map(|k| (k + h as isize) as usize);
            foot[at(i, j)] = x;
        }
        let places: Vec<[f64; 2]> = foot.iter().map(|x| around.place(x)).collect();
        let all = border(n).map(|(i, j)| {
            let [i, j] = [i, j].map(|k| (k + h as isize) as usize);
            places[at(i, j)][0]
        });
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| {
            (low.min(s), high.max(s))
        });
        let radius = path.radius(s);
        let middle = 0.5 * (low + high);
        let elements = (n / grid.degree()) as f64;
        let width = (0.55 * (high - low)).max(0.5 * SPREAD * elements * slicer.along * radius);
        let beside = BESIDE * radius;
        let reach = width.max(0.5 * (high - low)) + beside;
        let [begin, end] = [middle - reach, middle + reach];
        // Arc length and angle of each point, row by row: `a` counts from the branch, up to half a turn both ways.
        let signed = |a: usize| match a > 2 * n {
            true => (4 * n - a, -1.0),
            false => (a, 1.0),
        };
        let plane = |s: f64| -> Vec<[f64; 2]> {
            let of = |a: usize| {
                let (a, side) = signed(a);
                [s, side * grid.angle(a)]
            };
            (0..4 * n).map(of).collect()
        };
        let row = |i: usize| -> Vec<[f64; 2]> {
            let far = middle + width * (2.0 * grid.place(i) - 1.0);
            let of = |a: usize| {
                let (a, side) = signed(a);
                if a <= h {
                    return match side > 0.0 {
                        true => places[at(i, h + a)],
                        false => places[at(i, h - a)],
                    };
                }
                let edge = places[at(i, if side > 0.0 { n } else { 0 })];
                let u = (grid.angle(a) - FRAC_PI_4) / (PI - FRAC_PI_4);
                lerp(edge, [far, side * PI], u)
            };
            (0..4 * n).map(of).collect()
        };
        let mean = |i: usize| {
            let u = grid.place(i);
            let near = places[at(0, h)][0] * (1.0 - u) + places[at(n, h)][0] * u;
            near * NEAR + (middle + width * (2.0 * u - 1.0)) * (1.0 - NEAR)
        };
        let between = grid.divided(beside / (slicer.along * radius));
        let mut rows: Vec<(f64, Vec<[f64; 2]>)> = Vec::new();
        let blend = |from: &(f64, Vec<[f64; 2]>), to: &(f64, Vec<[f64; 2]>), u: f64| {
            let pairs = from.1.iter().zip(&to.1);
            (
                from.0 * (1.0 - u) + to.0 * u,
                pairs.map(|(a, b)| lerp(*a, *b, u)).collect::<Vec<_>>(),
            )
        };
        let patch: Vec<(f64, Vec<[f64; 2]>)> = (0..=n).map(|i| (mean(i), row(i))).collect();
        let [upstream, downstream] = [begin, end].map(|s| (s, plane(s)));
        let inner = &between[1..between.len() - 1];
        rows.extend(inner.iter().map(|&u| blend(&upstream, &patch[0], u)));
        let first_row = rows.len();
        rows.extend(patch.iter().cloned());
        rows.extend(inner.iter().map(|&u| blend(&patch[n], &downstream, u)));
        rows.push(downstream);
        let mut sections = Vec::with_capacity(rows.len());
        for (number, (s, row)) in rows.iter().enumerate() {
            let i = number.checked_sub(first_row).filter(|i| *i <= n);
            let rim = (0..4 * n).map(|a| {
                let (off, side) = signed(a);
                match i {
                    Some(i) if off <= h => {
                        let j = if side > 0.0 { h + off } else { h - off };
                        let is_inside = i > 0 && i < n && off < h;
                        Ok(match is_inside {
                            true => coons(grid, i, j, |i, j| foot[at(i, j)]),
                            false => foot[at(i, j)],
                        })
                    }
                    _ => around.point(row[a]),
                }
            });
            let rim: Vec<Vec3> = rim.collect::<Result<_, _>>()?;
            let (centre, first, second) = around.frame(*s);
            let mut section = CrossSection::new(centre, rim);
            if number + 1 < rows.len() {
                let far = (n..=3 * n).map(|a| (section.rim[a] - centre).norm());
                let radius = far.sum::<f64>() / (2 * n + 1) as f64;
                let inner = (section.rim.iter().enumerate()).map(|(a, x)| {
                    let (sin, cos) = grid.angle(a).sin_cos();
                    let round = (first * cos + second * sin) * radius;
                    (x - centre) * (1.0 - UPRIGHT) + round * UPRIGHT
                });
                section.inner = Some(inner.collect());
            }
            sections.push(section);
        }
        let slope = along.dot(&flow).abs() / sine;
        Ok(Self {
            centre,
            axis,
            flow: first,
            parent: BranchEnd {
                line,
                cut: path.at(begin),
            },
            daughters: [
                BranchEnd {
                    line,
                    cut: path.at(end),
                },
                BranchEnd {
                    line: branch,
                    cut: thin.at(exit + r * (CUT + off * slope)),
                },
            ],
            sections,
            first: first_row,
        })
    }
}

/// The smallest radius (m) of a line within a radius after it left another one.
pub fn neck(thin: &CentreLine, exit: f64) -> f64 {
    let end = exit + thin.radius(exit);
    let all = thin.places().filter(|s| (exit..end).contains(s));
    all.map(|s| thin.radius(s)).fold(thin.radius(end), f64::min)
}

fn lerp(from: [f64; 2], to: [f64; 2], u: f64) -> [f64; 2] {
    [0, 1].map(|k| from[k] * (1.0 - u) + to[k] * u)
}
