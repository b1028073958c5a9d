//! The wall of a case in figures, without blood: how wide it stands under the pressures that its windkessel will make,
//! and how far they are from buckling.

use crate::Vec3;
use crate::curve::SpaceCurve;
use crate::geometry::{HexFace, HexMesh, Section as VesselSection, is_side, outer_side_of};
use crate::pfem::element::surface::{directions, on_face};
use crate::pfem::solution::stability::Bifurcation;
use crate::pfem::solution::statics::{self, StaticOptions};
use crate::pfem::{SolidError, Structure, supports};
use nalgebra::Vector2;
use std::collections::{BTreeMap, BTreeSet};

/// Pieces of a side of an element in which the volume of the lumen is measured.
const PIECES: usize = 8;
/// Up to this multiple of the highest pressure buckling is looked for.
const REACH: f64 = 2.0;

/// The lumen in the middle of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionFigures {
    /// What the section is called.
    pub name: String,
    /// Mean radius without load, m.
    pub radius: f64,
    /// Mean radius under each pressure, m.
    pub loaded_radii: Vec<f64>,
    /// Shift of the centre under each pressure, m.
    pub shifts: Vec<f64>,
}

/// The lumen along a branch, or over another part of the wall.
#[derive(Debug, Clone, PartialEq)]
pub struct PartFigures {
    /// What the part is called.
    pub name: String,
    /// How far its inner side moves outwards under each pressure, mean over its area, m.
    pub widenings: Vec<f64>,
}

/// The wall under its pressures.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WallFigures {
    /// Pressures of the figures, Pa, as far as the wall carries them.
    pub pressures: Vec<f64>,
    /// Share of each that the tissue around the wall carries; see [`Structure::tissue_share`].
    pub tissue_shares: Vec<f64>,
    /// In the middle of each section of a vessel.
    pub sections: Vec<SectionFigures>,
    /// Along each branch of a tree.
    pub parts: Vec<PartFigures>,
    /// Volume of the lumen relative to that without load, of a tree.
    pub volumes: Vec<f64>,
    /// Volume of the lumen without load, of a tree, m³.
    pub lumen_volume: f64,
    /// Pressure (Pa) at which this wall loses its stability, if below [`Self::reach`].
    pub buckling: Option<f64>,
    /// The same for the wall without its imperfection: an imperfect wall bends more and more on the way there.
    pub perfect_buckling: Option<f64>,
    /// Highest pressure under which an equilibrium was looked for and found, or stability lost, Pa.
    pub reach: f64,
    /// Whether none was found on the way to twice the highest pressure.
    pub is_cut_short: bool,
}

/// Where a piece of a side of an element begins, from -1 to 1.
fn along(piece: usize) -> f64 {
    2.0 * piece as f64 / PIECES as f64 - 1.0
}

/// Volume (m³) between a triangle and the origin.
fn cone(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    a.dot(&b.cross(&c)) / 6.0
}

/// A wall in its unloaded shape that can be put under pressure.
pub struct InflatableWall<'a> {
    /// The wall, unloaded.
    pub solid: &'a Structure,
    /// Its mesh, in the shape that the case gives.
    pub mesh: &'a HexMesh,
    /// Displacement whose values at held coefficients the ends are moved to, if they are.
    pub moved: Option<&'a [f64]>,
    /// The centre-line, in the shape that the case gives.
    pub line: &'a SpaceCurve,
}

