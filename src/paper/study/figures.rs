//! The figures of a study.

use crate::analysis::{ARTERY, BYPASS, MID_ARTERY};
use crate::case::Extension;
use crate::hemodynamics::summary::RegionSummary;
use crate::output::figure::{Curve, Marker};
use crate::output::report::maps::{self, OSI, RADIUS, TAWSS};
use crate::output::report::page::{
    chart, escape, figure, file_name, line, panel, significant, table,
};
use crate::output::report::study::pictures;
use crate::output::results::Results;
use crate::paper::findings::series;
use crate::paper::models::{EXTENSIONS, letter, vessel};
use crate::paper::runs::{PaperStudy, SectionDifference, influence};
use std::io;

/// A curve with points over d_max for each extension.
fn over_d_max(
    study: &PaperStudy,
    region: &str,
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
    let curves = EXTENSIONS.into_iter().zip(looks).map(curve);
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

/// Figure 14 of the paper.
pub fn influence_of_d_max(study: &PaperStudy) -> Vec<String> {
    vec![
        d_max_chart(
            "artery-volume",
            "lumen volume, artery",
            "volume / ml",
            "Mean over the window of the lumen volume of the artery.",
            over_d_max(study, ARTERY, |r| 1e6 * r.mean_volume()),
        ),
        d_max_chart(
            "artery-displacement",
            "largest displacement, artery",
            "displacement / mm",
            "Largest displacement of the wet surface in the window.",
            over_d_max(study, ARTERY, |r| 1e3 * r.max_displacement_m.max),
        ),
        d_max_chart(
            "artery-mean-wall-shear",
            "mean wall shear stress, artery",
            "stress / Pa",
            "Mean of the wall shear stress over area and window.",
            over_d_max(study, ARTERY, |r| r.mean_wall_shear_Pa.mean),
        ),
    ]
}

/// Figure 15.
pub fn largest(study: &PaperStudy) -> Vec<String> {
    let at = |r: &RegionSummary| r.max_wall_shear_Pa.at;
    let mut figures = vec![
        d_max_chart(
            "mid-artery-largest-wall-shear",
            "largest wall shear stress, mid-artery",
            "stress / Pa",
            "Largest value in time and space, middle of the artery.",
            over_d_max(study, MID_ARTERY, |r| r.max_wall_shear_Pa.max),
        ),
        d_max_chart(
            "mid-artery-largest-wall-shear-x",
            "where along the artery",
            "x / mm",
            "Position of the largest wall shear stress.",
            over_d_max(study, MID_ARTERY, |r| 1e3 * at(r).x_m),
        ),
        d_max_chart(
            "mid-artery-largest-wall-shear-phi",
            "where around the artery",
            "φ / °",
            "Position of the largest wall shear stress.",
            over_d_max(study, MID_ARTERY, |r| at(r).phi_deg),
        ),
    ];
    let row = |run: &Results| {
        let peak = run.hemodynamics.region(MID_ARTERY)?.max_wall_shear_Pa;
        let cells = [
            significant(peak.max, 4),
            format!("{:.3}", peak.time_s),
            run.hemodynamics.region(MID_ARTERY)?.told(peak.at),
        ];
        Some(std::iter::once(escape(&run.name())).chain(cells).collect())
    };
    let rows: Vec<Vec<String>> = study.runs.iter().filter_map(row).collect();
    figures.push(table(&["model", "largest / Pa", "t / s", "place"], &rows));
    figures
}

/// Figure 16.
pub fn stress(study: &PaperStudy) -> io::Result<Vec<String>> {
    let mut figures = Vec::new();
    for extension in EXTENSIONS {
        let curve = |(i, run): (usize, &&Results)| {
            let rows = run
                .regions
                .iter()
                .filter(|row| row.region.as_str() == MID_ARTERY);
            let points = rows
                .map(|row| (row.time_s, 1e-3 * row.max_von_mises_Pa))
                .collect();
            line(&run.name(), [0, 2, 3, 1][i % 4], points)
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
        over_d_max(study, MID_ARTERY, |r| 1e-3 * r.max_von_mises_Pa.max),
    ));
    for extension in [Extension::Helix, Extension::Straight, Extension::Arc] {
        if let [first, .., last] = study.of(extension).as_slice() {
            let caption = "Von Mises stress at the inner side of the wall";
            figures.extend(pictures(&[first, last], "Von Mises", caption)?);
            break;
        }
    }
    Ok(figures)
}

/// Figure 17.
pub fn alike(study: &PaperStudy) -> Vec<String> {
    let Some(run) = study.example().filter(|run| !run.faces.is_empty()) else {
        return Vec::new();
    };
    let (name, x) = (run.name(), maps::middle(run));
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
                Some((
                    &format!("{}-{}", file_name(&name), field.file),
                    maps::numbers(run, field),
                )),
            )
        })
        .collect()
}

/// Figure 18.
pub fn osi(study: &PaperStudy) -> Vec<String> {
    let caption = "Largest oscillating shear index on a face.";
    [
        ("bypass", BYPASS),
        ("artery", ARTERY),
        ("mid-artery", MID_ARTERY),
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

/// How far along the vessel the extension is felt.
pub fn distance(study: &PaperStudy) -> Vec<String> {
    let Some(example) = study.example() else {
        return Vec::new();
    };
    let d_max = vessel(example).model.d_max;
    let Some(straight) = study
        .find(Extension::Straight, d_max)
        .filter(|run| !run.faces.is_empty())
    else {
        return vec![
            "<p>The model with the straight extension has not been computed.</p>\n".into(),
        ];
    };
    let mut figures = Vec::new();
    // Behind the straight extension there is hardly an OSI to which differences could be related.
    type Shown = fn(&SectionDifference) -> f64;
    let shown: [(_, &str, &str, Shown); 2] = [
        (
            TAWSS,
            "difference / %",
            ", relative to the model with the straight extension",
            |d| 100.0 * d.relative,
        ),
        (OSI, "difference / 1", "", |d| d.absolute),
    ];
    for (field, label, relative, show) in shown {
        let (name, value) = (field.file, field.value);
        let curves = [(Extension::Helix, 1), (Extension::Arc, 2)]
            .into_iter()
            .filter_map(|(extension, colour)| {
                let run = study.find(extension, d_max)?;
                let differences = influence(straight, run, value);
                let points = differences.iter().map(|d| (1e3 * d.x, show(d)));
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
        let caption = format!("Root mean square around the axis of the difference to S{relative}.");
        let title = format!("{name}, d_{{max}} = {} mm", 1e3 * d_max);
        figures.push(chart(
            &format!("extension-{name}"),
            &caption,
            panel(&title, "x / mm", label, curves.collect()),
        ));
    }
    figures
}
