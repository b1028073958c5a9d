//! Figures of curves, as SVG for the screen and PNG for paper. They look the same on any machine:
//! the PNG is drawn with an embedded font (`font/DejaVuSans-subset.ttf`, licence next to it).

pub mod axis;
pub mod bars;
pub mod colour;
mod curve;
pub mod map;
pub mod picture;
mod raster;
pub mod section;
pub mod solid;
mod text;

use super::write_atomically;
use axis::Axis;
pub use axis::Scale;
pub use curve::{Curve, Marker};
use std::fmt::Write;
use std::path::Path;
use text::{letters, text, upward};

/// Size of a panel's axes, pixels of 1/96 inch.
const AXES: [f64; 2] = [360.0, 270.0];
/// Room around the axes of a panel: left, top, right, bottom.
const ROOM: [f64; 4] = [66.0, 30.0, 14.0, 46.0];
/// Pixels of the PNG per pixel of the SVG: 240 dots per inch.
pub const PNG_SCALE: f32 = 2.5;
const FONT: &[u8] = include_bytes!("../font/DejaVuSans-subset.ttf");
const FAMILY: &str = "DejaVu Sans, Verdana, Arial, sans-serif";

/// Height of a line of the legend.
const LINE: f64 = 15.0;
/// An axis is lengthened at most so often to make room for the legend.
const MOST_LENGTHENINGS: usize = 8;
/// More curves than these have their legend on the right of the axes: within, it would cover half of them.
const MOST_WITHIN: usize = 7;
/// Names in a column of that.
const MOST_NAMES: usize = 17;
/// Points of a curve count every so many pixels in the search for a place for the legend.
const STRIDE: f64 = 8.0;
/// Width of a letter of the size 11.
const LETTER: f64 = 6.2;

/// The axes of a panel, and its legend.
struct Placed {
    x: Axis,
    y: Axis,
    legend: Option<Legend>,
}

/// Where the legend stands.
struct Legend {
    /// Left and upper end.
    at: [f64; 2],
    /// Width and height.
    size: [f64; 2],
    /// Columns of names.
    columns: usize,
    /// Points of curves that it covers.
    hides: usize,
}

/// A pair of axes with curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Stands above.
    pub title: String,
    /// Below the axes.
    pub x_label: String,
    /// Beside the axes.
    pub y_label: String,
    /// How values become lengths: along x, and along y.
    pub scales: [Scale; 2],
    /// The curves in the order of the legend.
    pub curves: Vec<Curve>,
}

/// Panels in rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels in a row.
    pub columns: usize,
}

impl Figure {
    /// Writes `path` with the endings `svg` and `png`.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        let svg = self.to_svg();
        write_atomically(&path.with_extension("png"), &to_png(&svg, PNG_SCALE)?)?;
        write_atomically(&path.with_extension("svg"), svg.as_bytes())
    }

    /// Panels in a row, rows, the room to the left of the axes, and the size of a panel with the room around it.
    fn layout(&self) -> ([usize; 2], f64, [f64; 2]) {
        let [left, top, right, bottom] = ROOM;
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rows = self.panels.len().div_ceil(columns);
        let more = self
            .panels
            .iter()
            .map(|panel| panel.placed([0.0; 2]).more_room());
        let [more_left, more_right] = more.fold([0.0; 2], |a, b| {
            [f64::max(a[0], b[0]), f64::max(a[1], b[1])]
        });
        let left = left + more_left;
        let size = [left + AXES[0] + right + more_right, top + AXES[1] + bottom];
        ([columns, rows], left, size)
    }

    /// Width and height.
    pub fn size(&self) -> [f64; 2] {
        let ([columns, rows], _, [width, height]) = self.layout();
        [width * columns as f64, height * rows as f64]
    }

    /// The figure as a text in SVG.
    pub fn to_svg(&self) -> String {
        let ([columns, rows], left, [width, height]) = self.layout();
        let [_, top, ..] = ROOM;
        let [all_width, all_height] = [width * columns as f64, height * rows as f64];
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{all_width}\" height=\"{all_height}\" \
             viewBox=\"0 0 {all_width} {all_height}\" font-family=\"{FAMILY}\" font-size=\"12\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        for (i, panel) in self.panels.iter().enumerate() {
            let origin = [
                (i % columns) as f64 * width + left,
                (i / columns) as f64 * height + top,
            ];
            panel.draw(origin, &mut svg);
        }
        svg.push_str("</svg>\n");
        svg
    }
}