impl InflatableWall<'_> {
    /// Equilibrium under a pressure (Pa) inside and the one around, which grow together, or up to where stability is
    /// lost.
    fn inflate(&self, pressure: f64) -> Result<statics::Equilibrated, SolidError> {
        let options = StaticOptions {
            tolerance: 1e-6,
            ..Default::default()
        };
        self.solid.inflate(pressure, self.moved, &options)
    }

    /// The way to equilibrium under a pressure (Pa), from which those under lower ones are found.
    fn path(&self, pressure: f64) -> Result<Path<'_>, SolidError> {
        Ok(Path {
            wall: self,
            pressure,
            found: self.inflate(pressure)?,
        })
    }

    /// The same to [`REACH`] times a pressure (Pa), or to that pressure where the wall finds no equilibrium on the way:
    /// stretched or stiffening walls may have none far above what they will see, which must not hide the rest.
    fn far_path(&self, pressure: f64) -> Result<Path<'_>, SolidError> {
        match self.path(REACH * pressure) {
            Err(SolidError::NoEquilibrium(_)) => self.path(pressure),
            found => found,
        }
    }

    /// Where a point of an element is, m, for a displacement.
    fn place(&self, element: usize, xi: [f64; 3], displacement: &[f64]) -> Vec3 {
        let body = self.solid.body();
        body.mapping.at(element, xi).position + body.displacement_at(element, xi, displacement)
    }

    /// Volume of the lumen (m³) for a displacement, by the theorem of Gauss.
    fn lumen_volume(&self, displacement: &[f64]) -> Result<f64, SolidError> {
        let inner = supports::surface(self.mesh, "inner")?;
        let mut volume = self.volume_at_ends(inner, displacement);
        for &(e, face) in inner {
            let at =
                |i: usize, j: usize| self.place(e, on_face(face, along(i), along(j)), displacement);
            for (i, j) in (0..PIECES * PIECES).map(|n| (n / PIECES, n % PIECES)) {
                let [a, b, c, d] =
                    [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| at(i, j));
                volume += cone(a, b, c) + cone(a, c, d);
            }
        }
        Ok(volume.abs())
    }

    /// The part of the triangles that close the lumen, from its rims to their middles.
    fn volume_at_ends(&self, inner: &[(usize, HexFace)], displacement: &[f64]) -> f64 {
        let inner: BTreeMap<usize, HexFace> = inner.iter().copied().collect();
        let rims = (self.mesh.surfaces.iter()).filter(|(name, _)| !is_side(name));
        let mut volume = 0.0;
        for (_, faces) in rims {
            let mut edges = Vec::new();
            for (e, rim) in faces {
                let Some(face) = inner.get(e) else { continue };
                let is_first = rim.axis as usize == directions(*face)[0];
                // Around the face, counter-clockwise seen from within the wall.
                let is_forward = is_first == rim.upper;
                let end = if rim.upper { 1.0 } else { -1.0 };
                let at = |i: usize| {
                    let t = along(if is_forward { i } else { PIECES - i });
                    let (a, b) = if is_first { (end, t) } else { (t, end) };
                    self.place(*e, on_face(*face, a, b), displacement)
                };
                edges.extend((0..PIECES).map(|i| (at(i), at(i + 1))));
            }
            let middle = edges.iter().map(|(a, _)| a).sum::<Vec3>() / edges.len().max(1) as f64;
            volume += edges.iter().map(|(a, b)| cone(*b, *a, middle)).sum::<f64>();
        }
        volume
    }

    /// How far (m) the inner side moves outwards along a branch, mean over its area, for a displacement.
    fn widening(&self, branch: &str, displacement: &[f64]) -> Result<f64, SolidError> {
        let body = self.solid.body();
        let inner = supports::surface(self.mesh, "inner")?;
        // The elements over a face are numbered one after the other, and the last one is outside.
        let through = self.mesh.hexes.len() / inner.len();
        let outside = supports::surface(self.mesh, &outer_side_of(branch))?;
        let outside: BTreeSet<usize> = outside.iter().map(|(e, _)| *e).collect();
        let is_here = |e: usize| outside.contains(&(e + through - 1));
        let (mut swept, mut area) = (0.0, 0.0);
        for &(e, face) in inner.iter().filter(|(e, _)| is_here(*e)) {
            let place = |a: f64, b: f64| body.mapping.at(e, on_face(face, a, b)).position;
            let diagonals = [
                place(1.0, 1.0) - place(-1.0, -1.0),
                place(-1.0, 1.0) - place(1.0, -1.0),
            ];
            let across = 0.5 * diagonals[0].cross(&diagonals[1]);
            let within = body.mapping.at(e, [0.0; 3]).position - place(0.0, 0.0);
            let outwards = across * across.dot(&within).signum();
            swept += body
                .displacement_at(e, on_face(face, 0.0, 0.0), displacement)
                .dot(&outwards);
            area += across.norm();
        }
        Ok(swept / area)
    }

    /// Mean radius and centre of the lumen around `x` (m), for a displacement.
    fn lumen(&self, x: f64, displacement: &[f64]) -> Result<(f64, Vector2<f64>), SolidError> {
        let faces = supports::surface(self.mesh, "inner")?;
        let middle = |&(e, _): &(usize, HexFace)| {
            let vertices = self.mesh.hexes[e].iter().map(|&v| self.mesh.vertices[v]);
            (self.line.nearest(&(vertices.sum::<Vec3>() / 8.0)).s - x).abs()
        };
        let frame = self.line.frame(x);
        let nearest = faces.iter().map(middle).fold(f64::INFINITY, f64::min);
        // The ring of elements whose middle is closest.
        let ring = faces
            .iter()
            .filter(|face| middle(face) < nearest * (1.0 + 1e-6) + 1e-9);
        let mut places = Vec::new();
        for &(e, face) in ring {
            for (a, b) in [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)] {
                let xi = on_face(face, a, b);
                let place = self.solid.body().mapping.at(e, xi).position
                    + self.solid.body().displacement_at(e, xi, displacement);
                places.push(Vector2::from(frame.across(&(place - frame.origin))));
            }
        }
        let count = places.len() as f64;
        let centre = places.iter().sum::<Vector2<f64>>() / count;
        let radius = places
            .iter()
            .map(|place| (place - centre).norm())
            .sum::<f64>()
            / count;
        Ok((radius, centre))
    }
}

