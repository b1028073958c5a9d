//! The keys of the paper's vessel: graft and artery end to end, a rigid extension upstream.

use super::keys::Material;
use super::schema::{ValueKind, above, from};
use super::{BloodVessel, Case, Problem, Shape};
use crate::{table, words};

table! {
    /// A graft that is sewn end to end to an artery.
    pub struct Anastomosis {
        [model: Model, "which of the models"]
        [geometry: Geometry, "sizes of the vessel"]
        [wall: Layers, "materials of the wall"]
    }
}

table! {
    /// Upstream path and imperfection.
    pub struct Model {
        extension: Extension = "extension", ValueKind::Word(Extension::WORDS), "path of the rigid extension";
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
        helix_radius: f64 = "helix_radius_m", above(0.0, 1.0), "radius of the helix", only HELIX;
        arc_angle_deg: f64 = "arc_angle_deg", above(0.0, 270.0), "angle that the arc turns through", only ARC;
        /// Rows along x (first and last zero), columns around.
        imperfection: Vec<Vec<f64>> = "imperfection", ValueKind::Rows(100), "support values of the imperfection relative to model.d_max_m", only IMPERFECT;
    }
}

table! {
    /// Materials of the wall's parts.
    pub struct Layers {
        [graft: Material, "the graft"]
        [media: Material, "the artery's inner layer"]
        [adventitia: Material, "the artery's outer layer"]
    }
}

impl Case {
    /// The same without the imperfection of its wall; none if it has none.
    pub fn without_imperfection(&self) -> Option<Self> {
        let mut perfect = self.clone();
        match &mut perfect.problem {
            Problem::Vessel(BloodVessel {
                shape: Shape::Anastomosis(vessel),
                ..
            }) if vessel.model.d_max != 0.0 => vessel.model.d_max = 0.0,
            _ => return None,
        }
        Some(perfect)
    }
}
