//! Scale, direction of the flow and names of the colours, for a picture that stands by itself.

use super::{CELL, EDGE, FIBRE, LUMEN, RIGID, colour, html_colour};
use crate::Vec3;
use crate::output::figure::onto_png;
use crate::output::figure::solid::Projection;
use fsi_numerics::twelve_digits;
use std::fmt::Write;

/// Height of a line of the legend, and of its letters, for a picture of 1000 pixels width.
const LINE: f64 = 24.0;
const LETTERS: f64 = 13.0;
/// Width of a letter relative to its height, at most, and room after a name.
const WIDE: f64 = 0.6;
const ROOM: f64 = 20.0;
/// Pixels of an image for one of the drawing.
const DRAWN: f64 = 2.5;

/// The sign before a name.
pub enum Sign {
    Patch([u8; 3]),
    Stroke([u8; 3]),
}

/// What is drawn over a picture.
pub struct Overlay<'a> {
    /// Where the flow begins and a bit further on (m), and the radius of the wall there.
    pub flow: Option<([Vec3; 2], f64)>,
    /// Numbers, and the places (m) that get them.
    pub marked: &'a [(usize, Vec3)],
    /// What the colours stand for.
    pub names: &'a [(String, Sign)],
    /// How much larger letters are than those of a picture that fills a page.
    pub letters: f64,
}

/// The image with its legend as PNG.
pub fn with_legend(
    overlay: &Overlay<'_>,
    image: &[[u8; 3]],
    [columns, rows]: [usize; 2],
    projection: &Projection,
) -> std::io::Result<Vec<u8>> {
    let (width, height) = (columns as f64 / DRAWN, rows as f64 / DRAWN);
    let unit = overlay.letters * width / 1000.0;
    let mut drawn = String::new();
    if let Some(beginning) = overlay.flow {
        flow(beginning, projection, [width, height], unit, &mut drawn);
    }
    for (number, x) in overlay.marked {
        let [x, y] = projection.at(x).map(|x| x / DRAWN);
        let _ = writeln!(
            drawn,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.1}\" fill=\"white\" stroke=\"#b00000\" stroke-width=\"{:.1}\"/>\n\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#b00000\">{}</text>",
            8.0 * unit,
            1.6 * unit,
            y + 0.36 * LETTERS * unit,
            number
        );
    }
    let left = 20.0 * unit;
    let mut y = height + 0.7 * LINE * unit;
    let mut x = scale(projection, [left, y], unit, &mut drawn);
    for (name, sign) in overlay.names {
        let wide = (24.0 + WIDE * LETTERS * name.chars().count() as f64) * unit;
        if x + wide > width {
            (x, y) = (left, y + LINE * unit);
        }
        let _ = match sign {
            Sign::Patch(colour) => writeln!(
                drawn,
                "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{}\"/>",
                y - 11.0 * unit,
                18.0 * unit,
                13.0 * unit,
                html_colour(*colour)
            ),
            Sign::Stroke(colour) => writeln!(
                drawn,
                "<path d=\"M{x:.1} {:.1}h{:.1}\" stroke=\"{}\" stroke-width=\"{:.1}\"/>",
                y - 4.5 * unit,
                18.0 * unit,
                html_colour(*colour),
                2.0 * unit
            ),
        };
        label(name, [x + 24.0 * unit, y], &mut drawn);
        x += wide + ROOM * unit;
    }
    let bottom = y + 0.5 * LINE * unit - height;
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{:.1}\" font-family=\"DejaVu Sans\" font-size=\"{}\">\n\
         <rect y=\"{height}\" width=\"{width}\" height=\"{bottom:.1}\" fill=\"white\"/>\n{drawn}</svg>\n",
        height + bottom,
        LETTERS * unit
    );
    onto_png(&svg, DRAWN as f32, [columns, rows], image)
}

