//! A field in colours over x, and over the angle of the unrolled wall or a length across, with a colour bar.

use super::axis::{Axis, Scale};
use super::colour::Palette;
use super::raster::{Bar, framed_image};
use super::text::{text, upward};
use std::fmt::Write;

/// Pixels of the field: enough for the finest meshes that are drawn, and little to store.
const PIXELS: [usize; 2] = [220, 72];
/// Size of the axes.
const AXES: [f64; 2] = [360.0, 150.0];
/// Room around: left, top, right, bottom.
const ROOM: [f64; 4] = [66.0, 30.0, 78.0, 46.0];

/// Width of a letter next to the colours.
const LETTER: f64 = 6.2;

/// What runs upwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Up {
    /// The angle φ from -180 to 180 degrees.
    Angle,
    /// The length y between these limits, m.
    Length([f64; 2]),
}

impl Up {
    fn limits(self) -> [f64; 2] {
        match self {
            Self::Angle => [-180.0, 180.0],
            Self::Length(limits) => limits,
        }
    }

    /// Values with a mark, and the numbers next to them.
    fn ticks(self, floor: f64, top: f64) -> Vec<(f64, String)> {
        let minus = |text: String| text.replace('-', "\u{2212}");
        match self {
            Self::Angle => [-180, -90, 0, 90, 180]
                .map(|phi| (f64::from(phi), minus(format!("{phi}°"))))
                .to_vec(),
            Self::Length(limits) => {
                let limits = limits.map(|y| 1e3 * y).into_iter();
                let axis = Axis::new(Scale::Linear, limits, false, floor, top);
                let ticks = axis.ticks().into_iter();
                ticks
                    .map(|tick| (1e-3 * tick.value, tick.name.unwrap_or_default()))
                    .collect()
            }
        }
    }

    fn label(self) -> &'static str {
        match self {
            Self::Angle => "φ",
            Self::Length(_) => "y / mm",
        }
    }
}

/// A map.
pub struct Map<'a> {
    /// Stands above.
    pub title: String,
    /// Names the colours, with unit.
    pub label: String,
    /// The field at x (m) and φ (degrees) or y (m); white where it is not a number.
    pub field: &'a dyn Fn(f64, f64) -> f64,
    /// Limits of x, m.
    pub x: [f64; 2],
    /// What runs upwards.
    pub up: Up,
    /// Values of the first and the last colour.
    pub range: [f64; 2],
    /// The colours.
    pub palette: Palette,
    /// Names of the values 0, 1, ... of a field that has no others; none of a field of numbers.
    pub classes: Vec<String>,
    /// Places with a cross: x (m) and φ (degrees).
    pub marks: Vec<[f64; 2]>,
}

impl Map<'_> {
    /// The map as a text in SVG.
    pub fn to_svg(&self) -> String {
        let [left, top, mut right, bottom] = ROOM;
        let letters = self.classes.iter().map(|name| name.chars().count());
        right = right.max(40.0 + LETTER * letters.max().unwrap_or(0) as f64);
        let (width, height) = (left + AXES[0] + right, top + AXES[1] + bottom);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"{}\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            super::FAMILY
        );
        let (end, floor) = (left + AXES[0], top + AXES[1]);
        self.draw_field([left, top], &mut svg);
        let millimetres = self.x.map(|x| 1e3 * x);
        let x = Axis::new(Scale::Linear, millimetres.into_iter(), false, left, end);
        let mut line = |path: String| {
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" stroke=\"black\" stroke-width=\"0.8\"/>"
            );
        };
        let [low, high] = self.up.limits();
        let up = |value: f64| floor - (value - low) / (high - low) * AXES[1];
        let ticks = self.up.ticks(floor, top);
        for tick in x.ticks() {
            line(format!("M{:.1} {floor:.1}v4", x.at(tick.value)));
        }
        for (value, _) in &ticks {
            line(format!("M{left:.1} {:.1}h-4", up(*value)));
        }
        for tick in x.ticks() {
            let name = tick.name.unwrap_or_default();
            text(
                &mut svg,
                x.at(tick.value),
                floor + 17.0,
                "middle",
                11.0,
                &name,
            );
        }
        for (value, name) in &ticks {
            text(&mut svg, left - 7.0, up(*value) + 4.0, "end", 11.0, name);
        }
        let middle = 0.5 * (left + end);
        text(&mut svg, middle, top - 10.0, "middle", 13.0, &self.title);
        text(&mut svg, middle, floor + 36.0, "middle", 12.0, "x / mm");
        let (at, height) = (left - 46.0, 0.5 * (top + floor));
        upward(&mut svg, at, height, self.up.label());
        for [at, phi] in &self.marks {
            let (cx, cy) = (x.at(1e3 * at), up(*phi));
            let _ = writeln!(
                svg,
                "<path d=\"M{:.1} {cy:.1}h10M{cx:.1} {:.1}v10\" stroke=\"white\" stroke-width=\"3\"/>\
                 <path d=\"M{:.1} {cy:.1}h10M{cx:.1} {:.1}v10\" stroke=\"black\" stroke-width=\"1.3\"/>",
                cx - 5.0,
                cy - 5.0,
                cx - 5.0,
                cy - 5.0
            );
        }
        let bar = Bar {
            range: self.range,
            palette: &self.palette,
            classes: &self.classes,
            label: &self.label,
        };
        bar.draw([end + 14.0, top], AXES[1], &mut svg);
        svg.push_str("</svg>\n");
        svg
    }

    fn draw_field(&self, [left, top]: [f64; 2], svg: &mut String) {
        let [columns, rows] = PIXELS;
        let mut pixels = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            let [low, high] = self.up.limits();
            let y = high - (high - low) * (row as f64 + 0.5) / rows as f64;
            for column in 0..columns {
                let share = (column as f64 + 0.5) / columns as f64;
                let x = self.x[0] + share * (self.x[1] - self.x[0]);
                let value = (self.field)(x, y);
                pixels.push(if value.is_nan() {
                    [255; 3]
                } else {
                    self.palette.within(self.range, value)
                });
            }
        }
        framed_image(svg, [left, top, AXES[0], AXES[1]], PIXELS, &pixels);
    }
}
