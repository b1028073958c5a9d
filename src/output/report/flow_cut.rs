//! The speed of the blood in a longitudinal cut, from the times that OpenFOAM has written.

use super::page::figure;
use crate::Vec3;
use crate::geometry::Vessel;
use crate::hemodynamics::{Rings, Wall};
use crate::output::figure::colour::Palette;
use crate::output::figure::map::{Map, Up};
use crate::output::results::Results;
use crate::output::wall_history::WallHistoryReader;
use std::io;
use std::path::Path;

/// Cuts that are shown, at most.
const CUTS: usize = 4;

/// Cell centres of the unloaded lumen, cross-section by cross-section, with their numbers.
struct Sections(Vec<(f64, Vec<(Vec3, usize)>)>);

/// Cuts through the axis in the plane of y, at times spread over the evaluated window; none if the fields are not there
/// (they lie in one folder a rank in a run with several).
pub fn of_run(run: &Results) -> io::Result<Vec<String>> {
    let mut times = written_times(run)?;
    let every = times.len().div_ceil(CUTS).max(1);
    times = times.into_iter().rev().step_by(every).collect();
    times.reverse();
    if times.is_empty() || !run.files.wall_history().is_file() {
        return Ok(Vec::new());
    }
    let sections = Sections::new(run);
    let mut found = Vec::new();
    let reader = WallHistoryReader::open(&run.files.wall_history())?;
    let wall = reader.wall.clone();
    for state in reader {
        let state = state?;
        let near = |t: &&(f64, String)| (t.0 - state.time).abs() < 0.5 * run.case.time.step;
        if let Some((time, name)) = times.iter().find(near) {
            let path = run.files.openfoam().join(name).join("U");
            let speed: Vec<f64> = velocity(&path)?.iter().map(Vec3::norm).collect();
            if speed.len() == run.case.fluid.mesh.cells() {
                found.push((*time, speed, wall.displaced(&state.displacement)));
            }
        }
    }
    let high = found
        .iter()
        .flat_map(|(_, speed, _)| speed)
        .copied()
        .fold(0.0, f64::max);
    Ok(found
        .iter()
        .map(|(time, speed, positions)| draw(run, &sections, &wall, *time, speed, positions, high))
        .collect())
}

fn draw(
    run: &Results,
    sections: &Sections,
    wall: &Wall,
    time: f64,
    speed: &[f64],
    positions: &[Vec3],
    high: f64,
) -> String {
    let radius = |face: &Vec<u32>| {
        let at = |p: &u32| positions[*p as usize];
        let radii = face.iter().map(|p| at(p).y.hypot(at(p).z));
        radii.sum::<f64>() / face.len() as f64
    };
    let radii: Vec<f64> = wall.faces.iter().map(radius).collect();
    let most = radii.iter().copied().fold(0.0, f64::max);
    let Some(rings) = Rings::new(&wall.places()) else {
        return String::new();
    };
    let vessel = Vessel::new(&run.case);
    // The same share of the radius, before and after the deformation.
    let field = |x: f64, y: f64| {
        let phi = if y < 0.0 { 180.0 } else { 0.0 };
        let share = y.abs() / rings.value(&radii, x, phi);
        if share > 1.0 {
            return f64::NAN;
        }
        let unloaded = share * vessel.lumen_radius(x, f64::to_radians(phi)) * y.signum();
        speed[sections.nearest(x, unloaded)]
    };
    let svg = Map {
        title: format!("t = {time:.3} s"),
        label: "speed / (m/s)".into(),
        field: &field,
        x: super::maps::whole(run),
        up: Up::Length([-1.05 * most, 1.05 * most]),
        range: [0.0, high],
        palette: Palette::sequential(),
        marks: Vec::new(),
    }
    .to_svg();
    figure(
        &svg,
        "Speed of the blood in the cut z = 0; lengths across are magnified.",
        None,
    )
}

