//! The page of a study.

use super::findings::{self, series};
use super::maps::{self, OSI, RADIUS, TAWSS};
use super::page::{Page, chart, download, escape, figure, gallery, line, panel, table};
use super::quantities::{MMHG, place};
use super::surface::{Field, Surface};
use super::{letter, name_of, scene};
use crate::case::Extension;
use crate::hemodynamics::RegionName::{Artery, Bypass, MidArtery};
use crate::hemodynamics::summary::RegionSummary;
use crate::output::figure::{Curve, Marker};
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

/// Difference of a field between two runs on the same mesh along the axis: root mean square around, relative to that of
/// the first run.
pub fn influence(a: &Results, b: &Results, value: fn(&FaceRow) -> f64) -> Vec<(f64, f64)> {
    let Some(rings) = crate::hemodynamics::Rings::new(&maps::places(b)) else {
        return Vec::new();
    };
    let values: Vec<f64> = b.faces.iter().map(value).collect();
    let share = |(x, ring): &(f64, Vec<&FaceRow>)| {
        let there = |f: &FaceRow| rings.value(&values, f.x_m, f.phi_deg);
        let gap: f64 = ring.iter().map(|f| (value(f) - there(f)).powi(2)).sum();
        let size: f64 = ring.iter().map(|f| value(f).powi(2)).sum();
        (*x, (gap / size).sqrt())
    };
    rings_of(a).iter().map(share).collect()
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
        &gallery(&pictures(
            &beside,
            "Oscillating",
            "Oscillating shear index",
        )?),
    );
    page.section(
        "influence",
        "Influence of the imperfection",
        &gallery(&influence_of_d_max(study)),
    );
    page.section(
        "largest",
        "Largest wall shear stress",
        &gallery(&largest(study)),
    );
    page.section("stress", "Von Mises stress", &gallery(&stress(study)?));
    page.section(
        "alike",
        "Radius and oscillating shear index",
        &gallery(&alike(study)),
    );
    page.section(
        "osi",
        "Largest oscillating shear index",
        &gallery(&osi(study)),
    );
    page.section(
        "distance",
        "Influence of the extension along the vessel",
        &gallery(&distance(study)),
    );
    page.section(
        "maps",
        "All models on the unrolled wall",
        &gallery(&all_maps(study)),
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

/// A curve with points over d_max for each extension.
fn over_d_max(
    study: &Study,
    region: crate::hemodynamics::RegionName,
    value: impl Fn(&RegionSummary) -> f64,
) -> Vec<Curve> {
    let looks = [
        (Marker::Circle, 0),
        (Marker::Square, 1),
        (Marker::Triangle, 2),
    ];
    let curve = |(extension, (marker, colour)): (Extension, (Marker, usize))| Curve {
        name: letter(extension).into(),
        points: series(study, extension, region, &value),
        colour,
        marker: Some(marker),
        open: false,
    };
    let curves = Study::EXTENSIONS.into_iter().zip(looks).map(curve);
    curves.filter(|curve| !curve.points.is_empty()).collect()
}

fn d_max_chart(
    name: &str,
    title: &str,
    y_label: &str,
    caption: &str,
    curves: Vec<Curve>,
) -> String {
    chart(name, caption, panel(title, "d_{max} / mm", y_label, curves))
}

fn influence_of_d_max(study: &Study) -> Vec<String> {
    vec![
        d_max_chart(
            "artery-volume",
            "lumen volume, artery",
            "volume / ml",
            "Mean over the window of the lumen volume of the artery.",
            over_d_max(study, Artery, |r| 1e6 * r.lumen_volume_m3.mean),
        ),
        d_max_chart(
            "artery-displacement",
            "largest displacement, artery",
            "displacement / mm",
            "Largest displacement of the wet surface in the window.",
            over_d_max(study, Artery, |r| 1e3 * r.max_displacement_m.max),
        ),
        d_max_chart(
            "artery-mean-wall-shear",
            "mean wall shear stress, artery",
            "stress / Pa",
            "Mean of the wall shear stress over area and window.",
            over_d_max(study, Artery, |r| r.mean_wall_shear_Pa.mean),
        ),
    ]
}

fn largest(study: &Study) -> Vec<String> {
    let at = |r: &RegionSummary| r.max_wall_shear_Pa.at;
    let mut figures = vec![
        d_max_chart(
            "mid-artery-largest-wall-shear",
            "largest wall shear stress, mid-artery",
            "stress / Pa",
            "Largest value in time and space, middle of the artery.",
            over_d_max(study, MidArtery, |r| r.max_wall_shear_Pa.max),
        ),
        d_max_chart(
            "mid-artery-largest-wall-shear-x",
            "where along the artery",
            "x / mm",
            "Position of the largest wall shear stress.",
            over_d_max(study, MidArtery, |r| 1e3 * at(r).x_m),
        ),
        d_max_chart(
            "mid-artery-largest-wall-shear-phi",
            "where around the artery",
            "φ / °",
            "Position of the largest wall shear stress.",
            over_d_max(study, MidArtery, |r| at(r).phi_deg),
        ),
    ];
    let row = |run: &Results| {
        let peak = run.hemodynamics.region(MidArtery)?.max_wall_shear_Pa;
        let cells = [
            format!("{:.3}", peak.max),
            format!("{:.3}", peak.time_s),
            place(peak.at),
        ];
        Some(std::iter::once(name_of(run)).chain(cells).collect())
    };
    let rows: Vec<Vec<String>> = study.runs.iter().filter_map(row).collect();
    figures.push(table(&["model", "largest / Pa", "t / s", "place"], &rows));
    figures
}

fn stress(study: &Study) -> io::Result<Vec<String>> {
    let mut figures = Vec::new();
    for extension in Study::EXTENSIONS {
        let curve = |(i, run): (usize, &&Results)| {
            let rows = run.regions.iter().filter(|row| row.region == MidArtery);
            let points = rows
                .map(|row| (row.time_s, 1e-3 * row.max_von_mises_Pa))
                .collect();
            line(&name_of(run), [0, 2, 3, 1][i % 4], points)
        };
        let curves: Vec<Curve> = study.of(extension).iter().enumerate().map(curve).collect();
        if curves.is_empty() {
            continue;
        }
        let letter = letter(extension);
        figures.push(chart(
            &format!("von-mises-{letter}"),
            "Largest von Mises stress over time, middle of the artery.",
            panel(
                &format!("largest von Mises stress, {letter}"),
                "time / s",
                "stress / kPa",
                curves,
            ),
        ));
    }
    figures.push(d_max_chart(
        "von-mises",
        "largest von Mises stress in the window",
        "stress / kPa",
        "Middle of the artery.",
        over_d_max(study, MidArtery, |r| 1e-3 * r.max_von_mises_Pa.max),
    ));
    for extension in Study::EXTENSIONS {
        if let [first, .., last] = study.of(extension).as_slice() {
            let caption = "Von Mises stress at the inner side of the wall";
            figures.extend(pictures(&[first, last], "Von Mises", caption)?);
            break;
        }
    }
    Ok(figures)
}

/// Rendered pictures of some models with the same colours, where their field is largest.
fn pictures(runs: &[&Results], field: &str, caption: &str) -> io::Result<Vec<String>> {
    let mut found = Vec::new();
    for run in runs {
        if let Some(surface) = Surface::of(run)?
            && let Some(field) = surface.field(field).cloned()
        {
            found.push((name_of(run), surface, field));
        }
    }
    let high = found
        .iter()
        .map(|(.., field)| field.high)
        .fold(0.0, f64::max);
    let picture = |(name, surface, field): (String, Surface, Field)| {
        let frame = field.largest_frame();
        let time = surface.times[frame];
        let field = Field { high, ..field };
        let caption = format!("{name}, t = {time:.3} s: {caption}.");
        scene::picture(&surface, &field, frame, &caption)
    };
    Ok(found.into_iter().map(picture).collect())
}

fn alike(study: &Study) -> Vec<String> {
    let Some(run) = study.example().filter(|run| !run.faces.is_empty()) else {
        return Vec::new();
    };
    let (name, x) = (name_of(run), maps::middle(run));
    [RADIUS, OSI, TAWSS]
        .into_iter()
        .map(|field| {
            let svg = maps::map(run, field, &name, x, maps::range(&[run], field, x, false));
            let caption = format!(
                "{} in the middle of the artery; the cross marks the largest value.",
                field.label
            );
            figure(
                &svg,
                &caption,
                Some((&format!("{name}-{}", field.file), maps::numbers(run, field))),
            )
        })
        .collect()
}

fn osi(study: &Study) -> Vec<String> {
    let caption = "Largest oscillating shear index on a face.";
    [
        ("bypass", Bypass),
        ("artery", Artery),
        ("mid-artery", MidArtery),
    ]
    .into_iter()
    .map(|(name, region)| {
        d_max_chart(
            &format!("{name}-largest-OSI"),
            &format!("largest OSI, {name}"),
            "OSI / 1",
            caption,
            over_d_max(study, region, |r| r.OSI.max),
        )
    })
    .collect()
}

fn distance(study: &Study) -> Vec<String> {
    let Some(example) = study.example() else {
        return Vec::new();
    };
    let d_max = example.case.model.d_max;
    let Some(straight) = study
        .find(Extension::Straight, d_max)
        .filter(|run| !run.faces.is_empty())
    else {
        return vec![
            "<p>The model with the straight extension has not been computed.</p>\n".into(),
        ];
    };
    let fields: [(&str, fn(&FaceRow) -> f64); 2] = [("TAWSS", |f| f.TAWSS_Pa), ("OSI", |f| f.OSI)];
    let mut figures = Vec::new();
    for (name, value) in fields {
        let curves = [(Extension::Helix, 1), (Extension::Arc, 2)]
            .into_iter()
            .filter_map(|(extension, colour)| {
                let run = study.find(extension, d_max)?;
                let points = influence(straight, run, value)
                    .into_iter()
                    .map(|(x, share)| (1e3 * x, 100.0 * share));
                Some(line(
                    &format!(
                        "{} against {}",
                        letter(extension),
                        letter(Extension::Straight)
                    ),
                    colour,
                    points.collect(),
                ))
            });
        figures.push(chart(&format!("extension-{name}"), "Root mean square around the axis of the difference, relative to the model with the straight extension.",
            panel(&format!("{name}, d_{{max}} = {} mm", 1e3 * d_max), "x / mm", "difference / %", curves.collect())));
    }
    figures
}

fn all_maps(study: &Study) -> Vec<String> {
    let runs: Vec<&Results> = study
        .runs
        .iter()
        .filter(|run| !run.faces.is_empty())
        .collect();
    let Some(first) = runs.first() else {
        return Vec::new();
    };
    let whole = maps::whole(first);
    let mut figures = Vec::new();
    for (field, from_zero) in [(TAWSS, true), (OSI, true)] {
        let range = maps::range(&runs, field, whole, from_zero);
        for run in &runs {
            let svg = maps::map(run, field, &name_of(run), whole, range);
            figures.push(figure(
                &svg,
                &format!("{}, same colours for all models.", field.label),
                None,
            ));
        }
    }
    figures
}
