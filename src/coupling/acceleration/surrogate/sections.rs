//! Sections of a tube: from displacements of wall points to one radial displacement a section, and back.

use super::Tridiagonal;
use crate::Vec3;
use nalgebra::DVector;

/// The axis of a straight tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// A point on it, m.
    pub origin: Vec3,
    /// Its direction, of length 1.
    pub direction: Vec3,
}

/// A section that the wall points cannot tell apart from its neighbours.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "section {index} of {count} has too few wall points of its own: use at most half as many sections as the wall has rings of points"
)]
pub struct SparseSection {
    /// Number of the section, from 0.
    pub index: usize,
    /// Number of sections.
    pub count: usize,
}

/// A wall point's share in the sections.
#[derive(Debug, Clone, PartialEq)]
struct Point {
    /// Section before it; it lies between the centres of this one and the next.
    section: usize,
    /// Share of the next section.
    next: f64,
    /// Radial direction.
    radial: Vec3,
    /// Distance from the axis, m.
    radius: f64,
}

/// `count` sections of equal length along a straight tube; the radial displacement is linear between their centres.
#[derive(Debug, Clone, PartialEq)]
pub struct Sections {
    length: f64,
    points: Vec<Point>,
    /// EᵀE, where **E** maps sections to points.
    gram: Tridiagonal,
}

impl Sections {
    /// Sections of the tube around `axis` whose wall consists of `points` (reference positions, m).
    pub fn new(points: &[Vec3], axis: Axis, count: usize) -> Result<Self, SparseSection> {
        let along: Vec<f64> = points
            .iter()
            .map(|x| (x - axis.origin).dot(&axis.direction))
            .collect();
        let first = along.iter().copied().fold(f64::INFINITY, f64::min);
        let last = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let length = (last - first) / count as f64;
        let mut gram = Tridiagonal::zeros(count);
        let points: Vec<Point> = points
            .iter()
            .zip(&along)
            .map(|(x, along)| {
                let across = x - axis.origin - *along * axis.direction;
                let position = ((along - first) / length - 0.5).clamp(0.0, count as f64 - 1.0);
                let section = (position as usize).min(count.saturating_sub(2));
                Point {
                    section,
                    next: position - section as f64,
                    radial: across.normalize(),
                    radius: across.norm(),
                }
            })
            .collect();
        for point in &points {
            let (i, w) = (point.section, point.next);
            gram.diagonal[i] += (1.0 - w) * (1.0 - w);
            if i + 1 < count {
                gram.diagonal[i + 1] += w * w;
                gram.upper[i] += w * (1.0 - w);
                gram.lower[i + 1] += w * (1.0 - w);
            }
        }
        // A section that the points tell apart from those before it has a pivot of about a third of its points.
        let smallest = 0.02 * points.len() as f64 / count as f64;
        match gram.pivots().iter().position(|pivot| *pivot <= smallest) {
            Some(index) => Err(SparseSection { index, count }),
            None => Ok(Self {
                length,
                points,
                gram,
            }),
        }
    }

    /// Number of sections.
    pub fn count(&self) -> usize {
        self.gram.diagonal.len()
    }

    /// Length of a section, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Mean radius of each section in the reference configuration, m.
    pub fn reference_radius(&self) -> Vec<f64> {
        self.fit(self.points.iter().map(|point| point.radius))
    }

    /// The radial displacement of each section that fits the displacement `d` of all points (x0 y0 z0 x1 …) best in
    /// the sense of least squares.
    pub fn average(&self, d: &DVector<f64>) -> Vec<f64> {
        let vectors = d.as_slice().chunks_exact(3).map(Vec3::from_column_slice);
        self.fit(
            vectors
                .zip(&self.points)
                .map(|(d, point)| d.dot(&point.radial)),
        )
    }

    /// The displacement of all points for a radial displacement of each section.
    pub fn spread(&self, radial: &[f64]) -> DVector<f64> {
        let vectors = self.points.iter().flat_map(|point| {
            let (i, w) = (point.section, point.next);
            let next = radial.get(i + 1).map_or(0.0, |value| w * value);
            let vector = ((1.0 - w) * radial[i] + next) * point.radial;
            [vector.x, vector.y, vector.z]
        });
        DVector::from_iterator(3 * self.points.len(), vectors)
    }

    /// Least squares: (EᵀE)⁻¹ Eᵀ.
    fn fit(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.count()];
        for (value, point) in values.zip(&self.points) {
            sums[point.section] += (1.0 - point.next) * value;
            if let Some(sum) = sums.get_mut(point.section + 1) {
                *sum += point.next * value;
            }
        }
        self.gram.solve(&sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tube() -> Vec<Vec3> {
        let ring = |i: usize| {
            (0..6).map(move |k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 6.0).sin_cos();
                Vec3::new(0.01 + i as f64 * 1e-3, 2e-3 * cos, 2e-3 * sin)
            })
        };
        (0..31).flat_map(ring).collect()
    }

    const AXIS: Axis = Axis {
        origin: Vec3::new(0.0, 0.0, 0.0),
        direction: Vec3::new(1.0, 0.0, 0.0),
    };

    #[test]
    fn averages_give_back_what_was_spread() {
        for count in [1, 2, 10] {
            let sections = Sections::new(&tube(), AXIS, count).unwrap();
            let radial: Vec<f64> = (0..count).map(|i| (i as f64).cos()).collect();
            let back = sections.average(&sections.spread(&radial));
            for (a, b) in radial.iter().zip(back) {
                assert!((a - b).abs() < 1e-12);
            }
            assert!((sections.length() * count as f64 - 0.03).abs() < 1e-15);
            assert!(
                sections
                    .reference_radius()
                    .iter()
                    .all(|r| (r - 2e-3).abs() < 1e-15)
            );
        }
    }

    #[test]
    fn moving_the_tube_sideways_or_along_its_axis_is_no_widening() {
        let sections = Sections::new(&tube(), AXIS, 7).unwrap();
        let shift = DVector::from_fn(3 * 31 * 6, |i, _| [0.3, -0.2, 0.1][i % 3]);
        assert!(sections.average(&shift).iter().all(|s| s.abs() < 1e-12));
    }

    #[test]
    fn more_sections_than_rings_are_refused() {
        assert!(Sections::new(&tube(), AXIS, 40).is_err());
    }
}
