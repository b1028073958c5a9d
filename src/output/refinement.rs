//! Two meshes of each of two solvers: what refinement changes, and where it leads.
//!
//! Of the first solver, whose error falls like a power of the cells' size, the value at cells of no size is
//! extrapolated (Richardson), with the grid convergence index of two meshes as its uncertainty (Roache 1994: factor of
//! safety 3). Of the second, whose error falls faster than any power with the degree, the finer value counts, and what
//! the last degree changed is its uncertainty.

use super::comparison::{Comparison, RunDifference};
use super::write_atomically;
use serde::Serialize;
use std::path::Path;

/// Order that is taken for the first solver: that of its schemes in space.
const ORDER: f64 = 2.0;
/// Factor of safety for two meshes.
const SAFETY: f64 = 3.0;

/// Factor of safety for the observed order of three meshes.
const SAFETY_OF_THREE: f64 = 1.25;

/// Slowest decay of changes that is continued: with the step halved that is order one half, below which an observed
/// order says nothing (Eça and Hoekstra 2014).
const SLOWEST_DECAY: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Fastest decay that is believed: that of second order with the step halved. A change that is smaller still may be
/// small by chance.
const FASTEST_DECAY: f64 = 0.25;

/// Where a value goes as the mesh becomes finer, and how well that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// The value there.
    pub value: f64,
    /// Its uncertainty.
    pub uncertainty: f64,
}

impl Limit {
    /// From two meshes of a method of second order, whose cells are `ratio` times as long on the coarser one.
    pub fn of_meshes(coarse: f64, fine: f64, ratio: f64) -> Self {
        let change = (fine - coarse) / (ratio.powf(ORDER) - 1.0);
        Self {
            value: fine + change,
            uncertainty: SAFETY * change.abs(),
        }
    }

    /// From two meshes whose errors fall faster than any power: the finer one, and what it has changed.
    pub fn of_degrees(coarse: f64, fine: f64) -> Self {
        Self {
            value: fine,
            uncertainty: (fine - coarse).abs(),
        }
    }

    /// From a series that was refined by the same factor each time, from coarse to fine. If its last two changes have
    /// the same sign and decrease fast enough, they go on as a geometric series (Richardson's extrapolation with the
    /// observed order), of which no less is unknown than if they had decreased by [`FASTEST_DECAY`]; otherwise the last
    /// value counts, and the range of the last three is what is not known.
    ///
    /// # Panics
    /// If there are fewer than two values.
    pub fn of_series(values: &[f64]) -> Self {
        let [.., middle, fine] = values else {
            panic!("a series has at least two values");
        };
        let [.., coarse, _, _] = values else {
            return Self::of_degrees(*middle, *fine);
        };
        let (before, last) = (middle - coarse, fine - middle);
        let decay = last / before;
        if decay > 0.0 && decay <= SLOWEST_DECAY {
            let rest = last * decay / (1.0 - decay);
            let least = before * FASTEST_DECAY.powi(2) / (1.0 - FASTEST_DECAY);
            return Self {
                value: fine + rest,
                uncertainty: SAFETY_OF_THREE * rest.abs().max(least.abs()),
            };
        }
        let all = [coarse, middle, fine];
        let largest = all.into_iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let smallest = all.into_iter().copied().fold(f64::INFINITY, f64::min);
        Self {
            value: *fine,
            uncertainty: largest - smallest,
        }
    }

    /// The same after something else was refined once, which has `changed` the value: by so much it moves, and so much
    /// is not known of it.
    pub fn with(self, changed: f64) -> Self {
        Self {
            value: self.value + changed,
            uncertainty: self.uncertainty.hypot(changed),
        }
    }

    /// Whether two limits differ by no more than is not known of them.
    pub fn agrees_with(&self, other: &Self) -> bool {
        (self.value - other.value).abs() <= self.uncertainty + other.uncertainty
    }
}

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
    /// From the comparisons on the coarser and on the finer meshes; the first solver's cells are `ratio` times as long
    /// on the coarser one.
    fn of(coarse: &RunDifference, fine: &RunDifference, ratio: f64) -> Self {
        let [coarse_a, fine_a] = [coarse.mean_a, fine.mean_a];
        let [coarse_b, fine_b] = [coarse.mean_b, fine.mean_b];
        let a = Limit::of_meshes(coarse_a, fine_a, ratio);
        let b = Limit::of_degrees(coarse_b, fine_b);
        let distance = |value: f64| (value - fine_b).abs();
        let order = (distance(coarse_a) / distance(fine_a)).ln() / ratio.ln();
        Self {
            quantity: fine.quantity,
            region: fine.region.clone(),
            coarse_a,
            fine_a,
            extrapolated_a: a.value,
            uncertainty_a: a.uncertainty,
            observed_order_a: if order > 0.0 { order } else { f64::NAN },
            coarse_b,
            fine_b,
            uncertainty_b: b.uncertainty,
            relative_rms_coarse: coarse.relative_rms,
            relative_rms_fine: fine.relative_rms,
            agree: a.agrees_with(&b),
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

/// Writes a table with one row per quantity.
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

    fn difference(mean_a: f64, mean_b: f64) -> RunDifference {
        RunDifference {
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

    /// What else was refined moves a limit and is not known better than that.
    #[test]
    fn other_refinement_adds_uncertainty() {
        let limit = Limit {
            value: 2.0,
            uncertainty: 0.3,
        };
        let moved = limit.with(-0.4);
        assert!((moved.value - 1.6).abs() < 1e-15 && (moved.uncertainty - 0.5).abs() < 1e-15);
        assert_eq!(limit.with(0.0), limit);
    }

    /// Errors of second order are extrapolated away and their order is found.
    #[test]
    fn second_order_errors_are_extrapolated_away() {
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
    fn a_series_leads_to_its_limit_if_it_has_one() {
        let of = |values: &[f64]| {
            let limit = Limit::of_series(values);
            (limit.value, limit.uncertainty)
        };
        // 2 + 0.8 h with h halved: first order.
        let (value, uncertainty) = of(&[2.8, 2.4, 2.2]);
        assert!((value - 2.0).abs() < 1e-14 && (uncertainty - 0.25).abs() < 1e-14);
        // The last change is small by chance: no less is unknown than with 2 + 16/15 h², which changes by 0.8 and 0.2.
        let (value, uncertainty) = of(&[2.8, 2.0, 1.992]);
        assert!((value - 1.99192).abs() < 1e-5 && (uncertainty - 1.25 / 15.0).abs() < 1e-14);
        assert_eq!(of(&[9.0, 1.0, 2.0, 1.5]), (1.5, 1.0));
        assert_eq!(of(&[1.0, 2.0, 4.0]), (4.0, 3.0));
        assert_eq!(of(&[0.0, 1.0, 1.75]), (1.75, 1.75));
        assert_eq!(of(&[1.0, 1.5]), (1.5, 0.5));
        assert_eq!(of(&[1.0, 1.0, 1.0]), (1.0, 0.0));
    }

    #[test]
    fn solvers_that_lead_elsewhere_do_not_agree_and_have_no_order() {
        let found = Refined::of(&difference(2.0, 3.0), &difference(1.99, 3.001), 1.5);
        assert!(!found.agree && found.observed_order_a.is_nan(), "{found:?}");
    }
}
