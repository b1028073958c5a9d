//! The table of all keys of a case, as the types that hold their values: names carry the unit, values are SI.

use super::schema::{Kind, above, from, whole};
use super::table::{choice, table, words};
use super::{Flag, templates};
use std::path::PathBuf;

table! {
    /// Everything a run is determined by.
    pub struct Case {
        [model: Model, "which of the models"]
        [geometry: Geometry, "sizes of the vessel"]
        [wall: Wall, "materials and inertia of the wall"]
        [blood: Blood, "the blood"]
        [inflow: Inflow, "flow at the inlet"]
        [windkessel: Windkessel, "two-element windkessel at the outlet"]
        [ramp: Ramp, "smooth start"]
        [time: Time, "time axis"]
        [structure: Structure, "discretization of the wall"]
        [fluid: Fluid, "discretization of the blood and the way to its solver"]
        [coupling: Coupling, "the coupling iteration"]
        [output: Output, "what is written and how often"]
        [flag: Option<Flag>, "a flag in a channel in place of the vessel"]
    }
}

table! {
    /// Upstream path and imperfection.
    pub struct Model {
        extension: Extension = "extension", Kind::Word(Extension::WORDS), "path of the rigid extension";
        d_max: f64 = "d_max_m", from(0.0, 0.1), "largest radius deviation of the imperfection";
    }
}

words! {
    /// Path of the rigid upstream extension.
    pub enum Extension {
        /// Models S.
        Straight = "straight",
        /// One turn of a helix: models H.
        Helix = "helix",
        /// A part of a circle: models A.
        Arc = "arc",
    }
}

table! {
    /// Sizes of the vessel, unloaded. The graft section starts at x = 0.
    pub struct Geometry {
        graft_length: f64 = "graft_length_m", above(0.0, 10.0), "length of the graft section";
        artery_length: f64 = "artery_length_m", above(0.0, 10.0), "length of the artery section";
        graft_inner_radius: f64 = "graft_inner_radius_m", above(0.0, 0.1), "inner radius of the graft";
        graft_thickness: f64 = "graft_thickness_m", above(0.0, 0.1), "wall thickness of the graft";
        artery_inner_radius: f64 = "artery_inner_radius_m", above(0.0, 0.1), "inner radius of the artery";
        media_thickness: f64 = "media_thickness_m", above(0.0, 0.1), "thickness of the media";
        adventitia_thickness: f64 = "adventitia_thickness_m", above(0.0, 0.1), "thickness of the adventitia";
        /// It blends the two cross-sections.
        blend_length: f64 = "blend_length_m", above(0.0, 10.0), "length of the cosine blend, centred on the joint";
        /// Along its centre-line.
        extension_length: f64 = "extension_length_m", from(0.0, 10.0), "length of the rigid extension, 0 for none";
        helix_radius: f64 = "helix_radius_m", above(0.0, 1.0), "radius of the helix";
        arc_angle_deg: f64 = "arc_angle_deg", above(0.0, 270.0), "angle that the arc turns through";
        /// Rows along x (first and last zero), columns around.
        imperfection: Vec<Vec<f64>> = "imperfection", Kind::Rows(100), "support values of the imperfection relative to model.d_max_m";
    }
}

table! {
    /// Materials and inertia of the wall.
    pub struct Wall {
        density: f64 = "density_kg_m3", above(0.0, 1e5), "density of the wall";
        damping: f64 = "damping_1_s", from(0.0, 1e4), "mass-proportional damping";
        [graft: Material, "the graft"]
        [media: Material, "the artery's inner layer"]
        [adventitia: Material, "the artery's outer layer"]
    }
}

/// Of shear moduli.
const SHEAR: Kind = above(0.0, 1e12);
/// Of bulk moduli and Young's.
const BULK: Kind = above(0.0, 1e13);

