//! A piece of constant curvature and torsion.

use super::Frame;
use crate::Vec3;

/// How a piece bends: straight line (κ = τ = 0), circular arc (τ = 0) and helix are the same formula.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Bend {
    /// Curvature κ, 1/m.
    pub curvature: f64,
    /// Torsion τ, 1/m.
    pub torsion: f64,
    /// Direction in which it bends where it begins: angle (rad) in the cross-section.
    pub towards: f64,
}

impl Bend {
    /// A helix of this radius (m) that rises by `pitch` (m) in each turn.
    pub fn helix(radius: f64, pitch: f64, towards: f64) -> Self {
        let b = pitch / std::f64::consts::TAU;
        let squared = radius * radius + b * b;
        Self {
            curvature: radius / squared,
            torsion: b / squared,
            towards,
        }
    }
}

/// A piece from one arc length to another.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    pub from: f64,
    pub to: f64,
    /// Arc length where the frame is `start`.
    anchor: f64,
    start: Frame,
    bend: Bend,
}

impl Piece {
    pub fn new(from: f64, to: f64, anchor: f64, start: Frame, bend: Bend) -> Self {
        Self {
            from,
            to,
            anchor,
            start,
            bend,
        }
    }

    pub fn shifted(&self, by: f64) -> Self {
        Self {
            from: self.from + by,
            to: self.to + by,
            anchor: self.anchor + by,
            ..*self
        }
    }

    pub fn is_straight(&self) -> bool {
        self.bend.curvature == 0.0
    }

    /// Arc length of the point of a straight piece that is closest to `point`, if it lies on the piece, or beyond it
    /// where the whole curve, between these ends, ends with it.
    pub fn foot(&self, point: &Vec3, ends: [f64; 2]) -> Option<f64> {
        let s = self.anchor + (point - self.start.origin).dot(&self.start.tangent);
        let inside =
            (s >= self.from || self.from == ends[0]) && (s <= self.to || self.to == ends[1]);
        inside.then_some(s)
    }

    /// Frenet's normal and binormal where the frame is `start`.
    fn normals(&self) -> [Vec3; 2] {
        let (sin, cos) = self.bend.towards.sin_cos();
        let Frame { first, second, .. } = self.start;
        [first * cos + second * sin, second * cos - first * sin]
    }

    /// Place of the cross-section at arc length `s`: Frenet's frame rotates with the constant Darboux vector
    /// `ω = τ T + κ B`, and its turning τ s about the tangent is taken back.
    pub fn frame(&self, s: f64) -> Frame {
        let Bend {
            curvature: kappa,
            torsion: tau,
            towards,
        } = self.bend;
        let s = s - self.anchor;
        if kappa == 0.0 {
            return self.start.ahead(s);
        }
        let tangent = self.start.tangent;
        let [normal, binormal] = self.normals();
        let omega = kappa.hypot(tau);
        let axis = (tangent * tau + binormal * kappa) / omega;
        let (sin, cos) = (omega * s).sin_cos();
        // 1 - cos, without cancellation where the angle is small.
        let versine = match (omega * s).abs() < 0.01 {
            true => 2.0 * (0.5 * omega * s).sin().powi(2),
            false => 1.0 - cos,
        };
        // Rodrigues' rotation.
        let rotate = |v: Vec3| v * cos + axis.cross(&v) * sin + axis * (axis.dot(&v) * versine);
        let (t, n, b) = (rotate(tangent), rotate(normal), rotate(binormal));
        // ∫ T ds of the rotated tangent.
        let origin = self.start.origin
            + axis * (axis.dot(&tangent) * (s - sin / omega))
            + tangent * (sin / omega)
            + axis.cross(&tangent) * (versine / omega);
        let (sin, cos) = (towards + tau * s).sin_cos();
        Frame {
            origin,
            tangent: t,
            first: n * cos - b * sin,
            second: n * sin + b * cos,
        }
    }

    /// `dT/ds = κ N`.
    pub fn curvature(&self, s: f64) -> Vec3 {
        if self.bend.curvature == 0.0 {
            return Vec3::zeros();
        }
        let frame = self.frame(s);
        let (sin, cos) = (self.bend.towards + self.bend.torsion * (s - self.anchor)).sin_cos();
        (frame.first * cos + frame.second * sin) * self.bend.curvature
    }
}
