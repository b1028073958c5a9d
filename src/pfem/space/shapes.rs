//! The modes of an element, tabulated.

use super::basis::BasisTable;
use super::{Mode, Space};
use faer::MatRef;

/// Values and gradients of the modes at the points of a lattice in the reference hexahedron.
#[derive(Debug, Clone)]
pub struct Shapes {
    /// Number of modes.
    pub modes: usize,
    /// Number of points.
    pub points: usize,
    /// Modes (fastest) times points.
    pub values: Vec<f64>,
    /// Modes (fastest) times local directions times points.
    pub gradients: Vec<f64>,
}

impl Shapes {
    /// Tabulates `modes` at the lattice of `axes`, first direction fastest.
    pub fn new(modes: &[Mode], space: &Space, axes: [&[f64]; 3]) -> Self {
        let tables: [BasisTable; 3] =
            std::array::from_fn(|d| BasisTable::new(space.degrees[d], axes[d]));
        let sizes = axes.map(<[f64]>::len);
        let points: usize = sizes.iter().product();
        let mut values = Vec::with_capacity(modes.len() * points);
        let mut gradients = Vec::with_capacity(3 * modes.len() * points);
        for q in 0..points {
            let at = [
                q % sizes[0],
                q / sizes[0] % sizes[1],
                q / (sizes[0] * sizes[1]),
            ];
            let factor = |mode: &Mode, d: usize, derived: Option<usize>| {
                let table = &tables[d];
                if derived == Some(d) {
                    table.derivatives[mode[d]][at[d]]
                } else {
                    table.values[mode[d]][at[d]]
                }
            };
            let product = |mode: &Mode, derived| -> f64 {
                (0..3).map(|d| factor(mode, d, derived)).product()
            };
            values.extend(modes.iter().map(|m| product(m, None)));
            for alpha in 0..3 {
                gradients.extend(modes.iter().map(|m| product(m, Some(alpha))));
            }
        }
        Self {
            modes: modes.len(),
            points,
            values,
            gradients,
        }
    }

    /// Modes times local directions and points.
    pub fn gradient_matrix(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.gradients, self.modes, 3 * self.points)
    }

    /// Modes times points.
    pub fn value_matrix(&self) -> MatRef<'_, f64> {
        MatRef::from_column_major_slice(&self.values, self.modes, self.points)
    }
}
