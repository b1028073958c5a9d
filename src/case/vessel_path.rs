//! What follows from the table `[vessel]` alone: the curve of the centre-line and where the sections lie on it.

use super::{CurvePiece, NamedMaterial, VesselDescription, VesselSection, WallKind};
use crate::Vec3;
use crate::curve::{Bend, Frame, SpaceCurve};
use crate::interpolation::MonotoneCubic;

/// A curve that leaves its chord by less than this share of its length counts as straight.
const STRAIGHT: f64 = 1e-3;

/// Thickness of the wall of a vessel that is rigid throughout, as a share of the mean radius of its sections: it has a
/// mesh that does not move.
pub const RIGID_SHARE: f64 = 0.1;

impl VesselSection {
    /// Whether its wall is elastic.
    pub fn is_elastic(&self) -> bool {
        self.wall.unwrap_or_default() == WallKind::Elastic
    }
}

impl VesselDescription {
    /// Whether all sections are rigid: only the flow is computed.
    pub fn is_rigid(&self) -> bool {
        !self.section.is_empty() && self.section.iter().all(|section| !section.is_elastic())
    }

    /// Whether a section is of the part that is evaluated, between whose ends the wall has a mesh: an elastic one, and
    /// any of a vessel that is rigid throughout.
    pub fn is_evaluated(&self, section: &VesselSection) -> bool {
        section.is_elastic() || self.is_rigid()
    }

    /// Materials of the wall, by name.
    pub fn materials(&self) -> &[NamedMaterial] {
        self.material.as_deref().unwrap_or_default()
    }

    /// The points that the centre-line passes.
    pub fn curve_points(&self) -> Vec<Vec3> {
        self.points.iter().map(|point| Vec3::from(*point)).collect()
    }

    /// The centre-line without extensions, from s = 0 on. Needs points, or pieces.
    pub fn curve(&self) -> SpaceCurve {
        let points = self.curve_points();
        if points.len() >= 2 {
            let first = match self.first[..] {
                [x, y, z] => Vec3::new(x, y, z),
                _ => side(&points),
            };
            return SpaceCurve::through(&points, first);
        }
        let piece = |piece: &CurvePiece| match piece {
            CurvePiece::Line { length } => (*length, Bend::default()),
            CurvePiece::Arc {
                length,
                radius,
                side_deg,
            } => (
                *length,
                Bend {
                    curvature: 1.0 / radius,
                    torsion: 0.0,
                    towards: side_deg.unwrap_or(0.0).to_radians(),
                },
            ),
            CurvePiece::Helix {
                length,
                radius,
                pitch,
                side_deg,
            } => {
                let towards = side_deg.unwrap_or(0.0).to_radians();
                (*length, Bend::helix(*radius, *pitch, towards))
            }
        };
        let pieces = self.piece.iter().flatten().map(piece);
        SpaceCurve::of_pieces(Frame::along_x(), &pieces.collect::<Vec<_>>())
    }

    /// The radius of the lumen along a centre-line, from s = 0 on; that of a section without one of its own. Where it
    /// depends on the angle, its mean.
    pub fn radius_law(&self, curve: &SpaceCurve) -> MonotoneCubic {
        if let Some([mean, _]) = self.table_laws(curve.ends()[1]) {
            return mean;
        }
        if !self.radii.is_empty() {
            return MonotoneCubic::new(curve.knots(), self.radii.clone());
        }
        let first = self.radius.unwrap_or(0.0);
        match self.end_radius {
            Some(last) => MonotoneCubic::new(curve.ends().to_vec(), vec![first, last]),
            None => MonotoneCubic::constant(first),
        }
    }

    /// Ends of the sections on a centre-line of this length (m), each from its beginning: the section without a length
    /// takes what the others leave.
    pub fn places(&self, length: f64) -> Vec<[f64; 2]> {
        let given: f64 = self
            .section
            .iter()
            .filter_map(|section| section.length)
            .sum();
        let mut s = 0.0;
        let place = |section: &VesselSection| {
            let from = s;
            s += section.length.unwrap_or(length - given);
            [from, s]
        };
        self.section.iter().map(place).collect()
    }
}

/// The side to which a line of points bends away from its chord; +y if it is straight.
fn side(points: &[Vec3]) -> Vec3 {
    let (start, end) = (points[0], points[points.len() - 1]);
    let chord = end - start;
    let along = match chord.norm() {
        0.0 => chord,
        length => chord / length,
    };
    let off = |point: &Vec3| {
        let arm = point - start;
        arm - along * along.dot(&arm)
    };
    let farthest = points.iter().map(off);
    let farthest = farthest.max_by(|a, b| a.norm().total_cmp(&b.norm()));
    match farthest {
        Some(off) if off.norm() > STRAIGHT * chord.norm() => off,
        _ => Vec3::y(),
    }
}
