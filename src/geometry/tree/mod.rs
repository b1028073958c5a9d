//! The lumen of a branching vessel as hexahedra, from centre-lines with radii.
//!
//! Its surface is the smooth union of the tubes around the lines from the root to each end ([`Lumen`]). Lines part at
//! [`Junction`]s; between these lie branches, each a stack of cross-sections of an O-grid ([`SectionGrid`]), which
//! begins and ends with the folded cross-sections that it shares with its neighbours.

mod blocks;
mod described;
mod junction;
mod lumen;
mod section;
mod side;
#[cfg(test)]
mod tests;

pub use blocks::{Block, Displaced, NONE, Numbers, Outside, Positions};
pub use described::{TreeMeshes, TreeMistake};
pub use lumen::{CentreLine, Lumen};
pub use section::{CrossSection, SectionGrid, scaled_jacobian};
pub use side::Hole;

use super::PolyMesh;
use super::o_grid::{Polygon, WallPolygons};
use super::poly_mesh::PatchFaces;
use crate::Vec3;
use crate::curve::SpaceCurve;
use junction::{BranchEnd, Junction, Parting, Slicer, across, leaves};
use side::Side;
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// Lines part at one junction if they do within this many radii.
const TOGETHER: f64 = 1.5;
/// A surface may end, or be closed, so many radii before the line does.
const OVERLAP: f64 = 1.5;
/// Between two junctions the plane cross-sections of a branch take at least this many radii.
const LEAST_LENGTH: f64 = 0.5;

/// A branch is thin whose radius is less than this share of that of the one that goes straight on ...
const THIN: f64 = 0.65;
/// ... by the cosine of the angle that it turns.
const STRAIGHT: f64 = 0.8;
/// A thin branch meets another one as an equal if the scaled Jacobian of all cells is above this.
const FAN: f64 = 0.3;

/// Why a tree has no mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TreeError {
    /// A ray from this place (m) does not meet the surface.
    #[error("at {} the lumen is not closed around the centre-line: do the lines end there, or is a daughter inside its parent?", shown(.0))]
    Open(Vec3),
    /// No surface between two lines that part near this place (m).
    #[error(
        "near {} two centre-lines part, but their lumens do not: their radii are too large for the angle between them, or one lies \
         within the other", shown(.0)
    )]
    Apex(Vec3),
    /// Branches leave this place (m) at angles that are too small.
    #[error("at {} branches leave in nearly the same direction: a junction carries angles of 20 degrees and more", shown(.0))]
    Angle(Vec3),
    /// A thin branch that is wide as soon as it leaves this place (m).
    #[error(
        "at {} a branch with a narrow neck widens, or bends back, as soon as it leaves: let the neck go on for half of its radius", shown(.0)
    )]
    Neck(Vec3),
    /// Two junctions too close to this place (m).
    #[error("near {} two junctions follow each other within {:.1} radii of the branch between them: leave out one of the branches", shown(.0), .1)]
    Close(Vec3, f64),
    /// So few radii between an opening and a junction, near this place (m).
    #[error("near {} an opening is only {:.1} radii from a junction, which takes 3: continue the centre-line there, or leave the branch out", shown(.0), .1)]
    Short(Vec3, f64),
    /// A hexahedron inside out near this place (m).
    #[error("near {} the mesh would be inside out: a branch bends or changes its radius too sharply there", shown(.0))]
    InsideOut(Vec3),
    /// The triangles of the surface make none.
    #[error("the surface of the lumen: {0}")]
    Surface(crate::files::Fault),
    /// Lines do not begin at one place: this one (m) is far from the first.
    #[error("a centre-line begins at {}, far from where the first one does: are there two trees in the file?", shown(.0))]
    TwoTrees(Vec3),
}

impl TreeError {
    /// Where it is, m.
    fn place(&self) -> Option<Vec3> {
        match self {
            Self::Open(x)
            | Self::Apex(x)
            | Self::Angle(x)
            | Self::Neck(x)
            | Self::Close(x, _)
            | Self::Short(x, _)
            | Self::InsideOut(x)
            | Self::TwoTrees(x) => Some(*x),
            Self::Surface(_) => None,
        }
    }
}

