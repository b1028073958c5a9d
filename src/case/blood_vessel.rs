//! The keys of every case with a vessel: its shape and wall, what flows in and out, its surroundings, its meshes.

use super::schema::{KeyTable, Schema, ValueKind, above, from, whole};
use super::{
    Anastomosis, Case, FluidTimeScheme, Inflow, Inlet, OpeningKeys, Outlet, Problem, ProblemKind,
    RandomLumen, Solver, VesselDescription, WallMode, WallSupport, Windkessel,
};
use crate::{table, words};
use fsi_pfem::supports::{AtRest, Direction};
use serde::{Deserialize, Serialize};

table! {
    /// A vessel with blood that flows through. Its tables stand at the root of a file, and some of them hold keys that
    /// every case has as well.
    pub struct BloodVessel {
        [shape: Shape, "shape and materials"]
        [random_lumen: Option<RandomLumen>, "random deviation of the lumen's radius"]
        [inflow: Inflow, "flow at the inlet", only FLOW]
        [inlet: Option<Inlet>, "boundary condition at the inlet", only INLET]
        [windkessel: Windkessel, "windkessel at the outlet", only WINDKESSEL]
        [outlet: Option<Outlet>, "boundary condition at the outlet", only OUTLET]
        [opening: Option<Vec<OpeningKeys>>, "what is prescribed at an end, in place of the tables of inlet or outlet"]
        [structure: WallMesh, "mesh of the wall", only ELASTIC]
        [surroundings: Option<Surroundings>, "tissue around the vessel"]
        [ends: Option<VesselEnds>, "supports of the wall's ends"]
        [initial: Option<Initial>, "initial state of the wall"]
        [fluid: LumenMeshes, "meshes of the blood"]
    }
}

/// How a vessel is described.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// The paper's: a graft and an artery, end to end.
    Anastomosis(Anastomosis),
    /// Along any path, of any sections: the table `[vessel]`.
    Vessel(VesselDescription),
}

impl KeyTable for Shape {
    fn describe(_: &str, schema: &mut Schema) {
        schema.of_problems(&[ProblemKind::Anastomosis], |schema| {
            Anastomosis::describe("", schema);
        });
        schema.of_problems(&[ProblemKind::Vessel], |schema| {
            VesselDescription::describe("vessel", schema);
        });
    }
}

table! {
    /// Tissue around the vessel: springs, dampers and a pressure on the outer surface, per reference area. Where values
    /// vary along the vessel, they are given times a share at stations, linear in between.
    pub struct Surroundings {
        spring: Option<f64> = "spring_Pa_m", from(0.0, 1e15),
            "springs of the outer surface: force per reference area and displacement", absent "0";
        damping: Option<f64> = "damping_Pa_s_m", from(0.0, 1e12),
            "dampers of the outer surface: force per reference area and velocity", absent "0";
        direction: Option<TissueDirection> = "direction", ValueKind::Word(TissueDirection::WORDS),
            "direction of displacement that springs and dampers resist", absent "radial", only TISSUE;
        axial_spring: Option<f64> = "axial_spring_Pa_m", from(0.0, 1e15),
            "axial springs, in addition to radial ones", absent "0";
        axial_damping: Option<f64> = "axial_damping_Pa_s_m", from(0.0, 1e12),
            "axial dampers, in addition to radial ones", absent "0";
        at_rest: Option<GivenShape> = "at_rest", ValueKind::Word(GivenShape::WORDS),
            "state of the wall in which the springs carry no force; loaded is the given loaded shape, or else the initial equilibrium",
            absent "unloaded", only SPRINGS;
        pressure: Option<f64> = "pressure_Pa", from(-1e6, 1e6), "pressure on the deformed outer surface, at all times",
            absent "0";
        stations: Vec<f64> = "stations_m", ValueKind::Numbers(1000), "places along x where shares of these values are given",
            absent "none: the same everywhere", only STATIONS;
        shares: Vec<f64> = "shares", ValueKind::Numbers(1000), "shares of these values at surroundings.stations_m",
            absent "none: the same everywhere", only STATIONS;
    }
}

words! {
    /// Which displacement of the outer surface tissue resists.
    #[derive(Default)]
    pub enum TissueDirection {
        /// The distance from the vessel's axis.
        Radial = "radial" (default),
        /// The displacement along the vessel's axis.
        Axial = "axial",
        /// All components alike.
        All = "all",
    }
}

