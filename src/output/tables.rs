//! `history.csv` (one row per time step), `iterations.csv` (one row per coupling iteration) `probes.csv` and
//! `fluid-probes.csv` (one row per time step and probe), `openings.csv` (one row per time step and opening).

use crate::files::named;
use flate2::read::GzDecoder;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// A row of `history.csv`. Field names are the headers: they carry the unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct HistoryRow {
    /// Time at the end of the step.
    pub time_s: f64,
    /// Coupling iterations.
    pub coupling_iterations: usize,
    /// Fixed-point residual of the accepted iteration, relative to the displacement.
    pub residual: f64,
    /// Wall-clock time in the fluid.
    pub fluid_s: f64,
    /// Wall-clock time in the structure.
    pub structure_s: f64,
    /// Inflow.
    pub Q_in_m3_s: f64,
    /// Outflow.
    pub Q_out_m3_s: f64,
    /// Mean pressure at the inlet.
    pub p_in_Pa: f64,
    /// Mean pressure at the outlet.
    pub p_out_Pa: f64,
    /// Volume of the lumen of the deformable section.
    pub lumen_volume_m3: f64,
    /// Change of the volume over the step.
    pub dVdt_m3_s: f64,
    /// Largest displacement of the wet surface.
    pub max_displacement_m: f64,
    /// Largest von Mises stress at the quadrature points.
    pub max_von_mises_Pa: f64,
    /// Pressure of the windkessel before the ramp.
    pub p_windkessel_Pa: f64,
    /// Mismatch of the resultant force between the two surfaces, relative to the sum of |load|.
    pub force_mismatch: f64,
    /// Largest difference between the fluid's velocity at the wall and the wall's.
    pub wall_velocity_mismatch_m_s: f64,
    /// Wall-clock time of the whole step.
    pub wall_s: f64,
}

/// A row of `iterations.csv`.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct IterationRow {
    /// Time at the end of the step.
    pub time_s: f64,
    /// Attempt at the step, from 1; only the last one counts.
    pub attempt: usize,
    /// Number within the attempt, from 1.
    pub iteration: usize,
    /// Change (14) relative to the displacement.
    pub change: f64,
    /// Change (14), root mean square over the points.
    pub change_rms_m: f64,
    /// Fixed-point residual relative to the displacement.
    pub residual: f64,
    /// Fixed-point residual, root mean square over the points.
    pub residual_rms_m: f64,
    /// Columns of the quasi-Newton model.
    pub columns: usize,
    /// Sweeps of the fluid over its equations: outer correctors of OpenFOAM.
    pub correctors: u32,
    /// Relative residual with which the fluid's last sweep began: OpenFOAM's first one of the pressure.
    pub pressure_residual: f64,
    /// Mismatch of the resultant force.
    pub force_mismatch: f64,
    /// Wall-clock time in the fluid.
    pub fluid_s: f64,
    /// Wall-clock time in the structure.
    pub structure_s: f64,
    /// Wall-clock time in transfer and acceleration.
    pub coupling_s: f64,
}

/// A row of `openings.csv`: what flows through an opening whose name is the user's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct OpeningRow {
    /// Time at the end of the step.
    pub time_s: f64,
    /// Its name: that of the patch.
    pub opening: String,
    /// Flow into the domain; negative where the fluid leaves it.
    pub flow_m3_s: f64,
    /// Mean pressure.
    pub p_Pa: f64,
    /// Pressure of the model downstream, such as a windkessel's before its ramp; empty without one.
    pub p_model_Pa: Option<f64>,
}

/// A row of `sections.csv`: what flows through a cross-section.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct SectionRow {
    /// Time at the end of the step.
    pub time_s: f64,
    /// Its name in the case.
    pub section: String,
    /// Flow through it, away from the inlet; empty in the first step.
    pub flow_m3_s: Option<f64>,
    /// Mean pressure on the wall there.
    pub p_Pa: f64,
    /// Area.
    pub area_m2: f64,
}

/// A row of `fluid-probes.csv`: the blood at a point, NaN where that is not in the blood.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct FluidProbeRow {
    /// Time at the end of the step.
    pub time_s: f64,
    /// Number of the probe in the case, from 0.
    pub probe: usize,
    /// Position.
    pub x_m: f64,
    /// Position.
    pub y_m: f64,
    /// Position.
    pub z_m: f64,
    /// Pressure.
    pub p_Pa: f64,
    /// Velocity.
    pub ux_m_s: f64,
    /// Velocity.
    pub uy_m_s: f64,
    /// Velocity.
    pub uz_m_s: f64,
}

/// A row of `probes.csv`: one point of the wet surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the headers of the CSV file carry the units")]
pub struct ProbeRow {
    /// Time at the end of the step.
    pub time_s: f64,
    /// Number of the probe in the case, from 0.
    pub probe: usize,
    /// Reference position.
    pub x_m: f64,
    /// Reference position.
    pub y_m: f64,
    /// Reference position.
    pub z_m: f64,
    /// Displacement.
    pub ux_m: f64,
    /// Displacement.
    pub uy_m: f64,
    /// Displacement.
    pub uz_m: f64,
    /// Wall shear stress on the face of the fluid's mesh there.
    pub wall_shear_x_Pa: f64,
    /// Wall shear stress.
    pub wall_shear_y_Pa: f64,
    /// Wall shear stress.
    pub wall_shear_z_Pa: f64,
    /// Pressure of the blood on that face.
    pub p_Pa: f64,
}

