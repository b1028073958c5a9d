//! Writes an OpenFOAM case: copies the templates, and writes next to them the numbers of the case.
//!
//! The templates include two generated files, so they need no substitution of text and stay valid dictionaries:
//! `system/fsiParameters` (the physics) and `system/fsiConnection` (the way to the driver, new at every start).
//! The mesh is written by others.

pub use self::openings::{PatchMotion, VesselOpenings};
pub use super::write_file::CaseFilesError;

use super::connection::Connection;
use super::names::{CONVECTION, INITIAL_VELOCITY, OPENINGS, TIME_DERIVATIVE, WALLS};
use super::write_file::{io_error, write_file};
use super::{probes, templates};
use crate::Vec3;
use crate::case::{Blood, ConvectionScheme, Flag, FluidTimeScheme, Ramp, Rheology, Time};
use crate::geometry::MotionBlend;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// A ramp of no duration, s.
const NO_RAMP: f64 = 1e-9;
/// From this non-orthogonality (degrees) on the part of a gradient that is not along the line between two cells is
/// limited and corrected for twice: in the steep expansion of the FDA's nozzle flow diverges otherwise, with 56°
/// (78,400 cells) and with 44.5° (237,440 cells; with 100,700 it did not). The paper's vessels have less.
const STEEP_DEG: f64 = 40.0;

/// From this diffusion number on the pressure's corrections leave out only what neighbours do not follow (`consistent`,
/// SIMPLEC). In the usual ones a smooth error of the pressure comes back from each outer corrector times the diffusion
/// number. Elastic walls, S-0.25 with dt = 2 ms: it converges with 0.18 (30,240 cells), takes 7.9 correctors per step
/// instead of 6.3 with 0.53 (199,680), and diverges with 1.58 (1,003,860). Rigid walls, a stenosis of 75 %: it takes 5
/// to 7 correctors per step instead of 1 or 2 with 0.83, and diverges with 1.55.
const DIFFUSIVE: f64 = 0.4;

