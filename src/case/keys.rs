//! The table of all keys of a case, as the types that hold their values: names carry the unit, values are SI.

use super::measured::MOST_POINTS;
use super::schema::{ValueKind, above, from, whole};
use super::table::choice;
use super::{Blood, Correlation, OutputMeasure, Problem, Uncertain, templates};
use crate::{table, words};
use fsi_coupling::acceleration::AccelerationModel;
use fsi_coupling::convergence::ConvergenceQuantity;
use fsi_coupling::predictor::Extrapolation;
use fsi_pfem::Formulation;
use fsi_pfem::element::surface::LoadKind;
use fsi_pfem::solution::time_scheme::TimeScheme;
pub use fsi_spectral::TimeScheme as FluidTimeScheme;
use std::path::PathBuf;

table! {
    /// Everything a run is determined by.
    pub struct Case {
        [problem: Problem, "what it is about, with the keys of that alone"]
        [wall: WallInertia, "inertia of the wall", only ELASTIC]
        [blood: Blood, "the blood"]
        [ramp: Ramp, "smooth start", only NOT_OWN]
        [time: Time, "time axis"]
        [structure: StructureSettings, "discretization of the wall", only ELASTIC]
        [fluid: FluidSettings, "discretization of the blood and the way to its solver"]
        [coupling: CouplingSettings, "the coupling iteration", only ELASTIC]
        [output: Output, "what is written and how often"]
        [uncertain: Option<Vec<Uncertain>>, "inputs of a study that are not known exactly"]
        [correlation: Option<Vec<Correlation>>, "uncertain inputs that depend on each other"]
    }
}

table! {
    /// Inertia of the wall.
    pub struct WallInertia {
        density: f64 = "density_kg_m3", above(0.0, 1e5), "density of the wall";
        damping: f64 = "damping_1_s", from(0.0, 1e4), "mass-proportional damping";
    }
}

/// Of shear moduli.
const SHEAR: ValueKind = above(0.0, 1e12);
/// Of bulk moduli and Young's.
const BULK: ValueKind = above(0.0, 1e13);
/// Of the viscosity of walls.
const VISCOSITY: ValueKind = from(0.0, 1e9);

choice! {
    /// A hyperelastic material.
    pub enum Material by "material", "material of this part of the wall" {
        /// Neo-Hooke's: equation (4).
        NeoHooke = "neo_hooke" {
            mu: f64 = "mu_Pa", SHEAR, "shear modulus";
            kappa: f64 = "kappa_Pa", BULK, "bulk parameter: Lamé's first, E nu/((1 + nu)(1 - 2 nu))";
            viscosity: Option<f64> = "viscosity_Pa_s", VISCOSITY,
                "viscous stress by rate of strain (Kelvin-Voigt)", absent "0";
        }
        /// Holzapfel, Gasser and Ogden's, with two families of fibres: equation (5).
        HolzapfelGasserOgden = "holzapfel_gasser_ogden" {
            mu: f64 = "mu_Pa", SHEAR, "shear modulus";
            kappa: f64 = "kappa_Pa", BULK, "bulk modulus";
            k1: f64 = "k1_Pa", from(0.0, 1e12), "stiffness of the fibres";
            k2: f64 = "k2", from(0.0, 1e4), "exponent of the fibres";
            fibre_angle_deg: f64 = "fibre_angle_deg", from(0.0, 90.0), "angle of the fibres from the circumferential direction";
            dispersion: Option<f64> = "dispersion", from(0.0, 1.0 / 3.0),
                "dispersion of the fibres about their angle, from 0 to 1/3 (none has a direction)", absent "0";
            tension_only: bool = "tension_only", ValueKind::Flag, "fibres that carry no compression", absent "false";
            viscosity: Option<f64> = "viscosity_Pa_s", VISCOSITY,
                "viscous stress by rate of strain (Kelvin-Voigt)", absent "0";
        }
        /// Linear relation between Green-Lagrange strain and second Piola-Kirchhoff stress, for benchmarks.
        SaintVenantKirchhoff = "saint_venant_kirchhoff" {
            youngs_modulus: f64 = "youngs_modulus_Pa", BULK, "Young's modulus";
            poisson_ratio: f64 = "poisson_ratio", from(-0.99, 0.4999), "Poisson's ratio";
            viscosity: Option<f64> = "viscosity_Pa_s", VISCOSITY,
                "viscous stress by rate of strain (Kelvin-Voigt)", absent "0";
        }
        /// Hooke's law between engineering strain and first Piola-Kirchhoff stress, for comparison with programs whose
        /// wall is linear: for small strains and rotations only.
        LinearElastic = "linear_elastic" {
            youngs_modulus: f64 = "youngs_modulus_Pa", BULK, "Young's modulus";
            poisson_ratio: f64 = "poisson_ratio", from(-0.99, 0.4999), "Poisson's ratio";
        }
    }
}

