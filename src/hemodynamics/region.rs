//! The parts of the vessel that are evaluated one by one.

use crate::case::{Anastomosis, Case, Problem};
use serde::{Deserialize, Serialize};

/// Which part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RegionName {
    /// The graft.
    Bypass,
    /// The artery.
    Artery,
    /// The artery without the influence of joint and outlet; the paper's 0.03375 m to 0.05625 m.
    MidArtery,
}

impl std::fmt::Display for RegionName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Bypass => "bypass",
            Self::Artery => "artery",
            Self::MidArtery => "mid-artery",
        })
    }
}

/// A part of the vessel between two cross-sections.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Which part.
    pub name: RegionName,
    /// Its beginning along the axis of the unloaded vessel, m.
    pub from_m: f64,
    /// Its end, m.
    pub to_m: f64,
}

impl Region {
    /// The regions of a case. The last one begins where the blend of the cross-sections ends, and ends as far from the
    /// outlet; there is none if the artery is too short for it. A flag is no vessel and has no regions.
    pub fn of(case: &Case) -> Vec<Self> {
        let Problem::Anastomosis(Anastomosis { geometry, .. }) = &case.problem else {
            return Vec::new();
        };
        let joint = geometry.graft_length;
        let end = joint + geometry.artery_length;
        let margin = 0.5 * geometry.blend_length;
        let regions = [
            (RegionName::Bypass, 0.0, joint),
            (RegionName::Artery, joint, end),
            (RegionName::MidArtery, joint + margin, end - margin),
        ];
        let some = regions.into_iter().filter(|(_, from, to)| from < to);
        some.map(|(name, from_m, to_m)| Self { name, from_m, to_m })
            .collect()
    }

    /// Whether the position `x` (m) lies in it.
    pub fn contains(&self, x: f64) -> bool {
        (self.from_m..=self.to_m).contains(&x)
    }

    /// Share of the interval from `low` to `high` (m) that lies in it.
    pub fn share(&self, low: f64, high: f64) -> f64 {
        let common = high.min(self.to_m) - low.max(self.from_m);
        // Cross-sections of the mesh lie on the borders up to rounding.
        let share = (common / (high - low)).clamp(0.0, 1.0);
        match share {
            s if s < 1e-6 => 0.0,
            s if s > 1.0 - 1e-6 => 1.0,
            s => s,
        }
    }
}
