//! Interpolation from a cloud of face centres to other points of the same surface, exact for linear fields.

use super::nearest::Nearest;
use crate::Vec3;
use nalgebra::{DMatrix, Matrix3};
use rayon::prelude::*;
use std::ops::{AddAssign, Mul};

/// A sparse matrix of weights: the value at target `i` is the weighted sum of some of the values at the sources.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolation {
    /// Sources and weights of each target.
    rows: Vec<Vec<(usize, f64)>>,
}

impl Interpolation {
    /// Weighted least squares of a linear field (moving least squares, Lancaster and Salkauskas 1981) over the face
    /// nearest to each target and the faces that share a vertex with it.
    ///
    /// `faces` are the vertices of the faces, `centres` their centres (m), `targets` the points to interpolate to (m).
    /// The coordinate normal to the surface takes part where the neighbourhood is curved; where it is flat, the
    /// solution of least norm ignores it.
    pub fn linear(faces: &[Vec<u32>], centres: &[Vec3], targets: &[Vec3]) -> Self {
        let (neighbours, nearest) = (faces_around(faces), Nearest::of(centres));
        let row = |target| {
            let nearest = (nearest.to(target)).expect("the wet surface has at least one face");
            weights(target, centres, &neighbours[nearest])
        };
        Self {
            rows: targets.par_iter().map(row).collect(),
        }
    }

    /// Values at the targets from values at the sources.
    pub fn apply<T>(&self, values: &[T]) -> Vec<T>
    where
        T: Copy + Mul<f64, Output = T> + AddAssign,
    {
        let interpolate = |row: &Vec<(usize, f64)>| {
            let mut sum = values[row[0].0] * row[0].1;
            for &(source, weight) in &row[1..] {
                sum += values[source] * weight;
            }
            sum
        };
        self.rows.iter().map(interpolate).collect()
    }
}