impl From<TissueDirection> for Direction {
    fn from(direction: TissueDirection) -> Self {
        match direction {
            TissueDirection::Radial => Self::Radial,
            TissueDirection::Axial => Self::Axial,
            TissueDirection::All => Self::All,
        }
    }
}

table! {
    /// What holds the ends of the deformable wall.
    pub struct VesselEnds {
        inlet: Option<InletEnd> = "inlet", ValueKind::Word(InletEnd::WORDS), "support of the wall at the inlet",
            absent "clamped";
        outlet: Option<VesselEnd> = "outlet", ValueKind::Word(VesselEnd::WORDS), "support of the wall at the outlet",
            absent "clamped";
        spring: Option<f64> = "spring_Pa_m", above(0.0, 1e15),
            "springs of an outlet on springs: force per area of the wall's end and displacement", absent "none";
    }
}

words! {
    /// What holds an end of the wall.
    #[derive(Default)]
    pub enum VesselEnd {
        /// No displacement.
        Clamped = "clamped" (default),
        /// The end slides in the plane of the cross-section, and its centre with it.
        Sliding = "sliding",
        /// Each point of the end slides along its radius.
        Radial = "radial",
        /// Springs in all directions.
        Springs = "springs",
    }
}

words! {
    /// What holds the end of the wall at the inlet. It moves only where the blood enters under a pressure: a flow is
    /// prescribed on an inlet at rest, and a rigid extension is fixed to the wall.
    #[derive(Default)]
    pub enum InletEnd {
        /// No displacement.
        Clamped = "clamped" (default),
        /// The end slides in the plane of the cross-section, and its centre with it.
        Sliding = "sliding",
        /// Each point of the end slides along its radius.
        Radial = "radial",
    }
}

table! {
    /// State of the wall at t = 0.
    pub struct Initial {
        start: Option<Start> = "start", ValueKind::Word(Start::WORDS), "how the wall is brought under its initial pressure", absent "ramp";
        axial_stretch: Option<f64> = "axial_stretch", from(0.8, 2.0),
            "length of the deformable part between its ends, relative to the unloaded one; the outlet is moved", absent "1";
        shape: Option<GivenShape> = "shape", ValueKind::Word(GivenShape::WORDS),
            "state of the wall that the given sizes describe", absent "unloaded";
        pressure: Option<f64> = "pressure_Pa", from(-1e6, 1e6), "internal pressure in the given loaded shape, that of the image",
            absent "the initial pressure, windkessel.initial_pressure_Pa or outlet.pressure_Pa";
        steps_before: Option<usize> = "steps_before", whole(10, 1000),
            "the blood begins as it is after a beat between walls at rest, computed natively in so many steps", absent "it begins at rest";
    }
}

words! {
    /// A state of the wall: that whose sizes are given, or in which tissue is at rest.
    #[derive(Default)]
    pub enum GivenShape {
        /// Free of stress.
        Unloaded = "unloaded" (default),
        /// Stretched and under pressure, as images show it.
        Loaded = "loaded",
    }
}

impl From<GivenShape> for AtRest {
    fn from(shape: GivenShape) -> Self {
        match shape {
            GivenShape::Unloaded => Self::Reference,
            GivenShape::Loaded => Self::Loaded,
        }
    }
}

words! {
    /// How the wall comes under its pressure.
    #[derive(Default)]
    pub enum Start {
        /// The run starts without internal pressure; inflow and outlet pressure are ramped.
        Ramp = "ramp" (default),
        /// The run starts in static equilibrium at `windkessel.initial_pressure_Pa`, or `outlet.pressure_Pa`; only the
        /// inlet is ramped.
        Equilibrium = "equilibrium",
    }
}

/// How the wall of a case is at t = 0, if it is not at rest in its unloaded shape.
#[derive(Debug, Clone, PartialEq)]
pub struct InitialWall {
    /// Pressure inside at t = 0, Pa.
    pub pressure: f64,
    /// The key that says it.
    pub key: String,
    /// Pressure inside in a given shape that is loaded, Pa.
    pub image_pressure: f64,
    /// The key that says that.
    pub key_of_image: String,
    /// State whose sizes are given, and its key.
    pub shape: GivenShape,
    /// The key that says it.
    pub key_of_shape: &'static str,
    /// Length relative to the unloaded one.
    pub stretch: f64,
    /// Whether the tissue is at rest in a loaded state.
    pub tissue_rests_loaded: bool,
}

