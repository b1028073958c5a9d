//! Elements of one degree on a mesh: gathers what an element needs, sums what elements give.

use super::FlowError;
use super::basis::Basis;
use super::kernel::{Kernel, kernel};
use super::space::Space;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// A space with the operators of its elements.
pub struct Discretization {
    /// Numbering.
    pub space: Space,
    /// One-dimensional operators.
    pub basis: Basis,
    /// Operations of an element.
    pub kernel: Box<dyn Kernel>,
    /// Weights of the `M³` Gauss points.
    pub gauss_weights: Vec<f64>,
    /// Weights of the `(N + 1)³` nodes.
    pub node_weights: Vec<f64>,
}

impl Discretization {
    /// For a numbering whose degree lies within [`Basis::DEGREES`].
    ///
    /// # Errors
    /// If it does not.
    pub fn new(space: Space) -> Result<Self, FlowError> {
        let [low, high] = Basis::DEGREES;
        if !(low..=high).contains(&space.degree) {
            return Err(FlowError::Model(format!(
                "the degree of the fluid's elements must lie from {low} to {high}, found {}",
                space.degree
            )));
        }
        let basis = Basis::new(space.degree);
        let cube = |weights: &[f64]| -> Vec<f64> {
            let n = weights.len();
            (0..n * n * n)
                .map(|i| weights[i % n] * weights[i / n % n] * weights[i / n / n])
                .collect()
        };
        Ok(Self {
            kernel: kernel(&basis),
            gauss_weights: cube(&basis.gauss.weights),
            node_weights: cube(&basis.nodes.weights),
            basis,
            space,
        })
    }

    /// Nodes of an element.
    pub fn node_count(&self) -> usize {
        self.node_weights.len()
    }

    /// Gauss points of an element.
    pub fn gauss_count(&self) -> usize {
        self.gauss_weights.len()
    }

    /// Pressure nodes of an element.
    pub fn pressure_count(&self) -> usize {
        self.space.degree.pow(3)
    }

    /// Copies the three components of a field to an element's nodes.
    pub fn gather(&self, e: usize, field: &[f64], local: &mut [f64]) {
        let nodes = self.space.element(e);
        for (c, local) in local.chunks_exact_mut(nodes.len()).enumerate() {
            let field = &field[c * self.space.nodes..(c + 1) * self.space.nodes];
            for (value, &node) in local.iter_mut().zip(nodes) {
                *value = field[node as usize];
            }
        }
    }

    /// Sums one value an element and node over the elements.
    pub fn sum_nodes(&self, local: &[f64], sums: &mut [f64]) {
        let Space { starts, places, .. } = &self.space;
        sums.par_iter_mut()
            .with_min_len(1024)
            .enumerate()
            .for_each(|(i, sum)| {
                let places = &places[starts[i] as usize..starts[i + 1] as usize];
                *sum = places.iter().map(|&place| local[place as usize]).sum();
            });
    }

    /// Sums three values an element and node, stored element by element and there one component after the other.
    pub fn sum_vectors(&self, local: &[f64], sums: &mut [f64]) {
        let Space {
            starts,
            places,
            nodes,
            ..
        } = &self.space;
        let n3 = self.node_count();
        for (c, sums) in sums.chunks_exact_mut(*nodes).enumerate() {
            sums.par_iter_mut()
                .with_min_len(1024)
                .enumerate()
                .for_each(|(i, sum)| {
                    let places = &places[starts[i] as usize..starts[i + 1] as usize];
                    let at = |&place: &u32| {
                        let (e, node) = (place as usize / n3, place as usize % n3);
                        local[(3 * e + c) * n3 + node]
                    };
                    *sum = places.iter().map(at).sum();
                });
        }
    }

    /// Sums one value an element and pressure node.
    pub fn sum_pressures(&self, local: &[f64], sums: &mut [f64]) {
        let Space {
            pressure_starts: starts,
            pressure_places: places,
            ..
        } = &self.space;
        sums.par_iter_mut()
            .with_min_len(1024)
            .enumerate()
            .for_each(|(i, sum)| {
                let places = &places[starts[i] as usize..starts[i + 1] as usize];
                *sum = places.iter().map(|&place| local[place as usize]).sum();
            });
    }

    /// Jacobian of the mapping at a node of an element whose nodes lie at `x` (m): column `d` is `∂x/∂ξ_d`.
    pub fn jacobian_at_node(&self, x: &[f64], node: usize) -> Matrix3<f64> {
        let n = self.basis.nodes.len();
        let n3 = self.node_count();
        let index = [node % n, node / n % n, node / n / n];
        let strides = [1, n, n * n];
        Matrix3::from_fn(|k, d| {
            let first = node - index[d] * strides[d];
            let row = &self.basis.nodal_derivative[index[d]];
            (0..n)
                .map(|j| row[j] * x[k * n3 + first + j * strides[d]])
                .sum()
        })
    }
}
