//! A branch at the side of another one, thin beside it: its O-grid stands on a patch of the other's wall.
//!
//! The patch is as many faces along the parent as around it as the square of a cross-section has, and the columns of
//! the rings below it are taken out. In the hole the branch's O-grid goes on as a plug, and ends as a bowl: its rings
//! are four sides and, bent around, the bottom; the square stays above that. So the wall's points at the corners of the
//! patch have five faces around them, and everything else is as in a tube.

use super::error::TreeError;
use super::junction::BranchEnd;
use super::section::{CrossSection, SectionGrid};
use super::shape::Shape;
use super::slicer::{Slicer, across};
use crate::Vec3;
use crate::curve::CentreLine;
use std::f64::consts::{FRAC_PI_4, PI};

/// Distances of the patch's border from the branch's line that are tried, in radii of the branch: the first one at
/// which the lumen ends within so many radii of the parent's.
const FOOT: [f64; 4] = [1.15, 1.25, 1.35, 1.5];
const ABOVE: f64 = 0.6;
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
    /// How it stands on the parent.
    pub shape: Shape,
}

/// A hole in the rings of a branch, where a side branch begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hole {
    /// Number of the first cross-section.
    pub first: usize,
    /// Point of the rims in the middle of the hole.
    pub middle: usize,
    /// How the branch stands there.
    pub shape: Shape,
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
    shape: &Shape,
    ring: usize,
    at: impl Fn((isize, isize), usize) -> Vec3,
) -> CrossSection {
    let t = if ring == 0 { 0.0 } else { grid.rings[ring - 1] };
    let outer = grid.rings.len();
    let middle = |ring: usize| at((0, 0), ring);
    let depth = middle(outer) - middle(0);
    let up = depth.normalize();
    let widths = border(grid.core).map(|place| (at(place, 0) - middle(0)).norm());
    let [of_height, of_width] = shape.bottom;
    let bottom = (of_height * depth.norm()).min(of_width * widths.fold(f64::INFINITY, f64::min));
    let centre = middle(ring);
    let rim: Vec<Vec3> = border(grid.core).map(|place| at(place, ring)).collect();
    let tilted = |tilt: f64| {
        let end = grid.core as isize / 2;
        let along = at((end, 0), outer) - at((-end, 0), outer);
        let level = along - up * up.dot(&along);
        let slope = up * (tilt * t * up.dot(&along) / level.norm_squared());
        let arms = rim.iter().map(|x| x - centre);
        arms.map(|arm| arm + slope * arm.dot(&level)).collect()
    };
    CrossSection {
        inner: (shape.tilt != 0.0).then(|| tilted(shape.tilt)),
        lift: up * (bottom * (1.0 - t)),
        ..CrossSection::new(centre, rim)
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

/// Where a branch leaves another one.
struct Exit<'a> {
    thin: &'a CentreLine,
    /// Arc length (m) on its line where that leaves the other's lumen, and the place.
    exit: f64,
    out: Vec3,
    /// Its radius there, m: lines become thin on the way.
    radius: f64,
    /// Unit vector along it.
    along: Vec3,
    /// Arc length (m) on the parent's line, the place, and the unit vectors along it and across it to the branch.
    s: f64,
    centre: Vec3,
    flow: Vec3,
    axis: Vec3,
    /// Sine of the angle between the branch and the parent.
    sine: f64,
}

impl<'a> Exit<'a> {
    fn new(thin: &'a CentreLine, path: &CentreLine) -> Result<Self, TreeError> {
        let exit = thin
            .leaves(path)
            .ok_or_else(|| TreeError::Apex(thin.at(thin.length())))?;
        let out = thin.at(exit);
        let radius = neck(thin, exit).max(thin.radius(exit));
        let along = thin.tangent(exit + radius);
        let s = path.foot(&out).s;
        let (centre, flow) = (path.at(s), path.tangent(s));
        let axis = across(&(out - centre), &flow);
        let sine = axis.dot(&along);
        if sine < LEAST_SINE {
            return Err(TreeError::Angle(out));
        }
        Ok(Self {
            thin,
            exit,
            out,
            radius,
            along,
            s,
            centre,
            flow,
            axis,
            sine,
        })
    }

    /// Unit vectors across the branch: along the parent, and around it.
    fn frame(&self) -> [Vec3; 2] {
        let first = across(&self.flow, &self.along);
        [first, self.along.cross(&first)]
    }

    /// The border of the patch on rays along the branch, and how far it is from the branch's line, in radii of that.
    fn border(
        &self,
        slicer: &Slicer,
        path: &CentreLine,
        shape: &Shape,
    ) -> Result<(f64, Vec<Vec3>), TreeError> {
        let (grid, r) = (&slicer.grid, self.radius);
        let [first, second] = self.frame();
        let point = |b: usize, off: f64| {
            let (sin, cos) = grid.angle(b).sin_cos();
            let along = shape.long * cos + shape.ahead;
            let beside = self.out + (first * along + second * sin) * off;
            let from = beside - self.along * ((beside - self.centre).dot(&self.axis) / self.sine);
            let wall = slicer.lumen.near(&from).wall(&from, &self.along)?;
            let foot = path.foot(&wall);
            let is_low = foot.distance - foot.radius < ABOVE * r;
            is_low.then(|| self.climbed(wall, slicer, shape.climb))?
        };
        let all_around = |off: f64| -> Option<Vec<Vec3>> {
            (0..4 * grid.core).map(|b| point(b, off * r)).collect()
        };
        let mut all = FOOT.iter().map(|off| off * shape.foot);
        let found = all.find_map(|off| Some((off, all_around(off)?)));
        found.ok_or(TreeError::Neck(self.out))
    }

    /// A point of the border further along the branch, the more the less sharply the branch leaves there: so the patch
    /// is less inclined to the branch.
    fn climbed(&self, x: Vec3, slicer: &Slicer, climb: f64) -> Option<Vec3> {
        if climb == 0.0 {
            return Some(x);
        }
        let [first, _] = self.frame();
        let s = (x - self.out).dot(&self.along);
        let arm = x - self.out - self.along * s;
        let slope = self.slope();
        let less_sharply = slope.abs() - slope * arm.dot(&first) / arm.norm();
        let beside = self.out + self.along * (s + climb * self.radius * less_sharply);
        slicer.lumen.near(&beside).wall(&beside, &arm.normalize())
    }

    /// Cotangent of the angle between the branch and the parent downstream.
    fn slope(&self) -> f64 {
        self.along.dot(&self.flow) / self.sine
    }
}

/// A cross-section of the parent before it is cut: arc length (m) of its centre, and arc length (m) and angle (rad) of
/// the points of its rim, which count from the branch.
#[derive(Clone)]
struct Row {
    s: f64,
    rim: Vec<[f64; 2]>,
}

impl Row {
    fn blended(from: &Self, to: &Self, u: f64) -> Self {
        let pairs = from.rim.iter().zip(&to.rim);
        Self {
            s: from.s * (1.0 - u) + to.s * u,
            rim: pairs.map(|(a, b)| lerp(*a, *b, u)).collect(),
        }
    }
}

/// The patch of the parent's wall on which a branch stands, with the cross-sections that go through it.
struct Patch<'a> {
    around: Around<'a>,
    /// Points on its border by [`Patch::index`]; those within are not set.
    points: Vec<Vec3>,
    /// Arc length (m) and angle (rad) of each.
    places: Vec<[f64; 2]>,
    /// Arc length of its middle, m.
    middle: f64,
    /// Half its length, m, and that which it has on the parent's other side.
    half: f64,
    width: f64,
    /// How far it lies further back there, m.
    back: f64,
    shape: &'a Shape,
}