/// For each face the faces that share a vertex with it, itself included.
fn faces_around(faces: &[Vec<u32>]) -> Vec<Vec<usize>> {
    let points = faces.iter().flatten().max().map_or(0, |&p| p as usize + 1);
    let mut of_point = vec![Vec::new(); points];
    for (face, vertices) in faces.iter().enumerate() {
        for &vertex in vertices {
            of_point[vertex as usize].push(face);
        }
    }
    let around = |vertices: &Vec<u32>| {
        let mut all: Vec<usize> = vertices
            .iter()
            .flat_map(|&v| of_point[v as usize].iter().copied())
            .collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    faces.iter().map(around).collect()
}

/// Weights of `sources` for the value of a linear least-squares fit at `target`.
fn weights(target: &Vec3, centres: &[Vec3], sources: &[usize]) -> Vec<(usize, f64)> {
    let offsets: Vec<Vec3> = sources.iter().map(|&s| centres[s] - target).collect();
    // Distances in units of the neighbourhood's own extent in each direction: faces are often long and narrow.
    let mean = offsets.iter().sum::<Vec3>() / offsets.len() as f64;
    let covariance: Matrix3<f64> = offsets
        .iter()
        .map(|o| (o - mean) * (o - mean).transpose())
        .sum::<Matrix3<f64>>()
        / offsets.len() as f64;
    let size = covariance.trace().max(f64::MIN_POSITIVE);
    let metric = (covariance + Matrix3::identity() * (1e-2 * size))
        .try_inverse()
        .unwrap_or_else(Matrix3::identity);
    let root: Vec<f64> = offsets
        .iter()
        .map(|o| (-0.25 * o.dot(&(metric * o))).exp())
        .collect();
    // Rows: sqrt(w) (1, x - mean). A direction without extent gets no gradient: the solution of least norm.
    let scale = size.sqrt();
    let row = |offset: Vec3| {
        let x = (offset - mean) / scale;
        [1.0, x.x, x.y, x.z]
    };
    let matrix = DMatrix::from_fn(sources.len(), 4, |i, j| root[i] * row(offsets[i])[j]);
    let pseudo_inverse = matrix
        .clone()
        .pseudo_inverse(1e-6 * matrix.norm())
        .expect("the tolerance is positive");
    let fit = DMatrix::from_row_slice(1, 4, &row(Vec3::zeros())) * pseudo_inverse;
    sources
        .iter()
        .enumerate()
        .map(|(i, &s)| (s, fit[(0, i)] * root[i]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Faces of a tube with `n` facets around and `m` along; returns faces, centres.
    fn tube(n: usize, m: usize, radius: f64, length: f64) -> (Vec<Vec<u32>>, Vec<Vec3>) {
        let point = |i: usize, j: usize| {
            let phi = TAU * j as f64 / n as f64;
            Vec3::new(
                length * i as f64 / m as f64,
                radius * phi.cos(),
                radius * phi.sin(),
            )
        };
        let mut faces = Vec::new();
        let mut centres = Vec::new();
        for i in 0..m {
            for j in 0..n {
                let corners = [(i, j), (i + 1, j), (i + 1, (j + 1) % n), (i, (j + 1) % n)];
                faces.push(corners.iter().map(|&(i, j)| (i * n + j) as u32).collect());
                centres.push(corners.iter().map(|&(i, j)| point(i, j)).sum::<Vec3>() / 4.0);
            }
        }
        (faces, centres)
    }

    fn targets(radius: f64, length: f64) -> Vec<Vec3> {
        let place = |k: usize| {
            let (x, phi) = (
                length * (k as f64 * 0.618).fract(),
                TAU * (k as f64 * 0.755).fract(),
            );
            Vec3::new(x, radius * phi.cos(), radius * phi.sin())
        };
        (0..300).map(place).collect()
    }

    #[test]
    fn linear_fields_are_reproduced_exactly() {
        let (faces, centres) = tube(20, 17, 3e-3, 60e-3);
        let targets = targets(3e-3, 60e-3);
        let interpolation = Interpolation::linear(&faces, &centres, &targets);
        let field = |x: &Vec3| 7.0 + 300.0 * x.x - 1100.0 * x.y + 900.0 * x.z;
        let values = interpolation.apply(&centres.iter().map(field).collect::<Vec<_>>());
        for (target, value) in targets.iter().zip(values) {
            assert!(
                (value - field(target)).abs() < 1e-9 * 7.0,
                "{value} instead of {}",
                field(target)
            );
        }
    }

    #[test]
    fn smooth_fields_converge_with_second_order() {
        let error = |n: usize| {
            let (faces, centres) = tube(n, n, 3e-3, 20e-3);
            let targets = targets(3e-3, 20e-3);
            let field = |x: &Vec3| (x.x / 6e-3).sin() * (1.0 + 2.0 * x.y.atan2(x.z).sin());
            let values = Interpolation::linear(&faces, &centres, &targets)
                .apply(&centres.iter().map(field).collect::<Vec<_>>());
            targets
                .iter()
                .zip(values)
                .map(|(t, v)| (v - field(t)).abs())
                .fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(16), error(32));
        assert!(coarse / fine > 3.0, "errors {coarse:.2e} and {fine:.2e}");
    }

    #[test]
    fn a_flat_strip_one_face_wide_keeps_constants_and_the_gradient_along_it() {
        let faces: Vec<Vec<u32>> = (0..10u32)
            .map(|i| vec![2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1])
            .collect();
        let centres: Vec<Vec3> = (0..10)
            .map(|i| Vec3::new(i as f64 + 0.5, 0.5, 0.0))
            .collect();
        let targets = [Vec3::new(3.2, 0.1, 0.0), Vec3::new(0.1, 0.9, 0.0)];
        let values: Vec<f64> = centres.iter().map(|c| 1.0 + 2.0 * c.x).collect();
        let found = Interpolation::linear(&faces, &centres, &targets).apply(&values);
        assert!(
            (found[0] - 7.4).abs() < 1e-10 && (found[1] - 1.2).abs() < 1e-10,
            "{found:?}"
        );
    }
}
