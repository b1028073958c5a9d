//! Elements of one degree on a mesh: gathers what an element needs, sums what elements give.

use super::FlowError;
use super::basis::Basis;
use super::contraction::LANES;
use super::kernel::{Kernel, kernel};
use super::taylor_hood_space::TaylorHoodSpace;
use rayon::prelude::*;

/// Numbers that one thread works on at a time.
pub const CHUNK: usize = 4096;

/// A space with the operators of its elements.
pub struct SpectralElements {
    /// Numbering.
    pub space: TaylorHoodSpace,
    /// One-dimensional operators.
    pub basis: Basis,
    /// Operations of an element.
    pub kernel: Box<dyn Kernel>,
    /// Weights of the `M³` Gauss points.
    pub gauss_weights: Vec<f64>,
    /// Weights of the `(N + 1)³` nodes.
    pub node_weights: Vec<f64>,
    /// Nodes of the groups, lane by lane.
    group_nodes: Vec<u32>,
    group_pressures: Vec<u32>,
    /// Where the values of `TaylorHoodSpace::places` stand in the groups' first component.
    node_slots: Vec<u32>,
    pressure_slots: Vec<u32>,
}

impl SpectralElements {
    /// For a numbering whose degree lies within [`Basis::DEGREES`].
    ///
    /// # Errors
    /// If it does not.
    pub fn new(space: TaylorHoodSpace) -> Result<Self, FlowError> {
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
            group_nodes: side_by_side(&space.of_element, space.elements),
            group_pressures: side_by_side(&space.pressures_of_element, space.elements),
            node_slots: slots(&space.places, (space.degree + 1).pow(3), 3),
            pressure_slots: slots(&space.pressure_places, space.degree.pow(3), 1),
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

    /// Groups of [`LANES`] elements; the last one repeats the last element where there are no more.
    pub fn groups(&self) -> usize {
        self.space.elements.div_ceil(LANES)
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

    /// Copies the three components of a field to the nodes of a group of elements.
    pub fn gather_group(&self, group: usize, field: &[f64], local: &mut [f64]) {
        let size = self.node_count() * LANES;
        let nodes = &self.group_nodes[group * size..(group + 1) * size];
        for (c, local) in local.chunks_exact_mut(size).enumerate() {
            let field = &field[c * self.space.nodes..(c + 1) * self.space.nodes];
            for (value, &node) in local.iter_mut().zip(nodes) {
                *value = field[node as usize];
            }
        }
    }

    /// Copies a pressure to the nodes of a group of elements.
    pub fn gather_pressures(&self, group: usize, field: &[f64], local: &mut [f64]) {
        let size = self.pressure_count() * LANES;
        let nodes = &self.group_pressures[group * size..(group + 1) * size];
        for (value, &node) in local.iter_mut().zip(nodes) {
            *value = field[node as usize];
        }
    }

    /// Sums one value a node and lane over the elements.
    pub fn sum_nodes(&self, local: &[f64], sums: &mut [f64]) {
        let (starts, size) = (&self.space.starts, self.node_count() * LANES);
        let all = sums.par_iter_mut().enumerate();
        all.with_min_len(CHUNK).for_each(|(i, sum)| {
            let slots = &self.node_slots[starts[i] as usize..starts[i + 1] as usize];
            // Slots are those of the first of three components
            let place = |slot: usize| slot - slot / (3 * size) * 2 * size;
            *sum = (slots.iter())
                .map(|&slot| local[place(slot as usize)])
                .sum();
        });
    }

    /// Sums three values a node and lane over the elements, and lets `take` put the sums of each node to its components
    /// of the `field`, which come one after the other.
    pub fn sum_vectors(
        &self,
        local: &[f64],
        field: &mut [f64],
        take: impl Fn(usize, [f64; 3], [&mut f64; 3]) + Sync,
    ) {
        let size = self.node_count() * LANES;
        let starts = &self.space.starts;
        at_each_node(field, |i, own| {
            let mut sums = [0.0; 3];
            for &slot in &self.node_slots[starts[i] as usize..starts[i + 1] as usize] {
                for (c, sum) in sums.iter_mut().enumerate() {
                    *sum += local[slot as usize + c * size];
                }
            }
            take(i, sums, own);
        });
    }

    /// Sums one value a pressure node and lane over the elements, and lets `take` put each sum to its own of `field`.
    pub fn sum_pressures(
        &self,
        local: &[f64],
        field: &mut [f64],
        take: impl Fn(usize, f64, &mut f64) + Sync,
    ) {
        let starts = &self.space.pressure_starts;
        let all = field.par_iter_mut().enumerate();
        all.with_min_len(CHUNK).for_each(|(i, own)| {
            let slots = &self.pressure_slots[starts[i] as usize..starts[i + 1] as usize];
            take(i, slots.iter().map(|&slot| local[slot as usize]).sum(), own);
        });
    }
}

/// Lists of the same length for each element, lane by lane.
fn side_by_side(lists: &[u32], elements: usize) -> Vec<u32> {
    let size = lists.len() / elements;
    let groups = 0..elements.div_ceil(LANES);
    groups
        .flat_map(|group| {
            (0..size * LANES).map(move |i| {
                let element = (group * LANES + i % LANES).min(elements - 1);
                lists[element * size + i / LANES]
            })
        })
        .collect()
}

/// Where the values of an element and node stand in groups with some components.
fn slots(places: &[u32], size: usize, components: usize) -> Vec<u32> {
    let slot = |&place: &u32| {
        let (element, node) = (place as usize / size, place as usize % size);
        let first = element / LANES * components * size + node;
        (first * LANES + element % LANES) as u32
    };
    places.iter().map(slot).collect()
}

/// Calls `f` with the number of each node and its components of a `field`, which come one after the other.
pub fn at_each_node(field: &mut [f64], f: impl Fn(usize, [&mut f64; 3]) + Sync) {
    let (x, others) = field.split_at_mut(field.len() / 3);
    let (y, z) = others.split_at_mut(x.len());
    let all = x.par_iter_mut().zip(y).zip(z).enumerate();
    all.with_min_len(CHUNK)
        .for_each(|(i, ((x, y), z))| f(i, [x, y, z]));
}