fn shown(x: &Vec3) -> String {
    format!("({:.4e}, {:.4e}, {:.4e}) m", x.x, x.y, x.z)
}

/// A stretch between two junctions, or a junction and an end of the tree.
#[derive(Debug, Clone)]
struct Branch {
    /// One of the lines that go through it.
    line: usize,
    /// Their mean.
    axis: CentreLine,
    /// Junction where it begins, and which daughter it is there.
    from: Option<(usize, usize)>,
    /// Junction where it ends.
    to: Option<usize>,
}

/// The cross-sections of a branch.
#[derive(Debug, Clone)]
pub struct Stack {
    /// The line of the tree that ends with it, if one does.
    pub end: Option<usize>,
    /// The number of its wall: 0 of the root, that of its line plus one where it ends with it, and one more than the
    /// last of these for branches between junctions.
    pub wall: usize,
    /// Junction where it begins; the root, which is the first branch, has none.
    pub from: Option<usize>,
    /// Junction where it ends.
    pub to: Option<usize>,
    /// Cross-sections, downstream.
    pub sections: Vec<CrossSection>,
    /// What the middle of each one goes with when the wall moves.
    pub middles: Vec<Middle>,
    /// Where a side branch begins in it.
    pub hole: Option<Hole>,
    /// The stack in whose hole it begins.
    pub plugs: Option<usize>,
    /// The wall over the last core, row by row (m), if it is closed.
    pub top: Option<Vec<Vec3>>,
}

/// Where branches meet.
#[derive(Debug, Clone)]
enum Meeting {
    /// As equals.
    Fan(Junction),
    /// A thin one begins at the side of another.
    Side(Side),
}

impl Meeting {
    /// Lines that part as equals, unless one goes straight on and the other is thin and would be squeezed.
    fn new(
        slicer: &Slicer,
        trunk: &CentreLine,
        parting: &Parting,
        path: impl Fn(usize) -> CentreLine,
    ) -> Result<Self, TreeError> {
        let Some([line, branch]) = thin(&slicer.lumen, parting) else {
            return Ok(Self::Fan(Junction::new(slicer, trunk, parting)?));
        };
        // The same for cells and elements.
        let usual = Slicer {
            lumen: slicer.lumen.clone(),
            grid: SectionGrid::of_cells(6, 5, 3.0),
            along: 0.4,
        };
        let is_good = !slicer.lumen.lines[branch].is_closed
            && Junction::new(&usual, trunk, parting)
                .and_then(|fan| fan.quality(&usual, trunk))
                .is_ok_and(|quality| quality > FAN);
        match is_good {
            true => Ok(Self::Fan(Junction::new(slicer, trunk, parting)?)),
            false => Ok(Self::Side(Side::new(slicer, &path(line), line, branch)?)),
        }
    }

    /// The middle, m.
    fn centre(&self) -> &Vec3 {
        match self {
            Self::Fan(fan) => &fan.centre,
            Self::Side(side) => &side.centre,
        }
    }

    /// From where the rims of a branch count, that of the parent or of a daughter.
    fn axis(&self, daughter: Option<usize>) -> Vec3 {
        match (self, daughter) {
            (Self::Fan(fan), _) => fan.axis,
            (Self::Side(side), Some(1)) => side.flow,
            (Self::Side(side), _) => side.axis,
        }
    }

    fn parent(&self) -> &BranchEnd {
        match self {
            Self::Fan(fan) => &fan.parent,
            Self::Side(side) => &side.parent,
        }
    }

    fn daughters(&self) -> &[BranchEnd] {
        match self {
            Self::Fan(fan) => &fan.daughters,
            Self::Side(side) => &side.daughters,
        }
    }
}

