//! Closest points of a surface of the body, in the shape as it is given.

use super::super::SolidError;
use super::super::discretization::Discretization;
use super::super::element::surface::{directions, mode_on_face, on_face};
use super::super::supports::modes_on_face;
use crate::Vec3;
use crate::mesh::HexFace;

/// Sample points along each direction of a face, from which the search starts.
const SAMPLES: usize = 7;
/// Faces that are searched for one point.
const CANDIDATES: usize = 4;
/// Largest distance from the surface over the size of the closest face.
const FARTHEST: f64 = 0.1;

/// Faces are as near as each other if their distances differ by less than this, in sizes of a face, ...
const SAME: f64 = 1e-9;
/// ... and different places if these are farther apart. Next to the edge between two faces places that are much nearer
/// to each other are as near as that to a point beside the surface.
const APART: f64 = 1e-3;

/// Where a point lies on the surface, with the functions that move it.
#[derive(Debug, Clone, PartialEq)]
pub struct Location {
    /// Index into the faces of the surface.
    pub face: usize,
    /// Coordinates along the two directions of the face.
    pub coordinates: [f64; 2],
    /// Distance (m) from the surface.
    pub distance: f64,
    /// Functions and their values there.
    functions: Vec<(usize, f64)>,
}

impl Location {
    /// The displacement there.
    pub fn evaluate(&self, displacement: &[f64]) -> Vec3 {
        self.functions
            .iter()
            .fold(Vec3::zeros(), |sum, &(f, value)| {
                sum + Vec3::from_row_slice(&displacement[3 * f..3 * f + 3]) * value
            })
    }
}

/// Sampled faces of a surface.
#[derive(Debug, Clone)]
pub struct Locator {
    faces: Vec<(usize, HexFace)>,
    /// Positions and coordinates of the samples of each face.
    samples: Vec<Vec<(Vec3, [f64; 2])>>,
    /// Centre and radius of a ball around the samples of each face.
    balls: Vec<(Vec3, f64)>,
}

impl Locator {
    /// Samples the faces.
    pub fn new(body: &Discretization, faces: &[(usize, HexFace)]) -> Self {
        let axis: Vec<f64> = (0..SAMPLES)
            .map(|i| 2.0 * i as f64 / (SAMPLES - 1) as f64 - 1.0)
            .collect();
        let given = body.mapping.given();
        let samples: Vec<Vec<(Vec3, [f64; 2])>> = faces
            .iter()
            .map(|&(e, face)| {
                let pairs = axis.iter().flat_map(|&a| axis.iter().map(move |&b| [a, b]));
                pairs
                    .map(|[a, b]| (given.at(e, on_face(face, a, b)).position, [a, b]))
                    .collect()
            })
            .collect();
        let balls = samples
            .iter()
            .map(|samples| {
                let centre = samples.iter().map(|(x, _)| x).sum::<Vec3>() / samples.len() as f64;
                let radius = samples
                    .iter()
                    .map(|(x, _)| (x - centre).norm())
                    .fold(0.0, f64::max);
                (centre, radius)
            })
            .collect();
        Self {
            faces: faces.to_vec(),
            samples,
            balls,
        }
    }

    /// The samples along the edges of each face, in order around it.
    pub fn outlines(&self) -> Vec<Vec<Vec3>> {
        let last = SAMPLES - 1;
        let edges = [
            (0..last).map(|i| i * SAMPLES).collect::<Vec<_>>(),
            (0..last).map(|j| last * SAMPLES + j).collect(),
            (1..=last).rev().map(|i| i * SAMPLES + last).collect(),
            (1..=last).rev().collect(),
        ]
        .concat();
        let around =
            |samples: &Vec<(Vec3, [f64; 2])>| edges.iter().map(|&i| samples[i].0).collect();
        self.samples.iter().map(around).collect()
    }

