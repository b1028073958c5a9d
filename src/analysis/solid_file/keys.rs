//! The table of all keys of the file of `fsi-driver solid`, as the types that hold their values.

use crate::analysis::tube::TubeEnds;
use crate::case::Material;
use crate::case::schema::{Key, KeyTable, Schema, ValueKind, above, from, join, whole};
use crate::case::table;
use crate::pfem::element::surface::LoadKind;
use crate::pfem::solution::stability::AtBifurcation;
use crate::pfem::{Formulation, SpaceKind};
use serde::{Deserialize, Serialize};

/// Largest degree of the shape functions.
const MAX_DEGREE: i64 = 12;

table! {
    /// The file.
    pub struct Keys {
        [tube: TubeKeys, "the unloaded tube"]
        [mesh: Mesh, "numbers of elements"]
        [space: Space, "the ansatz"]
        [load: Load, "the pressure inside"]
        [supports: Option<Supports>, "what holds the ends"]
        [outside: Option<Outside>, "what surrounds the tube"]
        [dynamics: Option<Dynamics>, "the load over time"]
    }
}

table! {
    /// The unloaded tube.
    pub struct TubeKeys {
        inner_radius: f64 = "inner_radius_m", above(0.0, 10.0), "inner radius of the unloaded tube";
        length: f64 = "length_m", above(0.0, 100.0), "length of the tube";
        [layer: Vec<Layer>, "the layers from the inside out"]
    }
}

/// A layer: its thickness next to the keys of its material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Layer {
    /// `thickness_m`.
    #[serde(rename = "thickness_m")]
    pub thickness: f64,
    /// The others.
    #[serde(flatten)]
    pub material: Material,
}

impl KeyTable for Layer {
    fn describe(path: &str, schema: &mut Schema) {
        schema.add(Key {
            path: join(path, "thickness_m"),
            kind: above(0.0, 10.0),
            absent: None,
            about: "thickness of this layer",
            choices: Vec::new(),
            problems: &[],
            only: Vec::new(),
        });
        Material::describe(path, schema);
    }
}

table! {
    /// Numbers of elements.
    pub struct Mesh {
        axial: usize = "axial", whole(1, 1000), "elements along the axis";
        circumferential: usize = "circumferential", whole(3, 1000), "elements around the circumference";
        radial_per_layer: usize = "radial_per_layer", whole(1, 100), "elements through each layer";
    }
}

table! {
    /// The ansatz.
    pub struct Space {
        kind: SpaceKind = "kind", ValueKind::Word(SpaceKind::WORDS), "ansatz space";
        p: [usize; 3] = "p", ValueKind::Degrees(1, MAX_DEGREE),
            "degree of the shape functions; of three: axial, circumferential, thickness";
        p_geometry: Option<toml::Value> = "p_geometry", ValueKind::WholeOr(1, MAX_DEGREE, "exact"),
            "degree of the mapping along the edges", absent "the largest of space.p";
        quadrature_points: Option<usize> = "quadrature_points", whole(2, 30), "Gauss points per direction",
            absent "space.p + 2 in each direction";
        formulation: Formulation = "formulation", ValueKind::Word(Formulation::WORDS),
            "volume ratio used in the wall's volumetric energy", absent "mixed";
    }
}

table! {
    /// The pressure inside.
    pub struct Load {
        pressure: f64 = "pressure_Pa", from(-1e9, 1e9), "pressure inside the tube";
        kind: LoadKind = "kind", ValueKind::Word(LoadKind::WORDS), "load on the deformed or on the reference area";
        steps: Option<usize> = "steps", whole(1, 10_000), "load steps to begin with", absent "10";
        at_bifurcation: Option<AtBifurcation> = "at_bifurcation", ValueKind::Word(AtBifurcation::WORDS),
            "what to do where the tube loses its stability", absent "stop";
    }
}

table! {
    /// What holds the tube.
    pub struct Supports {
        ends: TubeEnds = "ends", ValueKind::Word(TubeEnds::WORDS), "what holds both ends", absent "axial";
        spring: Option<f64> = "spring_Pa_m", above(0.0, 1e15),
            "springs of ends on springs: force per area of the end and displacement", absent "none";
        axial_stretch: Option<f64> = "axial_stretch", from(0.5, 3.0),
            "length between the ends relative to the unloaded one; they are moved apart and then held", absent "1";
    }
}

table! {
    /// What surrounds the tube.
    pub struct Outside {
        spring: Option<f64> = "spring_Pa_m", from(0.0, 1e15),
            "radial springs of the outer surface: force per reference area and displacement", absent "0";
        damping: Option<f64> = "damping_Pa_s_m", from(0.0, 1e12),
            "radial dampers of the outer surface: force per reference area and velocity", absent "0";
        pressure: Option<f64> = "pressure_Pa", from(-1e9, 1e9),
            "pressure outside, on the area that load.kind names", absent "0";
    }
}

table! {
    /// The load over time.
    pub struct Dynamics {
        density: f64 = "density_kg_m3", above(0.0, 1e5), "density of the wall";
        damping: f64 = "damping_1_s", from(0.0, 1e4), "mass-proportional damping", absent "0";
        step: f64 = "step_s", above(0.0, 1e4), "time step";
        end: f64 = "end_s", above(0.0, 1e6), "end of the analysis";
        times: Vec<f64> = "times_s", ValueKind::Numbers(10_000), "times at which the load is given";
        load_factors: Vec<f64> = "load_factors", ValueKind::Numbers(10_000), "shares of load.pressure_Pa at these times";
    }
}
