//! Whether what flows through a vessel, what surrounds it and its meshes fit together, whatever its shape.

use super::{Report, anastomosis, described, openings, random_lumen};
use crate::{
    BloodVessel, Case, GivenShape, InletEnd, Shape, Solver, Start, SurrogateModel, TissueDirection,
    VesselEnd, VesselSide,
};
use fsi_pfem::element::surface::LoadKind;

pub(super) fn check(case: &Case, vessel: &BloodVessel, report: &mut Report<'_>) {
    match &vessel.shape {
        Shape::Anastomosis(shape) => anastomosis::check(case, shape, &vessel.fluid, report),
        Shape::Vessel(shape) => described::check(vessel, shape, report),
    }
    if let Some(keys) = &vessel.random_lumen {
        random_lumen::check(keys, report);
    }
    openings::check(case, vessel, report);
    surroundings(vessel, report);
    ends(vessel, report);
    report(
        &["coupling.surrogate"],
        case.coupling.surrogate == SurrogateModel::Potential,
        "this surrogate is of vessels that branch: write \"tube\", \"open_tube\" or \"none\""
            .into(),
    );
    report(
        &["initial.shape", "initial.start"],
        vessel.given_shape() == GivenShape::Loaded && vessel.start() != Start::Equilibrium,
        "a shape that is given under pressure needs a start under that pressure: write initial.start = \"equilibrium\", and \
         that pressure into initial.pressure_Pa"
            .into(),
    );
    report(
        &["structure.load", "initial.shape"],
        case.structure.load == LoadKind::Dead && vessel.given_shape() == GivenShape::Loaded,
        "a dead load acts on the area of the unloaded wall, which is not known where the shape is given under pressure: \
         leave out structure.load, or give the wall unloaded"
            .into(),
    );
    let flows = case.steps_before().is_some();
    report(
        &["initial.steps_before", "initial.start"],
        flows && vessel.start() != Start::Equilibrium,
        "blood that flows from the beginning needs a wall under pressure: write initial.start = \"equilibrium\"".into(),
    );
    report(
        &["initial.steps_before", "ramp.duration_s"],
        flows && case.ramp.duration > 0.0,
        "a ramp would stop the blood that flows from the beginning: write ramp.duration_s = 0, and into \
         windkessel.initial_pressure_Pa the pressure at the beginning of a beat"
            .into(),
    );
    report(
        &["initial.steps_before", "fluid.solver"],
        flows && case.fluid.solver == Solver::External,
        "a program of your own begins as it likes: leave initial.steps_before out".into(),
    );
    report(
        &["initial.pressure_Pa", "initial.shape"],
        vessel.given_shape() != GivenShape::Loaded
            && vessel.initial.as_ref().is_some_and(|initial| initial.pressure.is_some()),
        "this is the pressure in a given shape that is loaded: write initial.shape = \"loaded\", or leave it out; the initial pressure of the run is windkessel.initial_pressure_Pa"
            .into(),
    );
    if let Some(degree) = case.structure.p_geometry {
        let around = vessel.structure.circumferential;
        let message =
            format!("straight edges need at least 12 elements around, not {around}: raise either");
        report(
            &["structure.p_geometry", "structure.circumferential"],
            degree == 1 && around < 12,
            message,
        );
    }
}

fn surroundings(vessel: &BloodVessel, report: &mut Report<'_>) {
    let Some(tissue) = &vessel.surroundings else {
        return;
    };
    let (stations, shares) = (&tissue.stations, &tissue.shares);
    let keys = ["surroundings.stations_m", "surroundings.shares"];
    for (key, other, found) in [
        (keys[0], keys[1], shares.len()),
        (keys[1], keys[0], stations.len()),
    ] {
        report(
            &[key],
            stations.len() != shares.len(),
            format!("expected as many numbers as {other} has, {found}"),
        );
    }
    report(
        &["surroundings.stations_m"],
        stations.windows(2).any(|pair| pair[0] >= pair[1]),
        "expected ascending places".into(),
    );
    report(
        &["surroundings.shares"],
        shares.iter().any(|share| *share < 0.0),
        "expected no negative share: tissue does not push".into(),
    );
    let resists_axially = tissue.direction.unwrap_or_default() != TissueDirection::Radial;
    let (spring, damping) = (tissue.axial_spring, tissue.axial_damping);
    for (key, is_given) in [
        ("surroundings.axial_spring_Pa_m", spring.is_some()),
        ("surroundings.axial_damping_Pa_s_m", damping.is_some()),
    ] {
        report(
            &[key, "surroundings.direction"],
            is_given && resists_axially,
            "tissue of this direction resists displacements along the axis already: write surroundings.direction = \"radial\", or \
             leave this out"
                .into(),
        );
    }
    report(
        &["surroundings.at_rest", "initial.start"],
        vessel.tissue_rests_loaded() && vessel.start() != Start::Equilibrium,
        "tissue can be at rest in the loaded wall only if the run starts with a loaded wall: write initial.start = \"equilibrium\"".into(),
    );
}

fn ends(vessel: &BloodVessel, report: &mut Report<'_>) {
    let (outlet, spring) = vessel.outlet_end();
    let inlet = vessel.inlet_end();
    let condition = |end| vessel.opening_key(end, "condition");
    report(
        &["ends.outlet", &condition(VesselSide::End)],
        outlet != VesselEnd::Clamped && vessel.condition_at(VesselSide::End).is_flow(),
        "a flow leaves through an outlet at rest: write \"clamped\", or a pressure as the condition there".into(),
    );
    if inlet != InletEnd::Clamped {
        let condition = condition(VesselSide::Start);
        report(
            &["ends.inlet", &condition],
            vessel.condition_at(VesselSide::Start).is_flow(),
            format!(
                "a prescribed flow needs an inlet at rest: write \"clamped\", or {condition} = \"pressure\""
            ),
        );
        let (key, extended) = match &vessel.shape {
            Shape::Anastomosis(shape) => (
                "geometry.extension_length_m",
                shape.geometry.extension_length > 0.0,
            ),
            Shape::Vessel(shape) => (
                "vessel.upstream_extension_m",
                shape.upstream.is_some_and(|length| length > 0.0),
            ),
        };
        report(
            &["ends.inlet", key],
            extended,
            format!("the rigid tube upstream holds this end: write \"clamped\", or {key} = 0.0"),
        );
    }
    report(
        &["ends.inlet", "ends.outlet"],
        inlet == InletEnd::Sliding && outlet == VesselEnd::Sliding,
        "nothing keeps a wall from moving sideways if both of its ends slide in their planes: write \"radial\" for one of them"
            .into(),
    );
    report(
        &["ends.outlet"],
        outlet == VesselEnd::Springs && spring == 0.0,
        "springs need a stiffness: add ends.spring_Pa_m".into(),
    );
    report(
        &["ends.spring_Pa_m"],
        outlet != VesselEnd::Springs && spring != 0.0,
        "only an end that is on springs has any: write ends.outlet = \"springs\", or leave it out"
            .into(),
    );
    report(
        &["initial.axial_stretch", "ends.outlet"],
        outlet == VesselEnd::Springs && vessel.axial_stretch() != 1.0,
        "an end on springs is not moved to a place: write ends.outlet = \"clamped\", \"sliding\" or \"radial\"".into(),
    );
}