/// The line that goes straight on, and that of a thin branch beside it, if these are the two that part.
fn thin(lumen: &Lumen, parting: &Parting) -> Option<[usize; 2]> {
    let &[(a, s), (b, t)] = parting else {
        return None;
    };
    let is_thin = |(line, s): (usize, f64), (branch, t): (usize, f64)| {
        let (line, branch) = (&lumen.lines[line], &lumen.lines[branch]);
        let at = |line: &CentreLine, s: f64, radii: f64| s + radii * line.radius(s);
        let upstream = line.tangent(at(line, s, -2.0));
        let downstream = line.tangent(at(line, s, 1.0));
        let t = side::exit(line, branch).unwrap_or(t);
        let wide = line
            .radius(at(line, s, 1.0))
            .min(line.radius(at(line, s, -2.0)));
        side::neck(branch, t) < THIN * wide && upstream.dot(&downstream) > STRAIGHT
    };
    match (is_thin((a, s), (b, t)), is_thin((b, t), (a, s))) {
        (true, _) => Some([a, b]),
        (_, true) => Some([b, a]),
        _ => None,
    }
}

impl Stack {
    /// The junction that the cross-section of this number is folded at.
    fn junction(&self, section: usize) -> Option<usize> {
        match section {
            0 => self.from,
            last if last + 1 == self.sections.len() => self.to,
            _ => None,
        }
    }
}

/// Corners of a cell by place in its three directions: the lower four counter-clockwise, then the upper four.
const CORNERS: [[usize; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [1, 1, 1],
    [0, 1, 1],
];

/// What the middle of a cross-section goes with: on the way from a plane cross-section to a junction, less and less
/// with the whole of its rim, and more and more with the two points of it where the axis of the junction ends, which
/// all branches there share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Middle {
    /// One of these points of the rim; the other one is opposite.
    pub axis: usize,
    /// Share of the whole rim.
    pub share: f64,
}

/// A tree in its branches.
#[derive(Debug, Clone)]
pub struct Tree {
    slicer: Slicer,
    junctions: Vec<Meeting>,
    branches: Vec<Branch>,
    stacks: Vec<Stack>,
}

impl Tree {
    /// Takes a lumen apart, for cells or elements of this cross-section whose length along the branches is `along`
    /// radii.
    ///
    /// # Errors
    /// If a junction or a branch cannot be meshed.
    pub fn new(lumen: Lumen, grid: SectionGrid, along: f64) -> Result<Self, TreeError> {
        let root = lumen.lines[0].at(0.0);
        let begins = lumen.lines.iter().map(|line| line.at(0.0));
        let apart = begins
            .into_iter()
            .find(|x| (x - root).norm() > lumen.lines[0].radius(0.0));
        if let Some(other) = apart {
            return Err(TreeError::TwoTrees(other));
        }
        let all: Vec<usize> = (0..lumen.lines.len()).collect();
        let mut tree = Self {
            slicer: Slicer { lumen, grid, along },
            junctions: Vec::new(),
            branches: Vec::new(),
            stacks: Vec::new(),
        };
        tree.divide(&all, None)?;
        for branch in &tree.branches {
            let stack = tree.stack(branch)?;
            tree.stacks.push(stack);
        }
        Ok(tree)
    }

