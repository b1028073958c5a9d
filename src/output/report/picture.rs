//! One picture of a run: the wall cut open next to the wall shear stress on the lumen, above pressure and flow.

use super::run;
use super::scene::interpolated;
use super::surface::DrawnSurface;
use crate::Vec3;
use crate::analysis::centre_line;
use crate::curve::SpaceCurve;
use crate::geometry::poly_mesh::HEX_FACES;
use crate::output::figure::Figure;
use crate::output::figure::colour::Palette;
use crate::output::figure::picture::Picture;
use crate::output::figure::solid::{DrawnSolid, View};
use crate::output::results::Results;
use crate::output::vtu::{self, Hexes};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;
use std::io;

/// Pixels of the vessel.
const PIXELS: [usize; 2] = [920, 314];
/// This share of the values has colours of its own; the largest ones, next to clamped ends, would leave none for the
/// others.
const SHOWN: f64 = 0.97;
/// Half of the angle that is cut out of the wall, towards the reader.
const OPEN: f64 = 0.36 * PI;
/// Colours of the layers from the first material on, and of the edges between elements.
const LAYERS: [[u8; 3]; 4] = [
    [226, 206, 178],
    [198, 160, 128],
    [222, 184, 150],
    [176, 140, 120],
];
const EDGE: [u8; 3] = [120, 95, 75];

/// The picture as a text in SVG, at the time of the largest wall shear stress in the evaluated window.
///
/// # Errors
/// If a file of the run cannot be read, or the run kept no wall in its window.
pub fn of_run(run: &Results) -> io::Result<String> {
    let nothing = || {
        io::Error::other(
            "it has kept no wall within its window: let it run on, with output.wall_history = true",
        )
    };
    let surface = DrawnSurface::of(run)?.ok_or_else(nothing)?;
    let shear = surface.field("Wall shear stress").ok_or_else(nothing)?;
    let frame = shear.largest_frame();
    let mut values = shear.values[frame].clone();
    values.sort_by(f64::total_cmp);
    let high = values[((values.len() - 1) as f64 * SHOWN) as usize];
    let time = surface.times[frame];
    let series = vtu::VtuSeries::read(&run.files.structure())?;
    let near = |(t, _): &&(f64, _)| (t - time).abs() < 0.5 * run.case.time.step;
    let (_, file) = series.iter().find(near).ok_or_else(nothing)?;
    let wall = vtu::read_hexes(&run.files.root().join(file), "displacement_m")?;

    let shares: Vec<f64> = (shear.values[frame].iter())
        .map(|value| (value / high).min(1.0))
        .collect();
    let picture = Picture {
        pixels: draw(
            run,
            &wall,
            &surface.frames[frame],
            &surface.triangles(),
            &shares,
        ),
        size: PIXELS,
        title: format!("{}, t = {time:.3} s", run.name()),
        label: "wall shear stress / Pa".into(),
        range: [0.0, high],
        palette: Palette::sequential(),
    };
    let curves = Figure {
        panels: vec![run::pressure_panel(run), run::flow_panel(run)],
        columns: 2,
    };
    Ok(picture.above(&curves))
}

/// The wall cut open, and the lumen, whose points have these positions (m) and shares of the largest colour.
fn draw(
    run: &Results,
    wall: &Hexes,
    lumen: &[Vec3],
    on_lumen: &[[u32; 3]],
    shares: &[f64],
) -> Vec<[u8; 3]> {
    let view = View::of(lumen);
    let kept = closed_part(run, wall, &view);
    let moved: Vec<Vec3> = wall
        .points
        .iter()
        .zip(&wall.displacement)
        .map(|(x, u)| x + u)
        .collect();
    let mut shell = shell(wall, &kept);
    // The lumen's own surface shows there.
    let line = centre_line(&run.case);
    shell.retain(|(_, corners)| !faces_axis(corners.map(|p| wall.points[p as usize]), &line));
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut colours = Vec::new();
    for (hex, [a, b, c, d]) in &shell {
        triangles.extend([[*a, *b, *c], [*a, *c, *d]]);
        colours.extend([LAYERS[wall.material[*hex] % LAYERS.len()]; 2]);
    }
    let lines = element_edges(wall, &shell, &moved);
    let first = moved.len();
    triangles.extend(on_lumen.iter().map(|t| t.map(|p| p + first as u32)));
    let points: Vec<Vec3> = moved.iter().chain(lumen).copied().collect();
    let palette = Palette::sequential();
    let solid = DrawnSolid {
        points: &points,
        triangles: &triangles,
        colour: &|triangle, corners, weights| match colours.get(triangle) {
            Some(colour) => *colour,
            None => palette.at(interpolated(shares, corners.map(|p| p - first), weights)),
        },
        lines: &lines,
    };
    solid.pixels(&view, PIXELS)
}

