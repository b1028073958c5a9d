//! The page of a study.

mod figures;

use super::page::{Page, download, escape, gallery, table};
use super::quantities::MMHG;
use super::surface::Surface;
use super::{findings, maps, name_of, scene};
use crate::case::Extension;
use crate::hemodynamics::RegionName::{Artery, Bypass, MidArtery};
use crate::hemodynamics::summary::RegionSummary;
use crate::output::results::Results;
use crate::output::wall_fields::FaceRow;
use std::io;

/// Runs of different models.
pub struct Study {
    title: String,
    runs: Vec<Results>,
    /// Models that cannot be shown, and why.
    missing: Vec<String>,
}

impl Study {
    /// All extensions, in the paper's order.
    pub const EXTENSIONS: [Extension; 3] = [Extension::Straight, Extension::Helix, Extension::Arc];

    /// A study of these runs; `missing` says of other models why they are not among them.
    pub fn new(title: &str, mut runs: Vec<Results>, missing: Vec<String>) -> Self {
        let rank = |run: &Results| {
            Self::EXTENSIONS
                .iter()
                .position(|e| *e == run.case.model.extension)
        };
        runs.sort_by(|a, b| {
            rank(a)
                .cmp(&rank(b))
                .then(a.case.model.d_max.total_cmp(&b.case.model.d_max))
        });
        Self {
            title: title.into(),
            runs,
            missing,
        }
    }

    /// All runs.
    pub fn runs(&self) -> &[Results] {
        &self.runs
    }

    /// The runs of an extension by `d_max`.
    pub fn of(&self, extension: Extension) -> Vec<&Results> {
        self.runs
            .iter()
            .filter(|run| run.case.model.extension == extension)
            .collect()
    }

    /// The model of an extension with this `d_max` (m).
    pub fn find(&self, extension: Extension, d_max: f64) -> Option<&Results> {
        self.of(extension)
            .into_iter()
            .find(|run| (run.case.model.d_max - d_max).abs() < 1e-9)
    }

