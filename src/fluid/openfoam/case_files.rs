//! Writes an OpenFOAM case: copies the templates, and writes beside them the numbers of the case.
//!
//! The templates include two generated files, so they need no substitution of text and stay valid dictionaries:
//! `system/fsiParameters` (the physics) and `system/fsiConnection` (the way to the driver, new at every start).
//! The mesh is written by others.

use crate::case::{Blood, Flag, Inflow, Ramp, Time, Windkessel};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

/// The inflow curve is written with at least this many points per period; OpenFOAM interpolates linearly between.
const CURVE_POINTS: usize = 10_000;
/// A ramp of no duration, s.
const NO_RAMP: f64 = 1e-9;

/// Why the case could not be written.
#[derive(Debug, thiserror::Error)]
pub enum CaseFilesError {
    /// The system refused.
    #[error("cannot {action} {}: {source}", .path.display())]
    Io {
        /// What was being done.
        action: &'static str,
        /// With what.
        path: PathBuf,
        /// Why it failed.
        source: io::Error,
    },
    /// A curve that is none.
    #[error("{}: {reason}", .path.display())]
    Curve {
        /// The file.
        path: PathBuf,
        /// What was expected and found, and where.
        reason: String,
    },
}

fn io_error(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> CaseFilesError {
    let path = path.to_owned();
    move |source| CaseFilesError::Io {
        action,
        path,
        source,
    }
}

/// The physics that OpenFOAM needs to know.
#[derive(Debug, Clone, Copy)]
pub struct CaseFiles<'a> {
    /// Folder of the templates.
    pub templates: &'a Path,
    /// The blood.
    pub blood: &'a Blood,
    /// Flow at the inlet; a relative path of its file is taken from the working directory.
    pub inflow: &'a Inflow,
    /// The outlet.
    pub windkessel: &'a Windkessel,
    /// Smooth start.
    pub ramp: &'a Ramp,
    /// Time axis.
    pub time: &'a Time,
    /// The channel, if the blood flows around a flag.
    pub flag: Option<&'a Flag>,
    /// MPI ranks.
    pub ranks: usize,
}

impl CaseFiles<'_> {
    /// Writes everything but `constant/polyMesh` into `folder`.
    pub fn write(&self, folder: &Path) -> Result<(), CaseFilesError> {
        copy_folder(self.templates, folder)?;
        write_file(&folder.join("system/fsiParameters"), &self.parameters())?;
        write_file(&folder.join("constant/inflow.csv"), &self.curve()?)?;
        // Until the solver is started: enough for checkMesh and other utilities to read the case.
        Connection {
            library: None,
            transport: "none",
            address: Path::new("none"),
            start_time: 0.0,
        }
        .write(folder)
    }

    fn parameters(&self) -> String {
        let entries: [(&str, f64, &str); 9] = [
            ("density", self.blood.density, "kg/m3"),
            (
                "kinematicViscosity",
                self.blood.viscosity / self.blood.density,
                "m2/s",
            ),
            ("timeStep", self.time.step, "s"),
            (
                "rampDuration",
                self.ramp.duration.max(NO_RAMP),
                "s, of inflow and outlet pressure",
            ),
            (
                "windkesselResistance",
                self.windkessel.resistance,
                "Pa s/m3",
            ),
            ("windkesselCompliance", self.windkessel.compliance, "m3/Pa"),
            (
                "windkesselPressure",
                self.windkessel.initial_pressure,
                "Pa, at t = 0, before the ramp",
            ),
            ("period", self.time.period, "s"),
            ("ranks", self.ranks as f64, "MPI ranks"),
        ];
        let channel = self.flag.map_or(vec![], |flag| {
            vec![
                ("channelHeight", flag.channel_height, "m"),
                ("meanVelocity", flag.mean_velocity, "m/s, at the inlet"),
                ("depth", flag.depth, "m, along z"),
            ]
        });
        let mut text = String::from("// Numbers of the case; written by fsi-driver, do not edit\n");
        for (name, value, unit) in entries.into_iter().chain(channel) {
            // `{:e}` is the shortest form that reads back as the same number
            let value = if name == "ranks" {
                format!("{value}")
            } else {
                format!("{value:e}")
            };
            let _ = writeln!(text, "{name:<23} {value}; // {unit}");
        }
        text
    }

    /// One period of the inflow as `time_s,flow_m3_s`, with a point at every multiple of the time step (and of its half,
    /// its quarter, …), where the interpolation is exact, if the time step divides the period.
    fn curve(&self) -> Result<String, CaseFilesError> {
        let mut text = String::from("time_s,flow_m3_s\n");
        if let Some(path) = &self.inflow.file {
            for [time, flow] in read_curve(path, self.time.period)? {
                let _ = writeln!(text, "{time:e},{flow:e}");
            }
            return Ok(text);
        }
        let per_period = (self.time.period / self.time.step).round().max(1.0) as usize;
        let n = per_period * CURVE_POINTS.div_ceil(per_period).next_power_of_two();
        for i in 0..=n {
            let time = self.time.period * i as f64 / n as f64;
            let _ = writeln!(text, "{time:e},{:e}", self.inflow.flow(time));
        }
        Ok(text)
    }
}