/// What is prescribed where the blood enters and leaves.
#[derive(Debug, Clone)]
pub enum Openings<'a> {
    /// Those of a vessel.
    Vessel(VesselOpenings),
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
    /// Patches of the elastic wall.
    pub walls: Vec<&'a str>,
    /// Smooth start.
    pub ramp: &'a Ramp,
    /// Time axis.
    pub time: &'a Time,
    /// How the convected velocity is interpolated.
    pub convection: ConvectionScheme,
    /// MPI ranks.
    pub ranks: usize,
    /// Largest non-orthogonality of the mesh at rest, degrees.
    pub non_orthogonality_deg: f64,
    /// Diffusion number `ν dt/h²` of the mesh at rest: kinematic viscosity times time step times the mean diagonal of
    /// Laplace's operator.
    pub diffusion_number: f64,
    /// How the points of the mesh follow its wall; by Laplace's equation if not by shares.
    pub blend: Option<MotionBlend>,
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
        if let Openings::Vessel(openings) = &self.openings {
            let at = folder.join("system/fsiOpenings");
            fs::create_dir_all(&at).map_err(io_error("make", &at))?;
            for (name, text) in openings.conditions(self.ramp_duration(), self.blood.density) {
                write_file(&folder.join(name), &text)?;
            }
            for (name, text) in openings.files(self.time.step) {
                // The curve is called so in templates that do not include these conditions.
                if name == "inletFlow" && !self.includes_openings() {
                    write_file(&folder.join("constant/inflow"), &text)?;
                }
                write_file(&folder.join("constant").join(name), &text)?;
            }
        }
        if let Some(blend) = &self.blend {
            write_file(&folder.join("constant/fsiMotionBlend"), &file_of(blend))?;
        }
        write_file(&folder.join("system/fsiProbes"), &probes::dictionary(&[]))?;
        Connection::none().write(folder)
    }

    fn ramp_duration(&self) -> f64 {
        self.ramp.duration.max(NO_RAMP)
    }

    /// Whether the fields leave the openings to what is written of them.
    fn includes_openings(&self) -> bool {
        templates::without_openings(self.templates).is_empty()
    }

    /// OpenFOAM's word for the blood's model, and the parameters of that, all by density.
    fn transport_model(&self) -> (&'static str, Vec<(&'static str, f64, &'static str)>) {
        let kinematic = |name, viscosity: f64| (name, viscosity / self.blood.density, "m2/s");
        let rest = |viscosity| kinematic("zeroShearViscosity", viscosity);
        match self.blood.rheology() {
            Rheology::Newtonian { .. } => ("Newtonian", Vec::new()),
            Rheology::CarreauYasuda {
                at_rest,
                time,
                n,
                a,
                ..
            } => (
                "BirdCarreau",
                vec![
                    rest(at_rest),
                    ("relaxationTime", time, "s"),
                    ("shearExponent", n, "1"),
                    ("yasudaExponent", a, "1"),
                ],
            ),
            Rheology::Casson {
                at_rest,
                yield_stress,
                ..
            } => {
                let stress = yield_stress / self.blood.density;
                (
                    "Casson",
                    vec![rest(at_rest), ("kinematicYieldStress", stress, "m2/s2")],
                )
            }
            Rheology::PowerLaw { at_rest, k, n, .. } => (
                "powerLaw",
                vec![
                    rest(at_rest),
                    kinematic("kinematicConsistency", k),
                    ("shearExponent", n, "1"),
                ],
            ),
        }
    }

    fn parameters(&self) -> String {
        let mut text = String::from("// Numbers of the case; written by fsi-driver, do not edit\n");
        let (model, of_blood) = self.transport_model();
        for (name, value, unit) in self.numbers().into_iter().chain(of_blood) {
            // `{:e}` is the shortest form that reads back as the same number
            let value = match name {
                "ranks" => format!("{value}"),
                _ => format!("{value:e}"),
            };
            text += &format!("{name:<23} {value}; // {unit}\n");
        }
        let mut word = |name: &str, value: &str| text += &format!("{name:<23} {value};\n");
        word("transportModel", model);
        word(
            "meshMotion",
            match self.blend {
                Some(_) => "blendedFromWall",
                None => "referenceLaplacian",
            },
        );
        word(
            TIME_DERIVATIVE,
            match self.time.scheme {
                FluidTimeScheme::ImplicitEuler => "Euler",
                FluidTimeScheme::Bdf2 => "backward",
            },
        );
        word(
            CONVECTION,
            match self.convection {
                ConvectionScheme::LinearUpwind => "linearUpwind grad(U)",
                ConvectionScheme::Lust => "LUST grad(U)",
                ConvectionScheme::Linear => "linear",
            },
        );
        let (gradient, correctors) = match self.non_orthogonality_deg < STEEP_DEG {
            true => ("corrected", "0"),
            false => ("limited corrected 0.33", "2"),
        };
        word("normalGradient", gradient);
        word("nonOrthogonalCorrectors", correctors);
        let consistent = match self.diffusion_number < DIFFUSIVE {
            true => "no",
            false => "yes",
        };
        text += &format!(
            "{:<23} {consistent}; // diffusion number {:.2}\n",
            "consistentPressure", self.diffusion_number
        );
        let names: Vec<&str> = match &self.openings {
            Openings::Vessel(openings) => openings.names().collect(),
            Openings::Channel(_) => vec!["inlet", "outlet"],
        };
        text += &format!("{OPENINGS:<23} ({});\n", names.join(" "));
        text += &format!("{WALLS:<23} ({});\n", self.walls.join(" "));
        if let Openings::Vessel(openings) = &self.openings
            && !self.includes_openings()
        {
            text += &openings.earlier_parameters(self.ramp_duration());
        }
        text
    }

    /// Numbers by name, with their units.
    fn numbers(&self) -> Vec<(&'static str, f64, &'static str)> {
        let (density, viscosity) = (self.blood.density, self.blood.viscosity);
        let ramp = self.ramp_duration();
        let mut numbers = vec![
            ("density", density, "kg/m3"),
            ("kinematicViscosity", viscosity / density, "m2/s"),
            ("timeStep", self.time.step, "s"),
            ("rampDuration", ramp, "s, of inflow and outlet pressure"),
            ("period", self.time.period, "s"),
            ("ranks", self.ranks as f64, "MPI ranks"),
        ];
        match &self.openings {
            Openings::Vessel(openings) => {
                let pressure = openings.initial_pressure() / density;
                numbers.push(("initialPressure", pressure, "m2/s2, p/rho at t = 0"));
            }
            Openings::Channel(flag) => numbers.extend([
                ("channelHeight", flag.channel_height, "m"),
                ("meanVelocity", flag.mean_velocity, "m/s, at the inlet"),
                ("depth", flag.depth, "m, along z"),
            ]),
        }
        numbers
    }
}

/// Writes the velocities (m/s) of the cells with which the blood begins, where `0/U` looks for them.
///
/// # Errors
/// If the file cannot be written.
pub fn write_velocities(velocities: &[Vec3], folder: &Path) -> Result<(), CaseFilesError> {
    let mut text = format!(
        "// The blood at t = 0; written by fsi-driver\ninternalField nonuniform List<vector>\n{}\n(\n",
        velocities.len()
    );
    for u in velocities {
        let _ = writeln!(text, "({:e} {:e} {:e})", u.x, u.y, u.z);
    }
    write_file(&folder.join(INITIAL_VELOCITY), &(text + ")\n;\n"))
}

/// Two lists for the adapter (`blendedMotionSolver`): points of each ring; for each point of the mesh its ring and
/// points of that, with their shares.
fn file_of(blend: &MotionBlend) -> String {
    let mut text = format!(
        "// How points follow the wall; written by fsi-driver, do not edit\n{}\n(\n",
        blend.rings.len()
    );
    let list = |items: &mut dyn Iterator<Item = String>| {
        let items: Vec<String> = items.collect();
        format!("{}({})", items.len(), items.join(" "))
    };
    for ring in &blend.rings {
        text += &list(&mut ring.iter().map(usize::to_string));
        text.push('\n');
    }
    let _ = write!(text, ")\n{}\n(\n", blend.points.len());
    for (ring, shares) in &blend.points {
        let points = shares.iter().map(|(place, _)| blend.rings[*ring][*place]);
        let labels = list(&mut [*ring].into_iter().chain(points).map(|i| i.to_string()));
        let shares = list(&mut shares.iter().map(|(_, share)| format!("{share:e}")));
        let _ = writeln!(text, "({labels} {shares})");
    }
    text + ")\n"
}

mod earlier;
mod openings;

#[cfg(test)]
mod tests;
