//! Integrals over faces of the boundary.

use super::spectral_elements::SpectralElements;
use super::taylor_hood_space::Face;
use crate::Vec3;

/// The Gauss points of a face.
pub struct FacePoints {
    /// Nodes of the face, fastest along its first axis.
    pub nodes: Vec<usize>,
    /// Area vectors out of the fluid with the quadrature weight, m².
    pub areas: Vec<Vec3>,
    /// Positions, m.
    pub positions: Vec<Vec3>,
}

impl SpectralElements {
    /// Nodes of a face.
    pub fn face_nodes(&self, face: Face) -> Vec<usize> {
        let element = self.space.element(face.element);
        let places = face.side.places(self.basis.nodes.len());
        places.into_iter().map(|i| element[i] as usize).collect()
    }

    /// Pressure nodes of a face.
    pub fn face_pressures(&self, face: Face) -> Vec<usize> {
        let element = self.space.element_pressures(face.element);
        let places = face.side.places(self.basis.pressure_nodes.len());
        places.into_iter().map(|i| element[i] as usize).collect()
    }

    /// The Gauss points of a face of a mesh whose nodes lie at `positions` (m).
    pub fn face_points(&self, face: Face, positions: &[f64]) -> FacePoints {
        let nodes = self.face_nodes(face);
        let x: Vec<Vec3> = nodes.iter().map(|&i| self.vector(positions, i)).collect();
        self.points_between(nodes, &x)
    }

    /// The Gauss points of a face whose `nodes` lie at `x` (m).
    pub fn points_between(&self, nodes: Vec<usize>, x: &[Vec3]) -> FacePoints {
        let (m, basis) = (self.basis.gauss.len(), &self.basis);
        let values = &basis.to_gauss;
        let at_gauss = face_values(values, values, x);
        // Tangents: derivatives of the interpolated values
        let weights = &basis.gauss.weights;
        let tangent = |q: usize, axis: usize| -> Vec3 {
            let (a, b) = (q % m, q / m);
            (0..m)
                .map(|j| match axis {
                    0 => basis.gauss_derivative[a][j] * at_gauss[b * m + j],
                    _ => basis.gauss_derivative[b][j] * at_gauss[j * m + a],
                })
                .sum()
        };
        let area = |q: usize| weights[q % m] * weights[q / m] * tangent(q, 0).cross(&tangent(q, 1));
        FacePoints {
            areas: (0..m * m).map(area).collect(),
            positions: at_gauss,
            nodes,
        }
    }

    /// Areas (m²) that the nodes' own rule gives to the nodes of a face.
    pub fn face_node_areas(&self, face: Face, positions: &[f64]) -> Vec<f64> {
        let nodes = self.face_nodes(face);
        let x: Vec<Vec3> = nodes.iter().map(|&i| self.vector(positions, i)).collect();
        let (n, slopes) = (self.basis.nodes.len(), &self.basis.nodal_derivative);
        let weights = &self.basis.nodes.weights;
        let area = |k: usize| {
            let (a, b) = (k % n, k / n);
            let along: Vec3 = (0..n).map(|j| slopes[a][j] * x[b * n + j]).sum();
            let across: Vec3 = (0..n).map(|j| slopes[b][j] * x[j * n + a]).sum();
            weights[a] * weights[b] * along.cross(&across).norm()
        };
        (0..n * n).map(area).collect()
    }

    /// The vector of a field at a node.
    pub fn vector(&self, field: &[f64], node: usize) -> Vec3 {
        let n = self.space.nodes;
        Vec3::new(field[node], field[n + node], field[2 * n + node])
    }

    /// Values at a face's Gauss points of a field given at its nodes.
    pub fn face_field(&self, nodes: &[usize], field: &[f64]) -> Vec<Vec3> {
        let values: Vec<Vec3> = nodes.iter().map(|&i| self.vector(field, i)).collect();
        face_values(&self.basis.to_gauss, &self.basis.to_gauss, &values)
    }

    /// Adds `∫ v_i · f` to `load`, where `forces` is **f** times area at the face's Gauss points.
    pub fn add_face_load(&self, nodes: &[usize], forces: &[Vec3], load: &mut [f64]) {
        let sums = face_integrals(&self.basis.to_gauss, forces);
        for (&node, sum) in nodes.iter().zip(&sums) {
            for c in 0..3 {
                load[c * self.space.nodes + node] += sum[c];
            }
        }
    }

    /// Adds `∫ q_j f` to `load`, where `sources` is `f` times area at the face's Gauss points.
    pub fn add_face_source(&self, face: Face, sources: &[f64], load: &mut [f64]) {
        let sums = face_integrals(&self.basis.pressure_to_gauss, sources);
        for (node, sum) in self.face_pressures(face).into_iter().zip(sums) {
            load[node] += sum;
        }
    }
}

/// Tensor product interpolation on a face: `first` acts on the fastest index.
pub fn face_values<T>(first: &[Vec<f64>], second: &[Vec<f64>], values: &[T]) -> Vec<T>
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::iter::Sum,
{
    let n = first[0].len();
    let half: Vec<T> = (0..second[0].len())
        .flat_map(|j| {
            (first.iter()).map(move |row| (0..n).map(|i| values[j * n + i] * row[i]).sum())
        })
        .collect();
    let m = first.len();
    (second.iter())
        .flat_map(|row| {
            let half = &half;
            (0..m).map(move |a| (0..row.len()).map(|j| half[j * m + a] * row[j]).sum())
        })
        .collect()
}

/// The transpose of [`face_values`] with one matrix for both directions.
pub(super) fn face_integrals<T>(to_points: &[Vec<f64>], values: &[T]) -> Vec<T>
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::iter::Sum,
{
    let (m, n) = (to_points.len(), to_points[0].len());
    let transposed: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..m).map(|q| to_points[q][i]).collect())
        .collect();
    face_values(&transposed, &transposed, values)
}
