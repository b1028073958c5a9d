//! Sections of a tube: from displacements of wall points to one radial displacement a section, and back.

use super::Tridiagonal;
use crate::Vec3;
use crate::curve::SpaceCurve;
use nalgebra::DVector;

/// A tube that is held at both ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Its centre-line; it begins at the arc length 0.
    pub line: SpaceCurve,
    /// Its length along that, m.
    pub length: f64,
}

/// A section that the wall points cannot tell apart from its neighbours.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "section {index} of {count} has too few wall points of its own: use one section for each ring of points, or half as many"
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
    /// The sections before and behind it, with its share in each.
    shares: [(usize, f64); 2],
    /// Radial direction.
    radial: Vec3,
    /// Distance from the axis, m.
    radius: f64,
}

/// `count` sections of equal length in a tube. The radial displacement is linear between their centres, and
/// from the first and the last of them to the ends, where it is zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Sections {
    axis: Axis,
    length: f64,
    points: Vec<Point>,
    /// EᵀE, where **E** maps sections to points.
    gram: Tridiagonal,
}

impl Sections {
    /// Sections of the tube around `axis` whose wall consists of `points` (reference positions, m).
    pub fn new(points: &[Vec3], axis: Axis, count: usize) -> Result<Self, SparseSection> {
        let mut sections = Self {
            length: axis.length / (count + 1) as f64,
            axis,
            points: Vec::new(),
            gram: Tridiagonal::zeros(count),
        };
        let place = |x: &Vec3| {
            let beside = sections.axis.line.beside(x);
            let across = x - beside.frame.origin;
            Point {
                shares: sections.shares(x),
                radial: across.normalize(),
                radius: across.norm(),
            }
        };
        let points: Vec<Point> = points.iter().map(place).collect();
        let gram = &mut sections.gram;
        for point in &points {
            let [(i, before), (j, behind)] = point.shares;
            gram.diagonal[i] += before * before;
            gram.diagonal[j] += behind * behind;
            if i + 1 == j {
                gram.upper[i] += before * behind;
                gram.lower[j] += before * behind;
            }
        }
        // A section that the points tell apart from those before it has a pivot of about a third of its points.
        let smallest = 0.02 * points.len() as f64 / count as f64;
        match gram.pivots().iter().position(|pivot| *pivot <= smallest) {
            Some(index) => Err(SparseSection { index, count }),
            None => Ok(Self { points, ..sections }),
        }
    }

    /// The sections whose centres lie before and behind `x`, with its share in each; shares of the ends are left out.
    fn shares(&self, x: &Vec3) -> [(usize, f64); 2] {
        let count = self.count();
        let along = self.axis.line.beside(x).s;
        let position = (along / self.length).clamp(0.0, (count + 1) as f64);
        let before = (position as usize).min(count);
        let behind = position - before as f64;
        // The first centre is number 1; 0 and count + 1 are the ends.
        match before {
            0 => [(0, 0.0), (0, behind)],
            last if last == count => [(last - 1, 1.0 - behind), (last - 1, 0.0)],
            i => [(i - 1, 1.0 - behind), (i, behind)],
        }
    }

    /// The value at `x` (m) of the field that is 1 at the centre of `section`, 0 at the others, and linear between.
    pub fn share(&self, section: usize, x: &Vec3) -> f64 {
        let shares = self.shares(x).into_iter();
        shares.filter(|(i, _)| *i == section).map(|(_, w)| w).sum()
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
        let (mut sums, mut weights) = (vec![0.0; self.count()], vec![0.0; self.count()]);
        for point in &self.points {
            for (i, share) in point.shares {
                sums[i] += share * point.radius;
                weights[i] += share;
            }
        }
        sums.iter().zip(weights).map(|(r, w)| r / w).collect()
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
    #[cfg(test)]
    pub(super) fn spread(&self, radial: &[f64]) -> DVector<f64> {
        let vectors = self.points.iter().flat_map(|point| {
            let size: f64 = point.shares.iter().map(|(i, w)| w * radial[*i]).sum();
            let vector = size * point.radial;
            [vector.x, vector.y, vector.z]
        });
        DVector::from_iterator(3 * self.points.len(), vectors)
    }

    /// Least squares: (EᵀE)⁻¹ Eᵀ.
    fn fit(&self, values: impl Iterator<Item = f64>) -> Vec<f64> {
        let mut sums = vec![0.0; self.count()];
        for (value, point) in values.zip(&self.points) {
            for (i, share) in point.shares {
                sums[i] += share * value;
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

    fn axis() -> Axis {
        Axis {
            line: SpaceCurve::x_axis(0.01, 0.04).counted_from(0.01),
            length: 0.03,
        }
    }

    #[test]
    fn averages_give_back_what_was_spread() {
        for count in [1, 2, 10, 29] {
            let sections = Sections::new(&tube(), axis(), count).unwrap();
            let radial: Vec<f64> = (0..count).map(|i| (i as f64).cos()).collect();
            let back = sections.average(&sections.spread(&radial));
            for (a, b) in radial.iter().zip(back) {
                assert!((a - b).abs() < 1e-12);
            }
            assert!((sections.length() * (count + 1) as f64 - 0.03).abs() < 1e-15);
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
        let sections = Sections::new(&tube(), axis(), 7).unwrap();
        let shift = DVector::from_fn(3 * 31 * 6, |i, _| [0.3, -0.2, 0.1][i % 3]);
        assert!(sections.average(&shift).iter().all(|s| s.abs() < 1e-12));
    }

    #[test]
    fn more_sections_than_rings_are_refused() {
        assert!(Sections::new(&tube(), axis(), 40).is_err());
    }
}
