//! The deformation gradient at the points of an element, and the volume ratio that its volumetric energy sees.

use super::super::SolidError;
use super::super::material::{Volumetric, inverse_transpose, volume_change};
use super::super::space::numbering::Numbering;
use super::{Body, ElementPoint, Elements, prestretch};
use crate::Mat3;
use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Elements whose displacement gradients are computed by one matrix product.
pub(super) const CHUNK: usize = 8;

/// Deformation of an element at its points.
pub(super) struct Deformed {
    pub F: Vec<Mat3>,
    /// The volumetric energy, its derivatives as far as the stress goes: with a projection, `U' = p̄`.
    pub U: Vec<Volumetric>,
}

impl Elements {
    /// Runs `f` on chunks of elements and their displacement gradients, in parallel; results in order.
    pub(super) fn chunks<T: Send>(
        &self,
        body: Body,
        displacement: &[f64],
        modes: MatRef<'_, f64>,
        f: impl Fn(&[usize], Vec<f64>) -> Result<T, SolidError> + Sync,
    ) -> Result<Vec<T>, SolidError> {
        let all: Vec<usize> = (0..self.points.len()).collect();
        all.par_chunks(CHUNK)
            .map(|chunk| f(chunk, gradients(body, chunk, displacement, modes)))
            .collect()
    }

    /// `F = (1 + H ∂ξ/∂X) S` at the points of the element at `place` in its chunk, and the volumetric energy there, of
    /// the linearized equations if they are `linearized_at` other gradients; an error if `det F <= 0` or `J̄ <= 0`.
    pub(super) fn deformed(
        &self,
        body: Body,
        element: usize,
        gradients: &[f64],
        place: usize,
        linearized_at: Option<&[f64]>,
    ) -> Result<Deformed, SolidError> {
        let material = &body.materials[body.regions[element]];
        let points = &self.points[element];
        let project = |field: Vec<f64>| match &self.projection {
            None => field,
            Some(projection) => projection.project(element, points, &field),
        };
        let F = self.deformation(element, gradients, place);
        let changes = project(self.volume_changes(body, element, &F)?);
        self.check_volumes(body, element, &changes)?;
        let mut U: Vec<Volumetric> = changes.iter().map(|&c| material.volumetric(c)).collect();
        if let Some(gradients) = linearized_at {
            let F0 = self.deformation(element, gradients, 0);
            let linear = |(F, F0): (&Mat3, &Mat3)| {
                let (G0, J0) = inverse_transpose(F0);
                J0 * G0.dot(&(F - F0))
            };
            let linear = project(F.iter().zip(&F0).map(linear).collect());
            let changes = project(F0.iter().map(volume_change).collect());
            for ((U, change), linear) in U.iter_mut().zip(changes).zip(linear) {
                let U0 = material.volumetric(change);
                U.slope = U0.slope + U0.curvature * linear;
            }
        }
        let slopes = project(U.iter().map(|U| U.slope).collect());
        U.iter_mut().zip(slopes).for_each(|(U, p)| U.slope = p);
        Ok(Deformed { F, U })
    }

    /// `det F - 1` at the points of an element.
    fn volume_changes(
        &self,
        body: Body,
        element: usize,
        F: &[Mat3],
    ) -> Result<Vec<f64>, SolidError> {
        let changes: Vec<f64> = F.iter().map(volume_change).collect();
        self.check_volumes(body, element, &changes)?;
        Ok(changes)
    }

    /// An error if the volume of an element with these `J - 1` vanishes at a point.
    pub(super) fn check_volumes(
        &self,
        body: Body,
        element: usize,
        changes: &[f64],
    ) -> Result<(), SolidError> {
        let vanishes = |change: &f64| change.is_nan() || *change <= -1.0;
        match changes.iter().position(vanishes) {
            None => Ok(()),
            Some(q) => Err(SolidError::Inverted {
                element,
                jacobian: 1.0 + changes[q],
                position: body.mapping.at(element, self.local[q]).position.into(),
            }),
        }
    }

    /// `F` at the points of the element at `place` in its chunk.
    pub(super) fn deformation(&self, element: usize, gradients: &[f64], place: usize) -> Vec<Mat3> {
        let stride = 3 * self.shapes.points;
        let at = |(q, point): (usize, &ElementPoint)| {
            let H = Mat3::from_fn(|i, alpha| gradients[(3 * place + i) * stride + 3 * q + alpha]);
            prestretch(self.prestretch, &point.frame.axial) + H * point.inverse_jacobian
        };
        self.points[element].iter().enumerate().map(at).collect()
    }
}

impl Deformed {
    pub fn points(&self) -> impl Iterator<Item = (&Mat3, &Volumetric)> {
        self.F.iter().zip(&self.U)
    }
}

/// `H`: gradients of the displacement by the local coordinates, in the order of the columns of `modes` (fastest), times
/// `(component, element)`; `modes` are the gradients of the modes.
pub(super) fn gradients(
    body: Body,
    chunk: &[usize],
    displacement: &[f64],
    modes: MatRef<'_, f64>,
) -> Vec<f64> {
    let (n, rows) = (modes.nrows(), modes.ncols());
    let mut local = vec![0.0; n * 3 * chunk.len()];
    for (&e, to) in chunk.iter().zip(local.chunks_exact_mut(3 * n)) {
        gather(body.numbering, e, displacement, to);
    }
    let mut gradients = vec![0.0; rows * 3 * chunk.len()];
    matmul(
        MatMut::from_column_major_slice_mut(&mut gradients, rows, 3 * chunk.len()),
        Accum::Replace,
        modes.transpose(),
        MatRef::from_column_major_slice(&local, n, 3 * chunk.len()),
        1.0,
        Par::Seq,
    );
    gradients
}

/// Coefficients of an element's modes: modes (fastest) times components.
pub fn gather(numbering: &Numbering, element: usize, global: &[f64], local: &mut [f64]) {
    let (functions, signs) = (&numbering.of_element[element], &numbering.signs[element]);
    let n = functions.len();
    for m in 0..n {
        for i in 0..3 {
            local[i * n + m] = functions[m].map_or(0.0, |f| signs[m] * global[3 * f + i]);
        }
    }
}

/// Adds forces of an element's modes (fastest) and components to the global vector.
pub fn scatter(numbering: &Numbering, element: usize, local: &[f64], global: &mut [f64]) {
    let (functions, signs) = (&numbering.of_element[element], &numbering.signs[element]);
    let n = functions.len();
    for m in 0..n {
        if let Some(f) = functions[m] {
            for i in 0..3 {
                global[3 * f + i] += signs[m] * local[i * n + m];
            }
        }
    }
}
