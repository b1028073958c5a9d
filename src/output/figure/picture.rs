//! Pixels with a title and a bar of colours, above a figure of curves.

use super::colour::Palette;
use super::raster::{Bar, image};
use super::text::text;
use super::{FAMILY, Figure};

/// Height of the title, and room to the right for the bar of colours.
const TITLE: f64 = 34.0;
const BAR: f64 = 84.0;

/// A picture and its colours.
pub struct Picture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Row by row from the top.
    pub pixels: Vec<[u8; 3]>,
    /// Stands above.
    pub title: String,
    /// Names the colours, with unit.
    pub label: String,
    /// Values of the first and the last colour.
    pub range: [f64; 2],
    /// The colours.
    pub palette: Palette,
}

impl Picture {
    /// The picture above curves, as wide as they are, as a text in SVG.
    pub fn above(&self, curves: &Figure) -> String {
        let [width, below] = curves.size();
        let [columns, rows] = self.size.map(|n| n as f64);
        let shown = [width - BAR, (width - BAR) * rows / columns];
        let top = TITLE + shown[1];
        let height = top + below;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FAMILY}\" font-size=\"12\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        image(
            &mut svg,
            [0.0, TITLE, shown[0], shown[1]],
            self.size,
            &self.pixels,
        );
        text(&mut svg, 0.5 * width, 22.0, "middle", 15.0, &self.title);
        let bar = Bar {
            range: self.range,
            palette: &self.palette,
            classes: &[],
            label: &self.label,
        };
        bar.draw(
            [shown[0] + 10.0, TITLE + 0.1 * shown[1]],
            0.8 * shown[1],
            &mut svg,
        );
        svg.push_str(&format!(
            "<g transform=\"translate(0 {top:.1})\">\n{}</g>\n</svg>\n",
            curves.to_svg()
        ));
        svg
    }
}