/// The bytes of a table, or of one that was stored compressed (`history.csv.gz`).
fn bytes(path: &Path) -> io::Result<Vec<u8>> {
    let found = std::fs::read(path);
    if found
        .as_ref()
        .is_err_and(|e| e.kind() == io::ErrorKind::NotFound)
        && let Ok(packed) = File::open(path.with_extension("csv.gz"))
    {
        let mut text = Vec::new();
        GzDecoder::new(packed).read_to_end(&mut text)?;
        return Ok(text);
    }
    found
}

/// The points of each name among the rows, in the order in which the names come; `point` is none where a row has no
/// value.
pub fn by_name<Row>(
    rows: &[Row],
    name: impl Fn(&Row) -> &str,
    point: impl Fn(&Row) -> Option<(f64, f64)>,
) -> Vec<(String, Vec<(f64, f64)>)> {
    let mut found: Vec<(String, Vec<(f64, f64)>)> = Vec::new();
    for row in rows {
        let known = found.iter().position(|(known, _)| known == name(row));
        let i = known.unwrap_or_else(|| {
            found.push((name(row).to_owned(), Vec::new()));
            found.len() - 1
        });
        found[i].1.extend(point(row));
    }
    found
}

/// The rows of a table; a last one that is cut off does not count.
///
/// # Errors
/// If the file cannot be read or is another table.
pub fn read<T: DeserializeOwned>(path: &Path) -> io::Result<Vec<T>> {
    let failed = |kind, what: &dyn std::fmt::Display| {
        io::Error::new(kind, format!("{}: {what}", path.display()))
    };
    let text = bytes(path).map_err(|e| failed(e.kind(), &e))?;
    let whole = text
        .iter()
        .rposition(|byte| *byte == b'\n')
        .map_or(0, |n| n + 1);
    let mut reader = csv::Reader::from_reader(&text[..whole]);
    let rows = reader.deserialize().collect::<Result<Vec<T>, _>>();
    rows.map_err(|e| failed(io::ErrorKind::InvalidData, &e))
}

/// A row of `resolution.csv`: how well the flow is resolved at a face of the wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ResolutionRow {
    /// Centre of the unloaded face along the axis.
    pub x_m: f64,
    /// Around the axis, from +y towards +z.
    pub phi_deg: f64,
    /// Difference of its time-averaged wall shear stress from that of the neighbouring faces, over the mean of the
    /// wall; empty at rims.
    pub jump: Option<f64>,
    /// Share of the velocity that is in the highest polynomials of the fluid's element there, if it has any.
    pub highest_modes: Option<f64>,
}

/// The rows at whole multiples of `step` (s): where steps were halved, others lie between.
pub fn whole_steps(history: &[HistoryRow], step: f64) -> Vec<&HistoryRow> {
    history
        .iter()
        .filter(|row| is_whole(row.time_s, step))
        .collect()
}

/// Whether a time (s) is a whole multiple of `step` (s).
pub fn is_whole(time: f64, step: f64) -> bool {
    let steps = time / step;
    (steps - steps.round()).abs() < 1e-3
}

/// A CSV file that is complete up to its last row at any moment.
pub struct CsvTable {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl CsvTable {
    /// Creates the file; the header follows with the first row.
    pub fn create(path: &Path) -> io::Result<Self> {
        let file = File::create(path).map_err(named(path))?;
        Ok(Self {
            path: path.to_owned(),
            writer: csv::Writer::from_writer(file),
        })
    }

    /// Opens the file of an earlier run to continue after its first `length` bytes; what follows them is cut off. With
    /// nothing to continue, the file need not exist.
    pub fn resume(path: &Path, length: u64) -> io::Result<Self> {
        let file = (File::options().append(true).create(length == 0)).open(path);
        let file = file.map_err(named(path))?;
        file.set_len(length).map_err(named(path))?;
        // An empty file still needs its header.
        let writer = csv::WriterBuilder::new()
            .has_headers(length == 0)
            .from_writer(file);
        Ok(Self {
            path: path.to_owned(),
            writer,
        })
    }

    /// Sees to it that all rows are on the disk; returns the length of the file.
    pub fn sync(&self) -> io::Result<u64> {
        let file = self.writer.get_ref();
        let length = || file.sync_data().and_then(|()| file.metadata());
        length().map(|it| it.len()).map_err(named(&self.path))
    }

    /// Adds rows and hands them to the operating system.
    pub fn append<T: Serialize>(&mut self, rows: &[T]) -> io::Result<()> {
        for row in rows {
            let added = self.writer.serialize(row).map_err(io::Error::other);
            added.map_err(named(&self.path))?;
        }
        self.writer.flush().map_err(named(&self.path))
    }
}
