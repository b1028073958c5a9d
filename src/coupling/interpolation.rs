//! Interpolation from a cloud of face centres to other points of the same surface, exact for linear fields.

use crate::Vec3;
use crate::fluid::FluidInterface;
use crate::interpolation::Nearest;
use crate::pfem::SurfacePoint;
use nalgebra::{DMatrix, Matrix3};
use rayon::prelude::*;
use std::ops::{AddAssign, Mul};

/// Faces belong together, and to a point of the wall, if the cosine between their normals is at least this: pressures
/// on the two sides of a sharp edge have nothing in common.
pub(super) const AGREEMENT: f64 = 0.25;
/// Centres that are spread so little (variance over that of the faces' corners) say nothing of a gradient.
const NO_EXTENT: f64 = 1e-4;
/// Square of the distance, in units of a neighbourhood's extent, beyond which weights would underflow.
const FAR: f64 = 40.0;

/// Sources with their weights.
pub(super) type SparseRow = Vec<(usize, f64)>;

/// A sparse matrix of weights: the value at target `i` is the weighted sum of some of the values at the sources.
#[derive(Debug, Clone, PartialEq)]
pub struct Interpolation {
    /// Sources and weights of each target.
    pub(super) rows: Vec<SparseRow>,
}

impl Interpolation {
    /// Values at the targets from values at the sources.
    pub fn apply<T>(&self, values: &[T]) -> Vec<T>
    where
        T: Copy + Default + Mul<f64, Output = T> + AddAssign,
    {
        let interpolate = |row: &SparseRow| {
            let Some((&(source, weight), others)) = row.split_first() else {
                return T::default();
            };
            let mut sum = values[source] * weight;
            for &(source, weight) in others {
                sum += values[source] * weight;
            }
            sum
        };
        self.rows.iter().map(interpolate).collect()
    }
}

/// The fluid's faces as sources of an interpolation.
pub(super) struct Sources<'a> {
    fluid: &'a FluidInterface,
    /// Unit normals out of the fluid.
    pub normals: Vec<Vec3>,
    /// Least cosine between normals of faces that belong together.
    agreement: f64,
    /// For each face those that share a vertex with it and have a similar normal, itself included.
    around: Vec<Vec<usize>>,
    /// Largest distance (m) of a corner of each face from its centre.
    pub reach: Vec<f64>,
    nearest: Nearest,
}

impl<'a> Sources<'a> {
    /// Of a mesh that was made for that of the wall: both are smooth, and their faces lie next to each other.
    pub fn made(fluid: &'a FluidInterface) -> Self {
        Self::new(fluid, f64::NEG_INFINITY)
    }

    /// Of any mesh.
    pub fn any(fluid: &'a FluidInterface) -> Self {
        Self::new(fluid, AGREEMENT)
    }

    fn new(fluid: &'a FluidInterface, agreement: f64) -> Self {
        let at_rest = vec![Vec3::zeros(); fluid.points.len()];
        let areas = fluid.face_areas(&at_rest).into_iter();
        // A face without area agrees with none, itself included.
        let normals: Vec<Vec3> = areas
            .map(|area| area.try_normalize(0.0).unwrap_or_default())
            .collect();
        let mut around = faces_around(&fluid.faces);
        for (face, others) in around.iter_mut().enumerate() {
            others
                .retain(|&other| other == face || normals[face].dot(&normals[other]) >= agreement);
        }
        let reach = |(corners, centre): (&Vec<u32>, &Vec3)| {
            let arms = corners
                .iter()
                .map(|&p| (fluid.points[p as usize] - centre).norm());
            arms.fold(0.0, f64::max)
        };
        Self {
            agreement,
            reach: fluid
                .faces
                .iter()
                .zip(&fluid.face_centres)
                .map(reach)
                .collect(),
            nearest: Nearest::of(&fluid.face_centres),
            fluid,
            normals,
            around,
        }
    }

    /// Weighted least squares of a linear field (moving least squares, Lancaster and Salkauskas 1981) over the face
    /// nearest to each target on the same side of the wall, and the faces around it.
    ///
    /// The coordinate normal to the surface takes part where the neighbourhood is curved; where it is flat, the
    /// solution of least norm ignores it.
    pub fn linear(&self, targets: &[SurfacePoint]) -> Interpolation {
        let row = |target: &SurfacePoint| {
            let faces_it = |face: usize| -self.normals[face].dot(&target.normal) >= self.agreement;
            let nearest = (self.nearest.to(&target.position, faces_it))
                .or_else(|| self.nearest.to(&target.position, |_| true))
                .expect("the wet surface has at least one face");
            self.weights(nearest, &target.position, &target.position)
        };
        Interpolation {
            rows: targets.par_iter().map(row).collect(),
        }
    }

