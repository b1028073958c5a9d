//! Two meshes of each of two solvers: what refinement changes, and where it leads.
//!
//! Of the first solver, whose error falls like a power of the cells' size, the value at cells of no size is extrapolated
//! (Richardson), with the grid convergence index of two meshes as its uncertainty (Roache 1994: factor of safety 3). Of the second,
//! whose error falls faster than any power with the degree, the finer value counts, and what the last degree changed is its
//! uncertainty.

use super::comparison::{Comparison, Difference};
use super::write_atomically;
use serde::Serialize;
use std::path::Path;

/// Order that is taken for the first solver: that of its schemes in space.
const ORDER: f64 = 2.0;
/// Factor of safety for two meshes.
const SAFETY: f64 = 3.0;

/// A quantity with both solvers on two meshes each.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refined {
    /// What, with its unit.
    pub quantity: &'static str,
    /// The region of a field; empty for histories.
    pub region: String,
    /// Mean with the first solver, coarser mesh.
    pub coarse_a: f64,
    /// The same on the finer mesh.
    pub fine_a: f64,
    /// Extrapolated to cells of no size.
    pub extrapolated_a: f64,
    /// Uncertainty of the extrapolated value.
    pub uncertainty_a: f64,
    /// Order at which the first solver comes nearer to the finer value of the second; not a number if it does not.
    pub observed_order_a: f64,
    /// Mean with the second solver, lower degree.
    pub coarse_b: f64,
    /// The same with the higher degree.
    pub fine_b: f64,
    /// Uncertainty of the latter.
    pub uncertainty_b: f64,
    /// Root mean square of the difference of the two solvers over that of the first, on the coarser meshes.
    pub relative_rms_coarse: f64,
    /// The same on the finer meshes.
    pub relative_rms_fine: f64,
    /// Whether the extrapolated values differ by no more than both uncertainties together.
    pub agree: bool,
}

impl Refined {
    /// From the comparisons on the coarser and on the finer meshes; the first solver's cells are `ratio` times as long on the
    /// coarser one.
    fn of(coarse: &Difference, fine: &Difference, ratio: f64) -> Self {
        let [coarse_a, fine_a] = [coarse.mean_a, fine.mean_a];
        let [coarse_b, fine_b] = [coarse.mean_b, fine.mean_b];
        let change = (fine_a - coarse_a) / (ratio.powf(ORDER) - 1.0);
        let (uncertainty_a, uncertainty_b) = (SAFETY * change.abs(), (fine_b - coarse_b).abs());
        let distance = |value: f64| (value - fine_b).abs();
        let order = (distance(coarse_a) / distance(fine_a)).ln() / ratio.ln();
        let extrapolated_a = fine_a + change;
        Self {
            quantity: fine.quantity,
            region: fine.region.clone(),
            coarse_a,
            fine_a,
            extrapolated_a,
            uncertainty_a,
            observed_order_a: if order > 0.0 { order } else { f64::NAN },
            coarse_b,
            fine_b,
            uncertainty_b,
            relative_rms_coarse: coarse.relative_rms,
            relative_rms_fine: fine.relative_rms,
            agree: distance(extrapolated_a) <= uncertainty_a + uncertainty_b,
        }
    }

    /// What, and where.
    pub fn name(&self) -> String {
        match self.region.as_str() {
            "" => self.quantity.to_owned(),
            region => format!("{} ({region})", self.quantity),
        }
    }
}

/// All quantities of a case.
pub fn refinement(coarse: &Comparison, fine: &Comparison, ratio: f64) -> Vec<Refined> {
    let pairs = coarse.differences.iter().zip(&fine.differences);
    pairs.map(|(c, f)| Refined::of(c, f, ratio)).collect()
}

/// Writes a table with a row a quantity.
///
/// # Errors
/// If the file cannot be written.
pub fn write(rows: &[Refined], path: &Path) -> std::io::Result<()> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(std::io::Error::other)?;
    }
    let bytes = writer
        .into_inner()
        .map_err(|e| std::io::Error::other(e.to_string()))?;
    write_atomically(path, &bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn difference(mean_a: f64, mean_b: f64) -> Difference {
        Difference {
            quantity: "TAWSS / Pa",
            region: "artery".into(),
            mean_a,
            mean_b,
            rms: 0.0,
            relative_rms: (mean_a - mean_b).abs() / mean_a,
            largest: 0.0,
            limit: None,
        }
    }

    #[test]
    fn errors_of_second_order_are_extrapolated_away_and_their_order_is_found() {
        let (exact, ratio) = (2.0, 1.5);
        let a = |h: f64| exact + 0.3 * h * h;
        let found = Refined::of(
            &difference(a(1.5), 2.001),
            &difference(a(1.0), exact),
            ratio,
        );
        assert!((found.extrapolated_a - exact).abs() < 1e-14, "{found:?}");
        assert!((found.observed_order_a - 2.0).abs() < 1e-12, "{found:?}");
        assert!((found.uncertainty_a - 0.9).abs() < 1e-12, "{found:?}");
        assert!((found.uncertainty_b - 0.001).abs() < 1e-12 && found.agree);
        assert_eq!(found.name(), "TAWSS / Pa (artery)");
    }

    #[test]
    fn solvers_that_lead_elsewhere_do_not_agree_and_have_no_order() {
        let found = Refined::of(&difference(2.0, 3.0), &difference(1.99, 3.001), 1.5);
        assert!(!found.agree && found.observed_order_a.is_nan(), "{found:?}");
    }
}