/// Equilibria of a wall under pressures that rise.
struct Path<'a> {
    wall: &'a InflatableWall<'a>,
    /// The highest, Pa.
    pressure: f64,
    found: statics::Equilibrated,
}

impl Path<'_> {
    /// Displacement under a pressure (Pa) on the way; `None` beyond the bifurcation.
    fn at(&self, pressure: f64) -> Result<Option<Vec<f64>>, SolidError> {
        let (solid, found) = (self.wall.solid, &self.found);
        let start = solid.pressure_at(0.0, self.pressure);
        let factor = (pressure - start) / (self.pressure - start);
        let is_lost = |at: &Bifurcation| at.factor <= factor;
        if found.bifurcation.as_ref().is_some_and(is_lost) {
            return Ok(None);
        }
        if factor == 1.0 {
            return Ok(Some(found.displacement.clone()));
        }
        let unloaded = (0.0, &found.unloaded);
        let steps = found
            .steps
            .iter()
            .map(|step| (step.factor, &step.displacement));
        let known: Vec<(f64, &Vec<f64>)> = [unloaded].into_iter().chain(steps).collect();
        let upper = known.iter().position(|(at, _)| *at > factor);
        // Tissue that rests under a higher pressure has the way begin there.
        let near = match upper {
            None | Some(0) => None,
            Some(i) => {
                let [(a, lower), (b, upper)] = [known[i - 1], known[i]];
                let share = (factor - a) / (b - a);
                let pairs = lower.iter().zip(upper);
                let start = pairs.map(|(lower, upper)| lower + share * (upper - lower));
                solid.equilibrium_from(pressure, start.collect()).ok()
            }
        };
        let directly = || -> Result<_, SolidError> {
            let found = self.wall.inflate(pressure)?;
            Ok(found.bifurcation.is_none().then_some(found.displacement))
        };
        near.map_or_else(directly, |near| Ok(Some(near)))
    }

    /// Where stability is lost, Pa.
    fn buckling(&self) -> Option<f64> {
        let at = |found: &Bifurcation| self.wall.solid.pressure_at(found.factor, self.pressure);
        self.found.bifurcation.as_ref().map(at)
    }
}

impl WallFigures {
    /// A vessel's wall with these sections under these `pressures` (Pa, ascending); `perfect` is the same without its
    /// imperfection, if it has one.
    ///
    /// # Errors
    /// If the wall finds no equilibrium.
    pub fn new(
        wall: &InflatableWall,
        perfect: Option<&InflatableWall>,
        sections: &[VesselSection],
        pressures: &[f64],
    ) -> Result<Self, SolidError> {
        let zero = vec![0.0; wall.solid.body().coefficients()];
        let section =
            |section: &VesselSection| -> Result<(SectionFigures, f64, Vector2<f64>), SolidError> {
                let x = 0.5 * (section.from + section.to);
                let (radius, centre) = wall.lumen(x, &zero)?;
                let empty = SectionFigures {
                    name: section.name.clone(),
                    radius,
                    loaded_radii: Vec::new(),
                    shifts: Vec::new(),
                };
                Ok((empty, x, centre))
            };
        let mut sections: Vec<_> = sections.iter().map(section).collect::<Result<_, _>>()?;
        let mut found = Self::under(wall, perfect, pressures, |displacement| {
            for (section, x, old) in &mut sections {
                let (radius, centre) = wall.lumen(*x, displacement)?;
                section.loaded_radii.push(radius);
                section.shifts.push((centre - *old).norm());
            }
            Ok(())
        })?;
        found.sections = sections.into_iter().map(|(section, ..)| section).collect();
        Ok(found)
    }

