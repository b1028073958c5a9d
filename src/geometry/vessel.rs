//! The vessel's surfaces: graft, cosine blend, artery with its imperfection.

use super::centre_line::CentreLine;
use super::wall::{Surfaces, WallGrid, equal_stations};
use super::{HexMesh, imperfection::Imperfection};
use crate::case::{Anastomosis, Geometry, WallMesh};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Regions of the wall's mesh, as indices into the list of materials.
pub mod region {
    /// The graft.
    pub const GRAFT: usize = 0;
    /// The artery's inner layer.
    pub const MEDIA: usize = 1;
    /// The artery's outer layer.
    pub const ADVENTITIA: usize = 2;
}

/// The surface between blood and wall. From the inside follow that between media and adventitia (the middle of the graft's
/// wall), and that between wall and surroundings.
const LUMEN: usize = 0;

/// An end-to-end anastomosis: graft from x = 0, artery downstream, rigid extension upstream.
///
/// With the cosine blend `w(x)` from 0 in the graft to 1 in the artery the radii are
/// `r_i(x, φ) = (1 - w) r_i,graft + w r_i,artery - c_i d(x, φ)`, where `c = (1, 1/3, 0)` for lumen, interface and
/// outer surface: equation (17).
#[derive(Debug, Clone, PartialEq)]
pub struct Vessel {
    geometry: Geometry,
    imperfection: Imperfection,
    centre_line: CentreLine,
    graft: [f64; 3],
    artery: [f64; 3],
}

impl Vessel {
    /// The vessel of a checked case.
    pub fn new(vessel: &Anastomosis) -> Self {
        let geometry = vessel.geometry.clone();
        let start = geometry.graft_length;
        let (graft, artery) = (geometry.graft_inner_radius, geometry.artery_inner_radius);
        let media = artery + geometry.media_thickness;
        Self {
            imperfection: Imperfection::new(
                &geometry.imperfection,
                [start, start + geometry.artery_length],
                vessel.model.d_max,
            ),
            centre_line: CentreLine::new(vessel.model.extension, &geometry),
            graft: [
                graft,
                graft + 0.5 * geometry.graft_thickness,
                graft + geometry.graft_thickness,
            ],
            artery: [artery, media, media + geometry.adventitia_thickness],
            geometry,
        }
    }

    /// Position (m) along the x-axis where the graft ends and the artery begins.
    pub fn joint(&self) -> f64 {
        self.geometry.graft_length
    }

    /// Position (m) of the outlet.
    pub fn end(&self) -> f64 {
        self.geometry.graft_length + self.geometry.artery_length
    }

    /// The centre-line; its arc length is x in the deformable part and negative in the rigid extension.
    pub fn centre_line(&self) -> &CentreLine {
        &self.centre_line
    }

    /// The imperfection of the artery's lumen.
    pub fn imperfection(&self) -> &Imperfection {
        &self.imperfection
    }

    /// Share of the artery's cross-section at `x`: 0 in the graft, 1 in the artery, half a cosine between.
    pub fn blend(&self, x: f64) -> f64 {
        let from_joint = (x - self.joint()) / self.geometry.blend_length;
        0.5 * (1.0 - (PI * (from_joint + 0.5).clamp(0.0, 1.0)).cos())
    }

    /// Radius (m) of the lumen at the arc length `s` (m) of the centre-line; the graft's in the rigid extension.
    pub fn lumen_radius(&self, s: f64, phi: f64) -> f64 {
        self.radius(LUMEN, s.max(0.0), phi)
    }

    /// Volume (m³) of the unloaded lumen between two cross-sections of the deformable part.
    pub fn lumen_volume(&self, from: f64, to: f64) -> f64 {
        // V = ∫∫ r²/2 dφ dx; the periodic trapezoidal rule around, Gauss' two points in many short pieces along.
        const AROUND: usize = 180;
        let pieces = 400;
        let h = (to - from) / pieces as f64;
        let mut sum = 0.0;
        for piece in 0..pieces {
            for gauss in [-1.0, 1.0] {
                let x = from + h * (piece as f64 + 0.5 + 0.5 * gauss / 3f64.sqrt());
                sum += (0..AROUND)
                    .map(|j| self.lumen_radius(x, TAU * j as f64 / AROUND as f64).powi(2))
                    .sum::<f64>();
            }
        }
        sum * 0.25 * h * TAU / AROUND as f64
    }

    /// Hexahedra of the deformable wall with the regions [`region`]; the number of elements per section is
    /// the same in graft and artery.
    pub fn solid_mesh(&self, mesh: &WallMesh) -> HexMesh {
        let n = mesh.axial_per_section;
        let mut stations = equal_stations(0.0, self.joint(), n);
        stations.extend(&equal_stations(self.joint(), self.end(), n)[1..]);
        let grid = WallGrid {
            stations,
            circumferential: mesh.circumferential,
            radial_per_layer: mesh.radial_per_layer,
            layers: 2,
        };
        grid.mesh(Arc::new(self.clone()), |axial, layer| {
            match (axial < n, layer) {
                (true, _) => region::GRAFT,
                (false, 0) => region::MEDIA,
                (false, _) => region::ADVENTITIA,
            }
        })
    }
}

impl Surfaces for Vessel {
    fn radius(&self, index: usize, x: f64, phi: f64) -> f64 {
        let w = self.blend(x);
        let circle = (1.0 - w) * self.graft[index] + w * self.artery[index];
        circle - Imperfection::SHARE[index] * self.imperfection.depth(x, phi)
    }
}

/// Hexahedra of the deformable wall of a case; see [`Vessel::solid_mesh`].
pub fn solid_mesh(vessel: &Anastomosis) -> HexMesh {
    Vessel::new(vessel).solid_mesh(&vessel.structure)
}
