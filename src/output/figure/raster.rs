//! Pictures of pixels within a figure, and the colours beside them.

use super::axis::{Axis, Scale};
use super::colour::Palette;
use super::text::text;
use base64::Engine;
use std::fmt::Write;

/// Pixels, row by row from the top, in a frame at left, top, width and height.
pub(super) fn image(
    svg: &mut String,
    [x, y, w, h]: [f64; 4],
    size: [usize; 2],
    pixels: &[[u8; 3]],
) {
    let _ = writeln!(
        svg,
        "<image x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" preserveAspectRatio=\"none\" \
         href=\"data:image/png;base64,{}\"/>\n\
         <rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\" fill=\"none\" stroke=\"black\" stroke-width=\"0.8\"/>",
        base64::engine::general_purpose::STANDARD.encode(super::png_image(size, pixels))
    );
}

/// A bar with the colours of a field.
pub(super) struct Bar<'a> {
    /// Values of the first and the last colour.
    pub range: [f64; 2],
    pub palette: &'a Palette,
    /// Names the field, with unit.
    pub label: &'a str,
}

impl Bar<'_> {
    /// Draws it from left and top.
    pub fn draw(&self, [left, top]: [f64; 2], height: f64, svg: &mut String) {
        const WIDTH: f64 = 10.0;
        let colours: Vec<[u8; 3]> = self.palette.colours().iter().rev().copied().collect();
        image(
            svg,
            [left, top, WIDTH, height],
            [1, colours.len()],
            &colours,
        );
        let limits = self.range.into_iter();
        let axis = Axis::new(Scale::Linear, limits, false, top + height, top);
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
        let _ = write!(
            svg,
            "<g transform=\"translate({at:.1} {middle:.1}) rotate(-90)\">"
        );
        text(svg, 0.0, 0.0, "middle", 12.0, self.label);
        svg.push_str("</g>\n");
    }
}
