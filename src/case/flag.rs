//! A flag behind a cylinder in a channel, which takes the place of the vessel where a case has the table `[flag]`.

use super::Material;
use serde::{Deserialize, Serialize};

/// An elastic flag that is clamped to a rigid cylinder in a plane channel, after Turek and Hron, *Proposal for numerical
/// benchmarking of fluid-structure interaction*, 2006. The channel begins at x = 0 and its lower wall is y = 0; the flag
/// points downstream. Plane strain: nothing depends on z.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Flag {
    /// Length of the channel, m.
    #[serde(rename = "channel_length_m")]
    pub channel_length: f64,
    /// Height of the channel, m.
    #[serde(rename = "channel_height_m")]
    pub channel_height: f64,
    /// Extent along z, one cell and one element, m.
    #[serde(rename = "depth_m")]
    pub depth: f64,
    /// Centre of the cylinder, m.
    #[serde(rename = "cylinder_x_m")]
    pub cylinder_x: f64,
    /// Centre of the cylinder, m.
    #[serde(rename = "cylinder_y_m")]
    pub cylinder_y: f64,
    /// Radius of the cylinder, m.
    #[serde(rename = "cylinder_radius_m")]
    pub cylinder_radius: f64,
    /// Length of the flag from the cylinder's rearmost point, m.
    #[serde(rename = "length_m")]
    pub length: f64,
    /// Thickness of the flag, m.
    #[serde(rename = "thickness_m")]
    pub thickness: f64,
    /// Mean velocity of the parabolic inflow after the ramp, m/s.
    #[serde(rename = "mean_velocity_m_s")]
    pub mean_velocity: f64,
    /// Material of the flag; its density and damping are those of the wall.
    pub solid: Material,
    /// Both meshes.
    pub mesh: FlagMesh,
}

/// Meshes of the flag and of the channel around it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlagMesh {
    /// Elements along the flag.
    pub elements: usize,
    /// Size of the fluid's cells at the flag and at the cylinder, m.
    #[serde(rename = "cell_size_m")]
    pub cell_size: f64,
    /// Ratio of the sizes of neighbouring cells away from there.
    pub growth: f64,
    /// Largest size of a cell along the channel, m.
    #[serde(rename = "largest_cell_m")]
    pub largest_cell: f64,
}

impl Flag {
    /// Position of the flag's free end, m.
    pub fn end(&self) -> f64 {
        self.cylinder_x + self.cylinder_radius + self.length
    }

    /// Degrees of freedom of the flag in the trunk space of degree `p` in its plane and 1 across, the held ones included.
    pub fn degrees_of_freedom(&self, p: usize) -> usize {
        let n = self.mesh.elements;
        let (vertices, edges) = (4 * (n + 1), 2 * (3 * n + 1));
        let face = if p >= 4 { (p - 2) * (p - 3) / 2 } else { 0 };
        3 * (vertices + edges * (p - 1) + 2 * n * face)
    }
}
