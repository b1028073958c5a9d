//! The paper's twelve models: three extensions, four imperfections.

use crate::case::{Anastomosis, Extension, Material};
use crate::output::results::Results;

/// All extensions, in the paper's order.
pub const EXTENSIONS: [Extension; 3] = [Extension::Straight, Extension::Helix, Extension::Arc];
/// Largest radius deviations of the imperfection, m.
pub const D_MAX: [f64; 4] = [0.0, 0.25e-3, 0.5e-3, 0.75e-3];
/// Length of the graft and of the artery, m.
const SECTION: f64 = 0.03;

/// The paper's letter for an extension.
pub fn letter(extension: Extension) -> &'static str {
    match extension {
        Extension::Straight => "S",
        Extension::Helix => "H",
        Extension::Arc => "A",
    }
}

/// A model's name as the paper has it, such as `H-0.5`.
pub fn name(extension: Extension, d_max: f64) -> String {
    let millimetres = (1e6 * d_max).round() / 1e3;
    format!("{}-{millimetres:?}", letter(extension))
}

/// The vessel of a run of a study.
///
/// # Panics
/// If it is not one of the models: a study holds no others.
pub fn vessel(run: &Results) -> &Anastomosis {
    (run.case.anastomosis()).expect("a study holds runs of the models only")
}

/// Whether a run is one of the models: called as the paper calls it, with that extension and imperfection, a graft and
/// an artery as long as the paper's and made of its materials. What the paper leaves open (radii, flow, windkessel) may
/// differ.
pub fn is_model(run: &Results) -> bool {
    let Some(Anastomosis {
        model,
        geometry,
        wall,
    }) = run.case.anastomosis()
    else {
        return false;
    };
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    let is_artery = |layer: &Material| matches!(layer, Material::HolzapfelGasserOgden { .. });
    run.name() == name(model.extension, model.d_max)
        && D_MAX.iter().any(|d_max| near(*d_max, model.d_max))
        && near(geometry.graft_length, SECTION)
        && near(geometry.artery_length, SECTION)
        && matches!(wall.graft, Material::NeoHooke { .. })
        && is_artery(&wall.media)
        && is_artery(&wall.adventitia)
}
