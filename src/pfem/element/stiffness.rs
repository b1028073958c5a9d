//! Element matrices: stiffness and mass.

use super::super::SolidError;
use super::super::material::Volumetric;
use super::deformation::{Deformed, gradients};
use super::{Body, Elements, Motion, PAIRS};
use crate::Mat3;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

impl Elements {
    /// The blocks `K^{ik}` of [`PAIRS`] of one element, each modes times modes, one after the other.
    ///
    /// If the displacement is the result of a step of Newton's method from `linearized_at`, the volumetric stress is
    /// the one that the linearized equations gave, `U'(J_0) + U''(J_0) J_0 F_0⁻ᵀ : (F - F_0)` (all of it projected in
    /// the mixed form), and not yet `U'(J)`, which the terms of second order of a long step spoil in a nearly
    /// incompressible material (Magisano, Leonetti, Garcea: *How to improve efficiency and robustness of the Newton
    /// method in geometrically non-linear structural problem discretized via displacement-based finite elements*,
    /// 2017).
    pub fn stiffness(
        &self,
        body: Body,
        element: usize,
        displacement: &[f64],
        linearized_at: Option<&[f64]>,
        motion: Option<&Motion>,
    ) -> Result<Vec<f64>, SolidError> {
        let viscous = motion.zip(body.viscous[body.regions[element]]);
        let viscous = viscous.map(|(motion, law)| {
            let rates = self.rates(body, element, motion.velocity);
            (law, rates, motion.slope)
        });
        let modes = self.shapes.gradient_matrix();
        let gradients = |at: &[f64]| gradients(body, &[element], at, modes);
        let (gradients, old_gradients) = (gradients(displacement), linearized_at.map(gradients));
        let material = &body.materials[body.regions[element]];
        let deformed = self.deformed(body, element, &gradients, 0, old_gradients.as_deref())?;
        let mut workspace = self
            .workspaces
            .take()
            .unwrap_or_else(|| self.sums.workspace());
        for (q, (F, U)) in deformed.points().enumerate() {
            let point = &self.points[element][q];
            // With a projection, points act on each other through the volume.
            let local = match &self.projection {
                None => *U,
                Some(_) => Volumetric {
                    curvature: 0.0,
                    ..*U
                },
            };
            let mut A = material.tangent_with(F, &point.frame, &local);
            if let Some((law, rates, slope)) = &viscous {
                A += law.symmetric_tangent(F, &rates[q], *slope);
            }
            let places = self.sums.places(q);
            for (pair, (i, k)) in PAIRS.into_iter().enumerate() {
                let block: Mat3 = A.fixed_view::<3, 3>(3 * i, 3 * k).into();
                let B = &point.inverse_jacobian;
                let pulled_back = B * block * B.transpose() * point.weight;
                for alpha in 0..3 {
                    for beta in 0..3 {
                        let place = places[3 * alpha + beta] + pair * self.sums.stride();
                        workspace.coefficients[place] = pulled_back[(alpha, beta)];
                    }
                }
            }
        }
        let mut matrices = self.sums.matrices(&mut workspace);
        self.workspaces.give(workspace);
        if let Some(projection) = &self.projection
            && deformed.U.iter().any(|U| U.curvature != 0.0)
        {
            let (points, gradients) = (&self.points[element], self.shapes.gradient_matrix());
            let Deformed { F, U } = &deformed;
            projection.add_stiffness(element, points, gradients, F, U, &mut matrices);
        }
        Ok(matrices)
    }

    /// `∫ N_a N_b dV` of one element, m³, modes times modes.
    pub fn mass(&self, element: usize) -> Vec<f64> {
        let n = self.shapes.modes;
        let mut weighted = self.shapes.values.clone();
        for (column, point) in weighted.chunks_exact_mut(n).zip(&self.points[element]) {
            column.iter_mut().for_each(|v| *v *= point.weight);
        }
        let mut mass = vec![0.0; n * n];
        matmul(
            MatMut::from_column_major_slice_mut(&mut mass, n, n),
            Accum::Replace,
            self.shapes.value_matrix(),
            MatRef::from_column_major_slice(&weighted, n, self.shapes.points).transpose(),
            1.0,
            Par::Seq,
        );
        mass
    }
}
