//! When a key is read: the conditions of the tables of keys.

use super::schema::Only;
use super::{
    Case, ConditionKeys, Extension, Extrusion, Inflow, Problem, Shape, Solver, VesselDescription,
    VesselSide, WallMode,
};

macro_rules! conditions {
    ($($name:ident: $when:literal, $holds:expr;)*) => {
        $(pub const $name: &Only = &Only { when: $when, holds: $holds };)*
    };
}

conditions! {
    ELASTIC: "if a wall is elastic", |case, _| case.has_elastic_wall();
    OPENFOAM: "with fluid.solver = \"openfoam\"", |case, _| case.fluid.solver == Solver::OpenFoam;
    NATIVE: "with fluid.solver = \"native\"", |case, _| case.fluid.solver == Solver::Native;
    EXTERNAL: "with fluid.solver = \"external\"", |case, _| case.fluid.solver == Solver::External;
    NATIVE_ELEMENTS: "with fluid.solver = \"native\", or with initial.steps_before",
        |case, _| case.fluid.solver == Solver::Native || case.steps_before().is_some();
    NOT_NATIVE: "with another fluid.solver than \"native\"", |case, _| case.fluid.solver != Solver::Native;
    TEMPLATES: "with fluid.solver = \"openfoam\", and not by an OpenFOAM case of your own",
        |case, _| case.fluid.solver == Solver::OpenFoam && !case.has_own_openfoam();
    NOT_OWN: "in other cases than an OpenFOAM case of your own", |case, _| !case.has_own_openfoam();
    COUPLED_MESH: "with fluid.solver = \"openfoam\" and an elastic wall",
        |case, _| case.fluid.solver == Solver::OpenFoam && case.has_elastic_wall();
    FLOW: "where a flow is prescribed, not with inlet.condition = \"pressure\" or an [[opening]] at the start",
        |case, _| of_tables(case, VesselSide::Start).is_some_and(|condition| condition.is_flow());
    INLET: "without an [[opening]] at the start", |case, _| of_tables(case, VesselSide::Start).is_some();
    OUTLET: "without an [[opening]] at the end", |case, _| of_tables(case, VesselSide::End).is_some();
    FORMULA: "without inflow.file", |case, _| inflow(case, |inflow| inflow.file.is_none());
    PULSE: "without inflow.file, and with inflow.amplitude_m3_s other than 0",
        |case, _| inflow(case, |inflow| inflow.file.is_none() && inflow.amplitude != 0.0);
    WINDKESSEL: "with outlet.condition = \"windkessel\", and without an [[opening]] at the end",
        |case, _| matches!(of_tables(case, VesselSide::End), Some(ConditionKeys::Windkessel { .. }));
    REMEMBERED: "with a quasi-Newton coupling.acceleration (iqn_ls, multi_vector, hybrid)",
        |case, _| case.coupling.acceleration.remembers();
    HELIX: "with model.extension = \"helix\"", |case, _| is_extended(case, Extension::Helix);
    ARC: "with model.extension = \"arc\"", |case, _| is_extended(case, Extension::Arc);
    IMPERFECT: "with model.d_max_m above 0",
        |case, _| case.anastomosis().is_some_and(|vessel| vessel.model.d_max > 0.0);
    EXTENDED: "by a vessel of graft and artery with geometry.extension_length_m above 0",
        |case, _| case.anastomosis().is_some_and(|vessel| vessel.geometry.extension_length > 0.0);
    JOINTS: "where two sections meet", |case, _| described(case, |keys| keys.section.len() > 1);
    OWN_RADIUS: "by sections without a radius_m of their own",
        |case, _| described(case, |keys| keys.section.iter().any(|section| section.radius.is_none()));
    USED: "if a layer is of this material", |case, path| is_used(case, path);
    TISSUE: "with surroundings.spring_Pa_m or surroundings.damping_Pa_s_m",
        |case, _| tissue(case, |[spring, damping, ..]| spring || damping);
    SPRINGS: "with springs or dampers of [surroundings]",
        |case, _| tissue(case, |values| values[..4].contains(&true));
    STATIONS: "with springs, dampers or a pressure of [surroundings]",
        |case, _| tissue(case, |values| values.contains(&true));
    BEATS: "where what drives the blood changes with the beat", |case, _| case.has_beats();
    FLAG: "if the flag is elastic (flag.rigid)", |case, _| case.has_elastic_wall();
    OWN_ELASTIC: "with wall.mode = \"elastic\"", |case, _| case.has_elastic_wall();
    MOVED: "with wall.mode = \"prescribed\"",
        |case, _| case.own().is_some_and(|own| own.wall.mode() == WallMode::Prescribed);
}

/// What the tables prescribe at an end that no list has.
fn of_tables(case: &Case, end: VesselSide) -> Option<ConditionKeys> {
    let vessel = case.vessel().filter(|vessel| vessel.listed(end).is_none());
    vessel.map(|vessel| vessel.condition_at(end))
}

fn inflow(case: &Case, holds: impl Fn(&Inflow) -> bool) -> bool {
    case.vessel().is_some_and(|vessel| holds(&vessel.inflow))
}

fn is_extended(case: &Case, path: Extension) -> bool {
    case.anastomosis().is_some_and(|vessel| {
        vessel.model.extension == path && vessel.geometry.extension_length > 0.0
    })
}

fn described(case: &Case, holds: impl Fn(&VesselDescription) -> bool) -> bool {
    match case.vessel().map(|vessel| &vessel.shape) {
        Some(Shape::Vessel(keys)) => holds(keys),
        _ => false,
    }
}

/// Whether the material of this path is that of a layer; those of a wall from a file go by its own names.
fn is_used(case: &Case, path: &str) -> bool {
    let index = path
        .split_once("material[")
        .and_then(|(_, rest)| rest.split_once(']'));
    let index = index
        .and_then(|(index, _)| index.parse::<usize>().ok())
        .unwrap_or(0);
    let (materials, layers): (_, Vec<&String>) = match &case.problem {
        Problem::Vessel(vessel) => match &vessel.shape {
            Shape::Vessel(keys) => (
                keys.materials(),
                keys.section
                    .iter()
                    .flat_map(|section| &section.layers)
                    .collect(),
            ),
            Shape::Anastomosis(_) => return true,
        },
        Problem::UserCase(own) if own.wall.is_extruded() => (
            own.wall.materials(),
            (own.wall.extrude.iter())
                .flat_map(Extrusion::materials)
                .collect(),
        ),
        Problem::UserCase(own) => return own.wall.mode() == WallMode::Elastic,
        Problem::Flag(_) => return true,
    };
    materials
        .get(index)
        .is_none_or(|material| layers.contains(&&material.name))
}

fn tissue(case: &Case, holds: impl Fn([bool; 5]) -> bool) -> bool {
    let tissue = case
        .vessel()
        .and_then(|vessel| vessel.surroundings.as_ref());
    tissue.is_some_and(|tissue| {
        holds(
            [
                tissue.spring,
                tissue.damping,
                tissue.axial_spring,
                tissue.axial_damping,
                tissue.pressure,
            ]
            .map(|value| value.is_some_and(|value| value != 0.0)),
        )
    })
}
