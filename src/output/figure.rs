//! Figures with double logarithmic axes, as SVG for the screen and PNG for paper. They look the same on any machine:
//! the PNG is drawn with an embedded font (`font/DejaVuSans-subset.ttf`, licence beside it).

use super::write_atomically;
use std::fmt::Write;
use std::path::Path;

/// Size of a panel's axes, pixels of 1/96 inch.
const AXES: [f64; 2] = [360.0, 270.0];
/// Room around the axes of a panel: left, top, right, bottom.
const ROOM: [f64; 4] = [66.0, 30.0, 14.0, 46.0];
/// Pixels of the PNG per pixel of the SVG: 240 dots per inch.
const PNG_SCALE: f32 = 2.5;
const FONT: &[u8] = include_bytes!("font/DejaVuSans-subset.ttf");
const FAMILY: &str = "DejaVu Sans, Verdana, Arial, sans-serif";

/// Colours that stay apart in print and for the colour-blind (Okabe and Ito).
const COLOURS: [&str; 7] = [
    "#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#e69f00", "#56b4e9",
];

/// Shape of the points of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Marker {
    /// ●
    Circle,
    /// ■
    Square,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// ▼
    Wedge,
}

impl Marker {
    /// All of them, to be given out in turn.
    pub const ALL: [Marker; 5] = [
        Marker::Circle,
        Marker::Square,
        Marker::Triangle,
        Marker::Diamond,
        Marker::Wedge,
    ];
}

/// A line through points.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name in the legend; `_{…}` and `^{…}` lower and raise.
    pub name: String,
    /// Points; those that are not positive are left out.
    pub points: Vec<(f64, f64)>,
    /// Number of the colour.
    pub colour: usize,
    /// Shape of the points.
    pub marker: Marker,
    /// Whether line and points are open: dashed and white inside.
    pub open: bool,
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

/// Logarithmic axis over whole and parts of decades.
#[derive(Debug, Clone, Copy)]
struct Axis {
    /// Common logarithms of the ends.
    low: f64,
    high: f64,
    /// Pixels of the ends.
    from: f64,
    to: f64,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, whole: bool, from: f64, to: f64) -> Self {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for value in values {
            (low, high) = (low.min(value.log10()), high.max(value.log10()));
        }
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if whole {
            (low, high) = ((low - 0.05).floor(), (high + 0.05).ceil());
        } else {
            (low, high) = (low - 0.08, high + 0.08);
        }
        Self {
            low,
            high,
            from,
            to,
        }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value.log10() - self.low) / (self.high - self.low);
        self.from + share * (self.to - self.from)
    }

    /// Values with a tick, and whether they carry a number.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let decades = self.high - self.low;
        let every = (decades / 8.0).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for exponent in self.low.floor() as i32..=self.high.ceil() as i32 {
            for digit in 1..10 {
                let value = f64::from(digit) * 10f64.powi(exponent);
                let inside = (self.low - 1e-9..=self.high + 1e-9).contains(&value.log10());
                let named = match digit {
                    1 => exponent.rem_euclid(every) == 0,
                    2 | 5 => decades < 1.6,
                    _ => false,
                };
                if inside && (digit == 1 || decades < 6.0) {
                    ticks.push((value, named));
                }
            }
        }
        ticks
    }
}

