//! The velocity of the blood at times that OpenFOAM has written, and where the lumen was then.

use crate::Vec3;
use crate::geometry::Vessel;
use crate::hemodynamics::{Rings, Wall};
use crate::output::results::Results;
use crate::output::wall_history::WallHistoryReader;
use std::io;
use std::path::Path;

/// Times that are read, at most.
const FRAMES: usize = 4;

/// Cell centres of the unloaded lumen, cross-section by cross-section, with their numbers.
struct Sections(Vec<(f64, Vec<(Vec3, usize)>)>);

/// The blood at one time.
pub struct Frame {
    /// Time, s.
    pub time: f64,
    /// Velocity in each cell, m/s.
    pub velocity: Vec<Vec3>,
    /// Distance of the lumen's surface from the axis at each face of the wall, m.
    radii: Vec<f64>,
}

impl Frame {
    /// Largest speed, m/s.
    pub fn fastest(&self) -> f64 {
        self.velocity.iter().map(Vec3::norm).fold(0.0, f64::max)
    }
}

/// The blood in the deformable part at some times of the evaluated window.
pub struct Flow {
    /// In the order of time; at least one.
    pub frames: Vec<Frame>,
    vessel: Vessel,
    sections: Sections,
    rings: Rings,
}

impl Flow {
    /// Times spread over the window; none if the fields are not there (they lie in one folder a rank in a run with
    /// several).
    pub fn of(run: &Results) -> io::Result<Option<Self>> {
        let mut times = written_times(run)?;
        let every = times.len().div_ceil(FRAMES).max(1);
        times = times.into_iter().rev().step_by(every).collect();
        times.reverse();
        if times.is_empty() || !run.files.wall_history().is_file() {
            return Ok(None);
        }
        let reader = WallHistoryReader::open(&run.files.wall_history())?;
        let wall = reader.wall.clone();
        let mut frames = Vec::new();
        for state in reader {
            let state = state?;
            let near = |t: &&(f64, String)| (t.0 - state.time).abs() < 0.5 * run.case.time.step;
            if let Some((time, name)) = times.iter().find(near) {
                let velocity = vectors(&run.files.openfoam().join(name).join("U"))?;
                if velocity.len() == run.vessel.fluid.mesh.cells() {
                    frames.push(Frame {
                        time: *time,
                        velocity,
                        radii: radii(&wall, &wall.displaced(&state.displacement)),
                    });
                }
            }
        }
        Ok(Rings::new(&wall.places())
            .filter(|_| !frames.is_empty())
            .map(|rings| Self {
                frames,
                vessel: Vessel::new(&run.vessel),
                sections: Sections::new(run),
                rings,
            }))
    }

    /// Largest distance of the lumen's surface from the axis, m.
    pub fn widest(&self) -> f64 {
        let all = self.frames.iter().flat_map(|frame| &frame.radii);
        all.copied().fold(0.0, f64::max)
    }

    /// Velocity (m/s) at a point (m) of the deformed lumen; none outside. The same share of the radius as in the unloaded
    /// lumen belongs to the same cell.
    pub fn velocity(&self, frame: &Frame, x: f64, y: f64, z: f64) -> Option<Vec3> {
        let phi = z.atan2(y);
        let share = y.hypot(z) / self.rings.value(&frame.radii, x, phi.to_degrees());
        let unloaded = share * self.vessel.lumen_radius(x, phi);
        let (sin, cos) = phi.sin_cos();
        (share <= 1.0)
            .then(|| frame.velocity[self.sections.nearest(x, unloaded * cos, unloaded * sin)])
    }
}

fn radii(wall: &Wall, positions: &[Vec3]) -> Vec<f64> {
    let radius = |face: &Vec<u32>| {
        let at = |p: &u32| positions[*p as usize];
        let radii = face.iter().map(|p| at(p).y.hypot(at(p).z));
        radii.sum::<f64>() / face.len() as f64
    };
    wall.faces.iter().map(radius).collect()
}

impl Sections {
    fn new(run: &Results) -> Self {
        let settings = &run.vessel.fluid.mesh;
        let mesh = Vessel::new(&run.vessel).fluid_mesh(settings);
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

    /// The cell whose centre is nearest to the point (x, y, z) (m) of the unloaded lumen.
    fn nearest(&self, x: f64, y: f64, z: f64) -> usize {
        let Self(sections) = self;
        let far = |section: &&(f64, Vec<(Vec3, usize)>)| (section.0 - x).abs();
        let section = sections.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        let (_, cells) = section.expect("a vessel has cross-sections");
        let far = |centre: &Vec3| (centre.y - y).hypot(centre.z - z);
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
fn vectors(path: &Path) -> io::Result<Vec<Vec3>> {
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
