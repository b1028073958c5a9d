//! The flow in the whole domain, for those who show it.

use super::lagrange_cell::{Extent, LagrangeCell, find};
use crate::Vec3;

/// The flow in the whole domain at the end of a step, in hexahedra on which all fields are polynomials of one degree in
/// each of the local coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct FluidField {
    /// The degree.
    pub degree: usize,
    /// Points where they are at that time, equally spaced in each cell's local coordinates, m.
    pub points: Vec<Vec3>,
    /// The `(degree + 1)³` points of each cell, fastest along its first axis; the three axes are right-handed.
    pub cells: Vec<u32>,
    /// Velocity at the points, m/s.
    pub velocity: Vec<Vec3>,
    /// Pressure at the points, Pa.
    pub pressure: Vec<f64>,
}

/// Local coordinates in [-1, 1] of as many equally spaced points as a polynomial of the degree has coefficients.
pub fn equally_spaced(degree: usize) -> Vec<f64> {
    (0..=degree)
        .map(|i| 2.0 * i as f64 / degree as f64 - 1.0)
        .collect()
}

/// A field in which points are looked up.
#[derive(Debug, Clone)]
pub struct SearchableField {
    field: FluidField,
    rule: Vec<f64>,
    extents: Vec<Extent>,
}

impl SearchableField {
    /// Of a field.
    pub fn new(field: FluidField) -> Self {
        let mut searchable = Self {
            rule: equally_spaced(field.degree),
            extents: Vec::new(),
            field,
        };
        let position = |i: usize| searchable.field.points[i];
        let cells = searchable.cells();
        searchable.extents = cells.map(|cell| cell.extent(&position)).collect();
        searchable
    }

    /// The field.
    pub fn field(&self) -> &FluidField {
        &self.field
    }

    fn cells(&self) -> impl Iterator<Item = LagrangeCell<'_>> {
        let size = (self.field.degree + 1).pow(3);
        self.field
            .cells
            .chunks_exact(size)
            .map(|nodes| LagrangeCell {
                rule: &self.rule,
                nodes,
            })
    }

    /// Velocity (m/s) at a point (m); none outside.
    pub fn velocity(&self, x: &Vec3) -> Option<Vec3> {
        let position = |i: usize| self.field.points[i];
        let (e, xi) = find(self.cells().zip(&self.extents), &position, x)?;
        let cell = self.cells().nth(e)?;
        let shapes = cell.shapes(&xi).into_iter();
        let nodes = cell.nodes.iter().zip(shapes);
        Some(
            nodes
                .map(|(&i, shape)| shape * self.field.velocity[i as usize])
                .sum(),
        )
    }
}
