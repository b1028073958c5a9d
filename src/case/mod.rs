//! Reads and checks `case.toml`: model, materials, boundary conditions, numerics. Does not know how anything is solved.
//!
//! In the files every name carries its unit (`mu_Pa`, `time.step_s`); in these types all values are SI.
//!
//! A case is a stack of layers, and what lies on top counts: the file that `extends` names (all parameters with unit and
//! origin: `openfoam-case/defaults.toml`), the preset found there, the case's own values, `--set key=value`. A vessel of
//! your own is a folder anywhere with a file `case.toml`:
//! ```toml
//! extends = "/path/to/openfoam-case/defaults.toml"
//!
//! [geometry]
//! graft_inner_radius_m = 4.0e-3
//! artery_inner_radius_m = 3.0e-3
//! ```
//! ```
//! use fsi_driver::case::{Case, Preset};
//! # fn main() -> Result<(), fsi_driver::case::CaseErrors> {
//! let overrides = [("time.end_s".to_owned(), "0.5".to_owned())];
//! let case = Case::load("openfoam-case/S-0.25".as_ref(), Preset::Demo, &overrides)?;
//! assert_eq!((case.model.d_max, case.time.end), (0.25e-3, 0.5));
//! # Ok(())
//! # }
//! ```

mod check;
mod error;
mod estimate;
mod flag;
mod flow_curve;
pub(crate) mod keys;
mod load;
pub mod schema;
pub(crate) mod source;
pub(crate) mod spelling;
mod stack;
mod text_file;
pub(crate) mod value;
mod warnings;
mod window;
mod write;

pub use error::{CaseError, CaseErrors, Place};
pub use flag::{Flag, FlagMesh};
pub use flow_curve::{FlowCurve, FlowCurveError};
pub use load::{Preset, ResolvedCase};
pub use window::Window;

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Everything a run is determined by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// Which of the models.
    pub model: Model,
    /// Sizes of the vessel.
    pub geometry: Geometry,
    /// Materials and inertia of the wall.
    pub wall: Wall,
    /// The blood.
    pub blood: Blood,
    /// Flow at the inlet.
    pub inflow: Inflow,
    /// Two-element windkessel at the outlet.
    pub windkessel: Windkessel,
    /// Smooth start.
    pub ramp: Ramp,
    /// Time axis.
    pub time: Time,
    /// Discretization of the wall.
    pub structure: Structure,
    /// Discretization of the blood and the way to its solver.
    pub fluid: Fluid,
    /// The coupling iteration.
    pub coupling: Coupling,
    /// What is written and how often.
    pub output: Output,
    /// A flag in a channel in place of the vessel.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flag: Option<Flag>,
}

/// Upstream path and imperfection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Path of the rigid upstream extension.
    pub extension: Extension,
    /// Largest radius deviation of the imperfection, m.
    #[serde(rename = "d_max_m")]
    pub d_max: f64,
}

/// Path of the rigid upstream extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Extension {
    /// S
    Straight,
    /// H
    Helix,
    /// A
    Arc,
}

/// Sizes of the vessel, unloaded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// Length of the graft section, m; it starts at x = 0.
    #[serde(rename = "graft_length_m")]
    pub graft_length: f64,
    /// Length of the artery section, m.
    #[serde(rename = "artery_length_m")]
    pub artery_length: f64,
    /// Inner radius of the graft, m.
    #[serde(rename = "graft_inner_radius_m")]
    pub graft_inner_radius: f64,
    /// Wall thickness of the graft, m.
    #[serde(rename = "graft_thickness_m")]
    pub graft_thickness: f64,
    /// Inner radius of the artery, m.
    #[serde(rename = "artery_inner_radius_m")]
    pub artery_inner_radius: f64,
    /// Thickness of the media, m.
    #[serde(rename = "media_thickness_m")]
    pub media_thickness: f64,
    /// Thickness of the adventitia, m.
    #[serde(rename = "adventitia_thickness_m")]
    pub adventitia_thickness: f64,
    /// Length over which the two cross-sections are blended by a cosine, centred on the joint, m.
    #[serde(rename = "blend_length_m")]
    pub blend_length: f64,
    /// Length of the centre-line of the rigid extension, m.
    #[serde(rename = "extension_length_m")]
    pub extension_length: f64,
    /// Radius of the helix of model H, m (one turn).
    #[serde(rename = "helix_radius_m")]
    pub helix_radius: f64,
    /// Angle that the arc of model A turns through, degrees.
    pub arc_angle_deg: f64,
    /// Support values of the imperfection, relative to `d_max`: rows along x (first and last zero), columns around.
    pub imperfection: Vec<Vec<f64>>,
}

/// Materials and inertia of the wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Density, kg/m³.
    #[serde(rename = "density_kg_m3")]
    pub density: f64,
    /// Mass-proportional damping, 1/s.
    #[serde(rename = "damping_1_s")]
    pub damping: f64,
    /// The graft.
    pub graft: Material,
    /// The artery's inner layer.
    pub media: Material,
    /// The artery's outer layer.
    pub adventitia: Material,
}