choice! {
    /// A hyperelastic material.
    pub enum Material by "material", "material of this part of the wall" {
        /// Neo-Hooke's: equation (4).
        NeoHooke = "neo_hooke" {
            mu: f64 = "mu_Pa", SHEAR, "shear modulus";
            kappa: f64 = "kappa_Pa", BULK, "bulk modulus";
        }
        /// Holzapfel, Gasser and Ogden's, with two families of fibres: equation (5).
        HolzapfelGasserOgden = "holzapfel_gasser_ogden" {
            mu: f64 = "mu_Pa", SHEAR, "shear modulus";
            kappa: f64 = "kappa_Pa", BULK, "bulk modulus";
            k1: f64 = "k1_Pa", from(0.0, 1e12), "stiffness of the fibres";
            k2: f64 = "k2", from(0.0, 1e4), "exponent of the fibres";
            fibre_angle_deg: f64 = "fibre_angle_deg", from(0.0, 90.0), "angle of the fibres from the circumferential direction";
            tension_only: bool = "tension_only", Kind::Flag, "fibres that carry no compression", absent "false";
        }
        /// Linear relation between Green-Lagrange strain and second Piola-Kirchhoff stress, for benchmarks.
        SaintVenantKirchhoff = "saint_venant_kirchhoff" {
            youngs_modulus: f64 = "youngs_modulus_Pa", BULK, "Young's modulus";
            poisson_ratio: f64 = "poisson_ratio", from(-0.99, 0.4999), "Poisson's ratio";
        }
    }
}

table! {
    /// The blood, a Newtonian fluid.
    pub struct Blood {
        density: f64 = "density_kg_m3", above(0.0, 1e5), "density of the blood";
        viscosity: f64 = "viscosity_Pa_s", above(0.0, 1e3), "dynamic viscosity of the blood";
    }
}

table! {
    /// Flow at the inlet: `base + amplitude sin²(pi (t/systole)^exponent)` for t < systole within a period, then `base`;
    /// or a curve from a CSV file with the columns `time_s,flow_m3_s` over one period.
    pub struct Inflow {
        base: f64 = "base_m3_s", from(-1.0, 1.0), "flow outside systole";
        amplitude: f64 = "amplitude_m3_s", from(-1.0, 1.0), "height of the pulse above the base";
        systole: f64 = "systole_s", above(0.0, 100.0), "duration of the pulse";
        exponent: f64 = "exponent", from(0.1, 10.0), "exponent that makes the rise faster than the fall";
        file: Option<PathBuf> = "file", Kind::Path, "CSV file with the columns time_s,flow_m3_s over one period",
            absent "the formula of the other keys";
    }
}

table! {
    /// `C dp/dt + p/R = Q` at the outlet.
    pub struct Windkessel {
        resistance: f64 = "resistance_Pa_s_m3", above(0.0, 1e15), "resistance R of the windkessel";
        compliance: f64 = "compliance_m3_Pa", above(0.0, 1.0), "compliance C of the windkessel";
        /// Before the ramp.
        initial_pressure: f64 = "initial_pressure_Pa", from(-1e6, 1e6), "pressure of the windkessel at t = 0";
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
        max_halvings: usize = "max_halvings", whole(0, 4), "how often the step may be halved where it fails";
        period: f64 = "period_s", above(0.0, 1e3), "duration of a beat";
    }
}

table! {
    /// Discretization of the wall.
    pub struct Structure {
        p: usize = "p", whole(3, 10), "degree of the trunk space; lower ones lock";
        p_geometry: Option<usize> = "p_geometry", whole(1, 10), "degree of the mapping", absent "structure.p";
        quadrature_points: Option<usize> = "quadrature_points", whole(3, 30), "Gauss points per direction",
            absent "structure.p + 1";
        formulation: Formulation = "formulation", Kind::Word(Formulation::WORDS),
            "volume ratio that the volumetric energy of the wall sees", absent "mixed";
        axial_per_section: usize = "axial_per_section", whole(1, 1000), "elements along each section";
        circumferential: usize = "circumferential", whole(3, 1000), "elements around";
        radial_per_layer: usize = "radial_per_layer", whole(1, 100), "elements through each layer";
        time_scheme: TimeScheme = "time_scheme", Kind::Word(TimeScheme::WORDS), "time integration of the wall",
            absent "newmark";
        newton_tolerance: f64 = "newton_tolerance", from(1e-14, 0.1), "relative residual at which Newton's method ends";
        newton_max_iterations: usize = "newton_max_iterations", whole(1, 1000), "most Newton iterations";
    }
}