    /// Takes lines apart that begin as one branch.
    fn divide(&mut self, lines: &[usize], from: Option<(usize, usize)>) -> Result<(), TreeError> {
        let mut branch = Branch {
            line: lines[0],
            axis: self.slicer.lumen.lines[lines[0]].clone(),
            from,
            to: None,
        };
        if lines.len() == 1 {
            self.branches.push(branch);
            return Ok(());
        }
        let lumen = &self.slicer.lumen;
        let leave = |a: usize, b: usize| match a == b {
            true => Ok(f64::INFINITY),
            false => {
                let line = &lumen.lines[a];
                leaves(lumen, a, b).ok_or_else(|| TreeError::Apex(line.at(line.length())))
            }
        };
        let of_line = |&a: &usize| lines.iter().map(|&b| leave(a, b)).collect();
        let apart: Vec<Vec<f64>> = lines.iter().map(of_line).collect::<Result<_, _>>()?;
        let first = apart
            .iter()
            .flatten()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let together: Vec<&CentreLine> = lines.iter().map(|i| &lumen.lines[*i]).collect();
        branch.axis = CentreLine::mean(&together, first);
        let reach = TOGETHER * lumen.lines[lines[0]].radius(first);
        // Classes of lines that stay together.
        let mut classes: Vec<Vec<usize>> = Vec::new();
        for i in 0..lines.len() {
            let mut known = classes.iter_mut();
            match known.find(|class| apart[class[0]][i] > first + reach) {
                Some(class) => class.push(i),
                None => classes.push(vec![i]),
            }
        }
        if classes.len() == 1 {
            return Err(TreeError::Apex(lumen.lines[lines[0]].at(first)));
        }
        let leaves_others = |class: &Vec<usize>| {
            let others = (0..lines.len()).filter(|j| !class.contains(j));
            others.map(|j| apart[class[0]][j]).fold(0.0, f64::max)
        };
        let parting: Vec<(usize, f64)> = (classes.iter())
            .map(|class| (lines[class[0]], leaves_others(class)))
            .collect();
        let path = |line: usize| {
            let class = classes.iter().find(|class| lines[class[0]] == line);
            let class: Vec<&CentreLine> = (class.into_iter().flatten())
                .map(|i| &lumen.lines[lines[*i]])
                .collect();
            match class[..] {
                [only] => only.clone(),
                _ => CentreLine::mean(&class, f64::INFINITY),
            }
        };
        let junction = Meeting::new(&self.slicer, &branch.axis, &parting, path)?;
        let at = self.junctions.len();
        branch.to = Some(at);
        self.branches.push(branch);
        let order: Vec<usize> = junction.daughters().iter().map(|end| end.line).collect();
        self.junctions.push(junction);
        for (daughter, line) in order.into_iter().enumerate() {
            let class = classes.iter().find(|class| lines[class[0]] == line);
            let below: Vec<usize> = class.into_iter().flatten().map(|i| lines[*i]).collect();
            self.divide(&below, Some((at, daughter)))?;
        }
        Ok(())
    }

    /// See [`Stack::wall`].
    fn wall(&self, branch: &Branch) -> usize {
        match (branch.from, branch.to) {
            (None, _) => 0,
            (Some(_), None) => 1 + branch.line,
            (Some(_), Some(_)) => 1 + self.slicer.lumen.lines.len(),
        }
    }

    /// What its cross-sections are divided into.
    pub fn grid(&self) -> &SectionGrid {
        &self.slicer.grid
    }

    /// Its branches, the root first and each before those that it divides into.
    pub fn stacks(&self) -> &[Stack] {
        &self.stacks
    }

    /// Scaled Jacobian and middle (m) of each cell, or of what lies between neighbouring nodes of the elements.
    pub fn qualities(&self) -> Vec<(f64, Vec3)> {
        let growth = match self.grid().degree() {
            1 => self.grid().growth_of_polygon(),
            _ => 1.0,
        };
        let (points, numbers) = self.points(growth);
        let n = self.grid().degree() + 1;
        let blocks = self.blocks(&numbers);
        let cells = blocks.iter().flat_map(|block| {
            let all = (0..n * n * n).map(move |k| [k % n, k / n % n, k / n / n]);
            let lower = all.filter(move |ijk| ijk.iter().all(|i| i + 1 < n));
            lower.map(|[i, j, k]| {
                CORNERS.map(|[x, y, z]| points[block.points[((k + z) * n + j + y) * n + i + x]])
            })
        });
        cells
            .map(|corners| (scaled_jacobian(corners), corners.iter().sum::<Vec3>() / 8.0))
            .collect()
    }