table! {
    /// Inflow and outlet pressure are multiplied by half a cosine from 0 to 1 over `duration`, then by 1.
    pub struct Ramp {
        duration: f64 = "duration_s", from(0.0, 100.0), "duration of the smooth start";
    }
}

table! {
    /// Time axis.
    pub struct Time {
        step: f64 = "step_s", above(0.0, 1.0), "time step";
        end: f64 = "end_s", above(0.0, 1e4), "end of the run";
        /// Flows and pressures at the openings, volume, displacement, mean wall shear of each region; the window of the
        /// hemodynamics is then the last whole beat.
        until_periodic: Option<f64> = "until_periodic", above(0.0, 0.1),
            "the run ends before time.end_s once a beat differs from the one before by less than this share",
            absent "none: the run goes on to time.end_s", only BEATS;
        /// OpenFOAM's through the templates, and that of the conditions at wall and outlet with it.
        scheme: FluidTimeScheme = "scheme", ValueKind::Word(FluidTimeScheme::WORDS), "time integration of the blood";
        max_halvings: usize = "max_halvings", whole(0, 4), "how often a failing step may be halved";
        period: f64 = "period_s", above(0.0, 1e3), "duration of a beat";
    }
}

table! {
    /// Discretization of the wall.
    pub struct StructureSettings {
        p: usize = "p", whole(3, 10), "degree of the trunk space; lower ones lock";
        p_geometry: Option<usize> = "p_geometry", whole(1, 10), "degree of the mapping", absent "structure.p";
        quadrature_points: Option<usize> = "quadrature_points", whole(3, 30), "Gauss points per direction",
            absent "structure.p + 1";
        formulation: Formulation = "formulation", ValueKind::Word(Formulation::WORDS),
            "volume ratio used in the wall's volumetric energy", absent "mixed";
        time_scheme: TimeScheme = "time_scheme", ValueKind::Word(TimeScheme::WORDS), "time integration of the wall",
            absent "newmark";
        load: LoadKind = "load", ValueKind::Word(LoadKind::WORDS), "area of the wall on which blood and surroundings press",
            absent "follower";
        newton_tolerance: f64 = "newton_tolerance", from(1e-14, 0.1), "relative residual at which Newton's method stops";
        newton_max_iterations: usize = "newton_max_iterations", whole(1, 1000), "most Newton iterations";
    }
}

table! {
    /// Discretization of the blood and the way to its solver.
    pub struct FluidSettings {
        solver: Solver = "solver", ValueKind::Word(Solver::WORDS), "solver for the blood",
            absent "external with fluid.command or fluid.await, otherwise openfoam";
        /// Files next to the one that names them are passed as absolute paths.
        command: Vec<String> = "command", ValueKind::Command(100), "a fluid solver of your own, with its arguments", absent "none", only EXTERNAL;
        is_awaited: bool = "await", ValueKind::Flag, "whether to wait for a fluid solver that is started separately", absent "false", only EXTERNAL;
        templates: PathBuf = "templates", ValueKind::PathOr(templates::WORDS), "folder of the OpenFOAM dictionary templates", only TEMPLATES;
        ranks: usize = "ranks", whole(1, 1024), "MPI ranks", only OPENFOAM;
        transport: TransportKind = "transport", ValueKind::Word(TransportKind::WORDS), "transport between driver and fluid", only NOT_NATIVE;
        answer_limit: f64 = "answer_limit_s", above(0.0, 1e6), "longest time to wait for the fluid's answer, or 50 times its longest so far", only NOT_NATIVE;
        max_correctors: u32 = "max_correctors", whole(1, 1000), "largest number of outer correctors in a coupling iteration", only NOT_NATIVE;
        pressure_residual: f64 = "pressure_residual", above(0.0, 1.0), "initial pressure residual at which the correctors stop", only NOT_NATIVE;
        convection: ConvectionScheme = "convection", ValueKind::Word(ConvectionScheme::WORDS),
            "how the blood's velocity is interpolated to the faces that carry it", absent "linear_upwind", only TEMPLATES;
    }
}

words! {
    /// How OpenFOAM interpolates the velocity that is convected.
    #[derive(Default)]
    pub enum ConvectionScheme {
        /// Upwind with the gradient: second order, smooths what few cells resolve.
        LinearUpwind = "linear_upwind" (default),
        /// Three quarters linear, one quarter linear_upwind: a quarter of its numerical diffusion, for jets.
        Lust = "lust",
        /// Between the two cells: no numerical diffusion, and wiggles where cells are too large.
        Linear = "linear",
    }
}

words! {
    /// Who solves for the blood.
    #[derive(Default)]
    pub enum Solver {
        /// OpenFOAM's pimpleFoam, by finite volumes.
        OpenFoam = "openfoam" (default),
        /// The driver itself, by spectral elements.
        Native = "native",
        /// Your own program, which speaks of-adapter/PROTOCOL.md.
        External = "external",
    }
}

