//! A vessel before anything is computed: lumen, wall, sections, layers, fibres and meshes.

mod cross_section;
mod cut_open;

use super::page::{Page, chart, escape, figure, gallery, line, panel, significant, table};
use super::scene;
use super::surface::{Field, Surface};
use crate::Vec3;
use crate::case::{ResolvedCase, Solver};
use crate::geometry::{Surfaces, Vessel};
use crate::hemodynamics::WetSurface;
use crate::output::figure::png_image;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::f64::consts::TAU;

/// Places along the vessel and around it where surfaces are drawn.
const ALONG: usize = 240;
const AROUND: usize = 48;
/// Pixels of the picture.
const PIXELS: [usize; 2] = [1800, 900];
/// Cross-sections that are drawn.
const CROSS_SECTIONS: usize = 4;

/// Colours of materials: light, and apart for the colour-blind (after Okabe and Ito).
const COLOURS: [[u8; 3]; 8] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [204, 121, 167],
    [213, 94, 0],
    [0, 114, 178],
    [160, 160, 160],
];

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// A page that needs no network.
    pub html: String,
    /// The vessel, its wall cut open.
    pub png: Vec<u8>,
    /// Cross-sections with both meshes.
    pub svg: String,
}

/// A vessel and its case.
struct Shown<'a> {
    case: &'a ResolvedCase,
    vessel: Vessel,
    /// Surfaces of the wall, the lumen's included.
    surfaces: usize,
    /// Arc lengths of all of the vessel, and of its elastic part, m.
    ends: [f64; 2],
    elastic: [f64; 2],
}

impl Shown<'_> {
    fn point(&self, surface: usize, s: f64, phi: f64) -> Vec3 {
        let r = self.vessel.radius(surface, s, phi);
        self.vessel.point(s, r * phi.cos(), r * phi.sin())
    }

    /// Mean, smallest and largest distance (m) of a surface from the centre-line.
    fn radii(&self, surface: usize, s: f64) -> [f64; 3] {
        let all = (0..AROUND).map(|j| {
            self.vessel
                .radius(surface, s, TAU * j as f64 / AROUND as f64)
        });
        let start = [0.0, f64::INFINITY, 0.0f64];
        let [sum, low, high] = all.fold(start, |[sum, low, high], r| {
            [sum + r, low.min(r), high.max(r)]
        });
        [sum / AROUND as f64, low, high]
    }
}

fn colour(material: usize) -> [u8; 3] {
    COLOURS[material % COLOURS.len()]
}