    /// The mesh of cells: patches of the openings, first that where the lines begin, then where each ends; and of the
    /// walls of the branches with these openings, in the same order, and of all others. `growth` is that of
    /// [`SectionGrid::positions`].
    ///
    /// # Errors
    /// If a cell would be inside out.
    pub fn mesh(
        &self,
        openings: &[String],
        walls: &[String],
        growth: f64,
    ) -> Result<PolyMesh, TreeError> {
        let (points, numbers) = self.points(growth);
        let patch = |name, kind| PatchFaces {
            name,
            kind,
            faces: Vec::new(),
        };
        let mut patches: Vec<PatchFaces<'_>> = (openings.iter())
            .map(|name| patch(name, "patch"))
            .chain(walls.iter().map(|name| patch(name, "wall")))
            .collect();
        let mut hexes: Vec<[usize; 8]> = Vec::new();
        for block in self.blocks(&numbers) {
            let hex = CORNERS.map(|[x, y, z]| block.points[4 * z + 2 * y + x]);
            if scaled_jacobian(hex.map(|i| points[i])) <= 0.0 {
                return Err(TreeError::InsideOut(points[hex[0]]));
            }
            for (axis, upper, outside) in block.sides {
                let (patch, face) = match (outside, axis, upper) {
                    (Outside::Opening(i), _, false) => (i, [0, 1, 2, 3]),
                    (Outside::Opening(i), _, true) => (i, [4, 5, 6, 7]),
                    (Outside::Wall(i), 2, _) => (openings.len() + i, [4, 5, 6, 7]),
                    (Outside::Wall(i), ..) => (openings.len() + i, [1, 2, 6, 5]),
                };
                patches[patch].faces.push(face.map(|k| hex[k]));
            }
            hexes.push(hex);
        }
        let is_closed = |line: usize| self.slicer.lumen.lines[line].is_closed;
        let mut number = 0..openings.len();
        patches.retain(|_| !number.next().is_some_and(|i| i > 0 && is_closed(i - 1)));
        Ok(PolyMesh::from_hexes(points, &hexes, &patches))
    }

    /// Positions (m) of all points, and their numbers. `growth` is that of [`SectionGrid::positions`].
    pub fn points(&self, growth: f64) -> (Vec<Vec3>, Numbers) {
        let positions = self.positions(growth, None);
        let numbers = self.numbers(&positions);
        let mut points = vec![None; numbers.count];
        let mut put = |numbers: &[usize], positions: &[Vec3]| {
            for (&number, x) in numbers.iter().zip(positions) {
                if number != NONE {
                    points[number].get_or_insert(*x);
                }
            }
        };
        for (stack, (sections, caps)) in
            (positions.sections.iter().zip(&positions.caps)).enumerate()
        {
            for (j, section) in sections.iter().enumerate() {
                put(&numbers.sections[stack][j], section);
            }
            for (cap, numbers) in caps.iter().zip(&numbers.caps[stack]) {
                if let (Some(cap), Some(numbers)) = (cap, numbers) {
                    put(numbers, cap);
                }
            }
        }
        (points.into_iter().flatten().collect(), numbers)
    }

    /// The centre-lines of its branches, from junction to junction, each with the number of its wall in
    /// [`Tree::mesh`]. The angle 0 is towards the axis of a junction that it ends at.
    pub fn lines(&self) -> Vec<(usize, SpaceCurve)> {
        let line = |branch: &Branch| {
            let axis = &branch.axis;
            let place = |junction: usize| axis.foot(self.junctions[junction].centre()).s;
            let from = branch.from.map(|(junction, _)| junction);
            let begin = from.map_or(0.0, place);
            let end = branch.to.map_or(axis.length(), place);
            let pieces = ((end - begin) / axis.radius(begin)).ceil().max(2.0) as usize;
            let step = (end - begin) / pieces as f64;
            let points: Vec<Vec3> = (0..=pieces)
                .map(|i| axis.at(begin + i as f64 * step))
                .collect();
            let first = match (branch.from, branch.to) {
                (Some((junction, daughter)), _) => self.junctions[junction].axis(Some(daughter)),
                (None, Some(junction)) => self.junctions[junction].axis(None),
                (None, None) => Vec3::z(),
            };
            (self.wall(branch), SpaceCurve::through(&points, first))
        };
        self.branches.iter().map(line).collect()
    }