    /// The closest point of the surface to `x`.
    pub fn locate(&self, body: &Discretization, x: &Vec3) -> Result<Location, SolidError> {
        let mut candidates: Vec<(f64, usize)> = self
            .balls
            .iter()
            .enumerate()
            .map(|(face, (centre, radius))| ((x - centre).norm() - radius, face))
            .collect();
        // Of thousands of faces only the first few are put in order.
        let by_distance =
            |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let few = candidates.len().min(4 * CANDIDATES);
        if few < candidates.len() {
            candidates.select_nth_unstable_by(few, by_distance);
        }
        candidates[..few].sort_unstable_by(by_distance);
        let mut starts: Vec<(f64, usize, [f64; 2])> = candidates[..few]
            .iter()
            .filter_map(|&(_, face)| {
                let distances = self.samples[face]
                    .iter()
                    .map(|(y, c)| ((x - y).norm(), face, *c));
                distances.min_by(|a, b| a.0.total_cmp(&b.0))
            })
            .collect();
        starts.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let projected: Vec<(f64, usize, [f64; 2])> = (starts.iter().take(CANDIDATES))
            .map(|&(_, face, start)| {
                let (coordinates, distance) = self.project(body, face, start, x);
                (distance, face, coordinates)
            })
            .collect();
        let Some(&best) = projected.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else {
            return Err(SolidError::Model("the wet surface has no faces".into()));
        };
        let (distance, face, coordinates) = best;
        let size = self.balls[face].1;
        if distance.is_nan() || distance > FARTHEST * 2.0 * size {
            return Err(SolidError::Model(format!(
                "the point ({:.6e}, {:.6e}, {:.6e}) m of the fluid is {distance:.2e} m away from the wet surface, whose faces there are about {size:.2e} m large: the two meshes do not describe the same wall",
                x.x, x.y, x.z
            )));
        }
        // Between two faces, as in the plane of symmetry between the daughters of a vessel, it goes with both.
        let foot = |&(_, face, [a, b]): &(f64, usize, [f64; 2])| {
            let (element, orientation) = self.faces[face];
            (body.mapping.given())
                .at(element, on_face(orientation, a, b))
                .position
        };
        let is_as_near = |other: &&(f64, usize, [f64; 2])| {
            other.0 - distance < SAME * size && (foot(other) - foot(&best)).norm() > APART * size
        };
        let nearest: Vec<_> = [&best]
            .into_iter()
            .chain(projected.iter().filter(is_as_near))
            .collect();
        let numbering = &body.numbering;
        let of_face = |&&(_, face, [a, b]): &&(f64, usize, [f64; 2])| {
            let (element, orientation) = self.faces[face];
            let (xi, share) = (on_face(orientation, a, b), 1.0 / nearest.len() as f64);
            modes_on_face(numbering, orientation).filter_map(move |m| {
                let value = mode_on_face(numbering.modes[m], &body.space, orientation, xi)[0];
                let function = numbering.of_element[element][m]?;
                Some((function, numbering.signs[element][m] * value * share))
            })
        };
        let functions = nearest.iter().flat_map(of_face).collect();
        Ok(Location {
            face,
            coordinates,
            distance,
            functions,
        })
    }

    /// Gauss-Newton iteration for the closest point of one face, within its bounds.
    fn project(
        &self,
        body: &Discretization,
        face: usize,
        start: [f64; 2],
        x: &Vec3,
    ) -> ([f64; 2], f64) {
        let (element, orientation) = self.faces[face];
        let [first, second] = directions(orientation);
        let mut c = start;
        let mut distance = f64::INFINITY;
        for _ in 0..50 {
            let given = body.mapping.given();
            let mapped = given.at(element, on_face(orientation, c[0], c[1]));
            let gap = x - mapped.position;
            distance = gap.norm();
            let t = [first, second].map(|d| Vec3::from(mapped.jacobian.column(d)));
            let slope = [gap.dot(&t[0]), gap.dot(&t[1])];
            // Coordinates at a bound that want to leave stay there.
            let free = [0, 1].map(|k| c[k].abs() < 1.0 || c[k] * slope[k] < 0.0);
            let (g00, g01, g11) = (t[0].dot(&t[0]), t[0].dot(&t[1]), t[1].dot(&t[1]));
            let step = match free {
                [true, true] => {
                    let determinant = g00 * g11 - g01 * g01;
                    [
                        (g11 * slope[0] - g01 * slope[1]) / determinant,
                        (g00 * slope[1] - g01 * slope[0]) / determinant,
                    ]
                }
                [true, false] => [slope[0] / g00, 0.0],
                [false, true] => [0.0, slope[1] / g11],
                [false, false] => [0.0, 0.0],
            };
            let moved = [0, 1].map(|k| (c[k] + step[k]).clamp(-1.0, 1.0));
            let change = (moved[0] - c[0]).abs().max((moved[1] - c[1]).abs());
            c = moved;
            if change < 1e-13 {
                break;
            }
        }
        (c, distance)
    }
}
