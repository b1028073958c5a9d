//! The wet surface over the last beat, with the fields on it at its points.

use crate::Vec3;
use crate::hemodynamics::WetSurface;
use crate::hemodynamics::wall::widened;
use crate::output::results::Results;
use crate::output::vtu;
use crate::output::wall_history::WallHistoryReader;
use std::io;

/// Frames of a beat, at most.
const FRAMES: usize = 25;

/// A field at the points of the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceField {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Values: one list for each frame, or one for all.
    pub values: Vec<Vec<f64>>,
    /// Largest value that is shown as such; the smallest is zero.
    pub high: f64,
    /// Colours of the values 0, 1, …, if they are numbers of kinds.
    pub kinds: Option<Vec<[u8; 3]>>,
}

/// The surface.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnSurface {
    /// The unloaded surface.
    pub wall: WetSurface,
    /// Times of the frames, s.
    pub times: Vec<f64>,
    /// Positions of the points in each frame, m.
    pub frames: Vec<Vec<Vec3>>,
    /// The fields.
    pub fields: Vec<SurfaceField>,
}

impl DrawnSurface {
    /// The surface of a run; `None` if it has not kept its wall, or has not come to its window.
    pub fn of(run: &Results) -> io::Result<Option<Self>> {
        let path = run.files.wall_history();
        if !path.is_file() || run.faces.is_empty() {
            return Ok(None);
        }
        let step = run.case.time.step;
        let window = run.hemodynamics.window;
        let inside = |time: f64| window.contains(time, step);
        // Where the stresses are known too, if they are.
        let series = vtu::VtuSeries::read(&run.files.structure())?;
        let mut times: Vec<f64> = series
            .iter()
            .map(|(t, _)| *t)
            .filter(|t| inside(*t))
            .collect();
        if times.is_empty() {
            times = run
                .history
                .iter()
                .map(|row| row.time_s)
                .filter(|t| inside(*t))
                .collect();
        }
        let every = times.len().div_ceil(FRAMES).max(1);
        let last = times.len() % every;
        // The last one is always among them.
        let times: Vec<f64> = times
            .into_iter()
            .skip((last + every - 1) % every)
            .step_by(every)
            .collect();
        let is_wanted = |time: f64| times.iter().any(|t| (t - time).abs() < 0.5 * step);

        let reader = WallHistoryReader::open(&path)?;
        let wall = reader.wall.clone();
        let to_points = Averaging::new(&wall);
        let (mut frames, mut shear, mut found) = (Vec::new(), Vec::new(), Vec::new());
        for state in reader {
            let state = state?;
            if !is_wanted(state.time) {
                continue;
            }
            let lengths: Vec<f64> = state.shear.iter().map(|v| widened(v).norm()).collect();
            shear.push(to_points.average(&lengths));
            frames.push(wall.displaced(&state.displacement));
            found.push(state.time);
        }
        if frames.is_empty() {
            return Ok(None);
        }
        let moved = |frame: &Vec<Vec3>| -> Vec<f64> {
            let pairs = frame.iter().zip(&wall.points);
            pairs.map(|(x, rest)| 1e3 * (x - rest).norm()).collect()
        };
        let of_faces = |value: fn(&crate::output::wall_fields::FaceRow) -> f64| {
            vec![to_points.average(&run.faces.iter().map(value).collect::<Vec<_>>())]
        };
        let mut fields = vec![
            SurfaceField::new("Displacement", "mm", frames.iter().map(moved).collect()),
            SurfaceField::new("Oscillating shear index", "", of_faces(|f| f.OSI)),
            SurfaceField::new(
                "Time-averaged wall shear stress",
                "Pa",
                of_faces(|f| f.TAWSS_Pa),
            ),
            SurfaceField::new("Relative residence time", "1/Pa", of_faces(|f| f.RRT_1_Pa)),
            SurfaceField::new("Wall shear stress", "Pa", shear),
        ];
        fields.splice(1..1, in_the_wall(run, &series, &wall, &found, step)?);
        Ok(Some(Self {
            wall,
            times: found,
            frames,
            fields,
        }))
    }

    /// Corners of triangles between the points.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let fan = |face: &Vec<u32>| {
            let pairs = face.windows(2).skip(1);
            pairs
                .map(|pair| [face[0], pair[0], pair[1]])
                .collect::<Vec<_>>()
        };
        self.wall.faces.iter().flat_map(fan).collect()
    }

    /// The frame in which the wall has moved farthest.
    pub fn widest_frame(&self) -> usize {
        self.field("Displacement")
            .map_or(0, SurfaceField::largest_frame)
    }

    /// A field by its name.
    pub fn field(&self, name: &str) -> Option<&SurfaceField> {
        self.fields
            .iter()
            .find(|field| field.name.starts_with(name))
    }
}

impl SurfaceField {
    pub fn new(name: &'static str, unit: &'static str, values: Vec<Vec<f64>>) -> Self {
        // A few extreme values would leave no colours for the others.
        let mut all: Vec<f64> = values
            .iter()
            .flatten()
            .copied()
            .filter(|v| v.is_finite())
            .collect();
        all.sort_by(f64::total_cmp);
        let high = all
            .get(all.len().saturating_sub(1) * 995 / 1000)
            .copied()
            .unwrap_or(1.0);
        Self {
            name,
            unit,
            values,
            high: if high > 0.0 { high } else { 1.0 },
            kinds: None,
        }
    }

