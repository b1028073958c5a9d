//! What lies between the folded cross-section of a junction and the first plane one of a branch.

use super::error::TreeError;
use super::section::CrossSection;
use super::slicer::Slicer;
use crate::Vec3;
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// The way from a folded cross-section to a plane one: parabolas that end along the branch.
pub struct Unfolding<'a> {
    slicer: &'a Slicer,
    folded: CrossSection,
    plane: CrossSection,
    /// Unit vector along the branch where it ends.
    end: Vec3,
    /// Of the cross-sections, from 0 to 1.
    places: Vec<f64>,
}

impl<'a> Unfolding<'a> {
    /// To a plane cross-section of this radius (m), which lies upstream or downstream of the folded one across
    /// `tangent`.
    pub fn new(
        slicer: &'a Slicer,
        folded: CrossSection,
        plane: CrossSection,
        tangent: &Vec3,
        radius: f64,
        upstream: bool,
    ) -> Self {
        let cells = (plane.centre - folded.centre).norm() / (slicer.along * radius);
        let least = 2.0 / slicer.grid.degree() as f64;
        Self {
            places: slicer.grid.divided(cells.max(least)),
            end: if upstream { -tangent } else { *tangent },
            slicer,
            folded,
            plane,
        }
    }

    /// How many intervals its cross-sections divide it into.
    pub fn intervals(&self) -> usize {
        self.places.len() - 1
    }

    /// The cross-sections of these numbers; the first of all is the folded one, the last one the plane one.
    pub fn sections(&self, numbers: RangeInclusive<usize>) -> Result<Vec<CrossSection>, TreeError> {
        let sections = numbers.into_par_iter().map(|number| self.section(number));
        // Of several mistakes always the same one.
        let sections: Vec<Result<CrossSection, TreeError>> = sections.collect();
        sections.into_iter().collect()
    }

    fn section(&self, number: usize) -> Result<CrossSection, TreeError> {
        if number == 0 {
            return Ok(self.folded.clone());
        }
        if number == self.intervals() {
            return Ok(self.plane.clone());
        }
        let u = self.places[number];
        let centre = self.on(&self.folded.centre, &self.plane.centre, u);
        let near = self.slicer.lumen.near(&centre);
        let rim = self.folded.rim.iter().zip(&self.plane.rim).map(|(a, b)| {
            let beside = self.on(a, b, u);
            let wall = near.wall(&centre, &(beside - centre).normalize());
            // In a sharp bend rays may look along the branch.
            let wall = wall.or_else(|| near.nearest(&beside));
            wall.ok_or(TreeError::Open(centre))
        });
        let mut section = CrossSection::new(centre, rim.collect::<Result<_, _>>()?);
        if let Some(inner) = &self.folded.inner {
            let arms = |section: &CrossSection, a: usize| section.rim[a] - section.centre;
            let off = |a: usize| (inner[a] - arms(&self.folded, a)) * (1.0 - u);
            let inner = (0..inner.len()).map(|a| arms(&section, a) + off(a));
            section.inner = Some(inner.collect());
        }
        Ok(section)
    }

    /// On the parabola from one point to another.
    fn on(&self, a: &Vec3, b: &Vec3, u: f64) -> Vec3 {
        let control = b - self.end * (0.5 * (b - a).norm());
        a * (1.0 - u).powi(2) + control * (2.0 * u * (1.0 - u)) + b * (u * u)
    }

    /// All cross-sections but the plane one, and the place of each on the way, from 0 to 1.
    pub fn all_folded(mut self) -> Result<(Vec<CrossSection>, Vec<f64>), TreeError> {
        let sections = self.sections(0..=self.intervals() - 1)?;
        self.places.pop();
        Ok((sections, self.places))
    }
}