/// A hyperelastic material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "material", rename_all = "snake_case", deny_unknown_fields)]
pub enum Material {
    /// Equation (4).
    NeoHooke {
        /// Shear modulus, Pa.
        #[serde(rename = "mu_Pa")]
        mu: f64,
        /// Bulk parameter, Pa.
        #[serde(rename = "kappa_Pa")]
        kappa: f64,
    },
    /// Equation (5).
    HolzapfelGasserOgden {
        /// Shear modulus of the ground substance, Pa.
        #[serde(rename = "mu_Pa")]
        mu: f64,
        /// Bulk modulus, Pa.
        #[serde(rename = "kappa_Pa")]
        kappa: f64,
        /// Stiffness of the fibres, Pa.
        #[serde(rename = "k1_Pa")]
        k1: f64,
        /// Exponent of the fibres.
        k2: f64,
        /// Angle of the two fibre families from the circumferential direction, degrees.
        fibre_angle_deg: f64,
        /// Fibres that carry no compression; the paper has no such switch.
        #[serde(default)]
        tension_only: bool,
    },
    /// Linear relation between Green-Lagrange strain and second Piola-Kirchhoff stress, for benchmarks.
    SaintVenantKirchhoff {
        /// Young's modulus, Pa.
        #[serde(rename = "youngs_modulus_Pa")]
        youngs_modulus: f64,
        /// Poisson's ratio.
        poisson_ratio: f64,
    },
}

/// The blood, a Newtonian fluid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Blood {
    /// Density, kg/m³.
    #[serde(rename = "density_kg_m3")]
    pub density: f64,
    /// Dynamic viscosity, Pa s.
    #[serde(rename = "viscosity_Pa_s")]
    pub viscosity: f64,
}

/// Flow at the inlet: `base + amplitude sin²(pi (t/systole)^exponent)` for t < systole within a period, then `base`;
/// or a curve from a CSV file with the columns `time_s,flow_m3_s` over one period.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inflow {
    /// Flow outside systole, m³/s.
    #[serde(rename = "base_m3_s")]
    pub base: f64,
    /// Height of the pulse above the base, m³/s.
    #[serde(rename = "amplitude_m3_s")]
    pub amplitude: f64,
    /// Duration of the pulse, s.
    #[serde(rename = "systole_s")]
    pub systole: f64,
    /// Exponent that makes the rise faster than the fall.
    pub exponent: f64,
    /// A curve of the user's own, used in place of the formula.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
}

/// `C dp/dt + p/R = Q` at the outlet.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Windkessel {
    /// R, Pa s/m³.
    #[serde(rename = "resistance_Pa_s_m3")]
    pub resistance: f64,
    /// C, m³/Pa.
    #[serde(rename = "compliance_m3_Pa")]
    pub compliance: f64,
    /// Pressure at t = 0 (before the ramp), Pa.
    #[serde(rename = "initial_pressure_Pa")]
    pub initial_pressure: f64,
}

/// Inflow and outlet pressure are multiplied by half a cosine from 0 to 1 over `duration`, then by 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ramp {
    /// Duration, s.
    #[serde(rename = "duration_s")]
    pub duration: f64,
}

/// Time axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// Time step, s.
    #[serde(rename = "step_s")]
    pub step: f64,
    /// End of the run, s.
    #[serde(rename = "end_s")]
    pub end: f64,
    /// Duration of a beat, s.
    #[serde(rename = "period_s")]
    pub period: f64,
    /// How often the time step may be halved, for a while, where it fails.
    pub max_halvings: usize,
}

/// Discretization of the wall.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Structure {
    /// Polynomial degree of the trunk space.
    pub p: usize,
    /// Polynomial degree of the mapping; `p` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_geometry: Option<usize>,
    /// Gauss points per direction; `p + 1` if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quadrature_points: Option<usize>,
    /// Elements along the graft, and as many along the artery.
    pub axial_per_section: usize,
    /// Elements around the circumference.
    pub circumferential: usize,
    /// Elements through each of the two layers.
    pub radial_per_layer: usize,
    /// Time integration.
    #[serde(default)]
    pub time_scheme: TimeScheme,
    /// Relative residual at which Newton's method ends.
    pub newton_tolerance: f64,
    /// Most Newton iterations of a solution.
    pub newton_max_iterations: usize,
}

/// How the wall's velocity and acceleration follow from its displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeScheme {
    /// Newmark's method as the trapezoidal rule: second order, no numerical damping.
    #[default]
    Newmark,
    /// Newmark's method with `β = 0.3025`, `γ = 0.6`: first order, damps what changes from step to step.
    DampedNewmark,
    /// First order; damps what is not resolved, and some of what is.
    ImplicitEuler,
}