    /// Weights for the value at `at` of a linear least-squares fit to the faces around `face`, of which those near
    /// `about` count most.
    pub fn weights(&self, face: usize, about: &Vec3, at: &Vec3) -> SparseRow {
        let sources = &self.around[face];
        let mut offsets: Vec<Vec3> = (sources.iter())
            .map(|&s| self.fluid.face_centres[s] - about)
            .collect();
        let mut offset = at - about;
        // Distances in units of the neighbourhood's own extent in each direction: faces are often long and narrow.
        let mut mean = offsets.iter().sum::<Vec3>() / offsets.len() as f64;
        let covariance: Matrix3<f64> = offsets
            .iter()
            .map(|o| (o - mean) * (o - mean).transpose())
            .sum::<Matrix3<f64>>()
            / offsets.len() as f64;
        for direction in self.idle_directions(sources, &covariance) {
            let places = offsets.iter_mut().chain([&mut mean, &mut offset]);
            places.for_each(|o| *o -= direction * direction.dot(o));
        }
        let size = covariance.trace().max(f64::MIN_POSITIVE);
        let metric = (covariance + Matrix3::identity() * (1e-2 * size))
            .try_inverse()
            .unwrap_or_else(Matrix3::identity);
        let squares: Vec<f64> = offsets.iter().map(|o| o.dot(&(metric * o))).collect();
        // Far from all of them they keep their weights relative to each other.
        let far = squares.iter().copied().fold(f64::INFINITY, f64::min) - FAR;
        let far = far.max(0.0);
        let root: Vec<f64> = (squares.iter())
            .map(|square| (-0.25 * (square - far)).exp())
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
        let fit = DMatrix::from_row_slice(1, 4, &row(offset)) * pseudo_inverse;
        let mut weights: Vec<f64> = (0..sources.len()).map(|i| fit[(0, i)] * root[i]).collect();
        // Where directions are cut off a constant is not met exactly by itself.
        let sum: f64 = weights.iter().sum();
        if (sum - 1.0).abs() > 1e-9 && sum > 0.5 {
            weights.iter_mut().for_each(|weight| *weight /= sum);
        }
        sources.iter().copied().zip(weights).collect()
    }

