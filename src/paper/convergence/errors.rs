//! The error measures (15) with the vectors (16).

use crate::Vec3;
use crate::analysis::tube::{Tube, fields, positions};
use crate::pfem::{Discretization, SolidError};
use serde::{Deserialize, Serialize};

/// Strain energy, and displacement and von Mises stress at the evaluation points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct EvaluatedSolution {
    /// Strain energy, J.
    pub energy: f64,
    /// Displacements, m.
    pub displacement: Vec<[f64; 3]>,
    /// Von Mises stresses, Pa.
    pub von_mises: Vec<f64>,
}

/// Relative errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Of the strain energy, with its sign.
    pub energy: f64,
    /// Of the displacements.
    pub displacement: f64,
    /// Of the von Mises stresses.
    pub von_mises: f64,
}

impl EvaluatedSolution {
    /// Errors (15) with respect to a reference at the same points.
    pub fn errors(&self, reference: &EvaluatedSolution) -> Errors {
        let flat = |solution: &EvaluatedSolution| solution.displacement.concat();
        Errors {
            energy: self.energy / reference.energy - 1.0,
            displacement: relative(&flat(self), &flat(reference)),
            von_mises: relative(&self.von_mises, &reference.von_mises),
        }
    }
}

fn relative(values: &[f64], reference: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let mut difference = values.iter().zip(reference).map(|(a, b)| a - b);
    norm(&mut difference) / norm(&mut reference.iter().copied())
}

/// Coordinates of centres, vertices, and middles of edges and faces along each local direction.
const LATTICE: [f64; 3] = [-1.0, 0.0, 1.0];

/// The evaluation points: element centres of the initial mesh, found in a mesh of any refinement.
pub struct ErrorProbes {
    /// For each point its places in the lattices of the elements; several where it lies between elements.
    places: Vec<Vec<usize>>,
}

impl ErrorProbes {
    /// Finds the element centres of `initial` in the mesh of `tube`.
    pub fn new(initial: &Tube, tube: &Tube) -> Result<Self, SolidError> {
        let known = positions(&tube.mesh, &LATTICE);
        let size = known.iter().map(|x| x.norm()).fold(0.0, f64::max);
        let find = |centre: &Vec3| -> Vec<usize> {
            let near = |place: &usize| (known[*place] - centre).norm() < 1e-9 * size;
            (0..known.len()).filter(near).collect()
        };
        let places: Vec<_> = positions(&initial.mesh, &[0.0]).iter().map(find).collect();
        match places.iter().position(Vec::is_empty) {
            None => Ok(Self { places }),
            Some(point) => Err(SolidError::Model(format!(
                "the centre of element {point} of the initial mesh is not a point of the refined one"
            ))),
        }
    }

    /// Values of a solution; means over the elements that meet at a point.
    pub fn evaluate(
        &self,
        body: &Discretization,
        displacement: &[f64],
        energy: f64,
    ) -> Result<EvaluatedSolution, SolidError> {
        let values = fields(body, &LATTICE, displacement)?;
        let mean = |places: &Vec<usize>| -> ([f64; 3], f64) {
            let count = places.len() as f64;
            let u: Vec3 = places.iter().map(|&p| values[p].0).sum();
            let stress: f64 = places.iter().map(|&p| values[p].1.von_mises()).sum();
            ((u / count).into(), stress / count)
        };
        let (displacement, von_mises) = self.places.iter().map(mean).unzip();
        Ok(EvaluatedSolution {
            energy,
            displacement,
            von_mises,
        })
    }
}