impl Case {
    /// Stretch along the vessel of each piece of its wall before it is loaded, besides that by ends which are moved.
    pub fn prestretch(&self) -> f64 {
        let initial = self.own().and_then(|own| own.wall.initial.as_ref());
        initial.and_then(|keys| keys.axial_stretch).unwrap_or(1.0)
    }

    /// How its wall is at t = 0, if that is asked for.
    pub fn initial_wall(&self) -> Option<InitialWall> {
        match &self.problem {
            Problem::Vessel(vessel) => Some(vessel.initial_wall()),
            Problem::Flag(_) => None,
            Problem::UserCase(own) => {
                let keys = own.wall.initial.as_ref();
                let keys = keys.filter(|_| own.wall.mode() == WallMode::Elastic)?;
                let key = "wall.initial.pressure_Pa".to_owned();
                Some(InitialWall {
                    pressure: keys.pressure,
                    image_pressure: keys.pressure,
                    key_of_image: key.clone(),
                    key,
                    shape: keys.shape.unwrap_or(GivenShape::Loaded),
                    key_of_shape: "wall.initial.shape",
                    stretch: 1.0,
                    tissue_rests_loaded: (own.wall.support.iter().flatten())
                        .any(WallSupport::rests_loaded),
                })
            }
        }
    }
}

impl BloodVessel {
    /// How its wall is at t = 0.
    pub fn initial_wall(&self) -> InitialWall {
        let (_, key) = self.start_pressure();
        let key_of_image = match self.initial.as_ref().and_then(|initial| initial.pressure) {
            Some(_) => "initial.pressure_Pa".into(),
            None => key.clone(),
        };
        InitialWall {
            pressure: self.equilibrium_pressure(),
            key,
            image_pressure: self.image_pressure(),
            key_of_image,
            shape: self.given_shape(),
            key_of_shape: "initial.shape",
            stretch: self.axial_stretch(),
            tissue_rests_loaded: self.tissue_rests_loaded(),
        }
    }

    /// The paper's vessel, if it is one.
    pub fn anastomosis(&self) -> Option<&Anastomosis> {
        match &self.shape {
            Shape::Anastomosis(vessel) => Some(vessel),
            Shape::Vessel(_) => None,
        }
    }

    /// Whether all of its wall is rigid: only the flow is computed.
    pub fn is_rigid(&self) -> bool {
        match &self.shape {
            Shape::Anastomosis(_) => false,
            Shape::Vessel(vessel) => vessel.is_rigid(),
        }
    }

    /// How the wall comes under its pressure.
    pub fn start(&self) -> Start {
        let initial = self.initial.as_ref();
        initial
            .and_then(|initial| initial.start)
            .unwrap_or_default()
    }

    /// Length of the deformable part relative to the unloaded one.
    pub fn axial_stretch(&self) -> f64 {
        let initial = self.initial.as_ref();
        initial
            .and_then(|initial| initial.axial_stretch)
            .unwrap_or(1.0)
    }

    /// What holds the wall at the inlet.
    pub fn inlet_end(&self) -> InletEnd {
        let ends = self.ends.as_ref();
        ends.and_then(|ends| ends.inlet).unwrap_or_default()
    }

    /// What holds the wall at the outlet, and the stiffness of its springs (Pa/m).
    pub fn outlet_end(&self) -> (VesselEnd, f64) {
        self.ends.as_ref().map_or_else(Default::default, |ends| {
            let end = ends.outlet.unwrap_or_default();
            (end, ends.spring.unwrap_or_default())
        })
    }

    /// State of the wall whose sizes are given.
    pub fn given_shape(&self) -> GivenShape {
        let initial = self.initial.as_ref();
        initial
            .and_then(|initial| initial.shape)
            .unwrap_or_default()
    }

    /// Pressure (Pa) inside in a given shape that is loaded.
    pub fn image_pressure(&self) -> f64 {
        let given = self.initial.as_ref().and_then(|initial| initial.pressure);
        given.unwrap_or_else(|| self.equilibrium_pressure())
    }