words! {
    /// Which volume ratio the volumetric energy of the wall sees.
    #[derive(Default)]
    pub enum Formulation {
        /// Its projection onto a lower space in each element: no volumetric locking.
        Mixed = "mixed" (default),
        /// That of the displacement at every point: locks at low degrees.
        Displacement = "displacement",
    }
}

words! {
    /// How the wall's velocity and acceleration follow from its displacement.
    #[derive(Default)]
    pub enum TimeScheme {
        /// Newmark's method as the trapezoidal rule: second order, no numerical damping.
        Newmark = "newmark" (default),
        /// Newmark's method with `β = 0.3025`, `γ = 0.6`: first order, damps what changes from step to step.
        DampedNewmark = "damped_newmark",
        /// First order; damps what is not resolved, and some of what is.
        ImplicitEuler = "implicit_euler",
    }
}

table! {
    /// Discretization of the blood and the way to its solver.
    pub struct Fluid {
        solver: Solver = "solver", Kind::Word(Solver::WORDS), "who solves for the blood", absent "openfoam";
        templates: PathBuf = "templates", Kind::PathOr(templates::WORDS), "folder of the OpenFOAM dictionary templates";
        ranks: usize = "ranks", whole(1, 1024), "MPI ranks";
        transport: Transport = "transport", Kind::Word(Transport::WORDS), "way between driver and OpenFOAM";
        answer_limit: f64 = "answer_limit_s", above(0.0, 1e6), "longest time to wait for OpenFOAM's answer, or 50 times its longest so far";
        max_correctors: u32 = "max_correctors", whole(1, 1000), "most outer correctors in a coupling iteration";
        pressure_residual: f64 = "pressure_residual", above(0.0, 1.0), "first pressure residual that ends the correctors";
        [mesh: FluidMesh, "the O-grid"]
        [native: Native, "the driver's own elements"]
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
    }
}

table! {
    /// Spectral elements in the lumen: an O-grid as OpenFOAM's, of a few elements of high degree.
    pub struct Native {
        /// That of the pressure is one less.
        degree: usize = "degree", whole(3, 8), "degree of the velocity and of the elements' shape";
        /// Four times as many lie around the circumference.
        core: usize = "core", whole(1, 50), "elements along a side of the square in the middle";
        radial: usize = "radial", whole(1, 50), "elements from the square to the wall";
        axial_extension: usize = "axial_extension", whole(0, 1000), "elements along the extension";
        axial_per_section: usize = "axial_per_section", whole(1, 1000), "elements along each section";
        time_scheme: FluidTimeScheme = "time_scheme", Kind::Word(FluidTimeScheme::WORDS), "time integration of the blood";
    }
}

words! {
    /// How the time derivative of the blood's velocity is taken.
    pub enum FluidTimeScheme {
        /// First order, as with OpenFOAM.
        ImplicitEuler = "implicit_euler",
        /// Backward differences of second order.
        Bdf2 = "bdf2",
    }
}

words! {
    /// How the driver and OpenFOAM talk.
    pub enum Transport {
        /// A Unix-domain socket.
        Socket = "socket",
        /// Files in a folder, for debugging.
        Files = "files",
    }
}

table! {
    /// The O-grid of the lumen: a square in the middle, rings of cells around it.
    pub struct FluidMesh {
        /// Four times as many lie around the circumference.
        core: usize = "core", whole(2, 200), "cells along a side of the square in the middle";
        radial: usize = "radial", whole(1, 200), "cells from the square to the wall";
        wall_grading: f64 = "wall_grading", from(0.1, 100.0), "thickness of the innermost ring over that at the wall";
        axial_extension: usize = "axial_extension", whole(0, 10_000), "cells along the extension";
        axial_per_section: usize = "axial_per_section", whole(1, 10_000), "cells along each section";
    }
}