impl Panel {
    /// The axes at a place of the picture.
    fn placed(&self, [left, top]: [f64; 2]) -> Placed {
        let (right, bottom) = (left + AXES[0], top + AXES[1]);
        let [along, up] = self.scales;
        let points = || self.curves.iter().flat_map(|curve| self.seen(curve));
        // Points, unlike lines, need room at the ends.
        let marked = self.curves.iter().any(|curve| curve.marker.is_some());
        let room = marked && along == Scale::Linear;
        let x = Axis::new(along, points().map(|p| p.0), room, left, right);
        let mut y = Axis::new(up, points().map(|p| p.1), true, bottom, top);
        let legend = |y: &Axis| {
            let curves = self.curves.iter();
            let drawn: Vec<_> = curves
                .flat_map(|curve| drawn(&self.pixels(curve, &x, y)))
                .collect();
            self.legend(&drawn, left, top)
        };
        for _ in 0..MOST_LENGTHENINGS {
            if legend(&y).is_some_and(|legend| legend.hides > 0) {
                y = y.lengthened();
            }
        }
        let legend = legend(&y);
        Placed { x, y, legend }
    }

    /// The points of a curve that the scales can show.
    fn seen<'a>(&self, curve: &'a Curve) -> impl Iterator<Item = &'a (f64, f64)> {
        let [along, up] = self.scales;
        let points = curve.points.iter();
        points.filter(move |(x, y)| along.shows(*x) && up.shows(*y))
    }

    fn pixels(&self, curve: &Curve, x: &Axis, y: &Axis) -> Vec<(f64, f64)> {
        let points = self.seen(curve);
        points.map(|&(a, b)| (x.at(a), y.at(b))).collect()
    }

    fn draw(&self, [left, top]: [f64; 2], svg: &mut String) {
        let (right, bottom) = (left + AXES[0], top + AXES[1]);
        let placed = self.placed([left, top]);
        let at = left - 53.0 - placed.more_room()[0];
        let Placed { x, y, legend } = placed;
        self.draw_axes(&x, &y, svg);
        for curve in &self.curves {
            curve.draw(&self.pixels(curve, &x, &y), svg);
        }
        if let Some(legend) = legend {
            self.draw_legend(&legend, svg);
        }
        let middle = 0.5 * (left + right);
        text(svg, middle, top - 10.0, "middle", 13.0, &self.title);
        text(svg, middle, bottom + 38.0, "middle", 12.0, &self.x_label);
        upward(svg, at, 0.5 * (top + bottom), &self.y_label);
    }

    fn draw_axes(&self, x: &Axis, y: &Axis, svg: &mut String) {
        let mut line = |x1: f64, y1: f64, x2: f64, y2: f64, colour: &str| {
            let _ = writeln!(
                svg,
                "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"{colour}\" stroke-width=\"0.8\"/>"
            );
        };
        let colour = |major: bool| if major { "#c4c4c4" } else { "#ececec" };
        for tick in x.ticks() {
            let at = x.at(tick.value);
            line(at, y.from, at, y.to, colour(tick.major));
        }
        for tick in y.ticks() {
            let at = y.at(tick.value);
            line(x.from, at, x.to, at, colour(tick.major));
        }
        let _ = writeln!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"black\"/>",
            x.from,
            y.to,
            x.to - x.from,
            y.from - y.to
        );
        for tick in x.ticks() {
            if let Some(name) = &tick.name {
                // The last number stays within the picture
                let half = 0.5 * LETTER * letters(name) as f64;
                let at = x.at(tick.value).min(x.to + ROOM[2] - 1.0 - half);
                text(svg, at, y.from + 17.0, "middle", 11.0, name);
            }
        }
        for tick in y.ticks() {
            if let Some(name) = &tick.name {
                text(svg, x.from - 6.0, y.at(tick.value) + 4.0, "end", 11.0, name);
            }
        }
    }

    /// The curves that have a name.
    fn named(&self) -> impl Iterator<Item = &Curve> {
        self.curves.iter().filter(|curve| !curve.name.is_empty())
    }

    /// In the corner where it covers least of the curves; the first of equals, as errors fall to the right. If there
    /// are many curves, on the right of the axes.
    fn legend(&self, points: &[(f64, f64)], left: f64, top: f64) -> Option<Legend> {
        let longest = self.named().map(|c| letters(&c.name)).max()?;
        let (width, height) = (
            41.0 + LETTER * longest as f64,
            LINE * self.named().count() as f64 + 6.0,
        );
        let count = self.named().count();
        if count > MOST_WITHIN {
            let columns = count.div_ceil(MOST_NAMES);
            return Some(Legend {
                at: [left + AXES[0] + 8.0, top],
                size: [
                    width * columns as f64,
                    height.min(LINE * MOST_NAMES as f64 + 6.0),
                ],
                columns,
                hides: 0,
            });
        }
        let right = left + AXES[0] - 8.0 - width;
        let bottom = top + AXES[1] - 8.0 - height;
        let (left, top) = (left + 8.0, top + 8.0);
        let covered = |x: f64, y: f64| {
            let inside = |p: &&(f64, f64)| {
                (x - 4.0..x + width + 4.0).contains(&p.0)
                    && (y - 4.0..y + height + 4.0).contains(&p.1)
            };
            points.iter().filter(inside).count()
        };
        let corners = [(left, bottom), (right, top), (left, top), (right, bottom)];
        let (x, y) = corners.into_iter().min_by_key(|(x, y)| covered(*x, *y))?;
        Some(Legend {
            at: [x, y],
            size: [width, height],
            columns: 1,
            hides: covered(x, y),
        })
    }

    fn draw_legend(&self, legend: &Legend, svg: &mut String) {
        let ([x, y], [width, height]) = (legend.at, legend.size);
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"white\" fill-opacity=\"0.85\" \
             stroke=\"#888888\" stroke-width=\"0.6\"/>"
        );
        for (i, curve) in self.named().enumerate() {
            let (column, row) = (i / MOST_NAMES, i % MOST_NAMES);
            let x = x + width / legend.columns as f64 * column as f64;
            let middle = y + 3.0 + LINE * (row as f64 + 0.5);
            let at = [(x + 5.0, middle), (x + 17.0, middle), (x + 29.0, middle)];
            curve.line(&at, svg);
            curve.marker.iter().for_each(|m| curve.mark(*m, at[1], svg));
            text(svg, x + 34.0, middle + 4.0, "start", 11.0, &curve.name);
        }
    }
}

