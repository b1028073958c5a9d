//! The wall of a tree that is proposed, and what it adds to the compliance.

use super::files::rounded;
use super::{Figures, PRESSURES, ProposalInput};
use crate::analysis::tube_law::TubeLaw;
use crate::case::Material;
use crate::tabular::units::MMHG;
use std::f64::consts::TAU;

/// Thicknesses of the wall, as shares of the radius: the first one with which no element is inside out where branches
/// part.
pub const THICKNESSES: [f64; 5] = [0.2, 0.15, 0.1, 0.07, 0.05];
/// Shear modulus of the wall (Pa), which is nearly incompressible.
pub const SHEAR: f64 = 2.5e5;
/// Its bulk modulus, Pa.
pub const BULK: f64 = 1e7;
/// Steps between the smallest and the largest radius of a tree for which the compliance of a tube is computed.
const RADII: usize = 8;
/// Stiffness of the tissue around the wall, as a share of that with which the wall itself resists a change of radius.
/// In proportion to that, vessels of all sizes are as far from buckling, and their bends move by the same share of the
/// radius: with the same springs as around a carotid, cerebral arteries have no equilibrium.
const TISSUE: f64 = 0.1;
/// Pressure under which the vessel has the shape of the files, mmHg.
const LOADED: f64 = 80.0;

/// Pressure of the shape of the files, Pa.
pub fn pressure(input: &ProposalInput) -> f64 {
    input.loaded.unwrap_or_else(|| rounded(LOADED * MMHG))
}

/// Thickness of a wall.
#[derive(Debug, Clone, Copy)]
enum Thickness {
    /// Relative to the radius.
    Share(f64),
    /// In metres.
    Metres(f64),
}

/// A wall that is proposed.
#[derive(Debug)]
pub struct Wall {
    thickness: Thickness,
    /// Stiffness of the tissue around it, Pa/m.
    pub springs: f64,
    /// Pressure under which the vessel has the shape of the files, Pa.
    pub pressure: f64,
    /// Compliance of the vessel, m³/Pa.
    pub compliance: f64,
}

impl Wall {
    /// Of the thickness that is given, or of those that are tried, the thickest first.
    pub fn tried(input: &ProposalInput, figures: &Figures) -> Vec<Self> {
        match input.thickness {
            Some(thickness) => vec![Self::new(Thickness::Metres(thickness), input, figures)],
            None => THICKNESSES
                .map(|share| Self::new(Thickness::Share(share), input, figures))
                .into(),
        }
    }

    fn new(thickness: Thickness, input: &ProposalInput, figures: &Figures) -> Self {
        let radius = figures.radii[1];
        let thick = input.thickness.unwrap_or(THICKNESSES[0] * radius);
        Self {
            thickness,
            // Young's modulus is three times the shear modulus.
            springs: rounded(TISSUE * 3.0 * SHEAR * thick / radius.powi(2)),
            pressure: pressure(input),
            compliance: 0.0,
        }
    }

    /// With the compliance of a vessel, as if each face of its wall were part of a long tube. `faces`: their areas
    /// (m²), and the radius (m) of the lumen at each.
    pub fn with_compliance(mut self, faces: &[[f64; 2]]) -> Self {
        let ends = faces
            .iter()
            .fold([f64::INFINITY, 0.0f64], |[low, high], [_, radius]| {
                [low.min(*radius), high.max(*radius)]
            });
        // What a tube of the radius 1 gains depends on the radius but little.
        let ratio = (ends[1] / ends[0]).powf(1.0 / RADII as f64);
        let radii: Vec<f64> = (0..=RADII)
            .map(|i| ends[0] * ratio.powi(i as i32))
            .collect();
        let gains: Vec<f64> = radii.iter().map(|radius| self.area_gain(*radius)).collect();
        let of_face = |[area, radius]: &[f64; 2]| {
            let place = (radius / ends[0]).ln() / ratio.ln().max(f64::MIN_POSITIVE);
            let i = (place as usize).min(RADII - 1);
            let gain = gains[i] + (place - i as f64) * (gains[i + 1] - gains[i]);
            // The face of a tube of the length area/(2 π r).
            area * radius * gain / TAU
        };
        self.compliance = faces.iter().map(of_face).sum();
        self
    }

    /// The key of the thickness.
    pub fn line(&self) -> String {
        match self.thickness {
            Thickness::Share(share) => {
                format!("thicknesses = [{share}] # of the radius; or thicknesses_m, in metres")
            }
            Thickness::Metres(thickness) => {
                format!("thicknesses_m = [{thickness:e}] # or thicknesses, as shares of the radius")
            }
        }
    }

    /// Area that a vessel of this radius (m) gains between the pressures that are aimed at, relative to the square of
    /// its radius and per pressure, 1/Pa; 0 if it does not stand up to them.
    fn area_gain(&self, radius: f64) -> f64 {
        let share = match self.thickness {
            Thickness::Share(share) => share,
            Thickness::Metres(thickness) => thickness / radius,
        };
        let material = Material::NeoHooke {
            mu: SHEAR,
            kappa: BULK,
            viscosity: None,
        };
        let loaded = TubeLaw::of_layers(&[(&material, share)], 1.0, self.springs * radius);
        let tube = loaded.unloaded(self.pressure);
        let gain = tube.and_then(|tube| tube.compliance(PRESSURES.map(|p| p * MMHG)));
        gain.unwrap_or(0.0)
    }
}
