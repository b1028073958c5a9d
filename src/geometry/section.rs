//! Sections of a vessel, one after the other.

use crate::interpolation::MonotoneCubic;
use std::f64::consts::PI;

/// A part of a vessel with the same layers throughout.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// What it is called.
    pub name: String,
    /// Arc length of its beginning, m.
    pub from: f64,
    /// Arc length of its end, m.
    pub to: f64,
    /// Whether its wall is elastic.
    pub is_elastic: bool,
    /// What the distances of the surfaces are counted from.
    pub(super) base: Base,
    /// Distance (m) of each surface, from the lumen outward.
    pub(super) surfaces: Vec<f64>,
    /// Material of each layer, an index into the vessel's list.
    pub(super) materials: Vec<usize>,
    /// Length (m) over which the section before it blends into it.
    pub(super) blend: f64,
}

/// What the distances of a section's surfaces are counted from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Base {
    /// The centre-line.
    CentreLine,
    /// A lumen with a radius that depends on the arc length.
    Lumen(MonotoneCubic),
}

impl Section {
    /// Distance (m) of surface `index` from the centre-line, as if there were no other section.
    pub(super) fn surface(&self, index: usize, s: f64) -> f64 {
        let base = match &self.base {
            Base::CentreLine => 0.0,
            Base::Lumen(law) => law.at(s),
        };
        base + self.surfaces[index]
    }

    /// Share of this section against those before it at `s`: half a cosine over the blend from 0 to 1.
    pub(super) fn share(&self, s: f64) -> f64 {
        if self.blend == 0.0 {
            return if s < self.from { 0.0 } else { 1.0 };
        }
        let from_joint = (s - self.from) / self.blend;
        0.5 * (1.0 - (PI * (from_joint + 0.5).clamp(0.0, 1.0)).cos())
    }
}