    /// The cross-sections of the wall, for the numbers and positions (m) of the points of [`Tree::points`] without
    /// growth. Those that are folded along the axis of a junction have their middle there: they make up one.
    pub fn polygons(&self, points: &[Vec3], numbers: &Numbers) -> WallPolygons {
        let grid = self.grid();
        let (around, outer) = (grid.around(), grid.rings.len());
        let polygon = |corners: Vec<usize>, middle_of: Vec<usize>, centre: Vec3| {
            let mean: Vec3 = middle_of.iter().map(|&i| points[i]).sum();
            Polygon {
                off: centre - mean / middle_of.len() as f64,
                corners,
                middle_of,
            }
        };
        let mut polygons = Vec::new();
        let mut folded: Vec<(BTreeSet<usize>, Vec<usize>)> =
            vec![Default::default(); self.junctions.len()];
        for (number, stack) in self.stacks.iter().enumerate() {
            let last = stack.sections.len() - 1;
            for j in self.plugged(stack)..=last {
                let section = &stack.sections[j];
                let rim = (0..around)
                    .map(|a| numbers.sections[number][j][grid.ring_point(outer, a)])
                    .filter(|point| *point != NONE);
                let mut rim: Vec<usize> = rim.collect();
                match stack.junction(j).map(|i| (i, &self.junctions[i])) {
                    Some((junction, Meeting::Fan(_))) => {
                        let axis = stack.middles[j].axis;
                        let ends = [axis, axis + around / 2].map(|a| rim[a % around]);
                        let (corners, middle_of) = &mut folded[junction];
                        corners.extend(rim);
                        *middle_of = ends.to_vec();
                    }
                    // The parent has it.
                    Some((_, Meeting::Side(_))) if j == 0 => {}
                    _ => {
                        let middle_of = rim.clone();
                        if let Some(top) = numbers.caps[number][1].as_ref().filter(|_| j == last) {
                            let outside = &top[top.len() - (grid.core + 1).pow(2)..];
                            rim.extend(outside.iter().filter(|point| !middle_of.contains(point)));
                        }
                        polygons.push(polygon(rim, middle_of, section.centre));
                    }
                }
            }
        }
        let junctions = folded.into_iter().zip(&self.junctions);
        let junctions = junctions.filter(|((corners, _), _)| !corners.is_empty());
        polygons.extend(junctions.map(|((corners, ends), junction)| {
            polygon(corners.into_iter().collect(), ends, *junction.centre())
        }));
        WallPolygons::new(polygons, around)
    }

    /// The plane cross-sections that a surface surrounds. At the open ends of the tree it may be closed, or end, a bit
    /// before the lines do.
    fn whole(
        &self,
        branch: &Branch,
        stations: &[f64],
        tangents: &[Vec3],
        first: &[Vec3],
    ) -> Range<usize> {
        let count = stations.len();
        let line = &branch.axis;
        if self.slicer.lumen.surface.is_none() {
            return 0..count;
        }
        let is_whole = |i: &usize| {
            let i = *i;
            (self.slicer).is_whole(line.at(stations[i]), &tangents[i], &first[i])
        };
        // So far from an end at most.
        let near = |end: f64| OVERLAP * line.radius(end);
        let at_start = (0..count).take_while(|i| stations[*i] <= near(0.0));
        let start = at_start.filter(|_| branch.from.is_none());
        let start = start
            .clone()
            .find(is_whole)
            .or_else(|| start.last().map(|i| i + 1));
        let length = line.length();
        let at_end = (0..count)
            .rev()
            .take_while(|i| length - stations[*i] <= near(length));
        let end = at_end.filter(|_| branch.to.is_none() && !line.is_closed);
        let end = end
            .clone()
            .find(is_whole)
            .or_else(|| end.last().and_then(|i| i.checked_sub(1)));
        let start = start.unwrap_or(0).min(count - 1);
        start..end.map_or(count, |last| last + 1).max(start + 1)
    }

