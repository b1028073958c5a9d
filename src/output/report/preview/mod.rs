//! A vessel before anything is computed: lumen, wall, sections, layers, fibres and meshes.

mod cross_section;
mod cut_open;
mod legend;
mod tree;

use crate::analysis::size;
use cut_open::{Drawing, DrawnPart};

use super::page::{Page, chart, escape, figure, gallery, line, panel, significant, table};
use super::scene;
use super::surface::{DrawnSurface, SurfaceField};
use crate::Vec3;
use crate::case::ResolvedCase;
use crate::geometry::{Surfaces, Vessel};
use crate::hemodynamics::WetSurface;
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

/// Colours of what is no material.
const LUMEN: [u8; 3] = [236, 178, 178];
const RIGID: [u8; 3] = [200, 200, 200];
const EDGE: [u8; 3] = [70, 70, 70];
const CELL: [u8; 3] = [196, 128, 128];
const FIBRE: [u8; 3] = [120, 20, 20];

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
    ///
    /// # Errors
    /// If a tree has no mesh, or the picture cannot be drawn.
    pub fn of(case: &ResolvedCase, name: &str) -> Option<std::io::Result<Self>> {
        if let Some(keys) = case.own().and_then(|own| own.tree.as_ref()) {
            return Some(tree::preview(case, keys, name));
        }
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
        let png = match cut_open::picture(&shown, PIXELS) {
            Ok(png) => png,
            Err(error) => return Some(Err(error)),
        };
        let at = |i: usize| shown.elastic[1] * (i as f64 + 0.5) / CROSS_SECTIONS as f64;
        let drawn: Vec<String> = (0..CROSS_SECTIONS)
            .map(|i| cross_section::draw(&shown, at(i)))
            .collect();
        let html = page(&shown, name, &png, &drawn);
        let svg = cross_section::side_by_side(&drawn);
        Some(Ok(Self { html, png, svg }))
    }
}

