//! The parts of the vessel, or of another wet surface, that are evaluated one by one.

use crate::Vec3;
use crate::geometry::PolyMesh;
use arrayvec::ArrayString;
use serde::{Deserialize, Serialize};

/// What a case calls a part: at most 30 characters. Underscores are shown as hyphens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "String", into = "String")]
pub struct RegionName(ArrayString<MOST_BYTES>);

/// Longest name: 30 characters.
const MOST_BYTES: usize = 120;

impl RegionName {
    /// The name as files have it.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl From<&str> for RegionName {
    fn from(name: &str) -> Self {
        let fitting = (name.char_indices()).take_while(|(at, c)| at + c.len_utf8() <= MOST_BYTES);
        Self(fitting.fold(ArrayString::new(), |mut name, (_, c)| {
            name.push(c);
            name
        }))
    }
}

impl From<String> for RegionName {
    fn from(name: String) -> Self {
        name.as_str().into()
    }
}

impl From<RegionName> for String {
    fn from(name: RegionName) -> Self {
        name.as_str().to_owned()
    }
}

impl std::fmt::Display for RegionName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0.replace('_', "-"))
    }
}

/// A part of the vessel or of the wet surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Which part.
    pub name: RegionName,
    /// Where it is.
    #[serde(flatten)]
    pub extent: RegionExtent,
}

/// Where a region is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum RegionExtent {
    /// In a box.
    Box {
        /// Two opposite corners, m.
        box_m: [[f64; 3]; 2],
    },
    /// Between two cross-sections along a branch; read before a patch, which is a part of it.
    Branch {
        /// Patch of the wall of the branch.
        patch: String,
        /// Its beginning, m along the branch.
        from_m: f64,
        /// Its end, m along the branch; none where the branch ends.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        to_m: Option<f64>,
    },
    /// In a patch of the fluid's mesh.
    Patch {
        /// Its name.
        patch: String,
    },
    /// Between two cross-sections along the centre-line of the unloaded vessel.
    Along {
        /// Its beginning, m.
        from_m: f64,
        /// Its end, m.
        to_m: f64,
    },
    /// The whole wet surface.
    Whole {},
}

impl Region {
    /// Between two cross-sections (m along the centre-line).
    pub fn along(name: RegionName, from_m: f64, to_m: f64) -> Self {
        Self {
            name,
            extent: RegionExtent::Along { from_m, to_m },
        }
    }

    /// Its beginning and its end (m) along a branch.
    pub fn along_branch(&self) -> Option<[f64; 2]> {
        match self.extent {
            RegionExtent::Branch { from_m, to_m, .. } => {
                Some([from_m, to_m.unwrap_or(f64::INFINITY)])
            }
            _ => None,
        }
    }

    /// Whether it consists of faces on a patch.
    pub fn is_on_patch(&self) -> bool {
        matches!(
            self.extent,
            RegionExtent::Patch { .. } | RegionExtent::Branch { .. }
        )
    }

    /// Volume (m³) of the fluid within at rest: of the cells whose centres lie in the box, or of all. There is none in
    /// a patch or along a branch, and in a box without cells; between two cross-sections it follows from the wall.
    pub fn volume_at_rest(&self, fluid: &PolyMesh) -> Option<f64> {
        match &self.extent {
            RegionExtent::Along { .. }
            | RegionExtent::Branch { .. }
            | RegionExtent::Patch { .. } => None,
            RegionExtent::Whole {} => Some(fluid.volume()),
            RegionExtent::Box { box_m } => {
                let cells = fluid.cell_geometry().into_iter();
                let within = cells.filter(|(_, centre)| is_in_box(box_m, centre));
                Some(within.map(|(volume, _)| volume).sum()).filter(|volume| *volume > 0.0)
            }
        }
    }
}

/// Whether a point (m) lies between two opposite corners (m).
pub fn is_in_box([a, b]: &[[f64; 3]; 2], point: &Vec3) -> bool {
    (0..3).all(|i| (a[i].min(b[i])..=a[i].max(b[i])).contains(&point[i]))
}

/// Share of the interval from `low` to `high` (m) that lies between `from` and `to` (m).
pub fn share([from, to]: [f64; 2], low: f64, high: f64) -> f64 {
    let common = high.min(to) - low.max(from);
    // Cross-sections of the mesh lie on the borders up to rounding.
    match (common / (high - low)).clamp(0.0, 1.0) {
        s if s < 1e-6 => 0.0,
        s if s > 1.0 - 1e-6 => 1.0,
        s => s,
    }
}