table! {
    /// The coupling iteration.
    pub struct Coupling {
        acceleration: AccelerationModel = "acceleration", Kind::Word(AccelerationModel::WORDS), "acceleration of the coupling";
        /// It answers for what the acceleration has not learnt.
        surrogate: Surrogate = "surrogate", Kind::Word(Surrogate::WORDS), "one-dimensional model behind the acceleration";
        /// Of the constant relaxation, and of the first iteration of the others.
        relaxation: Option<f64> = "relaxation", above(0.0, 1.0), "relaxation factor",
            absent "0.9 with a surrogate, 0.1 without";
        reuse_steps: usize = "reuse_steps", whole(0, 1000), "earlier steps whose columns are reused";
        /// Otherwise it is dropped.
        filter: f64 = "filter", from(0.0, 0.99), "share of a column that must be new";
        predictor: Extrapolation = "predictor", Kind::Word(Extrapolation::WORDS), "first trial of a step";
        criterion: ConvergenceQuantity = "criterion", Kind::Word(ConvergenceQuantity::WORDS), "what the limits are for", absent "change";
        e_rel: f64 = "e_rel", above(0.0, 0.1), "relative limit of the criterion";
        /// Root mean square over the points.
        e_abs: f64 = "e_abs_m", above(0.0, 1.0), "absolute limit of the criterion";
        /// A step that needs more stops the run.
        max_iterations: usize = "max_iterations", whole(1, 10_000), "most coupling iterations of a step";
    }
}

words! {
    /// What must be small for a coupling iteration to have converged.
    #[derive(Default)]
    pub enum ConvergenceQuantity {
        /// The change of the accelerated displacement: criterion (14).
        Change = "change" (default),
        /// The residual of the fixed point, by which most published numbers of iterations are counted.
        Residual = "residual",
    }
}

words! {
    /// A cheap model of both solvers.
    pub enum Surrogate {
        /// None: what is not known passes unchanged.
        None = "none",
        /// A one-dimensional tube with a prescribed inflow and the case's windkessel.
        Tube = "tube",
        /// A one-dimensional tube with prescribed pressures at both ends.
        OpenTube = "open_tube",
    }
}

words! {
    /// How the next trial displacement is found.
    pub enum AccelerationModel {
        /// Constant relaxation.
        Constant = "constant",
        /// Aitken's dynamic relaxation.
        Aitken = "aitken",
        /// Interface quasi-Newton: one least-squares fit of the columns of this and earlier steps.
        IqnLs = "iqn_ls",
        /// Interface quasi-Newton: the Jacobian of the earlier steps, updated by the columns of this one.
        MultiVector = "multi_vector",
        /// Interface quasi-Newton: the columns of this step first; earlier ones for what those do not span.
        Hybrid = "hybrid",
    }
}

words! {
    /// How accepted displacements are extrapolated to the next step of the same length; simplest first.
    pub enum Extrapolation {
        /// The last displacement.
        Constant = "constant",
        /// The line through the last two.
        Linear = "linear",
        /// The parabola through the last three.
        Quadratic = "quadratic",
        /// The parabola that fits the last five best: with Legendre's polynomials for equidistant points (Gram's).
        /// Where accepted displacements carry the scatter of the coupling tolerance it passes less of it on:
        /// `sqrt(sum w²)` is 2.1 against 4.4 for the parabola through three.
        LeastSquares = "least_squares",
    }
}

table! {
    /// What is written and how often.
    pub struct Output {
        title: Option<String> = "title", Kind::Text(100), "what pages and figures call the case",
            absent "the name of the run's folder, or of the case's where the run lies within it";
        structure_interval: f64 = "structure_interval_s", above(0.0, 1e4), "interval of the structure's files";
        fluid_interval: f64 = "fluid_interval_s", above(0.0, 1e4), "interval of the fluid's files";
        checkpoint_interval: f64 = "checkpoint_interval_min", from(0.0, 1e5),
            "wall-clock time between two checkpoints; 0: each step";
        wall_history: bool = "wall_history", Kind::Flag, "whether wall shear stress and displacement of each step are kept";
        window_start: Option<f64> = "window_start_s", from(0.0, 1e4), "start of the time window of the hemodynamics",
            absent "a period before the window's end";
        window_end: Option<f64> = "window_end_s", above(0.0, 1e4), "end of the time window of the hemodynamics",
            absent "time.end_s";
        probes: Vec<[f64; 3]> = "probes_m", Kind::Points(1000),
            "points of the unloaded lumen's surface whose motion and wall shear stress are recorded", absent "none";
        fluid_probes: Vec<[f64; 3]> = "fluid_probes_m", Kind::Points(1000),
            "points, fixed in space, where pressure and velocity of the blood are recorded", absent "none";
    }
}
