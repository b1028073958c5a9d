//! A vessel that branches: `[tree]` of a case, whose lumen is meshed by the driver and whose wall is extruded from it.

use super::opening::{ConditionKeys, Opening, VesselSide, prescribe_shares};
use super::schema::{Key, KeyTable, Schema, ValueKind, above, from, join, whole};
use super::table::choice;
use super::tree_lumen::MOST_TRIANGLES;
use super::vessel::MOST_POINTS;
use super::{BumpProfile, LengthUnit, NativeTimeScheme, OwnCase, TableError};
use crate::Vec3;
use crate::curve::{CentreLine, Partings};
use crate::table;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The key to blame, and what is wrong.
pub type Mistake = (String, String);

/// No vessel is so far (m) from the origin of its coordinates.
pub(super) const FAR: f64 = 100.0;
/// Most ends of a tree: the adapter carries 64 openings.
pub const MAX_ENDS: usize = 63;
/// How the names of the patches begin at which blood and wall meet; that of a branch with an opening goes on with the
/// name of that.
pub(super) const WALL: &str = "wallFsi";
/// What the branches are called that lie between two junctions.
pub(super) const BETWEEN: &str = "between";
table! {
    /// A vessel that branches, by the centre-lines from its beginning to each of its ends.
    #[derive(Default)]
    pub struct TreeKeys {
        lines: Option<PathBuf> = "lines", ValueKind::Path, "file with the centre-lines of all branches and their radii: .vtp, .vtk or .swc",
            absent "tree.line";
        unit: Option<LengthUnit> = "unit", ValueKind::Word(LengthUnit::WORDS), "unit of the lengths in that file, or those of tree.line",
            absent "needed with a file";
        inlet: Option<String> = "inlet", ValueKind::Text(30), "name of the opening where the lines begin", absent "inlet";
        outlets: Vec<String> = "outlets", ValueKind::Names(63), "names of the openings where they end, in the order of the lines",
            absent "those of tree.line, or outlet1, outlet2 and so on";
        closed: Vec<String> = "closed", ValueKind::Names(63), "which of these are no openings: lines that end with half a sphere, as an aneurysm does",
            absent "none";
        leave_out: Vec<String> = "leave_out", ValueKind::Names(200), "which of these are no part of the vessel: their lines, and branches that lead to them alone, are left out",
            absent "none";
        least_radius: Option<f64> = "least_radius_m", above(0.0, 1.0), "radius of the thinnest vessel that counts: each line ends where it is last as wide, and branches that are thinner are no part of the vessel",
            absent "all of the lines";
        junction_smoothing: Option<f64> = "junction_smoothing", from(0.0, 10.0), "points of the lines within so many radii of where branches part are left out: smooth curves lead through",
            absent "the lines are as the file has them";
        smoothing: Option<f64> = "smoothing_m", from(0.0, 1.0), "length of the waves of the lines that are halved",
            absent "the lines are as the file has them";
        lumen: Option<PathBuf> = "lumen", ValueKind::Path, "file with the surface of the whole lumen, open or closed at its ends: .stl, .vtp, .vtk, .ply or .obj",
            absent "the tubes around the lines";
        lumen_unit: Option<LengthUnit> = "lumen_unit", ValueKind::Word(LengthUnit::WORDS), "unit of the lengths in that file", absent "tree.unit";
        lumen_smoothing: Option<f64> = "lumen_smoothing_m", from(0.0, 1.0), "length of the waves of that surface that are halved",
            absent "three times the median length of an edge";
        lumen_points: Vec<[f64; 3]> = "lumen_points_m", ValueKind::Points(MOST_TRIANGLES), "points of triangles that are the surface of the lumen, in place of a file",
            absent "tree.lumen";
        lumen_triangles: Vec<[usize; 3]> = "lumen_triangles", ValueKind::Triples(MOST_TRIANGLES), "the three of tree.lumen_points_m that are the corners of each triangle, counted from 0",
            absent "tree.lumen";
        core: Option<usize> = "core", whole(2, 40), "cells along a side of the square in the middle of a cross-section, an even number", absent "6";
        radial: Option<usize> = "radial", whole(1, 100), "cells from that square to the wall", absent "5";
        wall_grading: Option<f64> = "wall_grading", from(0.1, 100.0), "thickness of the innermost ring over that at the wall", absent "3";
        length: Option<f64> = "length", above(0.0, 10.0), "length of a cell along a branch, in radii", absent "0.4";
        [native: Option<TreeElements>, "the driver's own elements in the lumen", only NATIVE]
        [line: Option<Vec<TreeLine>>, "centre-lines in place of that file: points of the case, or a file for each branch"]
        [opening: Option<Vec<TreeOpening>>, "what is prescribed at the openings"]
        [feature: Option<Vec<TreeFeature>>, "narrowings and widenings of branches"]
    }
}