    /// Kinds with colours, by their numbers.
    pub fn of_kinds(name: &'static str, numbers: &[usize], colours: &[[u8; 3]]) -> Self {
        Self {
            name,
            unit: "",
            values: vec![numbers.iter().map(|number| *number as f64).collect()],
            high: colours.len().saturating_sub(1).max(1) as f64,
            kinds: Some(colours.to_vec()),
        }
    }

    /// The frame in which its largest value is; the first one if it is the same in all.
    pub fn largest_frame(&self) -> usize {
        let most = |values: &Vec<f64>| values.iter().copied().fold(0.0, f64::max);
        let frames = self.values.iter().map(most).enumerate();
        let largest = frames.reduce(|a, b| if b.1 > a.1 { b } else { a });
        largest.map_or(0, |(frame, _)| frame)
    }

    /// Shares of the largest value at the points in a frame.
    pub fn shares(&self, frame: usize) -> Vec<f64> {
        let values = &self.values[frame.min(self.values.len() - 1)];
        values
            .iter()
            .map(|v| (v / self.high).clamp(0.0, 1.0))
            .collect()
    }
}

/// From faces to points.
struct Averaging(Vec<Vec<usize>>);

impl Averaging {
    fn new(wall: &WetSurface) -> Self {
        let mut faces_of = vec![Vec::new(); wall.points.len()];
        for (face, points) in wall.faces.iter().enumerate() {
            points.iter().for_each(|p| faces_of[*p as usize].push(face));
        }
        Self(faces_of)
    }

    fn average(&self, values: &[f64]) -> Vec<f64> {
        let mean = |faces: &Vec<usize>| {
            faces.iter().map(|f| values[*f]).sum::<f64>() / faces.len().max(1) as f64
        };
        self.0.iter().map(mean).collect()
    }
}

/// A field of the wall's files that the page shows.
struct InTheWall {
    name: &'static str,
    unit: &'static str,
    /// Fields of the file, of which the largest counts.
    of: &'static [&'static str],
    show: fn(f64) -> f64,
}

/// Smooth stresses, and the stretch of fibres as an elongation, so that its colours begin at zero.
const IN_THE_WALL: [InTheWall; 5] = [
    InTheWall {
        name: "Von Mises stress in the wall",
        unit: "kPa",
        of: &["von_mises_Pa"],
        show: |stress| 1e-3 * stress,
    },
    InTheWall {
        name: "Largest principal stress in the wall",
        unit: "kPa",
        of: &["max_principal_stress_Pa"],
        show: |stress| 1e-3 * stress,
    },
    InTheWall {
        name: "Hoop stress in the wall",
        unit: "kPa",
        of: &["hoop_stress_Pa"],
        show: |stress| 1e-3 * stress,
    },
    InTheWall {
        name: "Axial stress in the wall",
        unit: "kPa",
        of: &["axial_stress_Pa"],
        show: |stress| 1e-3 * stress,
    },
    InTheWall {
        name: "Elongation of the longer fibres",
        unit: "%",
        of: &["fibre_stretch_1", "fibre_stretch_2"],
        show: |stretch| 1e2 * (stretch - 1.0),
    },
];

/// The fields [`IN_THE_WALL`] at the surface's points at each of the times, as far as the run has kept them; zero where
/// there are no fibres.
fn in_the_wall(
    run: &Results,
    series: &[(f64, std::path::PathBuf)],
    wall: &WetSurface,
    times: &[f64],
    step: f64,
) -> io::Result<Vec<SurfaceField>> {
    let mut nearest: Option<Vec<usize>> = None;
    let mut all = IN_THE_WALL.map(|_| Vec::new());
    for time in times {
        let Some((_, file)) = series.iter().find(|(t, _)| (t - time).abs() < 0.5 * step) else {
            return Ok(Vec::new());
        };
        let grid = vtu::read_points(&run.files.root().join(file))?;
        let nearest = nearest.get_or_insert_with(|| {
            let nearest = |x: &Vec3| {
                let distances = grid
                    .points
                    .iter()
                    .map(|p| (p - x).norm_squared())
                    .enumerate();
                distances
                    .min_by(|a, b| a.1.total_cmp(&b.1))
                    .map_or(0, |(i, _)| i)
            };
            wall.points.iter().map(nearest).collect()
        });
        for (field, frames) in IN_THE_WALL.iter().zip(&mut all) {
            let found = field.of.iter().map(|name| grid.fields.get(*name));
            if let Some(found) = found.collect::<Option<Vec<_>>>() {
                let largest = |i: &usize| {
                    let all = found.iter().map(|values| (field.show)(values[*i]));
                    all.fold(0.0, f64::max)
                };
                frames.push(nearest.iter().map(largest).collect::<Vec<f64>>());
            }
        }
    }
    let complete = |(field, frames): (&InTheWall, Vec<Vec<f64>>)| {
        (frames.len() == times.len()).then(|| SurfaceField::new(field.name, field.unit, frames))
    };
    Ok((IN_THE_WALL.iter().zip(all)).filter_map(complete).collect())
}
