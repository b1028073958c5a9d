//! The surface for `viewer.js`, and as rendered pictures.

use super::page::{escape, significant};
use super::surface::{DrawnSurface, SurfaceField};
use crate::Vec3;
use crate::output::figure::solid::{DrawnSolid, View};
use crate::output::figure::{colour::Palette, png_image};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

/// Pixels of a picture.
const PIXELS: [usize; 2] = [1080, 300];

/// The interactive view, which begins with this frame.
pub fn viewer(surface: &DrawnSurface, frame: usize) -> String {
    let view = View::of(&surface.wall.points);
    let seen: Vec<Vec3> = surface
        .frames
        .iter()
        .flatten()
        .map(|x| view.turned(x))
        .collect();
    let most = seen.iter().map(|x| x.amax()).fold(0.0, f64::max);
    let unit = most / f64::from(i16::MAX);
    let coordinates = seen.iter().flat_map(|x| [x.x, x.y, x.z]);
    let positions: Vec<u8> = coordinates
        .flat_map(|c| ((c / unit).round() as i16).to_le_bytes())
        .collect();
    let triangles = surface.triangles();
    let triangles: Vec<u8> = triangles
        .iter()
        .flatten()
        .flat_map(|p| p.to_le_bytes())
        .collect();
    let field = |field: &SurfaceField| {
        let shares = (0..field.values.len()).flat_map(|frame| field.shares(frame));
        let values: Vec<u8> = shares
            .flat_map(|share| ((share * 65535.0).round() as u16).to_le_bytes())
            .collect();
        json!({
            "name": field.name,
            "unit": field.unit,
            "low": "0",
            "high": shown(field.high),
            "colours": field.kinds.as_ref().map(|kinds| STANDARD.encode(of_kinds(kinds))),
            "values": STANDARD.encode(values),
        })
    };
    let data = json!({
        "points": surface.wall.points.len(),
        "times": surface.times,
        "frame": frame,
        "unit": unit,
        "positions": STANDARD.encode(positions),
        "triangles": STANDARD.encode(triangles),
        "fields": surface.fields.iter().map(field).collect::<Vec<_>>(),
        "colours": STANDARD.encode(Palette::sequential().colours().concat()),
        "size": view.size,
        "still": surface.times.len() < 2,
    });
    format!(
        "<div class=\"viewer\">\n<canvas aria-label=\"the wall in three dimensions\"></canvas>\n\
         <div class=\"controls\"><label>Field <select></select></label><button type=\"button\">Play the beat</button>\
         <input type=\"range\" min=\"0\" value=\"0\" step=\"0.01\" aria-label=\"time\"><output></output></div>\n\
         <div class=\"bar\"><span></span><i style=\"background:linear-gradient(90deg,{})\"></i><span></span></div>\n\
         <script type=\"application/json\">{data}</script>\n</div>\n",
        gradient()
    )
}

/// 256 colours, so that the share of the last kind finds that of its number.
fn of_kinds(kinds: &[[u8; 3]]) -> Vec<u8> {
    let last = kinds.len().saturating_sub(1) as f64;
    let at = |i: u32| kinds[(f64::from(i) / 255.0 * last).round() as usize];
    (0..256).flat_map(at).collect()
}

fn gradient() -> String {
    let palette = Palette::sequential();
    let stop = |i: u32| {
        let [r, g, b] = palette.at(f64::from(i) / 16.0);
        format!("rgb({r},{g},{b})")
    };
    (0..=16).map(stop).collect::<Vec<_>>().join(",")
}

fn shown(value: f64) -> String {
    significant(value, 3)
}

/// A rendered picture of the surface in a frame, coloured by a field.
pub fn picture(
    surface: &DrawnSurface,
    field: &SurfaceField,
    frame: usize,
    caption: &str,
) -> String {
    let shares = field.shares(frame);
    let pixels = render(&surface.frames[frame], &surface.triangles(), &shares);
    let image = STANDARD.encode(png_image(PIXELS, &pixels));
    let text = format!(
        "{caption} Colours from 0 to {}{}.",
        shown(field.high),
        [" ", field.unit].concat().trim_end()
    );
    format!(
        "<figure>\n<img alt=\"{}\" src=\"data:image/png;base64,{image}\">\n{}<figcaption>{}</figcaption>\n</figure>\n",
        escape(caption),
        bar(field.high, field.unit),
        escape(&text)
    )
}

/// What the colours from zero to a value stand for.
pub fn bar(high: f64, unit: &str) -> String {
    format!(
        "<div class=\"bar\"><span>0</span><i style=\"background:linear-gradient(90deg,{})\"></i><span>{} {unit}</span></div>\n",
        gradient(),
        shown(high)
    )
}

/// The value in a triangle whose corners have these numbers and weights.
pub fn interpolated(values: &[f64], corners: [usize; 3], weights: [f64; 3]) -> f64 {
    (0..3).map(|i| weights[i] * values[corners[i]]).sum()
}

/// Lit from the eye.
fn render(positions: &[Vec3], triangles: &[[u32; 3]], shares: &[f64]) -> Vec<[u8; 3]> {
    let palette = Palette::sequential();
    let solid = DrawnSolid {
        points: positions,
        triangles,
        colour: &|_, corners, weights| palette.at(interpolated(shares, corners, weights)),
        lines: &[],
    };
    solid.pixels(&View::of(positions), PIXELS)
}