choice! {
    /// A part of a branch that is narrower or wider than the lines and the surface say.
    pub enum TreeFeature by "feature", "what is there" {
        /// A narrowing that thickens the wall inward.
        Stenosis = "stenosis" {
            branch: String = "branch", ValueKind::Text(30), "the branch that it is on: one with an opening of its own, by its name";
            at: f64 = "at_m", from(0.0, 10.0), "arc length along that branch of its middle";
            length: f64 = "length_m", above(0.0, 10.0), "its length; with a Gaussian profile four standard deviations";
            area_reduction: f64 = "area_reduction", above(0.0, 0.99), "share of the lumen's area that is lost in the middle";
            profile: Option<BumpProfile> = "profile", ValueKind::Word(BumpProfile::WORDS), "how it begins and ends", absent "cosine";
        }
        /// A widening with the whole wall.
        Aneurysm = "aneurysm" {
            branch: String = "branch", ValueKind::Text(30), "the branch that it is on: one with an opening of its own, by its name";
            at: f64 = "at_m", from(0.0, 10.0), "arc length along that branch of its middle";
            length: f64 = "length_m", above(0.0, 10.0), "its length; with a Gaussian profile four standard deviations";
            growth: f64 = "growth_m", above(0.0, 0.1), "growth of the lumen's radius in the middle";
            profile: Option<BumpProfile> = "profile", ValueKind::Word(BumpProfile::WORDS), "how it begins and ends", absent "cosine";
        }
    }
}

impl TreeFeature {
    /// The branch that it is on.
    pub fn branch(&self) -> &str {
        match self {
            Self::Stenosis { branch, .. } | Self::Aneurysm { branch, .. } => branch,
        }
    }

    /// Arc length (m) along that of its middle.
    pub fn at(&self) -> f64 {
        match self {
            Self::Stenosis { at, .. } | Self::Aneurysm { at, .. } => *at,
        }
    }
}

table! {
    /// Spectral elements in the lumen of a tree: fewer than there are cells, of high degree.
    #[derive(Default)]
    pub struct TreeElements {
        /// That of the pressure is one less.
        degree: Option<usize> = "degree", whole(3, 8), "degree of the velocity and of the elements' shape", absent "4";
        core: Option<usize> = "core", whole(2, 40), "elements along a side of the square in the middle of a cross-section, an even number", absent "2";
        radial: Option<usize> = "radial", whole(1, 50), "elements from that square to the wall", absent "2";
        wall_grading: Option<f64> = "wall_grading", from(0.1, 100.0), "thickness of the innermost ring over that at the wall", absent "1.5";
        length: Option<f64> = "length", above(0.0, 10.0), "length of an element along a branch, in radii", absent "1";
        time_scheme: Option<NativeTimeScheme> = "time_scheme", ValueKind::Word(NativeTimeScheme::WORDS),
            "time integration of the blood by the driver's own solver", absent "time.scheme";
    }
}

impl TreeElements {
    /// That of the velocity.
    pub fn degree(&self) -> usize {
        self.degree.unwrap_or(4)
    }
}

table! {
    /// A centre-line from the beginning of a tree to one of its ends, or from another line on.
    #[derive(Default)]
    pub struct TreeLine {
        name: Option<String> = "name", ValueKind::Text(30), "name of the line, and of the opening where it ends", absent "outlet1, outlet2 and so on";
        file: Option<PathBuf> = "file", ValueKind::Path, "file with its points and radii: CSV with the columns x,y,z,r", absent "tree.line.points_m";
        from: Option<String> = "from", ValueKind::Text(30), "name of the line that it begins on, at the place that is nearest to its first point",
            absent "the nearest line, or none of one that begins at the inlet";
        points: Vec<[f64; 3]> = "points_m", ValueKind::Points(MOST_POINTS), "points of the centre-line", absent "tree.line.file";
        radii: Vec<f64> = "radii_m", ValueKind::Sizes(MOST_POINTS), "radius of the lumen at each of these points", absent "tree.line.file";
    }
}

/// What is prescribed at an opening of a tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TreeOpening {
    /// `name`: that of the opening.
    pub name: String,
    /// The others.
    #[serde(flatten)]
    pub condition: ConditionKeys,
}

impl KeyTable for TreeOpening {
    fn describe(path: &str, schema: &mut Schema) {
        schema.add(Key {
            path: join(path, "name"),
            kind: ValueKind::Text(30),
            absent: None,
            about: "name of the opening: tree.inlet, or one of tree.outlets",
            choices: Vec::new(),
            problems: &[],
            only: Vec::new(),
        });
        ConditionKeys::describe(path, schema);
    }
}

