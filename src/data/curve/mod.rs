//! Curves in space by arc length, with cross-sections that are swept along them without twist.
//!
//! A curve consists of pieces of constant curvature and torsion (lines, arcs, helices), or passes through points as a
//! cubic spline. Beyond its ends it goes on straight. Each place has a [`Frame`]: of all frames that follow the
//! tangent, those of a curve turn about it as little as possible (Bishop, *There is more than one way to frame a
//! curve*, 1975).

mod centre_line;
mod piece;
mod spline;

use crate::Vec3;
pub use centre_line::{CentreLine, Foot, Fork, Partings};
pub use piece::Bend;
use piece::Piece;
use spline::Spline;
use std::sync::Arc;

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

impl Frame {
    /// The frame at the origin that looks along the x-axis.
    pub fn along_x() -> Self {
        Self {
            origin: Vec3::zeros(),
            tangent: Vec3::x(),
            first: Vec3::y(),
            second: Vec3::z(),
        }
    }

    /// The frame at `origin` with this `tangent` and the part of `first` that is perpendicular to it.
    pub fn new(origin: Vec3, tangent: Vec3, first: Vec3) -> Self {
        let tangent = tangent.normalize();
        let first = (first - tangent * tangent.dot(&first)).normalize();
        let second = tangent.cross(&first);
        Self {
            origin,
            tangent,
            first,
            second,
        }
    }

    /// Point of the cross-section's plane with the coordinates `y` and `z` (m) along `first` and `second`.
    pub fn point(&self, y: f64, z: f64) -> Vec3 {
        self.origin + self.first * y + self.second * z
    }

    /// Coordinates along `first` and `second` of a vector.
    pub fn across(&self, vector: &Vec3) -> [f64; 2] {
        [vector.dot(&self.first), vector.dot(&self.second)]
    }

    /// The frame a distance further straight on.
    fn ahead(&self, distance: f64) -> Self {
        Self {
            origin: self.origin + self.tangent * distance,
            ..*self
        }
    }
}

/// Where a point lies next to a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPoint {
    /// Arc length of the cross-section that holds the point, m.
    pub s: f64,
    /// Its frame.
    pub frame: Frame,
    /// The point's coordinates in it, m.
    pub across: [f64; 2],
}

/// A curve that is parametrized by its arc length `s`, m.
#[derive(Debug, Clone, PartialEq)]
pub struct SpaceCurve {
    law: Law,
    /// Arc lengths of its ends, m.
    ends: [f64; 2],
    /// Points on it in equal distances, for a first guess of what is nearest.
    nodes: Arc<[Vec3]>,
}

#[derive(Debug, Clone, PartialEq)]
enum Law {
    Pieces(Arc<[Piece]>),
    Spline(Arc<Spline>),
}

/// Points for a first guess.
const NODES: usize = 400;
/// Iterations of the perpendicular: it converges quadratically.
const MOST_ITERATIONS: usize = 30;

/// The line nearest to a point (m) among numbered ones, and the place on it. A line ends where the next ones begin:
/// there they are nearer, not what would go on straight.
pub fn nearest_of<'a>(
    lines: impl Iterator<Item = (usize, &'a SpaceCurve)>,
    x: &Vec3,
) -> Option<(usize, NearestPoint)> {
    let found = lines.map(|(number, line)| {
        let nearest = line.nearest(x);
        let [from, to] = line.ends();
        let end = line.frame(nearest.s.clamp(from, to)).origin;
        ((end - x).norm(), number, nearest)
    });
    let nearest = found.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, number, nearest)| (number, nearest))
}

impl SpaceCurve {
    /// The x-axis between two places.
    pub fn x_axis(from: f64, to: f64) -> Self {
        let piece = Piece::new(from, to, 0.0, Frame::along_x(), Bend::default());
        Self::of(Law::Pieces([piece].into()), [from, to])
    }

    /// Pieces one after the other, each as long (m) as is said with it, from the frame `start` at s = 0 on.
    pub fn of_pieces(start: Frame, pieces: &[(f64, Bend)]) -> Self {
        let (mut s, mut frame) = (0.0, start);
        let mut all: Vec<Piece> = Vec::new();
        for (length, bend) in pieces {
            let piece = Piece::new(s, s + length, s, frame, *bend);
            s += length;
            frame = piece.frame(s);
            all.push(piece);
        }
        Self::of(Law::Pieces(all.into()), [0.0, s])
    }

    /// A piece that ends at s = 0 where the x-axis goes on to `end`: the paper's vessels.
    pub fn onto_x_axis(length: f64, bend: Bend, end: f64) -> Self {
        let pieces = [
            Piece::new(-length, 0.0, 0.0, Frame::along_x(), bend),
            Piece::new(0.0, end, 0.0, Frame::along_x(), Bend::default()),
        ];
        Self::of(Law::Pieces(pieces.into()), [-length, end])
    }

