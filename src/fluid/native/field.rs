//! The flow at equally spaced points of each element, as programs that draw it expect.

use super::flow::FlowState;
use super::spectral_elements::SpectralElements;
use super::surface::face_values;
use crate::Vec3;
use crate::fluid::FluidField;
use crate::fluid::field::equally_spaced;
use crate::lagrange;

/// The newest fields of a state: the same polynomials, known by their values at other points. Elements that meet have
/// the same values where they do.
pub fn field(space: &SpectralElements, state: &FlowState) -> FluidField {
    let degree = space.basis.degree();
    let places = equally_spaced(degree);
    let rows = |points: &[f64]| -> Vec<Vec<f64>> {
        places
            .iter()
            .map(|&x| lagrange::values(points, x))
            .collect()
    };
    let from_nodes = rows(&space.basis.nodes.points);
    let from_pressures = rows(&space.basis.pressure_nodes.points);
    let nodes = space.space.nodes;
    let mut field = FluidField {
        degree,
        points: vec![Vec3::zeros(); nodes],
        cells: space.space.of_element.clone(),
        velocity: vec![Vec3::zeros(); nodes],
        pressure: vec![0.0; nodes],
    };
    for e in 0..space.space.elements {
        let element = space.space.element(e);
        let vectors = |values: &[f64]| -> Vec<Vec3> {
            let at_nodes = element.iter().map(|&i| space.vector(values, i as usize));
            volume_values(&from_nodes, &at_nodes.collect::<Vec<_>>())
        };
        let points = vectors(&state.positions[0]);
        let velocity = vectors(&state.velocity[0]);
        let pressures = space.space.element_pressures(e).iter();
        let pressures: Vec<f64> = pressures.map(|&i| state.pressure[0][i as usize]).collect();
        let pressure = volume_values(&from_pressures, &pressures);
        for (i, &node) in element.iter().enumerate() {
            let node = node as usize;
            field.points[node] = points[i];
            field.velocity[node] = velocity[i];
            field.pressure[node] = pressure[i];
        }
    }
    field
}

/// Tensor product interpolation with the same matrix for each direction.
fn volume_values<T>(rows: &[Vec<f64>], values: &[T]) -> Vec<T>
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::iter::Sum,
{
    let n = rows[0].len();
    let layers: Vec<Vec<T>> = (values.chunks_exact(n * n))
        .map(|layer| face_values(rows, rows, layer))
        .collect();
    (rows.iter())
        .flat_map(|row| {
            let layers = &layers;
            let sum = move |i| layers.iter().zip(row).map(|(layer, c)| layer[i] * *c).sum();
            (0..layers[0].len()).map(sum)
        })
        .collect()
}
