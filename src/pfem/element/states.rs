//! What the elements say about themselves: displacements, stresses, pressures.

use super::super::SolidError;
use super::super::evaluation::stress::StressState;
use super::super::material::Volumetric;
use super::super::space::numbering::Numbering;
use super::deformation::{Deformed, gather};
use super::volume::Basis;
use super::{Body, ElementPoint, Elements};
use crate::{Mat3, Vec3};

impl Elements {
    /// Coefficients of the pressure `p̄` in each element, if there is a projection.
    pub fn pressures(
        &self,
        body: Body,
        displacement: &[f64],
    ) -> Result<Option<Vec<Vec<f64>>>, SolidError> {
        let Some(projection) = &self.projection else {
            return Ok(None);
        };
        let parts = self.chunks(
            body,
            displacement,
            self.shapes.gradient_matrix(),
            |chunk, gradients| {
                let of = |(c, &e): (usize, &usize)| {
                    let deformed = self.deformed(body, e, &gradients, c, None)?;
                    let slopes: Vec<f64> = deformed.U.iter().map(|U| U.slope).collect();
                    Ok(projection.coefficients(e, &self.points[e], &slopes))
                };
                chunk
                    .iter()
                    .enumerate()
                    .map(of)
                    .collect::<Result<Vec<_>, SolidError>>()
            },
        )?;
        Ok(Some(parts.concat()))
    }

    /// Stresses and strains at all points, element by element; `pressures` are those of [`Self::pressures`] with their
    /// functions at these points, else the points' own volumetric stress counts. NaN where `det F <= 0`, as
    /// may be in the very corner of an element.
    pub fn states(
        &self,
        body: Body,
        displacement: &[f64],
        pressures: Option<(&Basis, &[Vec<f64>])>,
    ) -> Result<Vec<StressState>, SolidError> {
        let parts = self.chunks(
            body,
            displacement,
            self.shapes.gradient_matrix(),
            |chunk, gradients| {
                let mut states = Vec::with_capacity(chunk.len() * self.shapes.points);
                for (c, &e) in chunk.iter().enumerate() {
                    let material = &*body.materials[body.regions[e]];
                    let deformed = match pressures {
                        None => self.deformed(body, e, &gradients, c, None)?,
                        Some((basis, coefficients)) => {
                            let slopes = basis.evaluate(&coefficients[e]);
                            let of = |slope| Volumetric {
                                slope,
                                ..Volumetric::default()
                            };
                            Deformed {
                                F: self.deformation(e, &gradients, c),
                                U: slopes.into_iter().map(of).collect(),
                            }
                        }
                    };
                    let of = |((F, U), point): ((&Mat3, &Volumetric), &ElementPoint)| {
                        StressState::new(material, F, &point.frame, U)
                    };
                    states.extend(deformed.points().zip(&self.points[e]).map(of));
                }
                Ok(states)
            },
        )?;
        Ok(parts.concat())
    }

    /// Displacement (m) at all points, element by element.
    pub fn displacement(&self, numbering: &Numbering, displacement: &[f64]) -> Vec<Vec3> {
        let n = self.shapes.modes;
        let mut local = vec![0.0; 3 * n];
        let mut all = Vec::with_capacity(self.points.len() * self.shapes.points);
        for e in 0..self.points.len() {
            gather(numbering, e, displacement, &mut local);
            let component = |values: &[f64], i: usize| -> f64 {
                values.iter().zip(&local[i * n..]).map(|(v, u)| v * u).sum()
            };
            let at = |values: &[f64]| Vec3::from_fn(|i, _| component(values, i));
            all.extend(self.shapes.values.chunks_exact(n).map(at));
        }
        all
    }
}
