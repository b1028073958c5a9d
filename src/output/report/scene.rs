//! The surface for `viewer.js`, and as rendered pictures.

use super::page::{escape, significant};
use super::surface::{Field, Surface};
use crate::Vec3;
use crate::output::figure::{colour::Palette, png_image};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;

/// Pixels of a picture.
const PIXELS: [usize; 2] = [1080, 300];
/// From the surface towards the eye.
const EYE: [f64; 3] = [-0.35, 0.45, 1.0];

/// The interactive view, which begins with this frame.
pub fn viewer(surface: &Surface, frame: usize) -> String {
    let size = surface
        .wall
        .points
        .iter()
        .map(|x| x.amax())
        .fold(0.0, f64::max);
    // Room for what the wall moves outward.
    let unit = 1.2 * size / f64::from(i16::MAX);
    let coordinates = surface
        .frames
        .iter()
        .flatten()
        .flat_map(|x| [x.x, x.y, x.z]);
    let positions: Vec<u8> = coordinates
        .flat_map(|c| ((c / unit).round() as i16).to_le_bytes())
        .collect();
    let triangles = surface.triangles();
    let triangles: Vec<u8> = triangles
        .iter()
        .flatten()
        .flat_map(|p| p.to_le_bytes())
        .collect();
    let field = |field: &Field| {
        let shares = (0..field.values.len()).flat_map(|frame| field.shares(frame));
        let values: Vec<u8> = shares
            .flat_map(|share| ((share * 65535.0).round() as u16).to_le_bytes())
            .collect();
        json!({
            "name": field.name,
            "unit": field.unit,
            "low": "0",
            "high": shown(field.high),
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
        "middle": [0.5 * size, 0.0, 0.0],
        "size": size,
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
pub fn picture(surface: &Surface, field: &Field, frame: usize, caption: &str) -> String {
    let shares = field.shares(frame);
    let pixels = render(&surface.frames[frame], &surface.triangles(), &shares);
    let image = STANDARD.encode(png_image(PIXELS, &pixels));
    let text = format!(
        "{caption} Colours from 0 to {}{}.",
        shown(field.high),
        [" ", field.unit].concat().trim_end()
    );
    format!(
        "<figure>\n<img alt=\"{}\" src=\"data:image/png;base64,{image}\">\n\
         <div class=\"bar\"><span>0</span><i style=\"background:linear-gradient(90deg,{})\"></i><span>{} {}</span></div>\n\
         <figcaption>{}</figcaption>\n</figure>\n",
        escape(caption),
        gradient(),
        shown(field.high),
        field.unit,
        escape(&text)
    )
}

/// Parallel projection with a depth buffer, lit from the eye.
fn render(positions: &[Vec3], triangles: &[[u32; 3]], shares: &[f64]) -> Vec<[u8; 3]> {
    let [columns, rows] = PIXELS;
    let palette = Palette::sequential();
    let eye = Vec3::from(EYE).normalize();
    let right = Vec3::y().cross(&eye).normalize();
    let up = eye.cross(&right);
    let seen = |x: &Vec3| [right.dot(x), up.dot(x), eye.dot(x)];
    let points: Vec<[f64; 3]> = positions.iter().map(seen).collect();
    let limits = |d: usize| {
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        points
            .iter()
            .fold(ends, |(low, high), p| (low.min(p[d]), high.max(p[d])))
    };
    let [(left, end), (floor, top)] = [limits(0), limits(1)];
    let scale = (columns as f64 / (end - left)).min(rows as f64 / (top - floor)) * 0.96;
    let at = |p: &[f64; 3]| {
        let x = 0.5 * columns as f64 + scale * (p[0] - 0.5 * (left + end));
        let y = 0.5 * rows as f64 - scale * (p[1] - 0.5 * (floor + top));
        [x, y, p[2]]
    };
    let mut normals = vec![Vec3::zeros(); positions.len()];
    for corners in triangles {
        let [p, q, r] = corners.map(|p| positions[p as usize]);
        let normal = (q - p).cross(&(r - p));
        corners.iter().for_each(|p| normals[*p as usize] += normal);
    }
    let lights: Vec<f64> = normals
        .iter()
        .map(|n| n.normalize().dot(&eye).abs())
        .collect();
    let mut pixels = vec![[255; 3]; columns * rows];
    let mut depths = vec![f64::NEG_INFINITY; columns * rows];
    for triangle in triangles {
        let corner = triangle.map(|p| p as usize);
        let [a, b, c] = corner.map(|p| at(&points[p]));
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
        if area == 0.0 {
            continue;
        }
        let range = |d: usize, most: usize| {
            let low = a[d].min(b[d]).min(c[d]).floor().max(0.0) as usize;
            let high = a[d].max(b[d]).max(c[d]).ceil().max(0.0) as usize;
            low..high.min(most)
        };
        for row in range(1, rows) {
            for column in range(0, columns) {
                let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
                let v = ((x - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (y - a[1])) / area;
                let w = ((b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1])) / area;
                let u = 1.0 - v - w;
                if u < 0.0 || v < 0.0 || w < 0.0 {
                    continue;
                }
                let mix = |values: [f64; 3]| u * values[0] + v * values[1] + w * values[2];
                let depth = mix([a[2], b[2], c[2]]);
                let pixel = row * columns + column;
                if depth > depths[pixel] {
                    depths[pixel] = depth;
                    let colour = palette.at(mix(corner.map(|p| shares[p])));
                    let light = 0.5 + 0.5 * mix(corner.map(|p| lights[p]));
                    pixels[pixel] = colour.map(|c| (f64::from(c) * light) as u8);
                }
            }
        }
    }
    pixels
}