/// What the colours of a picture stand for.
pub fn names(materials: &[String], has_rigid: bool) -> Vec<(String, Sign)> {
    let materials = materials.iter().enumerate();
    let mut all: Vec<(String, Sign)> = materials
        .map(|(i, name)| (name.clone(), Sign::Patch(colour(i))))
        .collect();
    let parts = [("lumen", LUMEN, true), ("rigid", RIGID, has_rigid)];
    let parts = parts.into_iter().filter(|(.., is_there)| *is_there);
    all.extend(parts.map(|(name, colour, _)| (name.to_owned(), Sign::Patch(colour))));
    let lines = [
        ("elements of the wall", EDGE),
        ("mesh of the blood", CELL),
        ("fibres", FIBRE),
    ];
    all.extend(lines.map(|(name, colour)| (name.to_owned(), Sign::Stroke(colour))));
    all
}

fn label(name: &str, [x, y]: [f64; 2], svg: &mut String) {
    let name = super::escape(name);
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\">{name}</text>");
}

/// A bar of a round length; where the next thing begins.
fn scale(projection: &Projection, [x, y]: [f64; 2], unit: f64, svg: &mut String) -> f64 {
    let length = super::round_length(150.0 * unit * DRAWN / projection.scale);
    let long = length * projection.scale / DRAWN;
    let _ = writeln!(
        svg,
        "<path d=\"M{x:.1} {:.1}v{:.1}h{long:.1}v{:.1}\" fill=\"none\" stroke=\"black\" stroke-width=\"{:.1}\"/>",
        y - 10.0 * unit,
        10.0 * unit,
        -10.0 * unit,
        1.6 * unit
    );
    let name = format!("{} mm", twelve_digits(1e3 * length));
    label(&name, [x + long + 6.0 * unit, y], svg);
    x + long + (6.0 + WIDE * LETTERS * name.len() as f64 + ROOM) * unit
}

/// An arrow next to the beginning of the vessel.
fn flow(
    ([start, end], widest): ([Vec3; 2], f64),
    projection: &Projection,
    [width, height]: [f64; 2],
    unit: f64,
    svg: &mut String,
) {
    let on = |point: &Vec3| projection.at(point).map(|x| x / DRAWN);
    let [a, b] = [on(&start), on(&end)];
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let size = dx.hypot(dy);
    if size < 10.0 * unit {
        return; // it points at the eye
    }
    let distance = widest * projection.scale / DRAWN + 14.0 * unit;
    // On the side where there is more room, above if there is as much.
    let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
    let [mut nx, mut ny] = [dy / size, -dx / size];
    // Next to an arrow that goes up or down, the word begins or ends there.
    let anchor = |nx: f64| match nx {
        nx if nx > 0.5 => ("start", 0.0),
        nx if nx < -0.5 => ("end", 1.0),
        _ => ("middle", 0.5),
    };
    let word = WIDE * LETTERS * unit * "flow".len() as f64;
    let room = |nx: f64, ny: f64| {
        let [x, y] = [middle[0] + distance * nx, middle[1] + distance * ny];
        let left = x + 12.0 * unit * nx - anchor(nx).1 * word;
        let beside = left.min(width - (left + word));
        beside.min(y - 24.0 * unit).min(height - y)
    };
    if ny > 0.0 {
        (nx, ny) = (-nx, -ny);
    }
    if room(nx, ny) < 10.0 * unit && room(-nx, -ny) > room(nx, ny) {
        (nx, ny) = (-nx, -ny);
    }
    let [x, y] = [a[0] + distance * nx, a[1] + distance * ny];
    let [ux, uy] = [dx / size, dy / size];
    let head = 9.0 * unit;
    let [ex, ey] = [x + dx, y + dy];
    let side = |sign: f64| {
        let back = [ex - head * 1.6 * ux, ey - head * 1.6 * uy];
        format!(
            "{:.1} {:.1}",
            back[0] - sign * 0.6 * head * uy,
            back[1] + sign * 0.6 * head * ux
        )
    };
    let (anchor, _) = anchor(nx);
    let _ = write!(
        svg,
        "<path d=\"M{x:.1} {y:.1}L{:.1} {:.1}\" stroke=\"black\" stroke-width=\"{:.1}\"/>\n<path d=\"M{ex:.1} {ey:.1}L{}L{}Z\"/>\n\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">flow</text>\n",
        ex - head * ux,
        ey - head * uy,
        2.0 * unit,
        side(1.0),
        side(-1.0),
        0.5 * (x + ex) + 12.0 * unit * nx,
        0.5 * (y + ey) + 12.0 * unit * ny + if ny < 0.0 { 0.0 } else { 10.0 * unit }
    );
}
