//! The vessel with its wall cut open towards the reader.

use super::{CELL, EDGE, FIBRE, LUMEN, RIGID, Shown, colour, legend};
use crate::Vec3;
use crate::case::Material;
use crate::geometry::Surfaces;
use crate::output::figure::solid::{DrawnSolid, View};
use std::f64::consts::{PI, TAU};

/// Half of the angle of the part that is cut out.
const OPEN: f64 = 0.36 * PI;
/// Quadrilaterals along and around of what is drawn, and pieces of a line.
const ALONG: usize = 500;
const AROUND: usize = 72;
const PIECES: usize = 10;
/// Fibres along the vessel in ten radii, and around it.
const FIBRES: [usize; 2] = [14, 14];

/// A point of the wall: the number of the surface, arc length (m) and angle.
pub type WallPlace = (usize, f64, f64);

/// The wall cut open: triangles with what they are, and lines.
#[derive(Default)]
pub struct Drawing {
    pub points: Vec<Vec3>,
    pub places: Vec<WallPlace>,
    pub triangles: Vec<[u32; 3]>,
    /// What each triangle is a part of.
    pub parts: Vec<DrawnPart>,
    lines: Vec<([Vec3; 2], [u8; 3])>,
}

/// What a triangle is a part of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DrawnPart {
    Lumen,
    Rigid,
    /// A layer of this material.
    Layer(usize),
}

impl DrawnPart {
    pub fn colour(self) -> [u8; 3] {
        match self {
            Self::Lumen => LUMEN,
            Self::Rigid => RIGID,
            Self::Layer(material) => colour(material),
        }
    }
}

impl Drawing {
    /// The lumen, the wall outside the angle that is cut out, from `open` on, the faces of the cut and those of the
    /// ends; in so many quadrilaterals along and around.
    pub fn of(shown: &Shown<'_>, [open, closed]: [f64; 2], [along, around]: [usize; 2]) -> Self {
        let [from, to] = shown.ends;
        let [start, end] = shown.elastic;
        let outside = shown.surfaces - 1;
        let mut drawing = Self::default();
        let place = |i: usize| from + (to - from) * i as f64 / along as f64;
        drawing.lattice(
            shown,
            [along, around],
            |i, j| (0, place(i), TAU * j as f64 / around as f64),
            |i| match place(i) >= start && place(i) < end {
                true => DrawnPart::Lumen,
                false => DrawnPart::Rigid,
            },
        );
        let turn = |j: usize| open + closed * j as f64 / around as f64;
        for section in shown.vessel.elastic_sections() {
            let layers = shown.vessel.layers_of(section);
            let share = (section.to - section.from) / (to - from);
            let n = (share * along as f64).ceil().max(2.0) as usize;
            let s = |i: usize| section.from + (section.to - section.from) * i as f64 / n as f64;
            let last = layers.last().map_or(0, |(material, _)| *material);
            let skin = |i, j| (outside, s(i), turn(j));
            drawing.lattice(shown, [n, around], skin, |_| DrawnPart::Layer(last));
            for (layer, (material, _)) in layers.iter().enumerate() {
                let part = |_| DrawnPart::Layer(*material);
                for phi in [open, open + closed] {
                    drawing.lattice(shown, [n, 1], |i, j| (layer + j, s(i), phi), part);
                }
                // The ends of the elastic part are faces too.
                for place in [start, end] {
                    if place == section.from || place == section.to {
                        let face = |i, j| (layer + i, place, turn(j));
                        drawing.lattice(shown, [1, around], face, part);
                    }
                }
            }
        }
        drawing
    }

    /// A surface over a lattice of places, each row of quadrilaterals a part of its own.
    fn lattice(
        &mut self,
        shown: &Shown<'_>,
        [n, m]: [usize; 2],
        at: impl Fn(usize, usize) -> WallPlace,
        part: impl Fn(usize) -> DrawnPart,
    ) {
        let first = self.points.len() as u32;
        for (i, j) in (0..=n).flat_map(|i| (0..=m).map(move |j| (i, j))) {
            let place = at(i, j);
            self.places.push(place);
            self.points.push(shown.point(place.0, place.1, place.2));
        }
        let number = |i: usize, j: usize| first + (i * (m + 1) + j) as u32;
        for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
            let [a, b, c, d] = [
                number(i, j),
                number(i, j + 1),
                number(i + 1, j + 1),
                number(i + 1, j),
            ];
            self.triangles.extend([[a, b, c], [a, c, d]]);
            self.parts.extend([part(i); 2]);
        }
    }

    fn line(&mut self, at: impl Fn(f64) -> Vec3, colour: [u8; 3]) {
        let points: Vec<Vec3> = (0..=PIECES).map(|i| at(i as f64 / PIECES as f64)).collect();
        self.lines
            .extend(points.windows(2).map(|pair| ([pair[0], pair[1]], colour)));
    }
}

/// The view of the vessel, and the angles (rad) where the wall begins and how far it reaches around: what is cut out
/// lies towards the eye.
pub fn opened(shown: &Shown<'_>) -> (View, [f64; 2]) {
    let [from, to] = shown.ends;
    let [start, end] = shown.elastic;
    let outline: Vec<Vec3> = (0..=ALONG)
        .map(|i| from + (to - from) * i as f64 / ALONG as f64)
        .flat_map(|s| (0..8).map(move |j| (s, TAU * f64::from(j) / 8.0)))
        .map(|(s, phi)| shown.point(0, s, phi))
        .collect();
    let view = View::of(&outline);
    // Where the eye is, in the cross-section in the middle.
    let frame = shown.vessel.centre_line().frame(0.5 * (start + end));
    let [y, z] = frame.across(&view.eye());
    (view, [z.atan2(y) + OPEN, TAU - 2.0 * OPEN])
}

