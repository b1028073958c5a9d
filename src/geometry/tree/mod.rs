//! The lumen of a branching vessel as hexahedra, from centre-lines with radii.
//!
//! Its surface is the smooth union of the tubes around the lines from the root to each end ([`Lumen`]). Lines part at
//! [junctions](junction::Junction); between these lie branches, each a stack of cross-sections of an O-grid
//! ([`SectionGrid`]), which begins and ends with the folded cross-sections that it shares with its neighbours.

mod apex;
mod blocks;
mod branch;
mod carried;
mod choice;
mod described;
mod divide;
mod error;
mod feature;
mod junction;
mod layout;
mod lumen;
mod meeting;
mod meeting_place;
mod plan;
mod section;
mod shape;
mod side;
mod slicer;
mod stack;
#[cfg(test)]
mod tests;
mod unfolding;

pub use blocks::{Block, Displaced, NONE, Numbers, Outside, Positions};
pub use branch::{Middle, Stack};
pub use carried::Carried;
pub use described::{TreeMeshes, TreeMistake};
pub use error::TreeError;
pub use lumen::Lumen;
pub use meeting_place::MeetingPlace;
pub use section::{CrossSection, SectionGrid};
pub use side::Hole;

use super::PolyMesh;
use super::o_grid::{Polygon, WallPolygons};
use super::poly_mesh::PatchFaces;
use crate::Vec3;
use crate::curve::{Partings, SpaceCurve};
use branch::Branch;
use divide::Division;
use meeting::Meeting;
use slicer::Slicer;
use std::collections::BTreeSet;

/// A line that bends with less than this many radii is to blame for cells that are inside out.
const SHARP: f64 = 1.5;

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
        let partings = Partings::new(&lumen.lines);
        let slicer = Slicer { lumen, grid, along };
        Division::tree(slicer, &partings, None)?.stacked()
    }

    /// A tree that has been taken apart.
    fn of_parts(
        slicer: Slicer,
        junctions: Vec<Meeting>,
        branches: Vec<Branch>,
    ) -> Result<Self, TreeError> {
        let tree = Self {
            slicer,
            junctions,
            branches,
            stacks: Vec::new(),
        };
        tree.stacked()
    }

    /// With the cross-sections of its branches.
    fn stacked(mut self) -> Result<Self, TreeError> {
        for branch in &self.branches {
            let stack = self.stack(branch)?;
            self.stacks.push(stack);
        }
        Ok(self)
    }

    /// See [`Stack::wall`].
    fn wall(&self, branch: &Branch) -> usize {
        match (branch.from, branch.to) {
            (None, _) => 0,
            (Some(_), None) => 1 + branch.lines[0],
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

    /// The smallest scaled Jacobian at a corner of each cell, or at a node of each element, and where that is, m.
    pub fn qualities(&self) -> Vec<(f64, Vec3)> {
        let all = self.qualities_by_stack().into_iter();
        all.map(|(_, quality, x)| (quality, x)).collect()
    }

    /// As [`Tree::qualities`], each with the stack that it is in.
    fn qualities_by_stack(&self) -> Vec<(usize, f64, Vec3)> {
        let growth = match self.grid().degree() {
            1 => self.grid().growth_of_polygon(),
            _ => 1.0,
        };
        let (points, numbers) = self.points(growth);
        let quality = |block: &Block| {
            let at: Vec<Vec3> = block.points.iter().map(|i| points[*i]).collect();
            let (quality, x) = self.grid().quality(&at);
            (block.stack, quality, x)
        };
        self.blocks(&numbers).iter().map(quality).collect()
    }

    /// That nothing is inside out.
    ///
    /// # Errors
    /// Where, and why, if something is.
    pub fn validate(&self) -> Result<(), TreeError> {
        let all = self.qualities_by_stack().into_iter();
        let worst = all.min_by(|a, b| a.1.total_cmp(&b.1));
        match worst {
            Some((stack, quality, x)) if quality <= 0.0 => Err(self.inside_out(stack, &x)),
            _ => Ok(()),
        }
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
            let at: Vec<Vec3> = block.points.iter().map(|i| points[*i]).collect();
            let (quality, x) = self.grid().quality(&at);
            if quality <= 0.0 {
                return Err(self.inside_out(block.stack, &x));
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

    /// Junctions of more than two daughters: where (m), and a line that goes through each daughter.
    pub fn shared_junctions(&self) -> Vec<(Vec3, Vec<usize>)> {
        let several = self
            .junctions
            .iter()
            .filter(|meeting| meeting.daughters().len() > 2);
        let of = |meeting: &Meeting| {
            let lines = meeting.daughters().iter().map(|end| end.line);
            (*meeting.centre(), lines.collect())
        };
        several.map(of).collect()
    }

    /// What is wrong with a cell of this stack, at this place (m), that is inside out.
    fn inside_out(&self, stack: usize, x: &Vec3) -> TreeError {
        let line = &self.branches[stack].axis;
        let foot = line.foot(x);
        let h = 0.5 * foot.radius;
        let s = foot.s.clamp(h, (line.length() - h).max(h));
        let [a, b, c] = [s - h, s, s + h].map(|s| line.at(s));
        let (ab, bc) = ((b - a).normalize(), (c - b).normalize());
        // The angle between chords over the way between their middles.
        let bend = 0.5 * ((b - a).norm() + (c - b).norm()) / ab.dot(&bc).clamp(-1.0, 1.0).acos();
        match bend < SHARP * foot.radius {
            true => TreeError::Bend(*x, foot.radius, bend),
            false => TreeError::InsideOut(*x),
        }
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
}