impl Solver {
    /// Whether the blood is divided as `fluid.mesh` says; a user-supplied solver may follow it.
    pub fn has_cells(self) -> bool {
        self != Self::Native
    }

    /// What the blood is divided into.
    pub fn pieces(self) -> &'static str {
        match self {
            Self::OpenFoam => "cells",
            Self::Native => "elements",
            Self::External => "wet faces",
        }
    }
}

words! {
    /// How the driver and a fluid in a process of its own talk.
    pub enum TransportKind {
        /// A Unix-domain socket.
        Socket = "socket",
        /// Files in a folder, for debugging.
        Files = "files",
    }
}

table! {
    /// The coupling iteration.
    pub struct CouplingSettings {
        acceleration: AccelerationModel = "acceleration", ValueKind::Word(AccelerationModel::WORDS), "acceleration of the coupling";
        /// It answers for what the acceleration has not learnt.
        surrogate: SurrogateModel = "surrogate", ValueKind::Word(SurrogateModel::WORDS), "model of blood and wall that gives the acceleration its first Jacobian";
        /// Of the constant relaxation, and of the first iteration of the others.
        relaxation: Option<f64> = "relaxation", above(0.0, 1.0), "relaxation factor",
            absent "0.9 with a surrogate, 0.1 without";
        reuse_steps: usize = "reuse_steps", whole(0, 1000), "number of number of earlier steps whose columns are reused", only REMEMBERED;
        /// Otherwise it is dropped.
        filter: f64 = "filter", from(0.0, 0.99), "smallest independent share of a column", only REMEMBERED;
        predictor: Extrapolation = "predictor", ValueKind::Word(Extrapolation::WORDS), "first trial of a step";
        criterion: ConvergenceQuantity = "criterion", ValueKind::Word(ConvergenceQuantity::WORDS), "quantity to which the limits apply", absent "change";
        e_rel: f64 = "e_rel", above(0.0, 0.1), "relative limit of the criterion";
        /// Root mean square over the points.
        e_abs: f64 = "e_abs_m", above(0.0, 1.0), "absolute limit of the criterion";
        /// A step that needs more stops the run.
        max_iterations: usize = "max_iterations", whole(1, 10_000), "largest number of coupling iterations in a step";
    }
}

words! {
    /// A cheap model of both solvers.
    pub enum SurrogateModel {
        /// None: unknown components pass unchanged.
        None = "none",
        /// A one-dimensional tube with a prescribed inflow and the case's windkessel.
        Tube = "tube",
        /// A one-dimensional tube with prescribed pressures at both ends.
        OpenTube = "open_tube",
        /// Potential flow in the cells of a tree, with the openings of the case.
        Potential = "potential",
    }
}

table! {
    /// What is written and how often.
    pub struct Output {
        title: Option<String> = "title", ValueKind::Text(100), "name of the case on pages and in figures",
            absent "the name of the run's folder, or of the case's where the run lies within it";
        structure_interval: f64 = "structure_interval_s", above(0.0, 1e4), "interval of the structure's files";
        fluid_interval: f64 = "fluid_interval_s", above(0.0, 1e4), "interval of the fluid's files";
        checkpoint_interval: f64 = "checkpoint_interval_min", from(0.0, 1e5),
            "wall-clock time between two checkpoints; 0: each step";
        wall_history: bool = "wall_history", ValueKind::Flag, "whether wall shear stress and displacement of each step are kept";
        window_start: Option<f64> = "window_start_s", from(0.0, 1e4), "start of the time window of the hemodynamics",
            absent "a period before the window's end";
        window_end: Option<f64> = "window_end_s", above(0.0, 1e4), "end of the time window of the hemodynamics",
            absent "time.end_s";
        probes: Vec<[f64; 3]> = "probes_m", ValueKind::Points(MOST_POINTS),
            "points of the unloaded lumen's surface whose motion and wall shear stress are recorded", absent "none";
        fluid_probes: Vec<[f64; 3]> = "fluid_probes_m", ValueKind::Points(MOST_POINTS),
            "points, fixed in space, where pressure and velocity of the blood are recorded", absent "none";
        measured: Option<PathBuf> = "measured", ValueKind::Path,
            "file with what was measured in an experiment: its points are recorded too, for fsi-driver validate", absent "none";
        [section: Option<Vec<OutputSection>>, "cross-sections whose flow, pressure and area are recorded in sections.csv"]
        [measure: Option<Vec<OutputMeasure>>, "measures that a study of many runs has besides the usual ones"]
    }
}

table! {
    /// A cross-section that is watched: the closed line of edges of the fluid's faces nearest to it.
    pub struct OutputSection {
        name: String = "name", ValueKind::Text(30), "name of the cross-section";
        branch: Option<String> = "branch", ValueKind::Text(30), "branch of a tree, called as the opening at its end", absent "a vessel without branches";
        at: f64 = "at_m", from(-10.0, 10.0), "arc length along the branch, from the junction where it begins, or along the vessel's centre-line (x of a straight one)";
    }
}