/// Whether a face of the wall, seen from outside the wall, is turned to the vessel's axis.
fn faces_axis([a, b, c, d]: [Vec3; 4], line: &SpaceCurve) -> bool {
    let normal = (c - a).cross(&(d - b));
    let middle = 0.25 * (a + b + c + d);
    let inwards = line.nearest(&middle).frame.origin - middle;
    normal.dot(&inwards) > 0.7 * normal.norm() * inwards.norm()
}

/// Numbers of the hexahedra that are not cut out towards the reader.
fn closed_part(run: &Results, wall: &Hexes, view: &View) -> Vec<usize> {
    let line = centre_line(&run.case);
    let is_kept = |hex: &[u32; 8]| {
        let middle = hex.iter().map(|p| wall.points[*p as usize]).sum::<Vec3>() / 8.0;
        let nearest = line.nearest(&middle);
        let angle = |[y, z]: [f64; 2]| z.atan2(y);
        let from_eye = angle(nearest.across) - angle(nearest.frame.across(&view.eye()));
        ((from_eye + PI).rem_euclid(2.0 * PI) - PI).abs() > OPEN
    };
    (0..wall.hexes.len())
        .filter(|i| is_kept(&wall.hexes[*i]))
        .collect()
}

/// Where a point lies, in units of 10 nm. Elements have points of their own: those in the same place count as one.
fn place(wall: &Hexes, point: u32) -> [i64; 3] {
    wall.points[point as usize]
        .map(|c| (c * 1e8).round() as i64)
        .into()
}

/// The faces that only one of the kept hexahedra has, with its number.
fn shell(wall: &Hexes, kept: &[usize]) -> Vec<(usize, [u32; 4])> {
    let mut found = BTreeMap::new();
    for hex in kept {
        for face in HEX_FACES {
            let corners = face.map(|i| wall.hexes[*hex][i]);
            let mut key = corners.map(|p| place(wall, p));
            key.sort_unstable();
            let entry = found.entry(key).or_insert((*hex, corners, 0));
            entry.2 += 1;
        }
    }
    found
        .into_values()
        .filter(|(.., count)| *count == 1)
        .map(|(hex, corners, _)| (hex, corners))
        .collect()
}

/// Edges of the shell that belong to faces of several elements.
fn element_edges(
    wall: &Hexes,
    shell: &[(usize, [u32; 4])],
    moved: &[Vec3],
) -> Vec<([Vec3; 2], [u8; 3])> {
    let mut owners: HashMap<[[i64; 3]; 2], (usize, [u32; 2], bool)> = HashMap::new();
    for (hex, corners) in shell {
        let element = wall.element[*hex];
        for i in 0..4 {
            let ends = [corners[i], corners[(i + 1) % 4]];
            let mut key = ends.map(|p| place(wall, p));
            key.sort_unstable();
            let owner = owners.entry(key).or_insert((element, ends, false));
            owner.2 |= owner.0 != element;
        }
    }
    let mut edges: Vec<_> = owners
        .into_values()
        .filter(|(.., several)| *several)
        .map(|(_, ends, _)| ends)
        .collect();
    edges.sort_unstable();
    let line = |ends: [u32; 2]| (ends.map(|p| moved[p as usize]), EDGE);
    edges.into_iter().map(line).collect()
}
