//! Runs of the paper's models, and differences between them along the vessel.

use super::models::{EXTENSIONS, is_model, vessel};
use crate::case::Extension;
use crate::output::report::{self, maps};
use crate::output::results::Results;
use crate::output::wall_fields::FaceRow;

/// Runs of the paper's models.
pub struct PaperStudy {
    pub(super) runs: Vec<Results>,
    /// Models that cannot be shown, and why.
    pub(super) missing: Vec<String>,
}

impl PaperStudy {
    /// Whether a study has no other cases than the paper's models.
    pub fn is_that_of(study: &report::Study) -> bool {
        study.runs.iter().all(is_model)
    }

    /// Its runs in the paper's order.
    pub fn new(study: report::Study) -> Self {
        let report::Study {
            mut runs, missing, ..
        } = study;
        let rank = |run: &Results| {
            EXTENSIONS
                .iter()
                .position(|e| *e == vessel(run).model.extension)
        };
        runs.sort_by(|a, b| {
            rank(a)
                .cmp(&rank(b))
                .then(vessel(a).model.d_max.total_cmp(&vessel(b).model.d_max))
        });
        Self { runs, missing }
    }

    /// All runs.
    pub fn runs(&self) -> &[Results] {
        &self.runs
    }

    /// The runs themselves.
    pub fn into_runs(self) -> Vec<Results> {
        self.runs
    }

    /// The runs of an extension by `d_max`.
    pub fn of(&self, extension: Extension) -> Vec<&Results> {
        self.runs
            .iter()
            .filter(|run| vessel(run).model.extension == extension)
            .collect()
    }

    /// The model of an extension with this `d_max` (m).
    pub fn find(&self, extension: Extension, d_max: f64) -> Option<&Results> {
        self.of(extension)
            .into_iter()
            .find(|run| (vessel(run).model.d_max - d_max).abs() < 1e-9)
    }

    /// The model that the paper shows: H-0.5, or else one that is there.
    pub fn example(&self) -> Option<&Results> {
        self.find(Extension::Helix, 0.5e-3).or_else(|| {
            self.runs
                .iter()
                .max_by(|a, b| vessel(a).model.d_max.total_cmp(&vessel(b).model.d_max))
        })
    }
}

/// Faces of a run by their position along the axis.
fn rings_of(run: &Results) -> Vec<(f64, Vec<&FaceRow>)> {
    let mut faces: Vec<&FaceRow> = run.faces.iter().collect();
    faces.sort_by(|a, b| a.x_m.total_cmp(&b.x_m));
    let mut rings: Vec<(f64, Vec<&FaceRow>)> = Vec::new();
    for face in faces {
        match rings.last_mut() {
            Some((x, ring)) if face.x_m - *x < 1e-7 => ring.push(face),
            _ => rings.push((face.x_m, vec![face])),
        }
    }
    rings
}

/// A field of two runs in a cross-section.
pub struct SectionDifference {
    /// Where, m.
    pub x: f64,
    /// Root mean square of the difference around the axis.
    pub absolute: f64,
    /// The same over the root mean square of the first run's field.
    pub relative: f64,
}

/// Difference of a field between two runs along the axis.
pub fn influence(a: &Results, b: &Results, value: fn(&FaceRow) -> f64) -> Vec<SectionDifference> {
    let Some(rings) = crate::hemodynamics::Rings::new(&maps::places(b)) else {
        return Vec::new();
    };
    let values: Vec<f64> = b.faces.iter().map(value).collect();
    let difference = |(x, ring): &(f64, Vec<&FaceRow>)| {
        let there = |f: &FaceRow| rings.value(&values, f.x_m, f.phi_deg);
        let gap: f64 = ring.iter().map(|f| (value(f) - there(f)).powi(2)).sum();
        let size: f64 = ring.iter().map(|f| value(f).powi(2)).sum();
        SectionDifference {
            x: *x,
            absolute: (gap / ring.len() as f64).sqrt(),
            relative: (gap / size).sqrt(),
        }
    };
    rings_of(a).iter().map(difference).collect()
}