impl Figure {
    /// Writes `path` with the endings `svg` and `png`.
    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        let svg = self.to_svg();
        write_atomically(&path.with_extension("png"), &to_png(&svg)?)?;
        write_atomically(&path.with_extension("svg"), svg.as_bytes())
    }

    /// The figure as a text in SVG.
    pub fn to_svg(&self) -> String {
        let [left, top, right, bottom] = ROOM;
        let (width, height) = (left + AXES[0] + right, top + AXES[1] + bottom);
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let rows = self.panels.len().div_ceil(columns);
        let (all_width, all_height) = (width * columns as f64, height * rows as f64);
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
    fn draw(&self, [left, top]: [f64; 2], svg: &mut String) {
        let (right, bottom) = (left + AXES[0], top + AXES[1]);
        let points = || {
            let all = self.curves.iter().flat_map(|curve| &curve.points);
            all.copied().filter(|(x, y)| *x > 0.0 && *y > 0.0)
        };
        let x = Axis::new(points().map(|p| p.0), false, left, right);
        let y = Axis::new(points().map(|p| p.1), true, bottom, top);
        self.draw_axes(&x, &y, svg);
        for curve in &self.curves {
            let seen = curve.points.iter().filter(|(x, y)| *x > 0.0 && *y > 0.0);
            let at: Vec<_> = seen.map(|&(a, b)| (x.at(a), y.at(b))).collect();
            curve.draw(&at, svg);
        }
        self.draw_legend(left, bottom, svg);
        let middle = 0.5 * (left + right);
        text(svg, middle, top - 10.0, "middle", 13.0, &self.title);
        text(svg, middle, bottom + 38.0, "middle", 12.0, &self.x_label);
        let (at, height) = (left - 50.0, 0.5 * (top + bottom));
        let _ = write!(
            svg,
            "<g transform=\"translate({at:.1} {height:.1}) rotate(-90)\">"
        );
        text(svg, 0.0, 0.0, "middle", 12.0, &self.y_label);
        svg.push_str("</g>\n");
    }

    fn draw_axes(&self, x: &Axis, y: &Axis, svg: &mut String) {
        let mut line = |x1: f64, y1: f64, x2: f64, y2: f64, colour: &str| {
            let _ = writeln!(
                svg,
                "<path d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\" stroke=\"{colour}\" stroke-width=\"0.8\"/>"
            );
        };
        for (value, _) in x.ticks() {
            let decade = value.log10().fract().abs() < 1e-9;
            let (at, colour) = (x.at(value), if decade { "#c4c4c4" } else { "#ececec" });
            line(at, y.from, at, y.to, colour);
        }
        for (value, _) in y.ticks() {
            let decade = value.log10().fract().abs() < 1e-9;
            let (at, colour) = (y.at(value), if decade { "#c4c4c4" } else { "#ececec" });
            line(x.from, at, x.to, at, colour);
        }
        let _ = writeln!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"black\"/>",
            x.from,
            y.to,
            x.to - x.from,
            y.from - y.to
        );
        for (value, _) in x.ticks().into_iter().filter(|tick| tick.1) {
            text(
                svg,
                x.at(value),
                y.from + 17.0,
                "middle",
                11.0,
                &number(value),
            );
        }
        for (value, _) in y.ticks().into_iter().filter(|tick| tick.1) {
            text(
                svg,
                x.from - 6.0,
                y.at(value) + 4.0,
                "end",
                11.0,
                &number(value),
            );
        }
    }

    /// Bottom left: errors fall to the right.
    fn draw_legend(&self, left: f64, bottom: f64, svg: &mut String) {
        const LINE: f64 = 15.0;
        let longest = self
            .curves
            .iter()
            .map(|c| letters(&c.name))
            .max()
            .unwrap_or(0);
        let (width, height) = (
            38.0 + 6.2 * longest as f64,
            LINE * self.curves.len() as f64 + 6.0,
        );
        let (x, y) = (left + 8.0, bottom - 8.0 - height);
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" fill=\"white\" fill-opacity=\"0.85\" \
             stroke=\"#888888\" stroke-width=\"0.6\"/>"
        );
        for (i, curve) in self.curves.iter().enumerate() {
            let middle = y + 3.0 + LINE * (i as f64 + 0.5);
            let at = [(x + 5.0, middle), (x + 17.0, middle), (x + 29.0, middle)];
            curve.line(&at, svg);
            curve.mark(at[1], svg);
            text(svg, x + 34.0, middle + 4.0, "start", 11.0, &curve.name);
        }
    }
}

impl Curve {
    fn draw(&self, at: &[(f64, f64)], svg: &mut String) {
        self.line(at, svg);
        at.iter().for_each(|&point| self.mark(point, svg));
    }