impl Inflow {
    /// The formula's flow at a time within the period, m³/s.
    pub fn flow(&self, time: f64) -> f64 {
        if time >= self.systole {
            return self.base;
        }
        let phase = std::f64::consts::PI * (time / self.systole).powf(self.exponent);
        self.base + self.amplitude * phase.sin().powi(2)
    }
}

fn read_curve(path: &Path, period: f64) -> Result<Vec<[f64; 2]>, CaseFilesError> {
    let wrong = |reason: String| CaseFilesError::Curve {
        path: path.to_owned(),
        reason,
    };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|e| wrong(e.to_string()))?;
    let header = reader.headers().map_err(|e| wrong(e.to_string()))?;
    if header.iter().collect::<Vec<_>>() != ["time_s", "flow_m3_s"] {
        return Err(wrong("the first line must be time_s,flow_m3_s".to_owned()));
    }
    let rows = reader
        .deserialize::<[f64; 2]>()
        .collect::<Result<Vec<_>, _>>()
        .map_err(|e| wrong(e.to_string()))?;
    if let Some(i) = rows
        .iter()
        .position(|row| !row.iter().all(|x| x.is_finite()))
    {
        return Err(wrong(format!("line {}: not a finite number", i + 2)));
    }
    if let Some(i) = rows.windows(2).position(|pair| pair[1][0] <= pair[0][0]) {
        return Err(wrong(format!("line {}: times must increase", i + 3)));
    }
    match (rows.first(), rows.last()) {
        (Some(first), Some(last))
            if first[0] == 0.0 && (last[0] - period).abs() <= 1e-9 * period =>
        {
            Ok(rows)
        }
        (Some(first), Some(last)) => Err(wrong(format!(
            "must cover one period, 0 to {period} s (time.period_s); found {} to {} s",
            first[0], last[0]
        ))),
        _ => Err(wrong("has no rows".to_owned())),
    }
}

/// The way from OpenFOAM to the driver.
#[derive(Debug, Clone, Copy)]
pub struct Connection<'a> {
    /// The adapter's library.
    pub library: Option<&'a Path>,
    /// `socket` or `files`.
    pub transport: &'a str,
    /// The socket, or the folder.
    pub address: &'a Path,
    /// Time from which to start, s; its folder must exist.
    pub start_time: f64,
}

impl Connection<'_> {
    /// Writes `system/fsiConnection`.
    pub fn write(&self, folder: &Path) -> Result<(), CaseFilesError> {
        let library = self
            .library
            .map_or(String::new(), |path| format!("\"{}\"", path.display()));
        let text = format!(
            "// The way to the driver; written by fsi-driver at each start\n\
             libs            ({library});\n\
             fsiTransport    {};\n\
             fsiAddress      \"{}\";\n\
             fsiDriver       {};\n\
             fsiStartTime    {};\n",
            self.transport,
            self.address.display(),
            std::process::id(),
            self.start_time,
        );
        write_file(&folder.join("system/fsiConnection"), &text)
    }
}

fn write_file(path: &Path, text: &str) -> Result<(), CaseFilesError> {
    fs::write(path, text).map_err(io_error("write", path))
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), CaseFilesError> {
    fs::create_dir_all(to).map_err(io_error("make", to))?;
    for entry in fs::read_dir(from).map_err(io_error("read", from))? {
        let entry = entry.map_err(io_error("read", from))?;
        let (source, target) = (entry.path(), to.join(entry.file_name()));
        if source.is_dir() {
            copy_folder(&source, &target)?;
        } else {
            fs::copy(&source, &target).map_err(io_error("copy", &source))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
