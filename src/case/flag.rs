//! A flag downstream of a cylinder in a channel, which takes the place of the vessel where a case has the table
//! `[flag]`.

use super::Material;
use super::schema::{ValueKind, above, from, whole};
use crate::table;

table! {
    /// An elastic flag that is clamped to a rigid cylinder in a plane channel, after Turek and Hron, *Proposal for
    /// numerical benchmarking of fluid-structure interaction*, 2006. The channel begins at x = 0 and its lower wall is
    /// y = 0; the flag points downstream. Plane strain: nothing depends on z, along which there is one cell and one
    /// element.
    pub struct Flag {
        channel_length: f64 = "channel_length_m", above(0.0, 1e3), "length of the channel";
        channel_height: f64 = "channel_height_m", above(0.0, 1e3), "height of the channel";
        depth: f64 = "depth_m", above(0.0, 1e3), "extent of the plane problem along z";
        cylinder_x: f64 = "cylinder_x_m", above(0.0, 1e3), "position of the cylinder along the channel";
        cylinder_y: f64 = "cylinder_y_m", above(0.0, 1e3), "position of the cylinder above the lower wall";
        cylinder_radius: f64 = "cylinder_radius_m", above(0.0, 1e3), "radius of the cylinder";
        /// From the cylinder's rearmost point.
        length: f64 = "length_m", above(0.0, 1e3), "length of the flag, downstream of the cylinder";
        thickness: f64 = "thickness_m", above(0.0, 1e3), "thickness of the flag";
        /// Of a parabola, after the ramp.
        mean_velocity: f64 = "mean_velocity_m_s", from(-1e3, 1e3), "mean velocity of the inflow";
        rigid: bool = "rigid", ValueKind::Flag, "whether the flag is rigid", absent "false";
        [solid: Material, "material of the flag; its density and damping are those of the wall", only FLAG]
        [mesh: FlagMesh, "both meshes"]
    }
}

table! {
    /// Meshes of the flag and of the channel around it.
    pub struct FlagMesh {
        elements: usize = "elements", whole(1, 1000), "elements along the flag";
        /// And at the cylinder.
        cell_size: f64 = "cell_size_m", above(0.0, 1e3), "size of the fluid's cells at the flag";
        growth: f64 = "growth", from(1.0, 2.0), "ratio of the sizes of neighbouring cells";
        largest_cell: f64 = "largest_cell_m", above(0.0, 1e3), "largest size of a cell along the channel";
    }
}

impl Flag {
    /// Position of the flag's free end, m.
    pub fn end(&self) -> f64 {
        self.cylinder_x + self.cylinder_radius + self.length
    }

    /// Degrees of freedom of the flag in the trunk space of degree `p` in its plane and 1 across, the held ones
    /// included.
    pub fn degrees_of_freedom(&self, p: usize) -> usize {
        let n = self.mesh.elements;
        let (vertices, edges) = (4 * (n + 1), 2 * (3 * n + 1));
        let face = if p >= 4 { (p - 2) * (p - 3) / 2 } else { 0 };
        3 * (vertices + edges * (p - 1) + 2 * n * face)
    }
}
