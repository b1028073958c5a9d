//! The page of the paper's study.

mod figures;

use super::findings;
use super::models::{EXTENSIONS, vessel};
use super::runs::PaperStudy;
use crate::output::report::page::{Page, gallery};
use crate::output::report::surface::DrawnSurface;
use crate::output::report::{self, run, scene};
use crate::output::results::Results;
use std::io;

/// Writes the page.
pub fn page(study: &PaperStudy) -> io::Result<String> {
    let lead = format!(
        "{} model(s) of the joint of a bypass graft and an artery: straight (S), helical (H) and arc-shaped (A) upstream extension, \
         imperfections of up to d_max = 0.75 mm.",
        study.runs.len()
    );
    let mut page = Page::new("The influence of geometric imperfections: a study", &lead);
    let found = findings::html(study);
    page.section("findings", "What the paper found, what we found", &found);
    let runs: Vec<&Results> = study.runs.iter().collect();
    let models = report::study::cases(&runs, &study.missing);
    page.section("models", "Models", &models);
    if let Some(example) = study.example() {
        let name = example.name();
        let title = format!("Flow and volume of {name}");
        page.section("flow", &title, &gallery(&run::flow(example)));
        let periods = gallery(&run::periodicity(example));
        page.section("periodicity", "Periodicity", &periods);
        if let Some(surface) = DrawnSurface::of(example)? {
            let html = format!(
                "<p>Model {name} over the evaluated window. Drag to rotate, scroll to zoom.</p>\n{}{}",
                scene::viewer(&surface, surface.widest_frame()),
                gallery(&run::pictures(&surface))
            );
            page.section("view", "The wall in three dimensions", &html);
        }
    }
    let d_max = study.example().map_or(0.0, |run| vessel(run).model.d_max);
    let extensions = EXTENSIONS.map(|extension| study.find(extension, d_max));
    let extensions: Vec<&Results> = extensions.into_iter().flatten().collect();
    page.section(
        "extensions",
        "Oscillating shear index downstream of the three extensions",
        &gallery(&report::study::pictures(
            &extensions,
            "Oscillating",
            "Oscillating shear index",
        )?),
    );
    #[rustfmt::skip]
    let figures = [
        ("influence", "Influence of the imperfection", figures::influence_of_d_max(study)),
        ("largest", "Largest wall shear stress", figures::largest(study)),
        ("stress", "Von Mises stress", figures::stress(study)?),
        ("alike", "Radius and oscillating shear index", figures::alike(study)),
        ("osi", "Largest oscillating shear index", figures::osi(study)),
        ("distance", "Influence of the extension along the vessel", figures::distance(study)),
        ("maps", "All models on the unrolled wall", report::study::all_maps(&runs)),
    ];
    for (anchor, title, figures) in figures {
        page.section(anchor, title, &gallery(&figures));
    }
    Ok(page.to_html())
}
