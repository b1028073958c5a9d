//! Where something lies on a wall.

use serde::{Deserialize, Serialize};

/// Where a face lies on the unloaded wall.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Along the centre-line: its arc length.
    pub x_m: f64,
    /// Around it, from -180 to 180.
    pub phi_deg: f64,
    /// In space, where that is known: branching walls have no other place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_m: Option<[f64; 3]>,
}

impl Place {
    /// Along the centre-line and around it.
    pub fn on_tube(x_m: f64, phi_deg: f64) -> Self {
        Self {
            x_m,
            phi_deg,
            position_m: None,
        }
    }
}