    /// The model that the paper shows: H-0.5, or else one that is there.
    pub fn example(&self) -> Option<&Results> {
        self.find(Extension::Helix, 0.5e-3).or_else(|| {
            self.runs
                .iter()
                .max_by(|a, b| a.case.model.d_max.total_cmp(&b.case.model.d_max))
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
pub struct Difference {
    /// Where, m.
    pub x: f64,
    /// Root mean square of the difference around the axis.
    pub absolute: f64,
    /// The same over the root mean square of the first run's field.
    pub relative: f64,
}

/// Difference of a field between two runs along the axis.
pub fn influence(a: &Results, b: &Results, value: fn(&FaceRow) -> f64) -> Vec<Difference> {
    let Some(rings) = crate::hemodynamics::Rings::new(&maps::places(b)) else {
        return Vec::new();
    };
    let values: Vec<f64> = b.faces.iter().map(value).collect();
    let difference = |(x, ring): &(f64, Vec<&FaceRow>)| {
        let there = |f: &FaceRow| rings.value(&values, f.x_m, f.phi_deg);
        let gap: f64 = ring.iter().map(|f| (value(f) - there(f)).powi(2)).sum();
        let size: f64 = ring.iter().map(|f| value(f).powi(2)).sum();
        Difference {
            x: *x,
            absolute: (gap / ring.len() as f64).sqrt(),
            relative: (gap / size).sqrt(),
        }
    };
    rings_of(a).iter().map(difference).collect()
}

/// Writes the page.
pub fn page(study: &Study) -> io::Result<String> {
    let lead = format!(
        "{} model(s) of the joint of a bypass graft and an artery: straight (S), helical (H) and arc-shaped (A) upstream extension, \
         imperfections of up to d_max = 0.75 mm.",
        study.runs.len()
    );
    let mut page = Page::new(&study.title, &lead);
    page.section(
        "findings",
        "What the paper found, what we found",
        &findings::html(study),
    );
    page.section("models", "Models", &models(study));
    if let Some(example) = study.example() {
        let name = name_of(example);
        page.section(
            "flow",
            &format!("Flow and volume of {name}"),
            &gallery(&super::run::flow(example)),
        );
        page.section(
            "periodicity",
            "Periodicity",
            &gallery(&super::run::periodicity(example)),
        );
        if let Some(surface) = Surface::of(example)? {
            let html = format!(
                "<p>Model {name} over the evaluated window. Drag to rotate, roll to zoom.</p>\n{}{}",
                scene::viewer(&surface),
                gallery(&super::run::pictures(example, &surface))
            );
            page.section("view", "The wall in three dimensions", &html);
        }
    }
    let d_max = study.example().map_or(0.0, |run| run.case.model.d_max);
    let beside = Study::EXTENSIONS.map(|extension| study.find(extension, d_max));
    let beside: Vec<&Results> = beside.into_iter().flatten().collect();
    page.section(
        "extensions",
        "Oscillating shear index behind the three extensions",
        &gallery(&figures::pictures(
            &beside,
            "Oscillating",
            "Oscillating shear index",
        )?),
    );
    page.section(
        "influence",
        "Influence of the imperfection",
        &gallery(&figures::influence_of_d_max(study)),
    );
    page.section(
        "largest",
        "Largest wall shear stress",
        &gallery(&figures::largest(study)),
    );
    page.section(
        "stress",
        "Von Mises stress",
        &gallery(&figures::stress(study)?),
    );
    page.section(
        "alike",
        "Radius and oscillating shear index",
        &gallery(&figures::alike(study)),
    );
    page.section(
        "osi",
        "Largest oscillating shear index",
        &gallery(&figures::osi(study)),
    );
    page.section(
        "distance",
        "Influence of the extension along the vessel",
        &gallery(&figures::distance(study)),
    );
    page.section(
        "maps",
        "All models on the unrolled wall",
        &gallery(&figures::all_maps(study)),
    );
    Ok(page.to_html())
}

fn models(study: &Study) -> String {
    let heads = [
        "model",
        "steps",
        "coupling iterations a step",
        "s per step",
        "outlet pressure / mmHg",
        "period to period, outflow / %",
        "period to period, displacement / %",
        "artery volume / ml",
        "artery mean WSS / Pa",
        "mid-artery largest WSS / Pa",
        "bypass largest OSI",
        "artery largest OSI",
        "mid-artery largest von Mises / kPa",
    ];
    let row = |run: &Results| {
        let found = &run.hemodynamics;
        let show = |value: Option<String>| value.unwrap_or_else(|| "–".into());
        let last = |differences: &[crate::hemodynamics::periodicity::Difference]| {
            show(
                differences
                    .last()
                    .map(|d| format!("{:.2}", 100.0 * d.relative)),
            )
        };
        let of =
            |region, value: fn(&RegionSummary) -> String| show(found.region(region).map(value));
        let summary = run.summary.as_ref();
        vec![
            escape(&name_of(run)),
            run.history.len().to_string(),
            show(summary.map(|s| format!("{:.2}", s.mean_coupling_iterations))),
            show(summary.map(|s| format!("{:.2}", s.seconds_per_step))),
            show(found.vessel.as_ref().map(|v| {
                format!(
                    "{:.0} to {:.0}",
                    v.p_out_Pa.min / MMHG,
                    v.p_out_Pa.max / MMHG
                )
            })),
            last(&found.periodicity.outflow),
            last(&found.periodicity.max_displacement),
            of(Artery, |r| format!("{:.4}", 1e6 * r.lumen_volume_m3.mean)),
            of(Artery, |r| format!("{:.4}", r.mean_wall_shear_Pa.mean)),
            of(MidArtery, |r| format!("{:.3}", r.max_wall_shear_Pa.max)),
            of(Bypass, |r| format!("{:.4}", r.OSI.max)),
            of(Artery, |r| format!("{:.4}", r.OSI.max)),
            of(MidArtery, |r| {
                format!("{:.1}", 1e-3 * r.max_von_mises_Pa.max)
            }),
        ]
    };
    let rows: Vec<Vec<String>> = study.runs.iter().map(row).collect();
    let mut html = table(&heads, &rows);
    let lines = std::iter::once(heads.map(str::to_owned).to_vec()).chain(rows);
    let quoted = lines.map(|line| {
        line.iter()
            .map(|cell| format!("\"{cell}\""))
            .collect::<Vec<_>>()
            .join(",")
    });
    html += &format!(
        "<p>{}</p>\n",
        download("models", &quoted.collect::<Vec<_>>().join("\n"))
    );
    for missing in &study.missing {
        html += &format!("<p class=\"lead\">{}</p>\n", escape(missing));
    }
    html
}
