//! A field in colours and arrows in a cross-section of a vessel.

use super::axis::{Axis, Scale};
use super::colour::Palette;
use super::raster::{Bar, framed_image};
use super::text::{text, upward};
use std::fmt::Write;

/// Pixels along a side.
const PIXELS: usize = 96;
/// Length of a side.
const SIDE: f64 = 230.0;
/// Room around: left, top, right, bottom.
const ROOM: [f64; 4] = [66.0, 30.0, 78.0, 46.0];
/// Length of the longest arrow.
const LONGEST: f64 = 28.0;

/// A vector in the plane of the cross-section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Arrow {
    /// Where it begins: y and z, m.
    pub at: [f64; 2],
    /// Its components.
    pub vector: [f64; 2],
}

/// A cross-section; y runs to the right and z upwards.
pub struct FlowSection<'a> {
    /// Stands above.
    pub title: String,
    /// Names the colours, with unit.
    pub label: String,
    /// The field at y and z (m); white where it is not a number.
    pub field: &'a dyn Fn(f64, f64) -> f64,
    /// y and z run from minus this to this, m.
    pub half: f64,
    /// Values of the first and the last colour.
    pub range: [f64; 2],
    /// The colours.
    pub palette: Palette,
    /// The arrows.
    pub arrows: Vec<Arrow>,
    /// Length of a vector whose arrow is as long as arrows get.
    pub unit: f64,
}

impl FlowSection<'_> {
    /// The cross-section as a text in SVG.
    pub fn to_svg(&self) -> String {
        let [left, top, right, bottom] = ROOM;
        let (width, height) = (left + SIDE + right, top + SIDE + bottom);
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"{}\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            super::FAMILY
        );
        let (end, floor) = (left + SIDE, top + SIDE);
        let mut pixels = Vec::with_capacity(PIXELS * PIXELS);
        let across = |i: usize| self.half * (2.0 * (i as f64 + 0.5) / PIXELS as f64 - 1.0);
        for row in 0..PIXELS {
            for column in 0..PIXELS {
                let value = (self.field)(across(column), -across(row));
                pixels.push(if value.is_nan() {
                    [255; 3]
                } else {
                    self.palette.within(self.range, value)
                });
            }
        }
        framed_image(&mut svg, [left, top, SIDE, SIDE], [PIXELS; 2], &pixels);

        let limits = [-1e3 * self.half, 1e3 * self.half].into_iter();
        let y = Axis::new(Scale::Linear, limits.clone(), false, left, end);
        let z = Axis::new(Scale::Linear, limits, false, floor, top);
        let mut marks = String::new();
        for tick in y.ticks() {
            let at = y.at(tick.value);
            let _ = write!(marks, "M{at:.1} {floor:.1}v4");
            let name = tick.name.unwrap_or_default();
            text(&mut svg, at, floor + 17.0, "middle", 11.0, &name);
        }
        for tick in z.ticks() {
            let at = z.at(tick.value);
            let _ = write!(marks, "M{left:.1} {at:.1}h-4");
            let name = tick.name.unwrap_or_default();
            text(&mut svg, left - 7.0, at + 4.0, "end", 11.0, &name);
        }
        let _ = writeln!(
            svg,
            "<path d=\"{marks}\" stroke=\"black\" stroke-width=\"0.8\"/>"
        );
        let middle = 0.5 * (left + end);
        text(&mut svg, middle, top - 10.0, "middle", 13.0, &self.title);
        text(&mut svg, middle, floor + 36.0, "middle", 12.0, "y / mm");
        let (at, height) = (left - 46.0, 0.5 * (top + floor));
        upward(&mut svg, at, height, "z / mm");
        self.draw_arrows(&y, &z, &mut svg);
        let bar = Bar {
            range: self.range,
            palette: &self.palette,
            classes: &[],
            label: &self.label,
        };
        bar.draw([end + 14.0, top], SIDE, &mut svg);
        svg.push_str("</svg>\n");
        svg
    }

    fn draw_arrows(&self, y: &Axis, z: &Axis, svg: &mut String) {
        let mut path = String::new();
        for arrow in &self.arrows {
            let [dy, dz] = arrow.vector.map(|v| LONGEST * v / self.unit);
            let length = dy.hypot(dz);
            // Shorter ones could not be seen.
            if length.is_nan() || length < 1.0 {
                continue;
            }
            let (from, to) = (y.at(1e3 * arrow.at[0]), z.at(1e3 * arrow.at[1]));
            let _ = write!(path, "M{from:.1} {to:.1}l{dy:.1} {:.1}", -dz);
            // A head of two strokes, a third of the arrow but no longer than 5.
            let head = (length / 3.0).min(5.0) / length;
            for side in [0.5, -0.5] {
                let (hy, hz) = (-head * (dy - side * dz), -head * (dz + side * dy));
                let (ey, ez) = (from + dy, to - dz);
                let _ = write!(path, "M{ey:.1} {ez:.1}l{hy:.1} {:.1}", -hz);
            }
        }
        for (colour, width) in [("white", 2.6), ("black", 1.0)] {
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>"
            );
        }
    }
}
