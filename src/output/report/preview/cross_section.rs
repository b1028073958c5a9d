//! A cross-section: layers of the wall by material, its elements, and the cells of the blood.

use super::{Shown, colour, html_colour};
use crate::geometry::{Surfaces, section_quads};
use fsi_numerics::twelve_digits;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Width and height of a drawing, and of its margin.
const SIDE: f64 = 300.0;
const MARGIN: f64 = 26.0;
/// Points of an outline.
const AROUND: usize = 144;

/// The cross-section at the arc length `s` (m) as SVG.
pub fn draw(shown: &Shown<'_>, s: f64) -> String {
    let outside = shown.surfaces - 1;
    let [.., widest] = shown.radii(outside, s);
    let scale = (0.5 * SIDE - MARGIN) / widest;
    let at = |[y, z]: [f64; 2]| {
        format!(
            "{:.2},{:.2}",
            0.5 * SIDE + scale * y,
            0.5 * SIDE - scale * z
        )
    };
    let on = |surface: f64, phi: f64| {
        let (below, above) = (surface.floor() as usize, surface.ceil() as usize);
        let [a, b] = [below, above].map(|index| shown.vessel.radius(index, s, phi));
        let r = a + (b - a) * surface.fract();
        [r * phi.cos(), r * phi.sin()]
    };
    let outline = |surface: f64| {
        let points = (0..AROUND).map(|i| at(on(surface, TAU * i as f64 / AROUND as f64)));
        format!("M{}Z", points.collect::<Vec<_>>().join("L"))
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{SIDE}\" height=\"{SIDE}\" viewBox=\"0 0 {SIDE} {SIDE}\" \
         font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let section = shown
        .vessel
        .elastic_sections()
        .find(|section| s <= section.to);
    let layers = section.map_or_else(Vec::new, |section| shown.vessel.layers_of(section));
    for (i, (material, _)) in layers.iter().enumerate() {
        let _ = writeln!(
            svg,
            "<path d=\"{}{}\" fill=\"{}\" fill-rule=\"evenodd\"/>",
            outline((i + 1) as f64),
            outline(i as f64),
            html_colour(colour(*material))
        );
    }
    if let Some(keys) = shown.case.vessel() {
        let (around, per_layer) = (
            keys.structure.circumferential,
            keys.structure.radial_per_layer,
        );
        let mut elements = String::new();
        for i in 0..=outside * per_layer {
            elements += &outline(i as f64 / per_layer as f64);
        }
        for j in 0..around {
            let phi = TAU * j as f64 / around as f64;
            let _ = write!(
                elements,
                "M{}L{}",
                at(on(0.0, phi)),
                at(on(outside as f64, phi))
            );
        }
        let _ = writeln!(
            svg,
            "<path d=\"{elements}\" fill=\"none\" stroke=\"#333\" stroke-width=\"0.8\"/>"
        );
        if shown.case.fluid.solver.has_cells() {
            let mut cells = String::new();
            for quad in section_quads(&keys.fluid.mesh, |phi| shown.vessel.lumen_radius(s, phi)) {
                let _ = write!(cells, "M{}Z", quad.map(at).join("L"));
            }
            let _ = writeln!(
                svg,
                "<path d=\"{cells}\" fill=\"none\" stroke=\"#a33\" stroke-width=\"0.5\"/>"
            );
        }
    }
    let bar = super::round_length(0.5 * widest);
    let (x, y) = (10.0, SIDE - 9.0);
    let _ = write!(
        svg,
        "<path d=\"M{x} {y}h{:.2}\" stroke=\"black\" stroke-width=\"2\"/>\n<text x=\"{:.2}\" y=\"{}\">{} mm</text>\n<text x=\"10\" \
         y=\"16\">s = {:.2} mm{}</text>\n</svg>\n",
        bar * scale,
        x + bar * scale + 6.0,
        y + 4.0,
        twelve_digits(1e3 * bar),
        1e3 * s,
        section.map_or(String::new(), |section| format!(
            ", {}",
            super::escape(&section.name)
        ))
    );
    svg
}

/// Drawings in a row.
pub fn side_by_side(drawings: &[String]) -> String {
    let width = SIDE * drawings.len() as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{SIDE}\" viewBox=\"0 0 {width} {SIDE}\">\n"
    );
    for (i, drawing) in drawings.iter().enumerate() {
        let _ = write!(
            svg,
            "<g transform=\"translate({} 0)\">\n{drawing}</g>\n",
            SIDE * i as f64
        );
    }
    svg + "</svg>\n"
}
