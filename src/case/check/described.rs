//! Whether centre-line, sections, materials and features of a vessel fit together.

mod line;
mod sections;

use super::{Report, material};
use crate::{BloodVessel, CurvePiece, GivenShape, InletEnd, VesselDescription, VesselEnd};

/// What is said of a line whose bends are too sharp for the wall.
pub const TOO_SHARP: &str = "the radius of the bend must be at least";

pub(super) fn check(vessel: &BloodVessel, keys: &VesselDescription, report: &mut Report<'_>) {
    let mut clean = true;
    let mut watched = |keys: &[&str], nonsense: bool, message: String| {
        clean &= !nonsense;
        report(keys, nonsense, message);
    };
    line::check(keys, &mut watched);
    materials(keys, &mut watched);
    for i in 0..keys.section.len() {
        sections::layers(keys, i, &mut watched);
    }
    match keys.is_rigid() {
        true => of_elastic_walls(vessel, &mut watched),
        false => of_straight_ones(vessel, keys, &mut watched),
    }
    // What follows needs a curve; a file that cannot be read has been reported.
    let is_there = keys.points.len() > 1 || keys.piece.as_ref().is_some_and(|all| !all.is_empty());
    if clean && is_there {
        sections::along(keys, report);
    }
}

/// The key that the centre-line comes from.
fn origin(keys: &VesselDescription) -> &'static str {
    match keys {
        _ if keys.centre_line.is_some() => "vessel.centre_line",
        _ if !keys.points.is_empty() => "vessel.points_m",
        _ => "vessel.section[0].name",
    }
}

fn materials(keys: &VesselDescription, report: &mut Report<'_>) {
    for (i, named) in keys.materials().iter().enumerate() {
        material(&format!("vessel.material[{i}]"), &named.material, report);
        let twice = keys.materials()[..i]
            .iter()
            .any(|other| other.name == named.name);
        report(
            &[&format!("vessel.material[{i}].name")],
            twice,
            "another material has this name: choose a different one".into(),
        );
    }
}

/// What is for elastic walls.
fn of_elastic_walls(vessel: &BloodVessel, report: &mut Report<'_>) {
    let (tissue, ends) = (vessel.surroundings.as_ref(), vessel.ends.as_ref());
    #[rustfmt::skip]
    let keys = [
        ("ends.inlet", ends.is_some_and(|ends| ends.inlet.is_some())),
        ("ends.outlet", ends.is_some_and(|ends| ends.outlet.is_some() || ends.spring.is_some())),
        ("initial.axial_stretch", vessel.axial_stretch() != 1.0),
        ("initial.shape", vessel.given_shape() == GivenShape::Loaded),
        ("surroundings.spring_Pa_m", tissue.is_some_and(|t| t.spring.is_some())),
        ("surroundings.damping_Pa_s_m", tissue.is_some_and(|t| t.damping.is_some())),
        ("surroundings.axial_spring_Pa_m", tissue.is_some_and(|t| t.axial_spring.is_some())),
        ("surroundings.axial_damping_Pa_s_m", tissue.is_some_and(|t| t.axial_damping.is_some())),
        ("surroundings.pressure_Pa", tissue.is_some_and(|t| t.pressure.is_some())),
    ];
    for (key, is_given) in keys {
        let message = "is for an elastic wall, and all sections of this vessel have wall = \"rigid\": leave it out";
        report(&[key], is_given, message.into());
    }
}

/// What is for vessels along the x-axis alone, where the arc length is x: a line from the origin on, with the first
/// elastic section at its beginning.
fn of_straight_ones(vessel: &BloodVessel, keys: &VesselDescription, report: &mut Report<'_>) {
    let is_line = |piece: &CurvePiece| matches!(piece, CurvePiece::Line { .. });
    let pieces = keys.piece.as_deref().unwrap_or_default();
    let begins_elastic = (keys.section.first()).is_some_and(|section| section.is_elastic());
    if !pieces.is_empty() && pieces.iter().all(is_line) && begins_elastic {
        return;
    }
    stretch_of_curved_ones(vessel, keys, report);
    const STRAIGHT: &str =
        "is for vessels of straight [[vessel.piece]] that begin with an elastic section";
    report(
        &["ends.inlet"],
        vessel.inlet_end() != InletEnd::Clamped,
        format!("{STRAIGHT}; the inlet of this one is \"clamped\""),
    );
    report(
        &["ends.outlet"],
        matches!(
            vessel.outlet_end().0,
            VesselEnd::Sliding | VesselEnd::Radial
        ),
        format!("{STRAIGHT}; the ends of this one are \"clamped\", or the outlet on \"springs\""),
    );
}

/// A curved vessel is stretched as an image shows it: its unloaded form, more curved and shorter, is found. What was
/// unloaded and given would leave its centre-line, along which tissue, places and sections are described.
fn stretch_of_curved_ones(vessel: &BloodVessel, keys: &VesselDescription, report: &mut Report<'_>) {
    if vessel.axial_stretch() == 1.0 {
        return;
    }
    report(
        &["initial.axial_stretch", "initial.shape"],
        vessel.given_shape() != GivenShape::Loaded,
        "a curved vessel leaves its centre-line when it is stretched, so its stretched shape must be the given one: write \
         initial.shape = \"loaded\""
            .into(),
    );
    let tissue = vessel.surroundings.as_ref();
    let is_held = tissue.is_some_and(|t| t.spring.is_some() || t.axial_spring.is_some());
    report(
        &["initial.axial_stretch", "surroundings.at_rest"],
        is_held && !vessel.tissue_rests_loaded(),
        "tissue around a curved vessel that is stretched is at rest in the given shape: write surroundings.at_rest = \"loaded\""
            .into(),
    );
    report(
        &["initial.axial_stretch", "vessel.section"],
        keys.section.iter().any(|section| !section.is_elastic()),
        "a rigid section of a curved vessel does not move with the end of the elastic wall: make all sections elastic, or leave \
         the stretch out"
            .into(),
    );
}