    /// Unit vectors along which these faces reach far but their centres do not: across a strip one face wide, of which
    /// nothing but a constant can be known.
    fn idle_directions(&self, faces: &[usize], covariance: &Matrix3<f64>) -> Vec<Vec3> {
        if self.agreement == f64::NEG_INFINITY {
            return Vec::new();
        }
        let mut reach = Matrix3::zeros();
        for &face in faces {
            let corners = &self.fluid.faces[face];
            for &corner in corners {
                let arm = self.fluid.points[corner as usize] - self.fluid.face_centres[face];
                reach += arm * arm.transpose() / (corners.len() * faces.len()) as f64;
            }
        }
        let spread = covariance.symmetric_eigen();
        let is_idle = |i: &usize| {
            let direction = spread.eigenvectors.column(*i);
            let reach_there = direction.dot(&(reach * direction));
            reach_there > NO_EXTENT * reach.trace()
                && spread.eigenvalues[*i] < NO_EXTENT * reach_there
        };
        let idle = (0..3).filter(is_idle);
        idle.map(|i| spread.eigenvectors.column(i).into()).collect()
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn interface(points: Vec<Vec3>, faces: Vec<Vec<u32>>) -> FluidInterface {
        let centre = |face: &Vec<u32>| {
            let sum: Vec3 = face.iter().map(|&p| points[p as usize]).sum();
            sum / face.len() as f64
        };
        FluidInterface {
            face_centres: faces.iter().map(centre).collect(),
            faces,
            points,
        }
    }

    /// Faces of a tube with `n` facets around and `m` along.
    fn tube(n: usize, m: usize, radius: f64, length: f64) -> FluidInterface {
        let point = |i: usize, j: usize| {
            let phi = TAU * j as f64 / n as f64;
            Vec3::new(
                length * i as f64 / m as f64,
                radius * phi.cos(),
                radius * phi.sin(),
            )
        };
        let mut faces = Vec::new();
        for i in 0..m {
            for j in 0..n {
                // The normal points outward.
                let corners = [(i, j), (i + 1, j), (i + 1, (j + 1) % n), (i, (j + 1) % n)];
                let corners = corners.iter().rev();
                faces.push(corners.map(|&(i, j)| (i * n + j) as u32).collect());
            }
        }
        let points = (0..=m).flat_map(|i| (0..n).map(move |j| (i, j)));
        interface(points.map(|(i, j)| point(i, j)).collect(), faces)
    }

    fn target(position: Vec3, normal: Vec3) -> SurfacePoint {
        SurfacePoint {
            position,
            normal,
            area: 1.0,
        }
    }

    fn targets(radius: f64, length: f64) -> Vec<SurfacePoint> {
        let place = |k: usize| {
            let (x, phi) = (
                length * (k as f64 * 0.618).fract(),
                TAU * (k as f64 * 0.755).fract(),
            );
            let outward = Vec3::new(0.0, phi.cos(), phi.sin());
            target(radius * outward + x * Vec3::x(), -outward)
        };
        (0..300).map(place).collect()
    }

    #[test]
    fn linear_fields_are_reproduced_exactly() {
        let fluid = tube(20, 17, 3e-3, 60e-3);
        let targets = targets(3e-3, 60e-3);
        let interpolation = Sources::any(&fluid).linear(&targets);
        let field = |x: &Vec3| 7.0 + 300.0 * x.x - 1100.0 * x.y + 900.0 * x.z;
        let values = fluid.face_centres.iter().map(field).collect::<Vec<_>>();
        let values = interpolation.apply(&values);
        for (target, value) in targets.iter().map(|t| t.position).zip(values) {
            let target = &target;
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
            let fluid = tube(n, n, 3e-3, 20e-3);
            let targets = targets(3e-3, 20e-3);
            let field = |x: &Vec3| (x.x / 6e-3).sin() * (1.0 + 2.0 * x.y.atan2(x.z).sin());
            let values = fluid.face_centres.iter().map(field).collect::<Vec<_>>();
            let values = Sources::any(&fluid).linear(&targets).apply(&values);
            targets
                .iter()
                .zip(values)
                .map(|(t, v)| (v - field(&t.position)).abs())
                .fold(0.0, f64::max)
        };
        let (coarse, fine) = (error(16), error(32));
        assert!(coarse / fine > 3.0, "errors {coarse:.2e} and {fine:.2e}");
    }

    /// A case in two dimensions: the strip is a thousand times as deep as its faces are long.
    #[test]
    fn flat_strips_keep_constants_and_gradients() {
        for depth in [1.0, 1e3] {
            let point = |i: u32| Vec3::new((i / 2) as f64, depth * (i % 2) as f64, 0.0);
            let faces = (0..10u32).map(|i| vec![2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]);
            let fluid = interface((0..22).map(point).collect(), faces.collect());
            let at = |x, y| target(Vec3::new(x, depth * y, 0.0), -Vec3::z());
            let values: Vec<f64> = fluid.face_centres.iter().map(|c| 1.0 + 2.0 * c.x).collect();
            let found = (Sources::any(&fluid).linear(&[at(3.2, 0.1), at(0.1, 0.9)])).apply(&values);
            assert!(
                (found[0] - 7.4).abs() < 1e-10 && (found[1] - 1.2).abs() < 1e-10,
                "{found:?} at the depth {depth}"
            );
        }
    }

    /// A plate that is thin compared with its faces: the nearest face is one of the other side.
    #[test]
    fn the_two_sides_of_a_thin_plate_have_nothing_in_common() {
        let square = |x: f64, z: f64| {
            let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
            corners.map(|[a, b]| Vec3::new(x + a, b, z)).into_iter()
        };
        // Above the plate the fluid's normals point down to it, below it up.
        let points = square(0.0, 0.1).chain(square(0.4, 0.0)).collect();
        let fluid = interface(points, vec![vec![3, 2, 1, 0], vec![4, 5, 6, 7]]);
        let place = Vec3::new(0.9, 0.5, 0.1);
        let row = Sources::any(&fluid).linear(&[target(place, Vec3::z())]);
        assert_eq!(row.apply(&[1.0, 5.0]), [1.0]);
    }
}