/// The picture, with a scale, the direction of the flow and the names of the colours below it.
pub fn picture(shown: &Shown<'_>, pixels: [usize; 2]) -> std::io::Result<Vec<u8>> {
    let (view, cut) = opened(shown);
    let mut drawing = Drawing::of(shown, cut, [ALONG, AROUND]);
    for section in shown.vessel.elastic_sections() {
        fibres(shown, section, cut, &mut drawing);
    }
    edges(shown, cut, &mut drawing);
    let solid = DrawnSolid {
        points: &drawing.points,
        triangles: &drawing.triangles,
        colour: &|triangle, _, _| drawing.parts[triangle].colour(),
        lines: &drawing.lines,
    };
    let image = solid.pixels(&view, pixels);
    let projection = solid.projection(&view, pixels);
    let [from, to] = shown.ends;
    let line = shown.vessel.centre_line();
    let places = [0.02, 0.16].map(|share| from + share * (to - from));
    let [_, _, widest] = shown.radii(shown.surfaces - 1, from + 0.07 * (to - from));
    let overlay = legend::Overlay {
        flow: Some((places.map(|s| line.frame(s).origin), widest)),
        marked: &[],
        names: &legend::names(shown.vessel.material_names(), shown.ends != shown.elastic),
        letters: 1.0,
    };
    legend::with_legend(&overlay, &image, pixels, &projection)
}

/// Edges of the elements on the outside, and of the cells on the lumen.
fn edges(shown: &Shown<'_>, [open, closed]: [f64; 2], drawing: &mut Drawing) {
    let Some(keys) = shown.case.vessel() else {
        return;
    };
    let outside = shown.surfaces - 1;
    let stations = |spans: Vec<crate::geometry::Span>| -> Vec<f64> {
        let of_span = |span: crate::geometry::Span| {
            (0..=span.pieces)
                .map(move |i| span.from + (span.to - span.from) * i as f64 / span.pieces as f64)
        };
        spans.into_iter().flat_map(of_span).collect()
    };
    let is_shown = |phi: f64| (phi - open).rem_euclid(TAU) <= closed;
    let elements = shown
        .vessel
        .spans(&keys.structure)
        .into_iter()
        .filter(|span| span.is_elastic);
    let around = keys.structure.circumferential;
    for s in stations(elements.clone().collect()) {
        for piece in 0..24 {
            let from = open + closed * f64::from(piece) / 24.0;
            drawing.line(|t| shown.point(outside, s, from + t * closed / 24.0), EDGE);
        }
    }
    for j in 0..around {
        let phi = -TAU * j as f64 / around as f64;
        if !is_shown(phi) {
            continue;
        }
        for pair in stations(elements.clone().collect()).windows(2) {
            drawing.line(
                |t| shown.point(outside, pair[0] + t * (pair[1] - pair[0]), phi),
                EDGE,
            );
        }
    }
    let mesh = &keys.fluid.mesh;
    let cells = stations(shown.vessel.spans(mesh));
    for s in &cells {
        for piece in 0..24 {
            let turn = |t: f64| TAU * (f64::from(piece) + t) / 24.0;
            drawing.line(|t| shown.point(0, *s, turn(t)), CELL);
        }
    }
    for j in 0..4 * mesh.core {
        let phi = TAU * (j as f64 / (4 * mesh.core) as f64 - 0.125);
        for pair in cells.windows(2) {
            drawing.line(
                |t| shown.point(0, pair[0] + t * (pair[1] - pair[0]), phi),
                CELL,
            );
        }
    }
}

/// Both families of fibres: of the innermost layer on the lumen where it is open, of the outermost one on the outside.
fn fibres(
    shown: &Shown<'_>,
    section: &crate::geometry::Section,
    [open, closed]: [f64; 2],
    drawing: &mut Drawing,
) {
    let layers = shown.vessel.layers_of(section);
    let outside = shown.surfaces - 1;
    let sides = [
        (0, layers.first(), [open + closed, TAU - closed]),
        (outside, layers.last(), [open, closed]),
    ];
    let middle = 0.5 * (section.from + section.to);
    let [radius, ..] = shown.radii(0, middle);
    for (surface, layer, [first, width]) in sides {
        let Some(Material::HolzapfelGasserOgden {
            fibre_angle_deg, ..
        }) = layer.map(|(m, _)| &shown.vessel.materials()[*m])
        else {
            continue;
        };
        let rows = ((section.to - section.from) / (10.0 * radius) * FIBRES[0] as f64)
            .ceil()
            .max(1.0) as usize;
        let columns = (FIBRES[1] as f64 * width / TAU).ceil() as usize;
        for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
            let s = section.from + (section.to - section.from) * (i as f64 + 0.5) / rows as f64;
            let phi = first + width * (j as f64 + 0.5) / columns as f64;
            for family in [1.0, -1.0] {
                let (sin, cos) = fibre_angle_deg.to_radians().sin_cos();
                let r = shown.vessel.radius(surface, s, phi);
                let half = 0.22 * radius;
                let at = |t: f64| {
                    let along = half * (2.0 * t - 1.0);
                    shown.point(surface, s + family * sin * along, phi + cos * along / r)
                };
                drawing.line(at, FIBRE);
            }
        }
    }
}
