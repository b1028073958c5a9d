//! The operators between velocity and pressure, `-∫ q div u` and `-∫ p div v`, and the results of the elements before
//! they are summed.

use super::contraction::LANES;
use super::spectral_elements::SpectralElements;
use rayon::prelude::*;

/// Results of the elements before they are summed, and sums.
#[derive(Debug, Default)]
pub struct Local {
    /// Of the equations of momentum, group after group.
    pub momentum: Vec<f64>,
    /// Of the equation of continuity.
    pub continuity: Vec<f64>,
    /// A field, one component after the other.
    pub vector: Vec<f64>,
}

impl Local {
    /// Memory for the elements of a space.
    pub fn new(space: &SpectralElements) -> Self {
        let groups = space.groups() * LANES;
        Self {
            momentum: vec![0.0; groups * 3 * space.node_count()],
            continuity: vec![0.0; groups * space.pressure_count()],
            vector: vec![0.0; 3 * space.space.nodes],
        }
    }

    /// `-∫ q div u` of a velocity `u`, one component after the other, with the cofactors of
    /// [`Metric`](super::metric::Metric); `take` as in [`SpectralElements::sum_pressures`].
    pub fn minus_divergence(
        &mut self,
        (space, cofactors): (&SpectralElements, &[f64]),
        u: &[f64],
        field: &mut [f64],
        take: impl Fn(usize, f64, &mut f64) + Sync,
    ) {
        let [n3, m3, p3] = sizes(space);
        self.continuity
            .par_chunks_mut(p3)
            .enumerate()
            .for_each_init(
                || (space.kernel.scratch(), vec![0.0; 3 * n3]),
                |(scratch, u_local), (e, continuity)| {
                    space.gather_group(e, u, u_local);
                    let g = &cofactors[9 * m3 * e..9 * m3 * (e + 1)];
                    (space.kernel).minus_divergence(g, u_local, continuity, scratch);
                },
            );
        space.sum_pressures(&self.continuity, field, take);
    }

    /// `-∫ p div v` of a pressure `p`; `take` as in [`SpectralElements::sum_vectors`].
    pub fn minus_gradient(
        &mut self,
        (space, cofactors): (&SpectralElements, &[f64]),
        p: &[f64],
        field: &mut [f64],
        take: impl Fn(usize, [f64; 3], [&mut f64; 3]) + Sync,
    ) {
        let [n3, m3, p3] = sizes(space);
        self.momentum
            .par_chunks_mut(3 * n3)
            .enumerate()
            .for_each_init(
                || (space.kernel.scratch(), vec![0.0; p3]),
                |(scratch, p_local), (e, momentum)| {
                    space.gather_pressures(e, p, p_local);
                    let g = &cofactors[9 * m3 * e..9 * m3 * (e + 1)];
                    space.kernel.minus_gradient(g, p_local, momentum, scratch);
                },
            );
        space.sum_vectors(&self.momentum, field, take);
    }
}

/// Nodes, Gauss points and nodes of the pressure of a group of elements.
pub fn sizes(space: &SpectralElements) -> [usize; 3] {
    let (n3, m3) = (space.node_count(), space.gauss_count());
    [n3, m3, space.pressure_count()].map(|count| count * LANES)
}