    /// The cross-sections of a branch.
    fn stack(&self, branch: &Branch) -> Result<Stack, TreeError> {
        let line = &branch.axis;
        let begin = branch.from.map_or(0.0, |(junction, daughter)| {
            line.foot(&self.junctions[junction].daughters()[daughter].cut)
                .s
        });
        let end = branch.to.map_or(line.length(), |junction| {
            line.foot(&self.junctions[junction].parent().cut).s
        });
        let least = LEAST_LENGTH * line.radius(begin);
        if end - begin < least {
            let radii = (end - begin) / line.radius(begin) + 3.0;
            let (x, radii) = (line.at(0.5 * (begin + end)), radii.max(0.0));
            return Err(match branch.from.is_some() && branch.to.is_some() {
                true => TreeError::Close(x, radii),
                false => TreeError::Short(x, radii),
            });
        }
        let stations = self.slicer.stations(line, begin, end);
        let tangents: Vec<Vec3> = stations.iter().map(|s| line.tangent(*s)).collect();
        let axis = |junction: usize, end| self.junctions[junction].axis(end);
        let frames = Frames::new(
            &tangents,
            (branch.from).map(|(junction, daughter)| axis(junction, Some(daughter))),
            branch.to.map(|junction| axis(junction, None)),
        );
        let mut sections = Vec::with_capacity(stations.len() + 8);
        let whole = self.whole(branch, &stations, &tangents, &frames.first);
        for (i, (s, tangent)) in stations.iter().zip(&tangents).enumerate() {
            let share = (s - begin) / (end - begin);
            // Without a kink at the ends.
            let turned = frames.turn * share * share * (3.0 - 2.0 * share);
            let cut = |i: usize| {
                let centre = line.at(stations[i]);
                (self.slicer).plane(centre, &tangents[i], &frames.first[i], turned)
            };
            let nearest = i.clamp(whole.start, whole.end - 1);
            let section = cut(nearest)?;
            sections.push(match nearest == i {
                true => section,
                false => section.moved(line.at(*s), [&tangents[nearest], tangent]),
            });
        }
        let whole = Middle {
            axis: 0,
            share: 1.0,
        };
        let mut middles = vec![whole; sections.len()];
        // Without a kink where the cross-sections become plane.
        let share = |u: f64| u * u * (3.0 - 2.0 * u);
        let mut plugs = None;
        let folded = match branch
            .from
            .map(|(junction, end)| (&self.junctions[junction], end))
        {
            Some((Meeting::Fan(fan), daughter)) => Some(fan.section(Some(daughter))),
            Some((Meeting::Side(side), 0)) => {
                sections[0] = side.sections[side.sections.len() - 1].clone();
                None
            }
            Some((Meeting::Side(_), _)) => {
                plugs = self
                    .stacks
                    .iter()
                    .position(|stack| stack.to == branch.from.map(|(at, _)| at));
                Some(self.plug(plugs, self.slicer.grid.rings.len()))
            }
            None => None,
        };
        if let Some(folded) = folded {
            let (plane, radius) = (&sections[0], line.radius(begin));
            let (between, places) =
                self.slicer
                    .unfolding(folded, plane, &tangents[0], radius, false)?;
            sections.splice(0..0, between);
            let held = places.iter().map(|u| Middle {
                axis: 0,
                share: if plugs.is_some() { 1.0 } else { share(*u) },
            });
            middles.splice(0..0, held);
        }
        if plugs.is_some() {
            let rings = self.slicer.grid.rings.len();
            sections.splice(0..0, (0..rings).map(|ring| self.plug(plugs, ring)));
            middles.splice(0..0, vec![whole; rings]);
        }
        let mut top = None;
        if line.is_closed && branch.to.is_none() {
            let last = tangents.len() - 1;
            let (dome, of_top) = self
                .slicer
                .dome(line, &tangents[last], &frames.first[last])?;
            middles.resize(sections.len() + dome.len(), whole);
            sections.extend(dome);
            top = Some(of_top);
        }
        let mut hole = None;
        let axis = frames.quarters * self.slicer.grid.core;
        match branch.to.map(|junction| &self.junctions[junction]) {
            Some(Meeting::Fan(fan)) => {
                let mut folded = fan.section(None);
                folded.rim.rotate_right(axis);
                let (plane, tangent) =
                    (&sections[sections.len() - 1], &tangents[tangents.len() - 1]);
                let radius = line.radius(end);
                let (mut between, places) = self
                    .slicer
                    .unfolding(folded, plane, tangent, radius, true)?;
                between.reverse();
                sections.extend(between);
                let held = places.iter().rev().map(|u| Middle {
                    axis,
                    share: share(*u),
                });
                middles.extend(held);
            }
            Some(Meeting::Side(side)) => {
                hole = Some(Hole {
                    first: sections.len() + side.first,
                    middle: axis,
                });
                middles.resize(sections.len() + side.sections.len(), whole);
                sections.extend(side.sections.iter().cloned().map(|mut section| {
                    section.rim.rotate_right(axis);
                    if let Some(inner) = &mut section.inner {
                        inner.rotate_right(axis);
                    }
                    section
                }));
            }
            None => {}
        }
        Ok(Stack {
            end: (branch.to.is_none() && !line.is_closed).then_some(branch.line),
            wall: self.wall(branch),
            from: branch.from.map(|(junction, _)| junction),
            to: branch.to,
            sections,
            middles,
            hole,
            plugs,
            top,
        })
    }