/// Places along a line through points.
fn drawn(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let between = points.windows(2).flat_map(|ends| {
        let [(x, y), (x2, y2)] = [ends[0], ends[1]];
        let count = ((x2 - x).hypot(y2 - y) / STRIDE).ceil().max(1.0);
        (0..count as usize).map(move |i| {
            let share = i as f64 / count;
            (x + share * (x2 - x), y + share * (y2 - y))
        })
    });
    between.chain(points.last().copied()).collect()
}

impl Placed {
    /// Room that long numbers beside the axes, and a legend there, take in addition to the usual.
    fn more_room(&self) -> [f64; 2] {
        let ticks = self.y.ticks().into_iter();
        let longest = ticks.filter_map(|tick| tick.name.map(|name| letters(&name)));
        let usual = 6.0;
        let left = (longest.max().unwrap_or(0) as f64 - usual).max(0.0) * LETTER;
        let beside = self
            .legend
            .as_ref()
            .filter(|legend| legend.at[0] > self.x.to);
        [left, beside.map_or(0.0, |legend| legend.size[0] + 8.0)]
    }
}

/// A text in SVG as PNG, with so many pixels per pixel of the SVG.
pub fn to_png(svg: &str, scale: f32) -> std::io::Result<Vec<u8>> {
    onto_png(svg, scale, [0, 0], &[])
}