    /// The natural cubic spline through points (m), of which neighbours differ; `first` is the direction of the angle 0
    /// at its beginning, or as close to it as is perpendicular.
    ///
    /// # Panics
    /// If there are fewer than two points.
    pub fn through(points: &[Vec3], first: Vec3) -> Self {
        let spline = Spline::new(points, first);
        let ends = [0.0, spline.length()];
        Self::of(Law::Spline(Arc::new(spline)), ends)
    }

    fn of(law: Law, ends: [f64; 2]) -> Self {
        let empty = Arc::new([]);
        let mut curve = Self {
            law,
            ends,
            nodes: empty,
        };
        let origin = |i: usize| curve.frame(curve.node(i)).origin;
        curve.nodes = (0..=NODES).map(origin).collect();
        curve
    }

    fn node(&self, i: usize) -> f64 {
        self.ends[0] + (self.ends[1] - self.ends[0]) * i as f64 / NODES as f64
    }

    /// The same curve with its arc length counted from another place: what was `s` becomes 0.
    #[must_use]
    pub fn counted_from(&self, s: f64) -> Self {
        let law = match &self.law {
            Law::Pieces(pieces) => {
                Law::Pieces(pieces.iter().map(|piece| piece.shifted(-s)).collect())
            }
            Law::Spline(spline) => Law::Spline(Arc::new(spline.shifted(-s))),
        };
        Self {
            law,
            ends: self.ends.map(|end| end - s),
            nodes: self.nodes.clone(),
        }
    }

    /// Arc lengths of its ends, m.
    pub fn ends(&self) -> [f64; 2] {
        self.ends
    }

    /// Arc lengths (m) of the points that it passes, or of the ends of its pieces.
    pub fn knots(&self) -> Vec<f64> {
        match &self.law {
            Law::Pieces(pieces) => {
                let ends = pieces.iter().map(|piece| piece.to);
                [self.ends[0]].into_iter().chain(ends).collect()
            }
            Law::Spline(spline) => spline.knots(),
        }
    }

    /// The cross-section at the arc length `s` (m).
    pub fn frame(&self, s: f64) -> Frame {
        let within = s.clamp(self.ends[0], self.ends[1]);
        let frame = match &self.law {
            Law::Pieces(pieces) => {
                let last = pieces.len() - 1;
                let index = pieces.partition_point(|piece| piece.to <= within).min(last);
                pieces[index].frame(within)
            }
            Law::Spline(spline) => spline.frame(within),
        };
        if within == s {
            frame
        } else {
            frame.ahead(s - within)
        }
    }

    /// Derivative of the tangent by the arc length at `s` (m): towards the centre of curvature, 1/m.
    pub fn curvature(&self, s: f64) -> Vec3 {
        if s < self.ends[0] || s > self.ends[1] {
            return Vec3::zeros();
        }
        match &self.law {
            Law::Pieces(pieces) => {
                let last = pieces.len() - 1;
                pieces[pieces.partition_point(|piece| piece.to <= s).min(last)].curvature(s)
            }
            Law::Spline(spline) => spline.curvature(s),
        }
    }

    /// Where a point lies next to the curve.
    pub fn nearest(&self, point: &Vec3) -> NearestPoint {
        let distances = self.nodes.iter().map(|node| (node - point).norm_squared());
        let nearest = distances.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
        self.nearest_from(point, self.node(nearest.map_or(0, |(i, _)| i)))
    }

    /// The straight piece that holds the arc length `s`.
    fn straight_at(&self, s: f64) -> Option<&Piece> {
        let Law::Pieces(pieces) = &self.law else {
            return None;
        };
        let last = pieces.len() - 1;
        let piece = &pieces[pieces.partition_point(|piece| piece.to <= s).min(last)];
        piece.is_straight().then_some(piece)
    }

    /// As [`SpaceCurve::nearest`] for a point whose cross-section is near that at the arc length `s` (m).
    pub fn nearest_from(&self, point: &Vec3, mut s: f64) -> NearestPoint {
        let mut frame = self.frame(s);
        let scale = self.ends[1] - self.ends[0];
        if let Some(straight) = self.straight_at(s)
            && let Some(found) = straight.foot(point, self.ends)
        {
            (s, frame) = (found, self.frame(found));
            let across = frame.across(&(point - frame.origin));
            return NearestPoint { s, frame, across };
        }
        for _ in 0..MOST_ITERATIONS {
            // Newton's method for (x - c)·t = 0, whose slope is -(1 - κ·(x - c)).
            let arm = point - frame.origin;
            let room = 1.0 - self.curvature(s).dot(&arm);
            let step = arm.dot(&frame.tangent) / if room > 0.1 { room } else { 1.0 };
            s += step;
            frame = self.frame(s);
            if step.abs() <= 1e-14 * scale {
                break;
            }
        }
        NearestPoint {
            s,
            frame,
            across: frame.across(&(point - frame.origin)),
        }
    }
}

#[cfg(test)]
mod tests;
