//! The imperfection: a smooth random thickening of the artery's wall towards the inside, equation (17).

use super::HexMesh;
use super::{Surfaces, WallGrid};
use crate::interpolation::BicubicSurface;
use fsi_pfem::mesh::equal_stations;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Radius deviation `d(x, φ)`: one bicubic spline surface, scaled so that its largest value is `d_max`.
///
/// The support values lie equally spaced along the section, ends included, and around the circumference, the first
/// at φ = 0 (+y). The slope along x is zero at both ends, where the support values are zero too: the surface joins the
/// regular vessel smoothly.
#[derive(Debug, Clone, PartialEq)]
pub struct Imperfection {
    surface: BicubicSurface,
    range: [f64; 2],
    scale: f64,
}

impl Imperfection {
    /// Share of `d` by which lumen, media's outer surface and adventitia's outer surface move inward.
    pub const SHARE: [f64; 3] = [1.0, 1.0 / 3.0, 0.0];

    /// Interpolates `support` (rows along x, columns around) over the axial `range` (m) with the largest value `d_max`
    /// (m). Support values that are all zero give no imperfection, whatever `d_max`.
    pub fn new(support: &[Vec<f64>], range: [f64; 2], d_max: f64) -> Self {
        let surface = BicubicSurface::new(support);
        let (largest, ..) = surface.maximum();
        let scale = if largest > 0.0 { d_max / largest } else { 0.0 };
        Self {
            surface,
            range,
            scale,
        }
    }

    /// `d` (m) at the axial position `x` (m) and the angle `phi`; zero outside the section.
    pub fn depth(&self, x: f64, phi: f64) -> f64 {
        let [start, end] = self.range;
        if self.scale == 0.0 || x <= start || x >= end {
            return 0.0;
        }
        self.scale * self.surface.value((x - start) / (end - start), phi / TAU)
    }
}

/// A two-layer tube with an imperfection over its whole length: the paper's test case *irregular shaped artery*.
/// Regions 0 (media) and 1 (adventitia); lengths in m.
///
/// # Panics
/// If there is no element in some direction, or fewer than three around the circumference.
pub fn irregular_tube_mesh(
    inner_radius: f64,
    layer_thickness: [f64; 2],
    imperfection: Imperfection,
    axial: usize,
    circumferential: usize,
    radial_per_layer: usize,
) -> HexMesh {
    struct Irregular([f64; 3], Imperfection);
    impl Surfaces for Irregular {
        fn radius(&self, index: usize, x: f64, phi: f64) -> f64 {
            self.0[index] - Imperfection::SHARE[index] * self.1.depth(x, phi)
        }
    }
    let [media, adventitia] = layer_thickness;
    let radii = [
        inner_radius,
        inner_radius + media,
        inner_radius + media + adventitia,
    ];
    let [start, end] = imperfection.range;
    let grid = WallGrid {
        stations: equal_stations(start, end, axial),
        circumferential,
        radial_per_layer,
        layers: 2,
    };
    grid.mesh(Arc::new(Irregular(radii, imperfection)), |_, layer| layer)
}
