//! Writes an OpenFOAM case: copies the templates, and writes beside them the numbers of the case.
//!
//! The templates include two generated files, so they need no substitution of text and stay valid dictionaries:
//! `system/fsiParameters` (the physics) and `system/fsiConnection` (the way to the driver, new at every start).
//! The mesh is written by others.

use super::{own_case, probes, templates};
use crate::case::{Blood, Flag, FlowCurve, Ramp, Start, Time, VesselEnd, Windkessel};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{fs, io};

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
}

pub(super) fn io_error(
    action: &'static str,
    path: &Path,
) -> impl FnOnce(io::Error) -> CaseFilesError {
    let path = path.to_owned();
    move |source| CaseFilesError::Io {
        action,
        path,
        source,
    }
}

/// What is prescribed where the blood enters and leaves.
#[derive(Debug, Clone)]
pub enum Openings<'a> {
    /// Those of a vessel.
    Vessel {
        /// Flow at the inlet.
        inflow: FlowCurve,
        /// The outlet.
        windkessel: &'a Windkessel,
        /// How the wall comes under its pressure.
        start: Start,
        /// What holds the wall at the outlet.
        outlet_end: VesselEnd,
    },
    /// Those of the channel around a flag.
    Channel(&'a Flag),
}

/// The physics that OpenFOAM needs to know.
#[derive(Debug, Clone)]
pub struct CaseFiles<'a> {
    /// Folder of the templates.
    pub templates: &'a Path,
    /// The blood.
    pub blood: &'a Blood,
    /// What it flows through.
    pub openings: Openings<'a>,
    /// Smooth start.
    pub ramp: &'a Ramp,
    /// Time axis.
    pub time: &'a Time,
    /// MPI ranks.
    pub ranks: usize,
}

impl CaseFiles<'_> {
    /// Writes everything but `constant/polyMesh` into `folder`.
    pub fn write(&self, folder: &Path) -> Result<(), CaseFilesError> {
        templates::copy(self.templates, folder).map_err(|(action, path, source)| {
            CaseFilesError::Io {
                action,
                path,
                source,
            }
        })?;
        // ParaView opens the case by this name.
        write_file(&folder.join("fluid.foam"), "")?;
        write_file(&folder.join("system/fsiParameters"), &self.parameters())?;
        if let Openings::Vessel { inflow, .. } = &self.openings {
            write_file(&folder.join("constant/inflow.csv"), &self.curve(inflow))?;
        }
        write_file(&folder.join("system/fsiProbes"), &probes::dictionary(&[]))?;
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
        let entries: [(&str, f64, &str); 6] = [
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
            ("period", self.time.period, "s"),
            ("ranks", self.ranks as f64, "MPI ranks"),
        ];
        let openings = match &self.openings {
            Openings::Vessel {
                windkessel, start, ..
            } => vec![
                ("windkesselResistance", windkessel.resistance, "Pa s/m3"),
                ("windkesselCompliance", windkessel.compliance, "m3/Pa"),
                (
                    "windkesselPressure",
                    windkessel.initial_pressure,
                    "Pa, at t = 0, before the ramp",
                ),
                (
                    "pressureRampStart",
                    match start {
                        Start::Ramp => 0.0,
                        // It is over when time begins.
                        Start::Equilibrium => -2.0 * self.ramp.duration.max(NO_RAMP),
                    },
                    "s",
                ),
                (
                    "initialPressure",
                    match start {
                        Start::Ramp => 0.0,
                        Start::Equilibrium => windkessel.initial_pressure / self.blood.density,
                    },
                    "m2/s2, p/rho at t = 0",
                ),
            ],
            Openings::Channel(flag) => vec![
                ("channelHeight", flag.channel_height, "m"),
                ("meanVelocity", flag.mean_velocity, "m/s, at the inlet"),
                ("depth", flag.depth, "m, along z"),
            ],
        };
        let mut text = String::from("// Numbers of the case; written by fsi-driver, do not edit\n");
        for (name, value, unit) in entries.into_iter().chain(openings) {
            // `{:e}` is the shortest form that reads back as the same number
            let value = if name == "ranks" {
                format!("{value}")
            } else {
                format!("{value:e}")
            };
            let _ = writeln!(text, "{name:<23} {value}; // {unit}");
        }
        if let Openings::Vessel { outlet_end, .. } = self.openings {
            let motion = match outlet_end {
                VesselEnd::Clamped => "fixedValue",
                // The end of the wall stays in its plane, and so do the points of the outlet.
                VesselEnd::Sliding | VesselEnd::Radial => "slip",
                VesselEnd::Springs => "zeroGradient",
            };
            let _ = writeln!(
                text,
                "{:<23} {motion}; // of the mesh's points",
                "outletMotion"
            );
        }
        text
    }

    /// One period of the inflow as `time_s,flow_m3_s`; OpenFOAM interpolates linearly and repeats it.
    fn curve(&self, inflow: &FlowCurve) -> String {
        let mut text = String::from("time_s,flow_m3_s\n");
        for [time, flow] in inflow.samples(self.time.step) {
            let _ = writeln!(text, "{time:e},{flow:e}");
        }
        text
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
        let library = self.library.map(|path| path.display().to_string());
        let libraries = own_case::libraries(folder).into_iter().chain(library);
        let libraries: Vec<String> = libraries.map(|path| format!("\"{path}\"")).collect();
        let text = format!(
            "// The way to the driver; written by fsi-driver at each start\n\
             libs            ({});\n\
             fsiTransport    {};\n\
             fsiAddress      \"{}\";\n\
             fsiDriver       {};\n\
             fsiStartTime    {};\n\
             // Pressure and velocity at output.fluid_probes_m; before the adapter, which reports the finished step\n\
             functions {{ #include \"$FOAM_CASE/system/fsiProbes\" }}\n",
            libraries.join(" "),
            self.transport,
            self.address.display(),
            std::process::id(),
            self.start_time,
        );
        write_file(&folder.join("system/fsiConnection"), &text)
    }
}

pub(super) fn write_file(path: &Path, text: &str) -> Result<(), CaseFilesError> {
    fs::write(path, text).map_err(io_error("write", path))
}

#[cfg(test)]
mod tests;