/// The same onto the pixels, row by row from the top, of a picture of so many columns and rows in its upper left
/// corner; what lies next to it stays transparent.
pub fn onto_png(
    svg: &str,
    scale: f32,
    [columns, rows]: [usize; 2],
    picture: &[[u8; 3]],
) -> std::io::Result<Vec<u8>> {
    let mut options = resvg::usvg::Options::default();
    options.fontdb_mut().load_font_data(FONT.to_vec());
    let tree = resvg::usvg::Tree::from_str(svg, &options).map_err(std::io::Error::other)?;
    let pixels = |length: f32| (length * scale).ceil() as u32;
    let size = [tree.size().width(), tree.size().height()].map(pixels);
    let mut pixels = resvg::tiny_skia::Pixmap::new(size[0], size[1])
        .ok_or_else(|| std::io::Error::other("the figure has no extent"))?;
    let width = size[0] as usize;
    let lines = pixels.data_mut().chunks_exact_mut(4 * width).take(rows);
    for (line, row) in lines.zip(picture.chunks(columns.max(1))) {
        for (to, [r, g, b]) in line.chunks_exact_mut(4).zip(row) {
            to.copy_from_slice(&[*r, *g, *b, 255]);
        }
    }
    let transform = resvg::tiny_skia::Transform::from_scale(scale, scale);
    resvg::render(&tree, transform, &mut pixels.as_mut());
    pixels.encode_png().map_err(std::io::Error::other)
}

/// Pixels, row by row from the top, as PNG.
pub fn png_image([columns, rows]: [usize; 2], pixels: &[[u8; 3]]) -> Vec<u8> {
    let mut image =
        resvg::tiny_skia::Pixmap::new(columns as u32, rows as u32).expect("an image has an extent");
    for (to, [r, g, b]) in image.data_mut().chunks_exact_mut(4).zip(pixels) {
        to.copy_from_slice(&[*r, *g, *b, 255]);
    }
    image.encode_png().expect("pixels can be written to memory")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(curves: &[&[(f64, f64)]]) -> Panel {
        let curve = |(i, points): (usize, &&[(f64, f64)])| Curve {
            name: format!("curve {i}"),
            points: points.to_vec(),
            colour: i,
            marker: None,
            open: false,
        };
        Panel {
            title: String::new(),
            x_label: "x".into(),
            y_label: "y".into(),
            scales: [Scale::Linear; 2],
            curves: curves.iter().enumerate().map(curve).collect(),
        }
    }

    fn width(panel: Panel) -> f64 {
        let panels = vec![panel];
        Figure { panels, columns: 1 }.size()[0]
    }

    #[test]
    fn a_legend_of_many_curves_stands_beside_the_axes() {
        let line: &[(f64, f64)] = &[(0.0, 0.0), (1.0, 1.0)];
        let [few, many] = [7, 8].map(|count| panel(&vec![line; count]));
        let placed = many.placed([0.0; 2]);
        let legend = placed.legend.unwrap();
        assert!(legend.at[0] > placed.x.to, "{}", legend.at[0]);
        assert!(few.placed([0.0; 2]).legend.unwrap().at[0] < placed.x.to);
        let more = width(many) - width(few);
        assert!((more - legend.size[0] - 8.0).abs() < 1e-9, "{more}");
        // Of very many in columns, within the height of the axes
        let legend = panel(&vec![line; 63]).placed([0.0; 2]).legend.unwrap();
        assert_eq!(legend.columns, 4);
        assert!(legend.size[1] < AXES[1], "{}", legend.size[1]);
    }

    /// A line between two points passes through the corner in which there are no points.
    #[test]
    fn a_legend_does_not_cover_lines() {
        let falling: &[(f64, f64)] = &[(-1.0, 0.5), (0.0, 0.0), (1.0, 0.5), (2.0, 1.0)];
        let panel = panel(&[falling, &[(-1.0, 1.2), (2.0, -0.2)]]);
        let legend = panel.placed([0.0; 2]).legend.unwrap();
        assert_eq!(legend.hides, 0);
    }

    #[test]
    fn long_numbers_have_room_beside_the_axes() {
        let short = panel(&[&[(0.0, 0.0), (1.0, 1.0)]]);
        let long = panel(&[&[(0.0, 0.884_168), (1.0, 0.884_174)]]);
        let more = width(long) - width(short);
        assert!((more - 2.0 * LETTER).abs() < 1e-9, "{more}");
    }
}