/// Discretization of the blood and the way to its solver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Folder of the OpenFOAM dictionary templates.
    pub templates: PathBuf,
    /// MPI ranks.
    pub ranks: usize,
    /// How the driver and OpenFOAM talk.
    pub transport: Transport,
    /// Longest time to wait for an answer, s.
    #[serde(rename = "answer_limit_s")]
    pub answer_limit: f64,
    /// Most outer correctors per coupling iteration.
    pub max_correctors: u32,
    /// A coupling iteration ends earlier once the first pressure residual is below this.
    pub pressure_residual: f64,
    /// The O-grid.
    pub mesh: FluidMesh,
}

/// How the driver and OpenFOAM talk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Transport {
    /// A Unix-domain socket.
    Socket,
    /// Files in a folder.
    Files,
}

/// The O-grid of the lumen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FluidMesh {
    /// Cells along a side of the central square; four times as many lie around the circumference.
    pub core: usize,
    /// Cells from the square to the wall.
    pub radial: usize,
    /// Thickness of the innermost of these cells over that of the cell at the wall.
    pub wall_grading: f64,
    /// Cells along the rigid extension.
    pub axial_extension: usize,
    /// Cells along the graft, and as many along the artery.
    pub axial_per_section: usize,
}

/// The coupling iteration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Coupling {
    /// How the next trial displacement is found.
    pub acceleration: Acceleration,
    /// Cheap model of both solvers that answers for what the acceleration has not learnt.
    pub surrogate: Surrogate,
    /// Relaxation factor: of the constant relaxation, and of the first iteration of the others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relaxation: Option<f64>,
    /// Columns of this many earlier steps are reused by IQN-LS.
    pub reuse_steps: usize,
    /// A column is dropped if less than this share of it is new.
    pub filter: f64,
    /// Degree of the extrapolation in time that gives the first trial.
    pub predictor: Predictor,
    /// What the limits are for.
    #[serde(default)]
    pub criterion: Criterion,
    /// Relative limit of the criterion.
    pub e_rel: f64,
    /// Absolute limit of the criterion, m, root mean square over the points.
    #[serde(rename = "e_abs_m")]
    pub e_abs: f64,
    /// A step that needs more iterations stops the run.
    pub max_iterations: usize,
}

impl Coupling {
    /// The relaxation factor that was given, or a good one: a surrogate knows how far to go, but not exactly.
    pub fn relaxation(&self) -> f64 {
        self.relaxation.unwrap_or(match self.surrogate {
            Surrogate::None => 0.1,
            Surrogate::Tube | Surrogate::OpenTube => 0.9,
        })
    }
}

/// What must be small for a coupling iteration to have converged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// The change of the accelerated displacement: criterion (14).
    #[default]
    Change,
    /// The residual of the fixed point, by which most published numbers of iterations are counted.
    Residual,
}

/// A cheap model of both solvers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Surrogate {
    /// None: what is not known passes unchanged.
    None,
    /// A one-dimensional tube with a prescribed inflow and the case's windkessel.
    Tube,
    /// A one-dimensional tube with prescribed pressures at both ends.
    OpenTube,
}

/// How the next trial displacement is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Acceleration {
    /// Constant relaxation.
    Constant,
    /// Aitken's dynamic relaxation.
    Aitken,
    /// Interface quasi-Newton: one least-squares fit of the columns of this and earlier steps.
    IqnLs,
    /// Interface quasi-Newton: the Jacobian of the earlier steps, updated by the columns of this one.
    MultiVector,
    /// Interface quasi-Newton: the columns of this step first; earlier ones for what those do not span.
    Hybrid,
}

/// How accepted displacements are extrapolated to the next step of the same length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Predictor {
    /// The last displacement.
    Constant,
    /// The line through the last two.
    Linear,
    /// The parabola through the last three.
    Quadratic,
    /// The parabola that fits the last five best: with Legendre's polynomials for equidistant points (Gram's). Where
    /// accepted displacements carry the scatter of the coupling tolerance it passes less of it on: `sqrt(sum w²)` is
    /// 2.1 against 4.4 for the parabola through three.
    LeastSquares,
}

/// What is written and how often.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Interval of the structure's VTU files, s.
    #[serde(rename = "structure_interval_s")]
    pub structure_interval: f64,
    /// Interval of OpenFOAM's written times, s.
    #[serde(rename = "fluid_interval_s")]
    pub fluid_interval: f64,
    /// Wall-clock time between two checkpoints, minutes; 0 writes one after each step.
    #[serde(rename = "checkpoint_interval_min")]
    pub checkpoint_interval: f64,
    /// Whether wall shear stress and displacement of each step are kept.
    pub wall_history: bool,
    /// Start of the window over which the hemodynamics are averaged, s; a period before its end if absent.
    #[serde(
        rename = "window_start_s",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub window_start: Option<f64>,
    /// Its end, s; the end of the run if absent.
    #[serde(
        rename = "window_end_s",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub window_end: Option<f64>,
    /// Points (m) of the unloaded lumen's surface whose displacement is written for every step.
    #[serde(rename = "probes_m", default, skip_serializing_if = "Vec::is_empty")]
    pub probes: Vec<[f64; 3]>,
}