    /// The wall of a tree with these branches under these `pressures` (Pa, ascending).
    ///
    /// # Errors
    /// If the wall finds no equilibrium, or has no such branch.
    pub fn of_tree(
        wall: &InflatableWall,
        branches: &[String],
        pressures: &[f64],
    ) -> Result<Self, SolidError> {
        let zero = vec![0.0; wall.solid.body().coefficients()];
        let empty = wall.lumen_volume(&zero)?;
        let part = |name: &String| PartFigures {
            name: name.clone(),
            widenings: Vec::new(),
        };
        let (mut volumes, mut parts) = (Vec::new(), branches.iter().map(part).collect::<Vec<_>>());
        let mut found = Self::under(wall, None, pressures, |displacement| {
            volumes.push(wall.lumen_volume(displacement)? / empty);
            for part in &mut parts {
                part.widenings
                    .push(wall.widening(&part.name, displacement)?);
            }
            Ok(())
        })?;
        (found.volumes, found.parts) = (volumes, parts);
        found.lumen_volume = empty;
        Ok(found)
    }

    /// What holds of any wall under these pressures, each of whose displacements is `measured` as far as it carries
    /// them.
    fn under(
        wall: &InflatableWall,
        perfect: Option<&InflatableWall>,
        pressures: &[f64],
        mut measure: impl FnMut(&[f64]) -> Result<(), SolidError>,
    ) -> Result<Self, SolidError> {
        let mut found = Self::default();
        let highest = pressures.last().copied().unwrap_or(0.0);
        let path = match perfect {
            Some(_) => wall.path(highest)?,
            None => wall.far_path(highest)?,
        };
        for &pressure in pressures {
            let Some(displacement) = path.at(pressure)? else {
                found.buckling = path.buckling();
                break;
            };
            found.pressures.push(pressure);
            found
                .tissue_shares
                .push(wall.solid.tissue_share(pressure, &displacement));
            measure(&displacement)?;
        }
        let far = match perfect {
            Some(perfect) => &perfect.far_path(highest)?,
            None => &path,
        };
        (found.perfect_buckling, found.reach) = (far.buckling(), far.pressure);
        let alike = found.perfect_buckling.filter(|_| perfect.is_none());
        found.buckling = found.buckling.or(alike);
        found.is_cut_short = found.reach < REACH * highest;
        Ok(found)
    }
}

/// How a vessel stores blood.
#[derive(Debug, Clone, Copy)]
pub struct Storage {
    /// Volume by pressure, m³/Pa.
    pub compliance: f64,
    /// Volume of the lumen of the deformable part, m³: half way.
    pub volume: f64,
}

/// Volume that the lumen of a vessel gains by pressure between `lowest` and `highest` (Pa), per pressure, m³/Pa. `None`
/// if its wall buckles on the way.
///
/// # Errors
/// If the wall finds no equilibrium.
pub fn compliance(
    wall: &InflatableWall,
    lowest: f64,
    highest: f64,
) -> Result<Option<Storage>, SolidError> {
    let path = wall.path(highest)?;
    let mut volumes = [0.0; 2];
    for (volume, pressure) in volumes.iter_mut().zip([lowest, highest]) {
        let Some(displacement) = path.at(pressure)? else {
            return Ok(None);
        };
        *volume = wall.lumen_volume(&displacement)?;
    }
    Ok(Some(Storage {
        compliance: (volumes[1] - volumes[0]) / (highest - lowest),
        volume: 0.5 * (volumes[0] + volumes[1]),
    }))
}