impl Sections {
    fn new(run: &Results) -> Self {
        let settings = &run.case.fluid.mesh;
        let mesh = Vessel::new(&run.case).fluid_mesh(settings);
        let mut sums = vec![(Vec3::zeros(), 0.0); mesh.cells()];
        let sides = mesh
            .owner
            .iter()
            .enumerate()
            .chain(mesh.neighbour.iter().enumerate());
        for (face, &cell) in sides {
            for &point in &mesh.faces[face] {
                sums[cell].0 += mesh.points[point];
                sums[cell].1 += 1.0;
            }
        }
        let centres = sums.iter().map(|(sum, count)| sum / *count).enumerate();
        let per_section = mesh.cells() / settings.slices();
        // Cells are numbered cross-section by cross-section, those of the rigid extension first.
        let first = per_section * settings.axial_extension;
        let mut sections: Vec<(f64, Vec<(Vec3, usize)>)> = Vec::new();
        for (cell, centre) in centres.skip(first) {
            if (cell - first).is_multiple_of(per_section) {
                sections.push((centre.x, Vec::with_capacity(per_section)));
            }
            let last = sections.len() - 1;
            sections[last].1.push((centre, cell));
        }
        Self(sections)
    }

    /// The cell whose centre is nearest to the point (x, y, 0) (m) of the unloaded lumen.
    fn nearest(&self, x: f64, y: f64) -> usize {
        let Self(sections) = self;
        let far = |section: &&(f64, Vec<(Vec3, usize)>)| (section.0 - x).abs();
        let section = sections.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        let (_, cells) = section.expect("a vessel has cross-sections");
        let far = |centre: &Vec3| (centre.y - y).hypot(centre.z);
        let nearest = cells.iter().min_by(|a, b| far(&a.0).total_cmp(&far(&b.0)));
        nearest.expect("a cross-section has cells").1
    }
}

/// Times of the window with the names of their folders.
fn written_times(run: &Results) -> io::Result<Vec<(f64, String)>> {
    let mut times = Vec::new();
    let Ok(folders) = std::fs::read_dir(run.files.openfoam()) else {
        return Ok(times);
    };
    for folder in folders {
        let folder = folder?;
        let name = folder.file_name().to_string_lossy().into_owned();
        let Ok(time) = name.parse::<f64>() else {
            continue;
        };
        let inside = run.hemodynamics.window.contains(time, run.case.time.step);
        if inside && folder.path().join("U").is_file() {
            times.push((time, name));
        }
    }
    times.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(times)
}

/// The vectors of a field in the cells, from a binary file of OpenFOAM.
fn velocity(path: &Path) -> io::Result<Vec<Vec3>> {
    let bytes = std::fs::read(path)?;
    let bad = || {
        let text = format!("{}: not a binary field of vectors", path.display());
        io::Error::new(io::ErrorKind::InvalidData, text)
    };
    let after = |from: usize, what: &[u8]| {
        let found = bytes[from..].windows(what.len()).position(|w| w == what);
        found.map(|at| from + at + what.len())
    };
    let header = after(0, b"internalField").ok_or_else(bad)?;
    let list = after(header, b"List<vector>").ok_or_else(bad)?;
    let open = after(list, b"(").ok_or_else(bad)?;
    let count = std::str::from_utf8(&bytes[list..open - 1]).map_err(|_| bad())?;
    let count: usize = count.trim().parse().map_err(|_| bad())?;
    let end = count.checked_mul(24).and_then(|n| n.checked_add(open));
    let numbers = end.and_then(|end| bytes.get(open..end)).ok_or_else(bad)?;
    let vector = |chunk: &[u8]| {
        let mut v = Vec3::zeros();
        for (c, bytes) in v.iter_mut().zip(chunk.chunks_exact(8)) {
            let mut number = [0; 8];
            number.copy_from_slice(bytes);
            *c = f64::from_le_bytes(number);
        }
        v
    };
    Ok(numbers.chunks_exact(24).map(vector).collect())
}
