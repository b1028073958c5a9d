//! The paper's vessel: a rigid extension, a graft, an artery with its imperfection.

use super::feature::Feature;
use super::section::{Base, Section};
use super::{Imperfection, Vessel};
use crate::case::{Anastomosis, Extension, Geometry};
use crate::curve::{Bend, SpaceCurve};
use std::f64::consts::TAU;

impl Vessel {
    /// Graft from x = 0, artery downstream, rigid extension upstream. The graft's wall has two layers of one material.
    pub(super) fn anastomosis(vessel: &Anastomosis) -> Self {
        let g = &vessel.geometry;
        let (graft, artery) = (g.graft_inner_radius, g.artery_inner_radius);
        let graft = [
            graft,
            graft + 0.5 * g.graft_thickness,
            graft + g.graft_thickness,
        ];
        let media = artery + g.media_thickness;
        let artery = [artery, media, media + g.adventitia_thickness];
        let (joint, end) = (g.graft_length, g.graft_length + g.artery_length);
        let section =
            |name: &str, from: f64, to: f64, surfaces: [f64; 3], materials, blend| Section {
                name: name.into(),
                from,
                to,
                is_elastic: from >= 0.0,
                base: Base::CentreLine,
                surfaces: surfaces.to_vec(),
                materials,
                blend,
            };
        let extension = (g.extension_length > 0.0).then(|| {
            section(
                "extension",
                -g.extension_length,
                0.0,
                graft,
                vec![0, 0],
                0.0,
            )
        });
        let others = [
            section("graft", 0.0, joint, graft, vec![0, 0], 0.0),
            section("artery", joint, end, artery, vec![1, 2], g.blend_length),
        ];
        let imperfection = Imperfection::new(&g.imperfection, [joint, end], vessel.model.d_max);
        let wall = &vessel.wall;
        Self {
            line: SpaceCurve::onto_x_axis(g.extension_length, bend(vessel.model.extension, g), end),
            sections: extension.into_iter().chain(others).collect(),
            features: vec![Feature::Imperfection(imperfection)],
            materials: [&wall.graft, &wall.media, &wall.adventitia]
                .map(Clone::clone)
                .to_vec(),
            names: ["graft", "media", "adventitia"].map(String::from).to_vec(),
            counts_radii: false,
        }
    }
}

/// How the extension bends that the model asks for.
fn bend(extension: Extension, geometry: &Geometry) -> Bend {
    let length = geometry.extension_length;
    let (curvature, torsion) = match extension {
        Extension::Straight => (0.0, 0.0),
        Extension::Arc => (geometry.arc_angle_deg.to_radians() / length, 0.0),
        Extension::Helix => {
            // One turn of radius a and slope b: length 2π √(a² + b²), κ = a/(a² + b²), τ = b/(a² + b²).
            let (a, reach) = (geometry.helix_radius, length / TAU);
            let b = (reach * reach - a * a).max(0.0).sqrt();
            (a / (reach * reach), b / (reach * reach))
        }
    };
    Bend {
        curvature,
        torsion,
        towards: 0.0,
    }
}
