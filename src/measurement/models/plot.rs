//! The residual's fall over the coupling iterations of one step, as SVG.

use crate::coupling::predictor::Extrapolation;
use crate::coupling::reference::History;
use crate::coupling::reference::combinations::Combination;
use crate::output::figure::{Curve, Figure, Panel, Scale};
use crate::output::write_atomically;
use std::io;
use std::path::Path;

/// Iterations that are shown; constant relaxation goes on for hundreds.
const SHOWN: usize = 30;
/// Residuals that are shown.
const RESIDUALS: std::ops::RangeInclusive<f64> = 1e-8..=10.0;

/// A line for each model with the longest memory and quadratic prediction: full without, dashed with the surrogate.
pub fn residuals(path: &Path, problem: &str, results: &[(Combination, History)]) -> io::Result<()> {
    let steps = results.iter().map(|(_, history)| history.residuals.len());
    let step = steps.min().unwrap_or(1) / 2;
    let is_shown = |(trial, _): &&(Combination, History)| {
        trial.extrapolation == Extrapolation::Quadratic
            && (trial.reuse == 10 || !trial.kind.remembers())
    };
    let curve = |(trial, history): &(Combination, History)| {
        let falls = history.residuals[step].iter().take(SHOWN).enumerate();
        let points = falls.map(|(k, residual)| (k as f64 + 1.0, *residual));
        Curve {
            name: if trial.surrogate {
                String::new()
            } else {
                trial.kind.name().into()
            },
            points: points
                .filter(|(_, residual)| RESIDUALS.contains(residual))
                .collect(),
            colour: trial.kind as usize,
            marker: None,
            open: trial.surrogate,
        }
    };
    let panel = Panel {
        title: format!("{problem}: relative residual in step {}", step + 1),
        x_label: "coupling iteration".into(),
        y_label: "|S∘F(d) − d| / |S∘F(d)|".into(),
        scales: [Scale::Linear, Scale::Logarithmic],
        curves: results.iter().filter(is_shown).map(curve).collect(),
    };
    let figure = Figure {
        panels: vec![panel],
        columns: 1,
    };
    write_atomically(path, figure.to_svg().as_bytes())
}
