//! Wall shear where the branches of a tree meet, seen from both sides.

use super::maps::upper_end;
use super::page::{escape, gallery};
use super::scene::{bar, interpolated};
use super::surface::{DrawnSurface, SurfaceField};
use crate::Vec3;
use crate::case::TreeKeys;
use crate::geometry::tree::{MeetingPlace, Tree};
use crate::output::figure::colour::Palette;
use crate::output::figure::onto_png;
use crate::output::figure::solid::{DrawnSolid, View};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;
use std::io;

/// Fields that are drawn.
const FIELDS: [&str; 3] = [
    "Time-averaged wall shear stress",
    "Oscillating shear index",
    "Relative residence time",
];
/// How far around its centre a junction is drawn, in radii of the parent.
const REACH: f64 = 4.0;
/// Most junctions that are drawn: those of the widest vessels.
const MOST: usize = 6;
/// Pixels of the view from one side, and of an image for one of the drawing of its names.
const PIXELS: [usize; 2] = [500, 400];
const DRAWN: f64 = 2.0;

/// The junctions of a tree; empty if there is none.
///
/// # Errors
/// If names cannot be drawn.
pub fn html(keys: &TreeKeys, surface: &DrawnSurface) -> io::Result<String> {
    // Its lumen had a mesh when the run began; if it has none now, there is nothing to show.
    let Ok(tree) = Tree::of_cells(keys) else {
        return Ok(String::new());
    };
    let mut places = tree.meeting_places();
    let count = places.len();
    if count > MOST {
        places.sort_by(|a, b| b.radius.total_cmp(&a.radius));
        places.truncate(MOST);
    }
    let mut html = match count > MOST {
        true => format!("<p>The {MOST} junctions of the widest vessels, of {count}.</p>\n"),
        false => String::new(),
    };
    let names = keys.branches();
    for place in &places {
        let part = Part::new(&tree, place, &names, surface);
        let told = tree.told(place, &names);
        let fields = FIELDS.iter().filter_map(|name| surface.field(name));
        let figures = fields.map(|field| part.figure(field, &told));
        html += &gallery(&figures.collect::<io::Result<Vec<_>>>()?);
    }
    Ok(html)
}

/// The wall around a junction.
struct Part {
    /// Its points among those of the whole wall, and where they are, m.
    numbers: Vec<usize>,
    points: Vec<Vec3>,
    /// Between these.
    triangles: Vec<[u32; 3]>,
    /// From the front, and from behind.
    views: [View; 2],
    /// Names of the branches, and where they stand, m.
    names: Vec<(String, Vec3)>,
}

impl Part {
    fn new(
        tree: &Tree,
        place: &MeetingPlace<'_>,
        names: &[String],
        surface: &DrawnSurface,
    ) -> Self {
        let all = &surface.wall.points;
        let reach = REACH * place.radius;
        let is_near = |p: &usize| (all[*p] - place.centre).norm() < reach;
        let numbers: Vec<usize> = (0..all.len()).filter(is_near).collect();
        let renumbered = |corners: [u32; 3]| {
            let found = corners.map(|p| numbers.binary_search(&(p as usize)).ok());
            let [Some(a), Some(b), Some(c)] = found else {
                return None;
            };
            Some([a, b, c].map(|p| p as u32))
        };
        let triangles = surface.triangles().into_iter().filter_map(renumbered);
        let triangles = triangles.collect();
        let points: Vec<Vec3> = numbers.iter().map(|&p| all[p]).collect();
        let front = View::across(&points).with_to_the_right(&place.downstream());
        let stacks = [place.parent]
            .into_iter()
            .chain(place.daughters.iter().copied());
        let named = stacks.filter_map(|stack| {
            let centres = stack.sections.iter().map(|section| section.centre);
            // Not at the edge of what is drawn.
            let inside = centres.filter(|x| (x - place.centre).norm() < 0.8 * reach);
            let far = inside.max_by(|a, b| {
                let [a, b] = [a, b].map(|x| (x - place.centre).norm());
                a.total_cmp(&b)
            });
            Some((tree.branch_name(stack, names), far?))
        });
        Self {
            numbers,
            points,
            triangles,
            views: [front.clone(), front.behind()],
            names: named.collect(),
        }
    }

    fn figure(&self, field: &SurfaceField, told: &str) -> io::Result<String> {
        let values: Vec<f64> = self.numbers.iter().map(|&p| field.values[0][p]).collect();
        let (high, is_cut) = upper_end(values.clone());
        let palette = Palette::sequential();
        let solid = DrawnSolid {
            points: &self.points,
            triangles: &self.triangles,
            colour: &|_, corners, weights| {
                palette.at(interpolated(&values, corners, weights) / high.max(f64::MIN_POSITIVE))
            },
            lines: &[],
        };
        let alternative = format!("{}, seen from both sides: {told}", field.name);
        let mut html = String::from("<figure>\n");
        for view in &self.views {
            let projection = solid.projection(view, PIXELS);
            let [width, height] = PIXELS.map(|pixels| pixels as f64 / DRAWN);
            let mut svg = format!(
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" font-family=\"DejaVu Sans\" \
                 font-size=\"12\" text-anchor=\"middle\">\n"
            );
            for (name, x) in &self.names {
                let [x, y] = projection.at(x).map(|x| x / DRAWN);
                let _ = writeln!(
                    svg,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"black\" stroke=\"white\" stroke-width=\"3\" paint-order=\"stroke\">{}</text>",
                    escape(name)
                );
            }
            svg += "</svg>\n";
            let png = onto_png(&svg, DRAWN as f32, PIXELS, &solid.pixels(view, PIXELS))?;
            let _ = writeln!(
                html,
                "<img class=\"half\" alt=\"{}\" src=\"data:image/png;base64,{}\">",
                escape(&alternative),
                STANDARD.encode(png)
            );
        }
        let cut = match is_cut {
            true => " The colours end at the 95th percentile.",
            false => "",
        };
        let _ = write!(
            html,
            "{}<figcaption>{}: {} From both sides.{cut}</figcaption>\n</figure>\n",
            bar(high, field.unit),
            escape(field.name),
            escape(told)
        );
        Ok(html)
    }
}
