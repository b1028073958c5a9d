//! Forces of viscous stresses.

use super::deformation::{gradients, scatter};
use super::{Body, ElementPoint, Elements, prestretch};
use crate::Mat3;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

impl Elements {
    /// Forces of the viscous stresses at every degree of freedom, N.
    pub fn viscous_forces(&self, body: Body, displacement: &[f64], velocity: &[f64]) -> Vec<f64> {
        let (n, nq) = (self.shapes.modes, self.shapes.points);
        let modes = self.shapes.gradient_matrix();
        let all: Vec<usize> = (0..self.points.len()).collect();
        let of_element = |&e: &usize| -> Option<(usize, Vec<f64>)> {
            let law = body.viscous[body.regions[e]]?;
            let F = self.deformation(e, &gradients(body, &[e], displacement, modes), 0);
            let rates = self.rates(body, e, velocity);
            let mut fluxes = vec![0.0; 9 * nq];
            for (q, point) in self.points[e].iter().enumerate() {
                let P = law.stress(&F[q], &rates[q]);
                let Q = point.inverse_jacobian * P.transpose() * point.weight;
                for (i, alpha) in (0..9).map(|k| (k / 3, k % 3)) {
                    fluxes[i * 3 * nq + 3 * q + alpha] = Q[(alpha, i)];
                }
            }
            let mut forces = vec![0.0; 3 * n];
            matmul(
                MatMut::from_column_major_slice_mut(&mut forces, n, 3),
                Accum::Replace,
                modes,
                MatRef::from_column_major_slice(&fluxes, 3 * nq, 3),
                1.0,
                Par::Seq,
            );
            Some((e, forces))
        };
        let parts: Vec<_> = all.par_iter().filter_map(of_element).collect();
        let mut total = vec![0.0; displacement.len()];
        for (e, local) in &parts {
            scatter(body.numbering, *e, local, &mut total);
        }
        total
    }

    /// `Ḟ` at the points of an element, 1/s.
    pub(super) fn rates(&self, body: Body, element: usize, velocity: &[f64]) -> Vec<Mat3> {
        let gradients = gradients(body, &[element], velocity, self.shapes.gradient_matrix());
        let mut rates = self.deformation(element, &gradients, 0);
        let points = self.points[element].iter();
        let initial = |point: &ElementPoint| prestretch(self.prestretch, &point.frame.axial);
        (rates.iter_mut().zip(points)).for_each(|(F, point)| *F -= initial(point));
        rates
    }
}
