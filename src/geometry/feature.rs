//! What deviates from a vessel's sections: an imperfection, narrowings and widenings, random radii.

use super::Imperfection;
use super::lumen::LumenTable;
use super::random_radius::RandomRadius;
use crate::case::{self, BumpProfile};
use std::f64::consts::PI;

/// A deviation of the lumen, in which the wall's surfaces have a share.
#[derive(Debug, Clone, PartialEq)]
pub enum Feature {
    /// The paper's.
    Imperfection(Imperfection),
    /// A stenosis or an aneurysm.
    Bump(Bump),
    /// A lumen that is not a circle: the whole wall goes with it.
    Lumen(LumenTable),
    /// Random radii.
    Random(RandomRadius),
}

/// The share of a narrowing that surface `index` of `surfaces` has if the wall thickens inward evenly and its outer
/// surface stays.
pub fn thickening(index: usize, surfaces: usize) -> f64 {
    1.0 - index as f64 / (surfaces - 1).max(1) as f64
}

/// A part of a vessel where the cross-sections of the lumen are circles of another radius, which may lie off the
/// centre.
#[derive(Debug, Clone, PartialEq)]
pub struct Bump {
    /// Arc length of its middle, m.
    at: f64,
    /// Its length, m; with a Gaussian profile four standard deviations.
    length: f64,
    profile: BumpProfile,
    change: Change,
    /// How far the circles move to the side, as a share of the change of the radius.
    eccentricity: f64,
    /// Angle (rad) of the side on which the lumen keeps its place in a stenosis, and bulges out in an aneurysm.
    side: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Change {
    /// Share of the area that is lost in the middle.
    Stenosis(f64),
    /// Growth of the radius in the middle, m.
    Aneurysm(f64),
}

impl Bump {
    /// The feature that a case describes.
    pub fn new(keys: &case::Feature) -> Self {
        let (change, at, length, shape) = match keys {
            case::Feature::Stenosis {
                at,
                length,
                area_reduction,
                profile,
                eccentricity,
                side_deg,
            } => (
                Change::Stenosis(*area_reduction),
                *at,
                *length,
                (profile, eccentricity, side_deg),
            ),
            case::Feature::Aneurysm {
                at,
                length,
                growth,
                profile,
                eccentricity,
                side_deg,
            } => (
                Change::Aneurysm(*growth),
                *at,
                *length,
                (profile, eccentricity, side_deg),
            ),
        };
        let (profile, eccentricity, side) = shape;
        Self {
            at,
            length,
            profile: profile.unwrap_or_default(),
            change,
            eccentricity: eccentricity.unwrap_or(0.0),
            side: side.unwrap_or(0.0).to_radians(),
        }
    }

    /// 1 in the middle, 0 far away.
    fn shape(&self, s: f64) -> f64 {
        let from_middle = (s - self.at) / self.length;
        match self.profile {
            BumpProfile::Cosine => 0.5 * (1.0 + (2.0 * PI * from_middle.clamp(-0.5, 0.5)).cos()),
            BumpProfile::Gaussian => (-8.0 * from_middle * from_middle).exp(),
        }
    }

    /// By how much the radius `r` (m) is larger at `s` (m), m.
    fn change(&self, s: f64, r: f64) -> f64 {
        let shape = self.shape(s);
        match self.change {
            // The radius of the narrowed circle, so that the middle has exactly the area that is left.
            Change::Stenosis(reduction) => -r * (1.0 - (1.0 - reduction).sqrt()) * shape,
            Change::Aneurysm(growth) => growth * shape,
        }
    }

    /// The radius (m) at `s` (m) of circles that have the radius `r` (m) without it.
    pub(super) fn radius(&self, s: f64, r: f64) -> f64 {
        r + self.change(s, r)
    }

    /// By how much the lumen of the radius `r` (m) is narrower at `s` (m) and `phi`, m.
    fn depth(&self, s: f64, phi: f64, r: f64) -> f64 {
        let change = self.change(s, r);
        let (radius, off) = (r + change, self.eccentricity * change.abs());
        let psi = phi - self.side;
        // A circle whose centre lies off by that, in polar coordinates.
        r - (off * psi.cos() + (radius.powi(2) - (off * psi.sin()).powi(2)).sqrt())
    }
}

impl Feature {
    /// By how much surface `index` of `surfaces`, counted from the lumen outward, lies further inside at `s` (m) and
    /// `phi`, m; without features the lumen has the radius `r` (m) there.
    pub fn inward(&self, index: usize, surfaces: usize, s: f64, phi: f64, r: f64) -> f64 {
        match self {
            Self::Imperfection(imperfection) => {
                Imperfection::SHARE[index] * imperfection.depth(s, phi)
            }
            Self::Lumen(table) => r - table.radius(s, phi),
            Self::Random(random) => random.inward(index, s, phi),
            Self::Bump(bump) => {
                let share = match bump.change {
                    // What narrows the lumen thickens the wall: its outer surface stays.
                    Change::Stenosis(_) => thickening(index, surfaces),
                    // The wall goes out with the lumen.
                    Change::Aneurysm(_) => 1.0,
                };
                share * bump.depth(s, phi, r)
            }
        }
    }
}
