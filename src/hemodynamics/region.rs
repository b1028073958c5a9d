//! The parts of the vessel that are evaluated one by one.

use crate::Vec3;
use crate::case::{Case, Problem, Shape};
use crate::geometry::Vessel;
use arrayvec::ArrayString;
use serde::{Deserialize, Serialize};

/// Which part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub enum RegionName {
    /// The graft.
    Bypass,
    /// The artery.
    Artery,
    /// The artery without the influence of joint and outlet; the paper's 0.03375 m to 0.05625 m.
    MidArtery,
    /// A section or another part of a vessel that is not the paper's, as its case calls it.
    Section(ArrayString<MOST_BYTES>),
}

/// Longest name of a section: 30 characters.
const MOST_BYTES: usize = 120;

impl From<String> for RegionName {
    fn from(name: String) -> Self {
        match name.as_str() {
            "bypass" => Self::Bypass,
            "artery" => Self::Artery,
            "mid_artery" => Self::MidArtery,
            other => {
                let fitting = other
                    .char_indices()
                    .take_while(|(at, c)| at + c.len_utf8() <= MOST_BYTES);
                let mut name = ArrayString::new();
                fitting.for_each(|(_, c)| name.push(c));
                Self::Section(name)
            }
        }
    }
}

impl From<RegionName> for String {
    fn from(name: RegionName) -> Self {
        match name {
            RegionName::MidArtery => "mid_artery".into(),
            other => other.to_string(),
        }
    }
}

impl std::fmt::Display for RegionName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Section(name) => name,
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
    /// Its beginning along the centre-line of the unloaded vessel, m.
    pub from_m: f64,
    /// Its end, m.
    pub to_m: f64,
    /// Two opposite corners of the box that it lies in, m, where it is no part along a centre-line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub box_m: Option<[[f64; 3]; 2]>,
}

/// The whole wall of a case without regions: no wall is larger.
const EVERYWHERE: [[f64; 3]; 2] = [[-1e6; 3], [1e6; 3]];

impl Region {
    /// The regions of a case: the elastic sections of a vessel and what it names besides, or bypass, artery and its middle. The last of these begins where the blend of the cross-sections ends, and ends as far from the
    /// outlet; there is none if the artery is too short for it. Those of an OpenFOAM case of the user's own are boxes, or its whole wall. A flag
    /// is no vessel and has no regions.
    pub fn of(case: &Case) -> Vec<Self> {
        let vessel = match &case.problem {
            Problem::Vessel(vessel) => vessel,
            Problem::Flag(_) => return Vec::new(),
            Problem::Own(own) => {
                let boxes = own.fluid.region.iter().flatten();
                let boxes: Vec<Self> = boxes
                    .filter_map(|region| {
                        Some(Self::in_box(
                            &region.name,
                            [*region.corners.first()?, *region.corners.get(1)?],
                        ))
                    })
                    .collect();
                return match boxes.is_empty() {
                    true => vec![Self::in_box("wall", EVERYWHERE)],
                    false => boxes,
                };
            }
        };
        let geometry = match &vessel.shape {
            Shape::Anastomosis(vessel) => &vessel.geometry,
            Shape::Vessel(keys) => {
                let vessel = Vessel::new(vessel);
                let region = |section: &crate::geometry::Section| Self {
                    name: RegionName::from(section.name.clone()),
                    from_m: section.from,
                    to_m: section.to,
                    box_m: None,
                };
                let own = keys.region.iter().flatten().map(|own| Self {
                    name: RegionName::from(own.name.clone()),
                    from_m: own.from,
                    to_m: own.to,
                    box_m: None,
                });
                return vessel.elastic_sections().map(region).chain(own).collect();
            }
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
        some.map(|(name, from_m, to_m)| Self {
            name,
            from_m,
            to_m,
            box_m: None,
        })
        .collect()
    }

    /// What lies between two opposite corners (m).
    fn in_box(name: &str, corners: [[f64; 3]; 2]) -> Self {
        let [a, b] = corners;
        Self {
            name: RegionName::from(name.to_owned()),
            from_m: a[0].min(b[0]),
            to_m: a[0].max(b[0]),
            box_m: Some(corners),
        }
    }

    /// Whether a `point` (m) that is at `x` (m) along the centre-line lies in it.
    pub fn holds(&self, x: f64, point: &Vec3) -> bool {
        match self.box_m {
            None => self.contains(x),
            Some([a, b]) => (0..3).all(|i| (a[i].min(b[i])..=a[i].max(b[i])).contains(&point[i])),
        }
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