    /// Whether the tissue is at rest in a loaded state of the wall.
    pub fn tissue_rests_loaded(&self) -> bool {
        let tissue = self.surroundings.as_ref();
        tissue.and_then(|tissue| tissue.at_rest) == Some(GivenShape::Loaded)
    }

    /// Arc lengths (m) and what of `value` acts there: a single place if it is the same everywhere.
    pub fn along(&self, value: Option<f64>) -> Vec<(f64, f64)> {
        let Some((surroundings, value)) = self.surroundings.as_ref().zip(value) else {
            return Vec::new();
        };
        if value == 0.0 {
            return Vec::new();
        }
        if surroundings.stations.is_empty() {
            return vec![(0.0, value)];
        }
        let pairs = surroundings.stations.iter().zip(&surroundings.shares);
        pairs.map(|(&x, share)| (x, share * value)).collect()
    }
}

table! {
    /// Mesh of the wall.
    pub struct WallMesh {
        axial_per_section: usize = "axial_per_section", whole(1, 1000), "elements along each section";
        circumferential: usize = "circumferential", whole(3, 1000), "elements around";
        radial_per_layer: usize = "radial_per_layer", whole(1, 100), "elements through each layer";
    }
}

table! {
    /// Meshes of the blood, for either solver.
    pub struct LumenMeshes {
        [mesh: FluidMesh, "the O-grid", only NOT_NATIVE]
        [native: Native, "the driver's own elements", only NATIVE_ELEMENTS]
    }
}

table! {
    /// The O-grid of the lumen: a square in the middle, rings of cells around it.
    pub struct FluidMesh {
        /// Four times as many lie around the circumference.
        core: usize = "core", whole(2, 200), "cells along a side of the square in the middle";
        radial: usize = "radial", whole(1, 200), "cells from the square to the wall";
        wall_grading: f64 = "wall_grading", from(0.1, 100.0), "thickness of the innermost ring over that at the wall";
        axial_extension: usize = "axial_extension", whole(0, 10_000), "cells along the extension", only EXTENDED;
        axial_per_section: usize = "axial_per_section", whole(1, 10_000), "cells along each section";
        rim_parts: Option<usize> = "rim_parts", whole(1, 20), "parts of each of the four cells next to a rim of the elastic wall", absent "1";
        motion: Option<MeshMotion> = "motion", ValueKind::Word(MeshMotion::WORDS), "how the points follow the wall", absent "blend", only COUPLED_MESH;
    }
}

words! {
    /// How the points of OpenFOAM's mesh follow the wall.
    #[derive(Default)]
    pub enum MeshMotion {
        /// By fixed shares of the displacement of the wall around them.
        Blend = "blend" (default),
        /// By Laplace's equation on the undeformed mesh.
        Laplace = "laplace",
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
        axial_extension: usize = "axial_extension", whole(0, 1000), "elements along the extension, more where it turns by more than 45° in one", only EXTENDED;
        axial_per_section: usize = "axial_per_section", whole(1, 1000), "elements along each section";
        time_scheme: Option<NativeTimeScheme> = "time_scheme", ValueKind::Word(NativeTimeScheme::WORDS),
            "time integration of the blood by the driver's own solver", absent "time.scheme";
    }
}

words! {
    /// How the driver's own solver takes time derivatives.
    pub enum NativeTimeScheme {
        /// First order.
        ImplicitEuler = "implicit_euler",
        /// Backward differences of second order.
        Bdf2 = "bdf2",
    }
}

impl Case {
    /// Steps of a beat between walls at rest before the run, if the blood does not begin at rest.
    pub fn steps_before(&self) -> Option<usize> {
        self.vessel()?.initial.as_ref()?.steps_before
    }

    /// How the fluid takes time derivatives: as its own key says, or that of the `time` axis.
    pub fn fluid_time_scheme(&self) -> FluidTimeScheme {
        let own = match (self.fluid.solver, self.tree(), self.vessel()) {
            (Solver::Native, Some(tree), _) => tree.elements().time_scheme,
            (Solver::Native, None, Some(vessel)) => vessel.fluid.native.time_scheme,
            _ => None,
        };
        match own {
            Some(NativeTimeScheme::ImplicitEuler) => FluidTimeScheme::ImplicitEuler,
            Some(NativeTimeScheme::Bdf2) => FluidTimeScheme::Bdf2,
            None => self.time.scheme,
        }
    }
}