impl<'a> Patch<'a> {
    fn new(around: Around<'a>, shape: &'a Shape, exit: &Exit, on_border: Vec<Vec3>) -> Self {
        let slicer = around.slicer;
        let radius = around.path.radius(exit.s);
        let grid = &slicer.grid;
        let n = grid.core;
        let mut points = vec![Vec3::zeros(); (n + 1) * (n + 1)];
        let mut numbers = Vec::with_capacity(4 * n);
        for ((i, j), x) in border(n).zip(on_border) {
            let [i, j] = [i, j].map(|k| (k + (n / 2) as isize) as usize);
            numbers.push(i + (n + 1) * j);
            points[i + (n + 1) * j] = x;
        }
        let places: Vec<[f64; 2]> = points.iter().map(|x| around.place(x)).collect();
        let all = numbers.iter().map(|&number| places[number][0]);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), s| {
            (low.min(s), high.max(s))
        });
        let elements = (n / grid.degree()) as f64;
        Self {
            around,
            points,
            places,
            middle: 0.5 * (low + high),
            half: 0.5 * (high - low),
            width: (0.55 * (high - low)).max(0.5 * shape.spread * elements * slicer.along * radius),
            back: shape.back * radius * exit.slope(),
            shape,
        }
    }

    fn grid(&self) -> &'a SectionGrid {
        &self.around.slicer.grid
    }

    /// Number of the point at a place from 0 to n along the parent and around it.
    fn index(&self, i: usize, j: usize) -> usize {
        i + (self.grid().core + 1) * j
    }

    /// How far a point of a rim is from the branch, and on which side.
    fn signed(&self, a: usize) -> (usize, f64) {
        let n = self.grid().core;
        match a > 2 * n {
            true => (4 * n - a, -1.0),
            false => (a, 1.0),
        }
    }

    /// A plane cross-section.
    fn plane(&self, s: f64) -> Row {
        let of = |a: usize| {
            let (a, side) = self.signed(a);
            [s, side * self.grid().angle(a)]
        };
        let rim = (0..4 * self.grid().core).map(of).collect();
        Row { s, rim }
    }

    /// A cross-section of the patch.
    fn row(&self, i: usize) -> Row {
        let grid = self.grid();
        let (n, h) = (grid.core, grid.core / 2);
        let place = |j: usize| self.places[self.index(i, j)];
        let u = grid.place(i);
        let far = self.middle + self.width * (2.0 * u - 1.0) - self.back;
        let of = |a: usize| {
            let (a, side) = self.signed(a);
            if a <= h {
                return match side > 0.0 {
                    true => place(h + a),
                    false => place(h - a),
                };
            }
            let edge = place(if side > 0.0 { n } else { 0 });
            let u = (grid.angle(a) - FRAC_PI_4) / (PI - FRAC_PI_4);
            lerp(edge, [far, side * PI], u)
        };
        let [first, last] = [0, n].map(|i| self.places[self.index(i, h)][0]);
        let near = first * (1.0 - u) + last * u;
        Row {
            s: near * self.shape.near + far * (1.0 - self.shape.near),
            rim: (0..4 * n).map(of).collect(),
        }
    }

    /// All cross-sections but the first plane one, whose arc length is `begin`, up to the plane one at `end`; and which
    /// is the first one of the patch.
    fn rows(&self, [begin, end]: [f64; 2], between: &[f64]) -> (Vec<Row>, usize) {
        let n = self.grid().core;
        let patch: Vec<Row> = (0..=n).map(|i| self.row(i)).collect();
        let [upstream, downstream] = [begin, end].map(|s| self.plane(s));
        let inner = &between[1..between.len() - 1];
        let to_patch = (inner.iter()).map(|&u| Row::blended(&upstream, &patch[0], u));
        let from_patch = (inner.iter()).map(|&u| Row::blended(&patch[n], &downstream, u));
        let rows = to_patch.chain(patch.iter().cloned()).chain(from_patch);
        let mut rows: Vec<Row> = rows.collect();
        rows.push(downstream);
        (rows, inner.len())
    }

    /// The cross-section of a row; `number` is that of one of the patch.
    fn section(&self, row: &Row, number: Option<usize>) -> Result<CrossSection, TreeError> {
        let (n, h) = (self.grid().core, self.grid().core / 2);
        let point = |i, j| self.points[self.index(i, j)];
        let rim = (0..4 * n).map(|a| {
            let (off, side) = self.signed(a);
            match number {
                Some(i) if off <= h => {
                    let j = if side > 0.0 { h + off } else { h - off };
                    let is_inside = i > 0 && i < n && off < h;
                    Ok(match is_inside {
                        true => coons(self.grid(), i, j, point),
                        false => point(i, j),
                    })
                }
                _ => self.around.point(row.rim[a]),
            }
        });
        let (centre, _, _) = self.around.frame(row.s);
        Ok(CrossSection::new(centre, rim.collect::<Result<_, _>>()?))
    }

    /// Where the core of a cross-section would have its rim: nearly round, so that the core stays in place beside the
    /// patch.
    fn inner(&self, s: f64, section: &CrossSection) -> Vec<Vec3> {
        let n = self.grid().core;
        let (centre, first, second) = self.around.frame(s);
        let far = (n..=3 * n).map(|a| (section.rim[a] - centre).norm());
        let radius = far.sum::<f64>() / (2 * n + 1) as f64;
        let inner = (section.rim.iter().enumerate()).map(|(a, x)| {
            let (sin, cos) = self.grid().angle(a).sin_cos();
            let round = (first * cos + second * sin) * radius;
            (x - centre) * (1.0 - self.shape.upright) + round * self.shape.upright
        });
        inner.collect()
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
        shape: Shape,
    ) -> Result<Self, TreeError> {
        let grid = &slicer.grid;
        let exit = Exit::new(&slicer.lumen.lines[branch], path)?;
        let axis = exit.axis;
        let (off, on_border) = exit.border(slicer, path, &shape)?;
        let radius = path.radius(exit.s);
        let patch = Patch::new(Around { slicer, path, axis }, &shape, &exit, on_border);
        let beside = shape.beside * radius;
        let reach = patch.width.max(patch.half) + beside;
        let [begin, end] = [
            patch.middle - reach - patch.back.max(0.0),
            patch.middle + reach - patch.back.min(0.0),
        ];
        let between = grid.divided(beside / (slicer.along * radius));
        let (rows, first) = patch.rows([begin, end], &between);
        let mut sections = Vec::with_capacity(rows.len());
        for (number, row) in rows.iter().enumerate() {
            let of_patch = number.checked_sub(first).filter(|i| *i <= grid.core);
            let mut section = patch.section(row, of_patch)?;
            if number + 1 < rows.len() {
                section.inner = Some(patch.inner(row.s, &section));
            }
            sections.push(section);
        }
        let cut = exit.exit + exit.radius * (shape.cut + off * exit.slope().abs());
        let end_of = |line, cut| BranchEnd { line, cut };
        Ok(Self {
            centre: exit.centre,
            axis,
            flow: exit.frame()[0],
            parent: end_of(line, path.at(begin)),
            daughters: [
                end_of(line, path.at(end)),
                end_of(branch, exit.thin.at(cut)),
            ],
            sections,
            first,
            shape,
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
