//! The lumen of a branching vessel as hexahedra, from centre-lines with radii.
//!
//! Its surface is the smooth union of the tubes around the lines from the root to each end ([`Lumen`]). Lines part at
//! [`Junction`]s; between these lie branches, each a stack of cross-sections of an O-grid ([`SectionGrid`]), which
//! begins and ends with the folded cross-sections that it shares with its neighbours.

mod described;
mod junction;
mod lumen;
mod section;
#[cfg(test)]
mod tests;

pub use described::{TreeMeshes, TreeMistake};
pub use lumen::{CentreLine, Lumen};
use section::qualities;
pub use section::{CrossSection, SectionGrid, scaled_jacobian};

use super::PolyMesh;
use super::o_grid::{Polygon, WallPolygons};
use super::poly_mesh::PatchFaces;
use crate::Vec3;
use crate::curve::SpaceCurve;
use junction::{Junction, Slicer, across, leaves};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// Lines part at one junction if they do within this many radii.
const TOGETHER: f64 = 1.5;
/// A surface may end, or be closed, so many radii before the line does.
const OVERLAP: f64 = 1.5;
/// Between two junctions the plane cross-sections of a branch take at least this many radii.
const LEAST_LENGTH: f64 = 0.5;

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
    junctions: Vec<Junction>,
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
        let stacks = tree.branches.iter().map(|branch| tree.stack(branch));
        tree.stacks = stacks.collect::<Result<_, _>>()?;
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
        let junction = Junction::new(&self.slicer, &branch.axis, &parting)?;
        let at = self.junctions.len();
        branch.to = Some(at);
        self.branches.push(branch);
        let order: Vec<usize> = junction.daughters.iter().map(|end| end.line).collect();
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

    /// Scaled Jacobian and middle (m) of each cell.
    pub fn qualities(&self) -> Vec<(f64, Vec3)> {
        let stacks = self.stacks.iter();
        let of_stack = |stack: &Stack| qualities(&self.slicer.grid, &stack.sections);
        stacks.flat_map(of_stack).collect()
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
        let grid = &self.slicer.grid;
        let (quads, outer) = (grid.quads(), grid.rings.len());
        let mut hexes: Vec<[usize; 8]> = Vec::new();
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
        for (stack, numbers) in self.stacks.iter().zip(&numbers) {
            let last = stack.sections.len() - 1;
            let mut below: &[usize] = &[];
            for (j, here) in numbers.iter().enumerate() {
                if j > 0 {
                    for [a, b, c, d] in &quads {
                        let [a, b, c, d] = [*a, *b, *c, *d];
                        let hex = [
                            below[a], below[b], below[c], below[d], here[a], here[b], here[c],
                            here[d],
                        ];
                        if scaled_jacobian(hex.map(|i| points[i])) <= 0.0 {
                            return Err(TreeError::InsideOut(points[hex[0]]));
                        }
                        hexes.push(hex);
                    }
                    let faces = (0..grid.around()).map(|a| {
                        let [p, q] = [a, a + 1].map(|a| grid.ring_point(outer, a));
                        [below[p], below[q], here[q], here[p]]
                    });
                    patches[openings.len() + stack.wall].faces.extend(faces);
                }
                let opening = match j {
                    0 if stack.from.is_none() => Some(0),
                    j if j == last => stack.end.map(|line| 1 + line),
                    _ => None,
                };
                if let Some(opening) = opening {
                    patches[opening].faces =
                        quads.iter().map(|quad| quad.map(|i| here[i])).collect();
                }
                below = here.as_slice();
            }
        }
        Ok(PolyMesh::from_hexes(points, &hexes, &patches))
    }

    /// Positions (m) of all points, and the numbers of those of each cross-section of each stack: branches that meet
    /// have points in common.
    pub fn points(&self, growth: f64) -> (Vec<Vec3>, Vec<Vec<Vec<usize>>>) {
        let grid = &self.slicer.grid;
        let mut points: Vec<Vec3> = Vec::new();
        // Points of the junctions, to be found again.
        let mut shared: Vec<Vec<usize>> = vec![Vec::new(); self.junctions.len()];
        let of_stack = |stack: &Stack| -> Vec<Vec<usize>> {
            let of_section = |(j, section): (usize, &CrossSection)| {
                let junction = stack.junction(j);
                let close = 1e-6 * (section.rim[0] - section.centre).norm();
                let numbers = grid.positions(section, growth).into_iter().map(|x| {
                    let known = junction.and_then(|junction| {
                        let mut all = shared[junction].iter().copied();
                        all.find(|&i| (points[i] - x).norm() < close)
                    });
                    known.unwrap_or_else(|| {
                        points.push(x);
                        let new = points.len() - 1;
                        junction
                            .into_iter()
                            .for_each(|junction| shared[junction].push(new));
                        new
                    })
                });
                numbers.collect()
            };
            stack.sections.iter().enumerate().map(of_section).collect()
        };
        let numbers = self.stacks.iter().map(of_stack).collect();
        (points, numbers)
    }

    /// The centre-lines of its branches, from junction to junction, each with the number of its wall in
    /// [`Tree::mesh`]. The angle 0 is towards the axis of a junction that it ends at.
    pub fn lines(&self) -> Vec<(usize, SpaceCurve)> {
        let line = |branch: &Branch| {
            let axis = &branch.axis;
            let place = |junction: usize| axis.foot(&self.junctions[junction].centre).s;
            let from = branch.from.map(|(junction, _)| junction);
            let begin = from.map_or(0.0, place);
            let end = branch.to.map_or(axis.length(), place);
            let pieces = ((end - begin) / axis.radius(begin)).ceil().max(2.0) as usize;
            let step = (end - begin) / pieces as f64;
            let points: Vec<Vec3> = (0..=pieces)
                .map(|i| axis.at(begin + i as f64 * step))
                .collect();
            let first = from
                .or(branch.to)
                .map_or(Vec3::z(), |junction| self.junctions[junction].axis);
            (self.wall(branch), SpaceCurve::through(&points, first))
        };
        self.branches.iter().map(line).collect()
    }

    /// The cross-sections of the wall, for the numbers and positions (m) of the points of [`Tree::points`] without
    /// growth. Those that are folded along the axis of a junction have their middle there: they make up one.
    pub fn polygons(&self, points: &[Vec3], numbers: &[Vec<Vec<usize>>]) -> WallPolygons {
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
        for (stack, numbers) in self.stacks.iter().zip(numbers) {
            for (j, section) in stack.sections.iter().enumerate() {
                let rim = (0..around).map(|a| numbers[j][grid.ring_point(outer, a)]);
                let rim: Vec<usize> = rim.collect();
                match stack.junction(j) {
                    None => polygons.push(polygon(rim.clone(), rim, section.centre)),
                    Some(junction) => {
                        let axis = stack.middles[j].axis;
                        let ends = [axis, axis + around / 2].map(|a| rim[a % around]);
                        let (corners, middle_of) = &mut folded[junction];
                        corners.extend(rim);
                        *middle_of = ends.to_vec();
                    }
                }
            }
        }
        let junctions = folded.into_iter().zip(&self.junctions);
        polygons.extend(junctions.map(|((corners, ends), junction)| {
            polygon(corners.into_iter().collect(), ends, junction.centre)
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
        let end = at_end.filter(|_| branch.to.is_none());
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
            line.foot(&self.junctions[junction].daughters[daughter].cut)
                .s
        });
        let end = branch.to.map_or(line.length(), |junction| {
            line.foot(&self.junctions[junction].parent.cut).s
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
        let axis = |junction: usize| self.junctions[junction].axis;
        let frames = Frames::new(
            &tangents,
            branch.from.map(|(junction, _)| axis(junction)),
            branch.to.map(axis),
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
        if let Some((junction, daughter)) = branch.from {
            let folded = self.junctions[junction].section(Some(daughter));
            let (plane, radius) = (&sections[0], line.radius(begin));
            let (between, places) =
                self.slicer
                    .unfolding(folded, plane, &tangents[0], radius, false)?;
            sections.splice(0..0, between);
            let held = places.iter().map(|u| Middle {
                axis: 0,
                share: share(*u),
            });
            middles.splice(0..0, held);
        }
        if let Some(junction) = branch.to {
            let mut folded = self.junctions[junction].section(None);
            let axis = frames.quarters * self.slicer.grid.core;
            folded.rim.rotate_right(axis);
            let (plane, tangent) = (&sections[sections.len() - 1], &tangents[tangents.len() - 1]);
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
        Ok(Stack {
            end: branch.to.is_none().then_some(branch.line),
            wall: self.wall(branch),
            from: branch.from.map(|(junction, _)| junction),
            to: branch.to,
            sections,
            middles,
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
