//! Pictures of pixels within a figure, and the colours next to them.

use super::axis::{Axis, Scale};
use super::colour::Palette;
use super::text::{text, upward};
use base64::Engine;
use std::fmt::Write;

/// Pixels, row by row from the top, at left, top, width and height.
pub(super) fn image(
    svg: &mut String,
    [x, y, w, h]: [f64; 4],
    size: [usize; 2],
    pixels: &[[u8; 3]],
) {
    let _ = writeln!(
        svg,
        "<image x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" preserveAspectRatio=\"none\" \
         href=\"data:image/png;base64,{}\"/>",
        base64::engine::general_purpose::STANDARD.encode(super::png_image(size, pixels))
    );
}

/// The same in a frame.
pub(super) fn framed_image(
    svg: &mut String,
    [x, y, w, h]: [f64; 4],
    size: [usize; 2],
    pixels: &[[u8; 3]],
) {
    image(svg, [x, y, w, h], size, pixels);
    let _ = writeln!(
        svg,
        "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" fill=\"none\" stroke=\"black\" stroke-width=\"0.8\"/>"
    );
}

/// A bar with the colours of a field.
pub(super) struct Bar<'a> {
    /// Values of the first and the last colour.
    pub range: [f64; 2],
    pub palette: &'a Palette,
    /// Names of the values 0, 1, ... in place of numbers; none for numbers.
    pub classes: &'a [String],
    /// Names the field, with unit.
    pub label: &'a str,
}

impl Bar<'_> {
    /// Draws it from left and top.
    pub fn draw(&self, [left, top]: [f64; 2], height: f64, svg: &mut String) {
        const WIDTH: f64 = 10.0;
        let colours: Vec<[u8; 3]> = self.palette.colours().iter().rev().copied().collect();
        framed_image(
            svg,
            [left, top, WIDTH, height],
            [1, colours.len()],
            &colours,
        );
        if !self.classes.is_empty() {
            let part = height / self.classes.len() as f64;
            for (i, name) in self.classes.iter().enumerate() {
                let at = top + height - (i as f64 + 0.5) * part;
                text(svg, left + WIDTH + 6.0, at + 4.0, "start", 11.0, name);
            }
            return;
        }
        // Small numbers would need more room than there is: their power of ten stands in the label.
        let largest = self.range[0].abs().max(self.range[1].abs());
        let power = match largest > 0.0 && largest < 1e-2 {
            true => largest.log10().floor() as i32,
            false => 0,
        };
        let limits = self.range.map(|value| value / 10f64.powi(power));
        let axis = Axis::new(Scale::Linear, limits.into_iter(), false, top + height, top);
        let label = match (power, self.label.strip_suffix(" / 1")) {
            (0, _) => self.label.to_owned(),
            (_, Some(name)) => format!("{name} / 10^{{{power}}}"),
            (_, None) => format!("{} × 10^{{{}}}", self.label, -power),
        };
        for tick in axis.ticks() {
            let (at, name) = (axis.at(tick.value), tick.name.unwrap_or_default());
            let _ = writeln!(
                svg,
                "<path d=\"M{:.1} {at:.1}h4\" stroke=\"black\" stroke-width=\"0.8\"/>",
                left + WIDTH
            );
            text(svg, left + WIDTH + 6.0, at + 4.0, "start", 11.0, &name);
        }
        let (at, middle) = (left + WIDTH + 48.0, top + 0.5 * height);
        upward(svg, at, middle, &label);
    }
}
