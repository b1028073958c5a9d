//! The velocity of the blood at times that were written, and where the lumen was then.

use crate::Vec3;
use crate::analysis::centre_line;
use crate::analysis::size;
use crate::case::BloodVessel;
use crate::fluid::field::SearchableField;
use crate::geometry::{Vessel, elastic_pieces};
use crate::hemodynamics::{Rings, WetSurface};
use crate::output::fluid_fields;
use crate::output::results::Results;
use crate::output::vtu::VtuSeries;
use crate::output::wall_history::WallHistoryReader;
use crate::simulation::assembly::surroundings::{self, VelocityField};
use std::io;
use std::path::PathBuf;

/// Times that are read, at most.
const FRAMES: usize = 4;

/// Cell centres of the unloaded lumen, cross-section by cross-section, with their numbers.
struct Sections(Vec<(f64, Vec<(Vec3, usize)>)>);

/// The blood at one time.
pub struct Snapshot {
    /// Time, s.
    pub time: f64,
    velocity: Velocity,
    /// Distance of the lumen's surface from the axis at each face of the wall, m.
    radii: Vec<f64>,
}

/// Velocities (m/s) at one time.
enum Velocity {
    /// In the cells of OpenFOAM's mesh.
    Cells(Vec<Vec3>),
    /// In elements where they are at that time.
    Elements(Box<SearchableField>),
}

/// A time (s) at which they were written, and where.
struct Written {
    time: f64,
    source: FlowSource,
}

enum FlowSource {
    Cells(VelocityField),
    Elements(PathBuf),
}

impl Snapshot {
    /// The velocities, m/s.
    pub fn velocities(&self) -> &[Vec3] {
        match &self.velocity {
            Velocity::Cells(velocity) => velocity,
            Velocity::Elements(elements) => &elements.field().velocity,
        }
    }

    /// Largest speed, m/s.
    pub fn fastest(&self) -> f64 {
        let speeds = self.velocities().iter().map(Vec3::norm);
        speeds.fold(0.0, f64::max)
    }
}

impl Written {
    /// All times of a run.
    fn of(run: &Results) -> io::Result<Vec<Self>> {
        let elements = VtuSeries::read(&run.files.fluid_fields())?;
        let elements = elements.into_iter().map(|(time, file)| Self {
            time,
            source: FlowSource::Elements(run.files.root().join(file)),
        });
        let cells = surroundings::velocity_fields(run.case.fluid.solver, &run.files.fluid())?;
        let cells = cells.into_iter().map(|field| Self {
            time: field.time,
            source: FlowSource::Cells(field),
        });
        Ok(cells.chain(elements).collect())
    }

    /// The velocities; none if they belong to another mesh than the case's.
    fn read(&self, run: &Results) -> io::Result<Option<Velocity>> {
        Ok(match &self.source {
            FlowSource::Cells(field) => {
                let velocity = field.read()?;
                (velocity.len() == size::fluid_cells(&run.case))
                    .then_some(Velocity::Cells(velocity))
            }
            FlowSource::Elements(file) => {
                let elements = SearchableField::new(fluid_fields::read(file)?);
                Some(Velocity::Elements(Box::new(elements)))
            }
        })
    }
}

/// The blood in the deformable part at some times of the evaluated window.
pub struct LumenFlow {
    /// In the order of time; at least one.
    pub frames: Vec<Snapshot>,
    vessel: Vessel,
    sections: Sections,
    rings: Rings,
}

