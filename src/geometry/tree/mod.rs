//! The lumen of a branching vessel as hexahedra, from centre-lines with radii.
//!
//! Its surface is the smooth union of the tubes around the lines from the root to each end ([`Lumen`]). Lines part at
//! [`Junction`]s; between these lie branches, each a stack of cross-sections of an O-grid ([`SectionGrid`]), which
//! begins and ends with the folded cross-sections that it shares with its neighbours.

mod junction;
mod lumen;
mod section;
#[cfg(test)]
mod tests;

pub use lumen::{CentreLine, Lumen};
pub use section::{SectionGrid, scaled_jacobian};

use super::PolyMesh;
use super::poly_mesh::PatchFaces;
use crate::Vec3;
use junction::{Junction, Slicer, across, leaves};
use section::CrossSection;
use std::f64::consts::FRAC_PI_2;

/// Lines part at one junction if they do within this many radii.
const TOGETHER: f64 = 1.5;
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
    /// A hexahedron inside out near this place (m).
    #[error("near {} the mesh would be inside out: a branch bends or changes its radius too sharply there", shown(.0))]
    InsideOut(Vec3),
    /// Lines do not begin at one place: this one (m) is far from the first.
    #[error("a centre-line begins at {}, far from where the first one does: are there two trees in the file?", shown(.0))]
    TwoTrees(Vec3),
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

/// A tree in its branches.
#[derive(Debug, Clone)]
pub struct Tree {
    slicer: Slicer,
    junctions: Vec<Junction>,
    branches: Vec<Branch>,
}

impl Tree {
    /// Takes a lumen apart, for cells of this cross-section whose length along the branches is `along` radii.
    ///
    /// # Errors
    /// If a junction cannot be meshed.
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
        };
        tree.divide(&all, None)?;
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

    /// The mesh: patches of the openings, first that where the lines begin, then where each ends; and of the walls of
    /// the branches with these openings, in the same order, and of all others.
    ///
    /// # Errors
    /// If a branch cannot be meshed.
    pub fn mesh(&self, openings: &[String], walls: &[String]) -> Result<PolyMesh, TreeError> {
        let grid = &self.slicer.grid;
        let (quads, outer) = (grid.quads(), grid.rings.len());
        let (mut points, mut hexes): (Vec<Vec3>, Vec<[usize; 8]>) = Default::default();
        let patch = |name, kind| PatchFaces {
            name,
            kind,
            faces: Vec::new(),
        };
        let mut patches: Vec<PatchFaces<'_>> = (openings.iter())
            .map(|name| patch(name, "patch"))
            .chain(walls.iter().map(|name| patch(name, "wall")))
            .collect();
        // Points of the junctions, to be found again.
        let mut shared: Vec<Vec<usize>> = vec![Vec::new(); self.junctions.len()];
        for branch in &self.branches {
            let sections = self.sections(branch)?;
            let last = sections.len() - 1;
            let wall = match (branch.from, branch.to) {
                (None, _) => 0,
                (Some(_), None) => 1 + branch.line,
                (Some(_), Some(_)) => walls.len() - 1,
            };
            let mut below: Vec<usize> = Vec::new();
            for (j, section) in sections.iter().enumerate() {
                let junction = match j {
                    0 => branch.from.map(|(junction, _)| junction),
                    j if j == last => branch.to,
                    _ => None,
                };
                let close = 1e-6 * (section.rim[0] - section.centre).norm();
                let numbers = grid.positions(section).into_iter().map(|x| {
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
                let here: Vec<usize> = numbers.collect();
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
                    patches[openings.len() + wall].faces.extend(faces);
                }
                let opening = match j {
                    0 if branch.from.is_none() => Some(0),
                    j if j == last && branch.to.is_none() => Some(1 + branch.line),
                    _ => None,
                };
                if let Some(opening) = opening {
                    patches[opening].faces =
                        quads.iter().map(|quad| quad.map(|i| here[i])).collect();
                }
                below = here;
            }
        }
        Ok(PolyMesh::from_hexes(points, &hexes, &patches))
    }

    /// The cross-sections of a branch, downstream.
    fn sections(&self, branch: &Branch) -> Result<Vec<CrossSection>, TreeError> {
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
            return Err(TreeError::Close(
                line.at(0.5 * (begin + end)),
                radii.max(0.0),
            ));
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
        for (i, (s, tangent)) in stations.iter().zip(&tangents).enumerate() {
            let share = (s - begin) / (end - begin);
            // Without a kink at the ends.
            let turned = frames.turn * share * share * (3.0 - 2.0 * share);
            let first = &frames.first[i];
            sections.push(self.slicer.plane(line.at(*s), tangent, first, turned)?);
        }
        if let Some((junction, daughter)) = branch.from {
            let folded = self.junctions[junction].section(Some(daughter));
            let (plane, radius) = (&sections[0], line.radius(begin));
            let between = self
                .slicer
                .unfolding(folded, plane, &tangents[0], radius, false)?;
            sections.splice(0..0, between);
        }
        if let Some(junction) = branch.to {
            let mut folded = self.junctions[junction].section(None);
            folded
                .rim
                .rotate_right(frames.quarters * self.slicer.grid.core);
            let (plane, tangent) = (&sections[sections.len() - 1], &tangents[tangents.len() - 1]);
            let radius = line.radius(end);
            let mut between = self
                .slicer
                .unfolding(folded, plane, tangent, radius, true)?;
            between.reverse();
            sections.extend(between);
        }
        Ok(sections)
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