fn page(shown: &Shown<'_>, name: &str, png: &[u8], sections: &[String]) -> String {
    let case = shown.case;
    let blood = match size::fluid_cells(case) {
        0 => "0 cells".into(), // of a solver that brings its own
        cells => format!("{cells} {}", case.fluid.solver.pieces()),
    };
    let lead = format!(
        "Before anything is computed. Blood in {blood}; wall of {} elements of degree {}, {} degrees of freedom; {} of {} s; \
         about {:.2} GB of memory.",
        case.vessel()
            .map_or(0, |keys| shown.vessel.wall_elements(&keys.structure)),
        case.structure.p,
        size::structure_degrees_of_freedom(case),
        case.steps_told(),
        case.time.step,
        size::memory(case) / 1e9
    );
    let mut page = Page::new(&format!("The vessel {name}"), &lead);
    let picture = format!(
        "<figure class=\"whole\">\n<img alt=\"the vessel, its wall cut open\" src=\"data:image/png;base64,{}\">\n<figcaption>{}</figcaption>\n\
         </figure>\n",
        STANDARD.encode(png),
        escape(
            "The wall is cut open towards the reader: lumen (rose) with the blood's mesh, layers by material, elements of the wall \
             on its outside. Fibres of the innermost layer are drawn on the lumen, those of the outermost one on the outside. Rigid \
             parts are grey."
        )
    );
    page.section("picture", "The wall cut open", &picture);
    let html = format!(
        "<p>The wall with its layers, cut open. Drag to rotate, scroll to zoom.</p>\n{}{}",
        legend(shown.vessel.material_names()),
        scene::viewer(&wall(shown), 0)
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

fn legend(names: &[String]) -> String {
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

/// A length of 1, 2 or 5 times a power of ten, at most `most`.
fn round_length(most: f64) -> f64 {
    let power = 10f64.powf(most.log10().floor());
    let digits = [5.0, 2.0, 1.0].map(|digit| digit * power);
    digits
        .into_iter()
        .find(|length| *length <= most)
        .unwrap_or(power)
}

/// The wall cut open, with fields on it.
fn wall(shown: &Shown<'_>) -> DrawnSurface {
    let (_, cut) = cut_open::opened(shown);
    let drawing = Drawing::of(shown, cut, [ALONG, AROUND]);
    let outside = shown.surfaces - 1;
    let value = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let all = drawing.places.iter();
        all.map(|(_, s, phi)| of(*s, *phi)).collect()
    };
    let radius = |surface: usize| move |s: f64, phi: f64| shown.vessel.radius(surface, s, phi);
    let thickness = |s: f64, phi: f64| match (shown.elastic[0]..=shown.elastic[1]).contains(&s) {
        true => 1e3 * (radius(outside)(s, phi) - radius(0)(s, phi)),
        false => 0.0,
    };
    let bend =
        |s: f64, phi: f64| shown.vessel.centre_line().curvature(s).norm() * radius(outside)(s, phi);
    // Colours of materials, then those of lumen and rigid parts.
    let materials = shown.vessel.material_names().len();
    let mut colours: Vec<[u8; 3]> = (0..materials).map(colour).collect();
    colours.extend([DrawnPart::Lumen.colour(), DrawnPart::Rigid.colour()]);
    let mut parts = vec![0; drawing.points.len()];
    for (triangle, part) in drawing.triangles.iter().zip(&drawing.parts) {
        let number = match part {
            DrawnPart::Layer(material) => *material,
            DrawnPart::Lumen => materials,
            DrawnPart::Rigid => materials + 1,
        };
        triangle.iter().for_each(|p| parts[*p as usize] = number);
    }
    let faces = drawing.triangles.iter().map(|triangle| triangle.to_vec());
    DrawnSurface {
        wall: WetSurface::new(drawing.points.clone(), faces.collect()),
        times: vec![0.0],
        fields: vec![
            SurfaceField::of_kinds("Material", &parts, &colours),
            SurfaceField::new(
                "Distance of the lumen from the centre-line",
                "mm",
                vec![value(&|s, phi| 1e3 * radius(0)(s, phi))],
            ),
            SurfaceField::new("Thickness of the wall", "mm", vec![value(&thickness)]),
            SurfaceField::new(
                "Radius of the outside times curvature",
                "",
                vec![value(&bend)],
            ),
        ],
        frames: vec![drawing.points],
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{Case, Preset};
    use resvg::tiny_skia::Pixmap;

    fn shown(text: &str) -> Preview {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("case.toml"), text).unwrap();
        let case = Case::load(folder.path(), Preset::Demo, &[]).unwrap_or_else(|e| panic!("{e}"));
        Preview::of(&case, "a vessel").unwrap().unwrap()
    }

    /// The picture stands by itself: with the colours of its legend, a bar of five millimetres, and an arrow.
    #[test]
    fn the_picture_has_scale_names_and_direction() {
        let text = "extends = \"defaults\"\n[vessel]\nradius_m = 3e-3\nupstream_extension_m = 0.01\n[[vessel.piece]]\npiece = \
                    \"line\"\nlength_m = 0.05\n[[vessel.section]]\nname = \"a\"\nlayers = [\"one\", \"two\"]\nthicknesses_m = [4e-4, \
                    6e-4]\n[[vessel.material]]\nname = \"one\"\nmaterial = \"neo_hooke\"\nmu_Pa = 1e5\nkappa_Pa = \
                    1e8\n[[vessel.material]]\nname = \"two\"\nmaterial = \"neo_hooke\"\nmu_Pa = 1e5\nkappa_Pa = 1e8\n";
        let preview = shown(text);
        let image = Pixmap::decode_png(&preview.png).unwrap();
        let (width, height) = (image.width() as usize, image.height() as usize);
        assert_eq!(width, PIXELS[0]);
        assert!(height > PIXELS[1] + 30, "{height}");
        let at = |x: usize, y: usize| {
            let pixel = image.pixel(x as u32, y as u32).unwrap();
            [pixel.red(), pixel.green(), pixel.blue()]
        };
        let count = |rows: std::ops::Range<usize>, is: &dyn Fn([u8; 3]) -> bool| {
            let all = rows.flat_map(|y| (0..width).map(move |x| (x, y)));
            all.filter(|(x, y)| is(at(*x, *y))).count()
        };
        // Patches in the legend, and lit surfaces of these colours in the picture.
        for part in [
            DrawnPart::Layer(0),
            DrawnPart::Layer(1),
            DrawnPart::Lumen,
            DrawnPart::Rigid,
        ] {
            let colour = part.colour();
            let legend = count(PIXELS[1]..height, &|p| p == colour);
            assert!(legend > 500, "{part:?}: {legend}");
            let hue = |p: [u8; 3]| {
                let light = f64::from(p[0]) / f64::from(colour[0]).max(1.0);
                let close = |i: usize| (f64::from(p[i]) - light * f64::from(colour[i])).abs() < 4.0;
                (0.5..=1.01).contains(&light) && (0..3).all(close)
            };
            let picture = count(0..PIXELS[1], &hue);
            assert!(picture > 1000, "{part:?}: {picture}");
        }
        // The longest black row of the legend is the bar: 5 mm of the vessel's 60, which fill 96 % of the picture.
        let black = |p: [u8; 3]| p.iter().all(|c| *c < 60);
        let longest = |y: usize| {
            let mut runs = vec![0];
            for x in 0..width {
                match black(at(x, y)) {
                    true => *runs.last_mut().unwrap() += 1,
                    false => runs.push(0),
                }
            }
            runs.into_iter().max().unwrap_or(0)
        };
        let bar = (PIXELS[1]..height).map(longest).max().unwrap();
        let long = |mm: f64| mm * 0.96 * width as f64 / 60.0;
        assert!(
            (0.95 * long(5.0)..1.1 * long(5.0)).contains(&(bar as f64)),
            "{bar}"
        );
        // The arrow is the only black in the picture.
        assert!(count(0..PIXELS[1], &|p| p == [0; 3]) > 300);
        assert!(preview.html.contains("The wall with its layers, cut open"));
        assert!(preview.html.contains("\"name\":\"Material\""));
    }
}
