//! The residual's fall over the coupling iterations of one step, as SVG.

use crate::coupling::predictor::Extrapolation;
use crate::coupling::reference::History;
use crate::coupling::reference::study::Trial;
use plotters::prelude::*;
use std::path::Path;

/// Iterations that are shown; constant relaxation goes on for hundreds.
const SHOWN: usize = 30;

/// A line for each model with the longest memory and quadratic prediction: full without, dashed with the surrogate.
pub fn residuals(
    path: &Path,
    problem: &str,
    results: &[(Trial, History)],
) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let root = SVGBackend::new(path, (900, 560)).into_drawing_area();
    root.fill(&WHITE)?;
    let step = results
        .iter()
        .map(|(_, history)| history.residuals.len())
        .min()
        .unwrap_or(1)
        / 2;
    let caption = format!("{problem}: relative residual in step {}", step + 1);
    let mut chart = ChartBuilder::on(&root)
        .caption(caption, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(70)
        .build_cartesian_2d(1.0..SHOWN as f64, (1e-8..10.0).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("coupling iteration")
        .y_desc("|S∘F(d) - d| / |S∘F(d)|")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_label_formatter(&|y| format!("{y:.0e}"))
        .light_line_style(TRANSPARENT)
        .draw()?;
    let shown = results.iter().filter(|(trial, _)| {
        trial.extrapolation == Extrapolation::Quadratic
            && (trial.reuse == 10 || !trial.kind.remembers())
    });
    for (trial, history) in shown {
        let colour = Palette99::pick(trial.kind as usize).to_rgba();
        let falls = history.residuals[step].iter().take(SHOWN).enumerate();
        let points: Vec<(f64, f64)> = falls.map(|(k, r)| (k as f64 + 1.0, *r)).collect();
        let name = trial.kind.name();
        if trial.surrogate {
            let dashed = DashedLineSeries::new(points, 6, 4, colour.stroke_width(2));
            chart.draw_series(dashed)?;
        } else {
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(name)
                .legend(move |(x, y)| {
                    PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2))
                });
        }
    }
    chart
        .configure_series_labels()
        .background_style(WHITE.mix(0.9))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 14))
        .draw()?;
    root.present()?;
    Ok(())
}