    /// The cross-section of a plug at a ring of the stack that it is in, at rest.
    fn plug(&self, parent: Option<usize>, ring: usize) -> CrossSection {
        let grid = self.grid();
        let Some((parent, hole)) =
            parent.and_then(|i| Some((&self.stacks[i], self.stacks[i].hole?)))
        else {
            unreachable!("a side branch comes after its parent")
        };
        let rows = hole.first..=hole.first + grid.core;
        let rows: Vec<Vec<Vec3>> = (parent.sections[rows].iter())
            .map(|section| grid.positions(section, 1.0))
            .collect();
        side::plug(grid, ring, |(i, j), ring| {
            let row = (grid.core / 2).wrapping_add_signed(i);
            let point = (hole.middle + grid.around()).wrapping_add_signed(j) % grid.around();
            rows[row][grid.ring_point(ring, point)]
        })
    }
}

/// The directions from which the rims of a branch's cross-sections count: transported along it without rotation.
struct Frames {
    first: Vec<Vec3>,
    /// Angle (rad) by which they are turned in addition on the way from one junction to the other, at most 45° ...
    turn: f64,
    /// ... so that the last one is that of the junction after so many quarters of a turn.
    quarters: usize,
}

impl Frames {
    fn new(tangents: &[Vec3], start: Option<Vec3>, end: Option<Vec3>) -> Self {
        let transported = |first: Vec3, tangents: &mut dyn Iterator<Item = &Vec3>| {
            let mut direction = first;
            let all = tangents.map(|tangent| {
                direction = across(&direction, tangent);
                direction
            });
            all.collect::<Vec<Vec3>>()
        };
        let mut frames = Self {
            first: Vec::new(),
            turn: 0.0,
            quarters: 0,
        };
        if let (None, Some(end)) = (start, end) {
            frames.first = transported(end, &mut tangents.iter().rev());
            frames.first.reverse();
            return frames;
        }
        let any = [Vec3::x(), Vec3::y()][usize::from(tangents[0].x.abs() > 0.9)];
        frames.first = transported(start.unwrap_or(any), &mut tangents.iter());
        let (last, tangent) = (frames.first.last(), tangents.last());
        if let (Some(end), Some(last), Some(tangent)) = (end, last, tangent) {
            let off = end.dot(&tangent.cross(last)).atan2(end.dot(last));
            let quarters = (off / FRAC_PI_2).round();
            frames.turn = off - quarters * FRAC_PI_2;
            frames.quarters = quarters.rem_euclid(4.0) as usize;
        }
        frames
    }
}