impl TreeLine {
    /// The curve through its points, unless they or the radii are too few, two points are the same, or one is so far
    /// away that a curve to it has no end.
    pub fn curve(&self) -> Option<CentreLine> {
        let points: Vec<Vec3> = self.points.iter().map(|x| Vec3::from(*x)).collect();
        let is_curve = points.len() > 1
            && points.len() == self.radii.len()
            && points.windows(2).all(|pair| pair[0] != pair[1])
            && points.iter().flatten().all(|x| x.abs() <= FAR)
            && self.radii.iter().all(|r| *r > 0.0);
        is_curve.then(|| CentreLine::new(&points, &self.radii))
    }
}

impl TreeKeys {
    /// The driver's own elements.
    pub fn elements(&self) -> TreeElements {
        self.native.clone().unwrap_or_default()
    }

    /// Names of the openings, that where the lines begin first.
    pub fn open_names(&self) -> Vec<String> {
        let mut names = self.names();
        names.retain(|name| !self.closed.contains(name));
        names
    }

    /// Names of all ends, open and closed, that where the lines begin first.
    pub fn names(&self) -> Vec<String> {
        let inlet = self.inlet.clone().unwrap_or_else(|| "inlet".into());
        let lines = self.line.iter().flatten().enumerate();
        let outlet = |(i, line): (usize, &TreeLine)| {
            let given = self.outlets.get(i).or(line.name.as_ref());
            given.cloned().unwrap_or_else(|| format!("outlet{}", i + 1))
        };
        [inlet].into_iter().chain(lines.map(outlet)).collect()
    }

    /// Names of the patches of the wall: of the branch at each opening, and of all others if there are some.
    pub fn walls(&self) -> Vec<String> {
        let names = self.names();
        let others = self.divides_twice().then(|| WALL.to_owned());
        let at_openings = names.iter().map(|name| format!("{WALL}_{name}"));
        at_openings.chain(others).collect()
    }

    /// Names of the branches that the patches of the wall are of.
    pub fn branches(&self) -> Vec<String> {
        let mut names = self.names();
        if self.divides_twice() {
            names.push(BETWEEN.into());
        }
        names
    }

    /// Whether there is more than one junction, and so a branch that has no opening.
    fn divides_twice(&self) -> bool {
        let given = || self.line.iter().flatten();
        if given().count() < 3 {
            return false;
        }
        let Some(lines) = given().map(TreeLine::curve).collect::<Option<Vec<_>>>() else {
            return true;
        };
        let all: Vec<usize> = (0..lines.len()).collect();
        let fork = Partings::new(&lines).fork(&lines, &all);
        !fork.is_ok_and(|fork| fork.daughters.iter().all(|(class, _)| class.len() == 1))
    }

    /// On which side of the blood's way an opening is.
    pub(super) fn side(&self, name: &str) -> VesselSide {
        match self.names()[0] == name {
            true => VesselSide::Start,
            false => VesselSide::End,
        }
    }

    /// What is prescribed at each opening, that where the lines begin first, in beats of `period` (s).
    ///
    /// # Errors
    /// If a curve cannot be read.
    pub fn openings(&self, period: f64) -> Result<Vec<Opening>, TableError> {
        let mut openings = Vec::new();
        for name in self.names() {
            let keys = self.opening.iter().flatten().find(|keys| keys.name == name);
            let Some(keys) = keys else { continue };
            let end = self.side(&name);
            openings.push(Opening {
                condition: keys.condition.read(end, period)?,
                name,
                end,
            });
        }
        prescribe_shares(&mut openings);
        Ok(openings)
    }
}

impl TreeKeys {
    /// Reads the files that it names.
    ///
    /// # Errors
    /// The key to blame, and what is wrong.
    pub fn read(&mut self) -> Result<(), Mistake> {
        self.read_lines().map_err(|mut all| all.swap_remove(0))?;
        let surface = self.read_lumen().map(|_| ());
        surface.map_err(|(key, reason)| (key.into(), reason))
    }
}

impl OwnCase {
    /// Reads the files of the centre-lines, if the case names some: they then stand in it, and so do patches and
    /// openings.
    ///
    /// # Errors
    /// What is wrong.
    pub(super) fn read_tree(&mut self) -> Result<(), Vec<Mistake>> {
        let Some(tree) = &mut self.tree else {
            return Ok(());
        };
        tree.read_lines()?;
        if self.fluid.case.is_none() {
            self.fluid.patches = tree.walls();
            self.fluid.openings = tree.open_names();
        }
        Ok(())
    }
}