    fn colour(&self) -> &'static str {
        COLOURS[self.colour % COLOURS.len()]
    }

    fn line(&self, at: &[(f64, f64)], svg: &mut String) {
        let points: Vec<String> = at.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let dashes = if self.open {
            " stroke-dasharray=\"5 3\""
        } else {
            ""
        };
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\"{dashes}/>",
            points.join(" "),
            self.colour()
        );
    }

    fn mark(&self, (x, y): (f64, f64), svg: &mut String) {
        let r = 3.6;
        let outline: &[(f64, f64)] = match self.marker {
            Marker::Circle => &[],
            Marker::Square => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Marker::Triangle => &[(0.0, -1.2), (1.1, 0.8), (-1.1, 0.8)],
            Marker::Diamond => &[(0.0, -1.3), (1.1, 0.0), (0.0, 1.3), (-1.1, 0.0)],
            Marker::Wedge => &[(0.0, 1.2), (1.1, -0.8), (-1.1, -0.8)],
        };
        let (colour, fill) = (
            self.colour(),
            if self.open { "white" } else { self.colour() },
        );
        let paint = format!("fill=\"{fill}\" stroke=\"{colour}\" stroke-width=\"1.2\"");
        if outline.is_empty() {
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\" {paint}/>"
            );
        } else {
            let corner = |(a, b): &(f64, f64)| format!("{:.1},{:.1}", x + r * a, y + r * b);
            let corners: Vec<String> = outline.iter().map(corner).collect();
            let _ = writeln!(svg, "<polygon points=\"{}\" {paint}/>", corners.join(" "));
        }
    }
}

/// A tick's number: powers of ten as such, others in full.
fn number(value: f64) -> String {
    let exponent = value.log10();
    if (exponent - exponent.round()).abs() < 1e-9 {
        format!("10^{{{}}}", exponent.round()).replace('-', "\u{2212}")
    } else {
        format!("{value}")
    }
}

/// Letters that a label shows.
fn letters(label: &str) -> usize {
    label.chars().filter(|c| !"_^{}".contains(*c)).count()
}

/// Text with `_{…}` lowered and `^{…}` raised.
fn text(svg: &mut String, x: f64, y: f64, anchor: &str, size: f64, label: &str) {
    let _ = write!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{size}\">"
    );
    let escaped = label.replace('&', "&amp;").replace('<', "&lt;");
    let mut rest = escaped.as_str();
    // How far the line must move to be back at its height.
    let mut back = 0.0;
    loop {
        let marked = rest.find(['_', '^']).and_then(|at| {
            let (inner, after) = rest[at + 1..].strip_prefix('{')?.split_once('}')?;
            let shift = if &rest[at..=at] == "_" { 3.0 } else { -4.0 };
            Some((&rest[..at], shift, inner, after))
        });
        let (plain, small) = match marked {
            Some((plain, shift, inner, _)) => (plain, Some((shift, inner))),
            None => (rest, None),
        };
        if !plain.is_empty() {
            let _ = write!(svg, "<tspan dy=\"{back}\">{plain}</tspan>");
            back = 0.0;
        }
        if let Some((shift, inner)) = small {
            let (dy, size) = (back + shift, 0.75 * size);
            let _ = write!(
                svg,
                "<tspan dy=\"{dy}\" font-size=\"{size}\">{inner}</tspan>"
            );
            back = -shift;
        }
        match marked {
            Some((.., after)) => rest = after,
            None => break,
        }
    }
    svg.push_str("</text>\n");
}

fn to_png(svg: &str) -> std::io::Result<Vec<u8>> {
    let mut options = resvg::usvg::Options::default();
    options.fontdb_mut().load_font_data(FONT.to_vec());
    let tree = resvg::usvg::Tree::from_str(svg, &options).map_err(std::io::Error::other)?;
    let scale = |length: f32| (length * PNG_SCALE).ceil() as u32;
    let size = [tree.size().width(), tree.size().height()].map(scale);
    let mut pixels = resvg::tiny_skia::Pixmap::new(size[0], size[1])
        .ok_or_else(|| std::io::Error::other("the figure has no extent"))?;
    let transform = resvg::tiny_skia::Transform::from_scale(PNG_SCALE, PNG_SCALE);
    resvg::render(&tree, transform, &mut pixels.as_mut());
    pixels.encode_png().map_err(std::io::Error::other)
}