impl LumenFlow {
    /// Times spread over the window; none if there is no centre-line, or the fields are not there (they lie in one
    /// folder a rank in a run with several).
    pub fn of(run: &Results) -> io::Result<Option<Self>> {
        let Some(keys) = &run.vessel else {
            return Ok(None);
        };
        let window = run.hemodynamics.window;
        let mut times = Written::of(run)?;
        times.retain(|field| window.contains(field.time, run.case.time.step));
        let every = times.len().div_ceil(FRAMES).max(1);
        times = times.into_iter().rev().step_by(every).collect();
        times.reverse();
        if times.is_empty() || !run.files.wall_history().is_file() {
            return Ok(None);
        }
        let reader = WallHistoryReader::open(&run.files.wall_history())?;
        let wall = reader.wall.clone().around(centre_line(&run.case));
        let mut frames = Vec::new();
        for state in reader {
            let state = state?;
            let near = |f: &&Written| (f.time - state.time).abs() < 0.5 * run.case.time.step;
            if let Some(field) = times.iter().find(near)
                && let Some(velocity) = field.read(run)?
            {
                frames.push(Snapshot {
                    time: field.time,
                    velocity,
                    radii: radii(&wall, &wall.displaced(&state.displacement)),
                });
            }
        }
        Ok(Rings::new(&wall.places())
            .filter(|_| !frames.is_empty())
            .map(|rings| Self {
                frames,
                vessel: Vessel::new(keys),
                sections: Sections::new(keys),
                rings,
            }))
    }

    /// Largest distance of the lumen's surface from the axis, m.
    pub fn widest(&self) -> f64 {
        let all = self.frames.iter().flat_map(|frame| &frame.radii);
        all.copied().fold(0.0, f64::max)
    }

    /// Velocity (m/s) along the centre-line and in the cross-section at a point (m) of the deformed lumen; none
    /// outside. In OpenFOAM's mesh, the same share of the radius as in the unloaded lumen belongs to the same cell.
    pub fn velocity(&self, frame: &Snapshot, x: f64, y: f64, z: f64) -> Option<Vec3> {
        let section = self.vessel.centre_line().frame(x);
        let components = |vector: &Vec3| {
            let [y, z] = section.across(vector);
            Vec3::new(vector.dot(&section.tangent), y, z)
        };
        let cells = match &frame.velocity {
            Velocity::Cells(cells) => cells,
            Velocity::Elements(elements) => {
                let found = elements.velocity(&section.point(y, z));
                return found.map(|velocity| components(&velocity));
            }
        };
        let phi = z.atan2(y);
        let share = y.hypot(z) / self.rings.value(&frame.radii, x, phi.to_degrees());
        let unloaded = share * self.vessel.lumen_radius(x, phi);
        let (sin, cos) = phi.sin_cos();
        (share <= 1.0).then(|| {
            let cell = self.sections.nearest(x, unloaded * cos, unloaded * sin);
            components(&cells[cell])
        })
    }
}

fn radii(wall: &WetSurface, positions: &[Vec3]) -> Vec<f64> {
    let radius = |(number, face): (usize, &Vec<u32>)| {
        let radii = (face.iter()).map(|p| wall.distance(number, &positions[*p as usize]));
        radii.sum::<f64>() / face.len() as f64
    };
    wall.faces.iter().enumerate().map(radius).collect()
}

impl Sections {
    fn new(keys: &BloodVessel) -> Self {
        let settings = &keys.fluid.mesh;
        let vessel = Vessel::new(keys);
        let mesh = vessel.fluid_mesh(settings);
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
        // Cells are numbered cross-section by cross-section, those of rigid sections upstream first.
        let spans = vessel.spans(settings);
        let slices: usize = spans.iter().map(|span| span.pieces).sum();
        let per_section = mesh.cells() / slices;
        let elastic = elastic_pieces(&spans);
        let [first, last] = [elastic.start, elastic.end].map(|slice| slice * per_section);
        let mut sections: Vec<(f64, Vec<(Vec3, usize)>)> = Vec::new();
        for (cell, centre) in centres.take(last).skip(first) {
            let nearest = vessel.centre_line().nearest(&centre);
            if (cell - first).is_multiple_of(per_section) {
                sections.push((nearest.s, Vec::with_capacity(per_section)));
            }
            let [y, z] = nearest.across;
            let last = sections.len() - 1;
            sections[last].1.push((Vec3::new(nearest.s, y, z), cell));
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