fn html_colour([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

impl Preview {
    /// Draws the vessel of a case, which is called `name`; `None` if it has none.
    pub fn of(case: &ResolvedCase, name: &str) -> Option<Self> {
        let keys = case.vessel()?;
        let vessel = Vessel::new(keys);
        let sections = vessel.sections();
        let ends = [sections.first()?.from, sections.last()?.to];
        let shown = Shown {
            case,
            surfaces: vessel.layers() + 1,
            ends,
            elastic: [0.0, vessel.end()],
            vessel,
        };
        let pixels = cut_open::picture(&shown, PIXELS);
        let png = png_image(PIXELS, &pixels);
        let at = |i: usize| shown.elastic[1] * (i as f64 + 0.5) / CROSS_SECTIONS as f64;
        let drawn: Vec<String> = (0..CROSS_SECTIONS)
            .map(|i| cross_section::draw(&shown, at(i)))
            .collect();
        let html = page(&shown, name, &png, &drawn);
        let svg = cross_section::beside(&drawn);
        Some(Self { html, png, svg })
    }
}

fn page(shown: &Shown<'_>, name: &str, png: &[u8], sections: &[String]) -> String {
    let case = shown.case;
    let blood = match case.fluid.solver {
        Solver::Native => format!("{} elements", case.fluid_cells()),
        _ => format!("{} cells", case.fluid_cells()),
    };
    let lead = format!(
        "Before anything is computed. Blood in {blood}; wall of {} elements of degree {}, {} degrees of freedom; {} steps of {} s; \
         about {:.2} GB of memory.",
        case.vessel()
            .map_or(0, |keys| shown.vessel.wall_elements(&keys.structure)),
        case.structure.p,
        case.structure_degrees_of_freedom(),
        case.steps(),
        case.time.step,
        case.memory() / 1e9
    );
    let mut page = Page::new(&format!("The vessel {name}"), &lead);
    let picture = format!(
        "<figure class=\"whole\">\n<img alt=\"the vessel, its wall cut open\" src=\"data:image/png;base64,{}\">\n<figcaption>{}</figcaption>\n\
         </figure>\n{}",
        STANDARD.encode(png),
        escape(
            "The wall is cut open towards the reader: lumen (rose) with the blood's mesh, layers by material, elements of the wall \
             on its outside. Fibres of the innermost layer are drawn on the lumen, those of the outermost one on the outside. Rigid \
             parts are grey."
        ),
        legend(shown)
    );
    page.section("picture", "The wall cut open", &picture);
    let html = format!(
        "<p>The lumen. Drag to rotate, roll to zoom.</p>\n{}",
        scene::viewer(&lumen(shown), 0)
    );
    page.section("view", "In three dimensions", &html);
    page.section("along", "Along the centre-line", &gallery(&along(shown)));
    let captions = sections.iter().map(|svg| figure(svg, "", None));
    page.section(
        "sections",
        "Cross-sections with both meshes",
        &gallery(&captions.collect::<Vec<_>>()),
    );
    page.section("parts", "Sections and layers", &parts(shown));
    page.to_html()
}

fn legend(shown: &Shown<'_>) -> String {
    let names = shown.vessel.material_names();
    let entry = |(i, name): (usize, &String)| {
        format!(
            "<span style=\"display:inline-block;width:1em;height:1em;vertical-align:-0.15em;background:{}\"></span> {} &nbsp; ",
            html_colour(colour(i)),
            escape(name)
        )
    };
    format!(
        "<p>{}</p>\n",
        names.iter().enumerate().map(entry).collect::<String>()
    )
}

/// The lumen with fields on it.
fn lumen(shown: &Shown<'_>) -> Surface {
    let [from, to] = shown.ends;
    let at = |i: usize| from + (to - from) * i as f64 / ALONG as f64;
    let phi = |j: usize| TAU * j as f64 / AROUND as f64;
    let mut points = Vec::new();
    let (mut radius, mut thickness, mut curvature) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..=ALONG {
        let s = at(i);
        let is_elastic = s >= shown.elastic[0] && s <= shown.elastic[1];
        let bend = shown.vessel.centre_line().curvature(s).norm();
        for j in 0..AROUND {
            points.push(shown.point(0, s, phi(j)));
            let inner = shown.vessel.radius(0, s, phi(j));
            radius.push(1e3 * inner);
            let outer = shown.vessel.radius(shown.surfaces - 1, s, phi(j));
            thickness.push(if is_elastic {
                1e3 * (outer - inner)
            } else {
                0.0
            });
            curvature.push(bend * outer);
        }
    }
    let faces = (0..ALONG).flat_map(|i| {
        (0..AROUND).map(move |j| {
            let next = (j + 1) % AROUND;
            [
                i * AROUND + j,
                i * AROUND + next,
                (i + 1) * AROUND + next,
                (i + 1) * AROUND + j,
            ]
            .map(|p| p as u32)
            .to_vec()
        })
    });
    Surface {
        wall: WetSurface::new(points.clone(), faces.collect()),
        times: vec![0.0],
        frames: vec![points],
        fields: vec![
            Field::new("Distance from the centre-line", "mm", vec![radius]),
            Field::new("Thickness of the wall", "mm", vec![thickness]),
            Field::new("Radius of the outside times curvature", "", vec![curvature]),
        ],
    }
}

fn along(shown: &Shown<'_>) -> Vec<String> {
    let [from, to] = shown.ends;
    let places: Vec<f64> = (0..=ALONG)
        .map(|i| from + (to - from) * i as f64 / ALONG as f64)
        .collect();
    let of = |surface: usize, which: usize| -> Vec<(f64, f64)> {
        let at = |s: &f64| (1e3 * s, 1e3 * shown.radii(surface, *s)[which]);
        places.iter().map(at).collect()
    };
    let outside = shown.surfaces - 1;
    let [start, end] = shown.elastic;
    let is_elastic = |p: &(f64, f64)| p.0 >= 1e3 * start - 1e-9 && p.0 <= 1e3 * end + 1e-9;
    let outer: Vec<(f64, f64)> = of(outside, 0).into_iter().filter(is_elastic).collect();
    let bend = places.iter().map(|s| {
        let kappa = shown.vessel.centre_line().curvature(*s).norm();
        (1e3 * s, kappa * shown.radii(outside, *s)[2])
    });
    vec![
        chart(
            "radius",
            "Distance of the lumen's surface from the centre-line, and of the outside of the elastic wall (mean).",
            panel(
                "radius",
                "arc length / mm",
                "radius / mm",
                vec![
                    line("lumen, mean", 2, of(0, 0)),
                    line("smallest", 3, of(0, 1)),
                    line("largest", 1, of(0, 2)),
                    line("outside", 0, outer),
                ],
            ),
        ),
        chart(
            "curvature",
            "Largest radius of the outside times the curvature of the centre-line: 0.9 is the limit.",
            panel(
                "bend",
                "arc length / mm",
                "radius times curvature / 1",
                vec![line("", 2, bend.collect())],
            ),
        ),
    ]
}

fn parts(shown: &Shown<'_>) -> String {
    let names = shown.vessel.material_names();
    let mm = |x: f64| significant(1e3 * x, 3);
    let rows = shown.vessel.sections().iter().map(|section| {
        let layers = shown
            .vessel
            .layers_of(section)
            .into_iter()
            .map(|(material, thickness)| {
                format!("{} {} mm", escape(&names[material]), mm(thickness))
            });
        let layers: Vec<String> = layers.collect();
        let [mean, ..] = shown.radii(0, 0.5 * (section.from + section.to));
        vec![
            escape(&section.name),
            format!("{} to {}", mm(section.from), mm(section.to)),
            mm(mean),
            if section.is_elastic {
                layers.join(", ")
            } else {
                "rigid".into()
            },
        ]
    });
    table(
        &[
            "section",
            "arc length / mm",
            "radius in its middle / mm",
            "layers from the inside out",
        ],
        &rows.collect::<Vec<_>>(),
    )
}
