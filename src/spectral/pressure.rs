//! The preconditioner: the block factorization of the saddle point with the diagonal of the momentum operator.
//!
//! With `D` the diagonal of mass and viscosity, the pressure's Schur complement is `S = B D⁻¹ Bᵀ`, as sparse as a
//! Laplacian on a wider neighbourhood and, at time steps that resolve the flow, close to the true one. Its inverse is
//! approximated by one cycle of a two-level Schwarz method (Smith, Bjørstad and Gropp: *Domain decomposition*, 1996): a
//! correction in the trilinear functions of the elements' corners, whose equations are factorized, then the inverses of
//! `S` within each element, added up with weights. It takes as many iterations as the inverse itself, and work and
//! memory that grow with the mesh alone. The blocks are of `S`, not of a Laplacian: at walls, where the velocity is
//! prescribed, the two differ by a factor of 30.
//!
//! All of it is made seldom, for a geometry that is kept until the mesh has moved far from it.

mod blocks;
mod corners;

use super::FlowError;
use super::divergence::element_rows;
use super::local::Local;
use super::metric::Metric;
use super::spectral_elements::SpectralElements;
use blocks::Blocks;
use corners::Corners;

/// A matrix is not positive definite.
struct NotPositive;

/// Approximate inverse of a Schur complement.
pub struct SchurComplement {
    corners: Corners,
    blocks: Blocks,
}

/// Products with the Schur complement at the moment, element by element.
pub struct SchurProduct<'a> {
    /// The elements.
    pub space: &'a SpectralElements,
    /// Of their [`Metric`].
    pub cofactors: &'a [f64],
    /// Inverse of `D` at each node, zero where the velocity is prescribed.
    pub inverse_diagonal: &'a [f64],
    /// Memory.
    pub local: &'a mut Local,
}

impl SchurProduct<'_> {
    /// Takes `B D⁻¹ Bᵀ p` off `from`.
    fn subtract(&mut self, p: &[f64], from: &mut [f64]) {
        let at = (self.space, self.cofactors);
        let mut vector = std::mem::take(&mut self.local.vector);
        (self.local).minus_gradient(at, p, &mut vector, |i, gradient, v| {
            let d = self.inverse_diagonal[i];
            v.into_iter().zip(gradient).for_each(|(v, g)| *v = g * d);
        });
        (self.local).minus_divergence(at, &vector, from, |_, product, r| *r -= product);
        self.local.vector = vector;
    }
}

impl SchurComplement {
    /// For a geometry and the inverse of `D` at each node, zero where the velocity is prescribed.
    ///
    /// # Errors
    /// If the matrix is not positive definite: the pressure is not fixed by any outlet.
    pub fn new(
        space: &SpectralElements,
        metric: &Metric,
        inverse_diagonal: &[f64],
    ) -> Result<Self, FlowError> {
        let of_elements = element_rows(space, metric);
        let parts = || {
            Ok(Self {
                corners: Corners::new(space, &of_elements, inverse_diagonal)?,
                blocks: Blocks::new(space, &of_elements, inverse_diagonal)?,
            })
        };
        parts().map_err(|NotPositive| {
            FlowError::Model(
                "the pressure's matrix cannot be factorized: is there no outlet?".into(),
            )
        })
    }

    /// Solves in place among the corners' functions alone: the residual that remains is orthogonal to them.
    pub fn solve_coarse(&self, rhs: &mut [f64], scale: f64, now: SchurProduct) {
        let mut x = vec![0.0; rhs.len()];
        (self.corners).add(now.space, rhs, scale, &mut now.local.continuity, &mut x);
        rhs.copy_from_slice(&x);
    }

    /// Solves in place, approximately, with a complement that is smaller by the factor `scale` than that of which this
    /// was made, and whose products are `now`.
    pub fn solve(&self, rhs: &mut [f64], scale: f64, mut now: SchurProduct) {
        let mut x = vec![0.0; rhs.len()];
        (self.corners).add(now.space, rhs, scale, &mut now.local.continuity, &mut x);
        now.subtract(&x, rhs);
        (self.blocks).add(now.space, rhs, scale, &mut now.local.continuity, &mut x);
        rhs.copy_from_slice(&x);
    }
}

/// Sums what the elements give, with a weight for each unknown, onto `x`.
fn add_sums(space: &SpectralElements, local: &[f64], weights: &[f64], x: &mut [f64]) {
    space.sum_pressures(local, x, |i, sum, x| *x += weights[i] * sum);
}
