//! The blood over time for ParaView (`fluid.pvd`): hexahedra on which velocity and pressure are polynomials.

use super::vtu::{Cells, Values, VtuGrid, VtuSeries, lagrange_order, read_piece};
use crate::Vec3;
use crate::fluid::FluidField;
use std::io;
use std::path::Path;
use vtkio::model::VertexNumbers;

const VELOCITY: &str = "velocity_m_s";
const PRESSURE: &str = "pressure_Pa";

/// Adds the flow at a time (s).
pub fn add(series: &mut VtuSeries, time: f64, field: &FluidField) -> io::Result<()> {
    let grid = VtuGrid {
        points: &field.points,
        cells: Cells::Lagrange {
            degree: field.degree,
            points: &field.cells,
        },
        point_data: vec![
            (VELOCITY, Values::Vectors(&field.velocity)),
            (PRESSURE, Values::Scalars(&field.pressure)),
        ],
        cell_data: Vec::new(),
    };
    series.add(time, &grid)
}

/// Reads what was added.
///
/// # Errors
/// If the file is not of this kind.
pub fn read(path: &Path) -> io::Result<FluidField> {
    let bad = |what: &str| {
        let text = format!("{}: {what}", path.display());
        io::Error::new(io::ErrorKind::InvalidData, text)
    };
    let piece = read_piece(path)?;
    let vectors = |numbers: Option<Vec<f64>>| -> Option<Vec<Vec3>> {
        let numbers = numbers?;
        let chunks = numbers.chunks_exact(3);
        Some(chunks.map(Vec3::from_column_slice).collect())
    };
    let points = vectors(piece.points.clone().into_vec());
    let VertexNumbers::XML {
        connectivity,
        offsets,
    } = &piece.cells.cell_verts
    else {
        return Err(bad("no cells"));
    };
    let size = offsets.first().map_or(0, |&size| size as usize);
    let degree = (1..=size).find(|n| (n + 1).pow(3) >= size).unwrap_or(0);
    let order = lagrange_order(degree);
    let (Some(points), Some(velocity), Some(pressure)) = (
        points,
        vectors(super::vtu::point_values(&piece, VELOCITY)),
        super::vtu::point_values(&piece, PRESSURE),
    ) else {
        return Err(bad("no velocity and pressure of blood"));
    };
    let count = points.len();
    let whole = order.len() == size
        && connectivity.len() == size * offsets.len()
        && connectivity.iter().all(|&i| (i as usize) < count)
        && [velocity.len(), pressure.len()] == [count; 2];
    if !whole {
        return Err(bad("not a grid of hexahedra with one degree"));
    }
    let mut cells = vec![0; connectivity.len()];
    for (cell, points) in (cells.chunks_exact_mut(size)).zip(connectivity.chunks_exact(size)) {
        for (&place, &point) in order.iter().zip(points) {
            cell[place] = point as u32;
        }
    }
    Ok(FluidField {
        degree,
        points,
        cells,
        velocity,
        pressure,
    })
}
