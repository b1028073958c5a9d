//! From a space to a larger one on the same mesh: the basis is hierarchic, so that coefficients are copied.

use super::Mode;
use super::numbering::Numbering;
use std::collections::HashMap;

/// The coefficients in the space of `to` of the displacement that has the coefficients `displacement` in the space of
/// `from`. Modes that the larger space lacks are left out.
pub fn prolong(from: &Numbering, to: &Numbering, displacement: &[f64]) -> Vec<f64> {
    let place: HashMap<Mode, usize> = to
        .modes
        .iter()
        .enumerate()
        .map(|(m, mode)| (*mode, m))
        .collect();
    let mut prolonged = vec![0.0; 3 * to.functions];
    for (element, functions) in from.of_element.iter().enumerate() {
        for (mode, function) in from.modes.iter().zip(functions) {
            let Some(&m) = place.get(mode) else { continue };
            // The sign of a mode depends on its element and its indices, but not on the space.
            if let (Some(f), Some(g)) = (*function, to.of_element[element][m]) {
                prolonged[3 * g..3 * g + 3].copy_from_slice(&displacement[3 * f..3 * f + 3]);
            }
        }
    }
    prolonged
}
