//! The centre-line: a rigid extension of constant curvature and torsion, then the x-axis.

use crate::Vec3;
use crate::case::{Extension, Geometry};
use std::f64::consts::TAU;

/// A curve parametrized by arc length `s` (m): the x-axis for `s >= 0`; upstream, for `s < 0`, a curve of constant
/// curvature κ and torsion τ that meets the axis at the origin with the tangent `e_x`.
///
/// Straight line (κ = τ = 0), circular arc (τ = 0) and helix are the same formula: the Frenet frame rotates with the
/// constant Darboux vector `ω = τ T + κ B`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CentreLine {
    /// Curvature κ of the extension, 1/m.
    pub curvature: f64,
    /// Torsion τ of the extension, 1/m.
    pub torsion: f64,
    /// Length of the extension, m.
    pub extension: f64,
}

/// A cross-section's place: its centre, the unit tangent, and two unit vectors in its plane; right-handed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Point on the centre-line, m.
    pub origin: Vec3,
    /// Direction of the flow.
    pub tangent: Vec3,
    /// Direction of the angle 0; `e_y` on the x-axis.
    pub first: Vec3,
    /// Direction of the angle π/2; `e_z` on the x-axis.
    pub second: Vec3,
}

impl CentreLine {
    /// The extension that the model asks for.
    pub fn new(extension: Extension, geometry: &Geometry) -> Self {
        let length = geometry.extension_length;
        let (curvature, torsion) = match extension {
            Extension::Straight => (0.0, 0.0),
            Extension::Arc => (geometry.arc_angle_deg.to_radians() / length, 0.0),
            Extension::Helix => {
                // One turn of radius a and slope b: length 2π √(a² + b²), κ = a/(a² + b²), τ = b/(a² + b²).
                let (a, reach) = (geometry.helix_radius, length / TAU);
                let b = (reach * reach - a * a).max(0.0).sqrt();
                (a / (reach * reach), b / (reach * reach))
            }
        };
        Self {
            curvature,
            torsion,
            extension: length,
        }
    }

    /// Place of the cross-section at arc length `s`, in the rotation-minimizing frame: the cross-section is swept
    /// without twist, so the Frenet frame's turning τ s about the tangent is taken back.
    pub fn frame(&self, s: f64) -> Frame {
        let (kappa, tau) = (self.curvature, self.torsion);
        if s >= 0.0 || kappa == 0.0 {
            return Frame {
                origin: Vec3::x() * s,
                tangent: Vec3::x(),
                first: Vec3::y(),
                second: Vec3::z(),
            };
        }
        let omega = kappa.hypot(tau);
        let axis = Vec3::new(tau, 0.0, kappa) / omega;
        let (sin, cos) = (omega * s).sin_cos();
        // Rodrigues' rotation about the Darboux vector of the Frenet frame (e_x, e_y, e_z) at s = 0.
        let rotate = |v: Vec3| v * cos + axis.cross(&v) * sin + axis * (axis.dot(&v) * (1.0 - cos));
        let (t, n, b) = (rotate(Vec3::x()), rotate(Vec3::y()), rotate(Vec3::z()));
        // ∫ T ds of the rotated tangent.
        let origin = axis * (axis.x * (s - sin / omega))
            + Vec3::x() * (sin / omega)
            + axis.cross(&Vec3::x()) * ((1.0 - cos) / omega);
        let (sin, cos) = (tau * s).sin_cos();
        Frame {
            origin,
            tangent: t,
            first: n * cos - b * sin,
            second: n * sin + b * cos,
        }
    }
}

impl Frame {
    /// Point of the cross-section's plane with the coordinates `y` and `z` (m) along `first` and `second`.
    pub fn point(&self, y: f64, z: f64) -> Vec3 {
        self.origin + self.first * y + self.second * z
    }
}
