//! Values that are allowed one by one but do not fit each other.

use super::SolidFile;
use crate::analysis::tube::TubeEnds;
use crate::case::CaseError;
use crate::case::stack::Stack;
use crate::case::value::shorten;
use crate::pfem::element::surface::LoadKind;

/// Displacement coefficients of all elements together, at most: beyond that the factorization needs more than 100 GB.
const MOST_COEFFICIENTS: usize = 3_000_000;

/// Appends what makes no sense.
pub(super) fn check(solid: &SolidFile, stack: &Stack, errors: &mut Vec<CaseError>) {
    let mut report = |key: &str, nonsense: bool, message: String| {
        if let (true, Some(entry)) = (nonsense, stack.entry(key)) {
            errors.push(CaseError::Nonsense {
                place: entry.place.clone(),
                key: key.to_owned(),
                found: shorten(&entry.value),
                message,
            });
        }
    };
    discretization(solid, &mut report);
    for (index, (_, material)) in solid.layers.iter().enumerate() {
        if let Some((keys, message)) = material.nonsense(&format!("tube.layer[{index}]")) {
            report(&keys[0], true, message);
        }
    }
    ends(solid, &mut report);
    dynamics(solid, &mut report);
}

fn ends(solid: &SolidFile, report: &mut Report<'_>) {
    let on_springs = solid.ends == TubeEnds::Springs;
    report(
        "supports.ends",
        on_springs && solid.end_spring == 0.0,
        "springs need a stiffness: add supports.spring_Pa_m".into(),
    );
    report(
        "supports.spring_Pa_m",
        !on_springs && solid.end_spring != 0.0,
        "only ends on springs have any: write supports.ends = \"springs\", or leave it out".into(),
    );
    report(
        "supports.axial_stretch",
        on_springs && solid.axial_stretch != 1.0,
        "ends on springs are not moved to a place: write supports.ends = \"clamped\", \"axial\" or \"radial\"".into(),
    );
}

type Report<'a> = dyn FnMut(&str, bool, String) + 'a;

fn discretization(solid: &SolidFile, report: &mut Report<'_>) {
    let (space, degree) = (&solid.options.space, solid.options.space.max_degree());
    let points = solid.options.quadrature_points[0];
    report(
        "space.quadrature_points",
        points < degree,
        format!(
            "degree {degree} needs at least {degree} points, better {}",
            degree + 2
        ),
    );
    let grid = solid.grid;
    let elements = grid.axial * grid.circumferential * grid.radial();
    let coefficients = 3 * elements * space.modes().len();
    report(
        "space.p",
        coefficients > MOST_COEFFICIENTS,
        format!(
            "{elements} elements with {} shape functions each have {coefficients} displacement coefficients, more than \
             {MOST_COEFFICIENTS}: take a smaller degree or fewer elements",
            space.modes().len()
        ),
    );
}

fn dynamics(solid: &SolidFile, report: &mut Report<'_>) {
    let Some(dynamics) = &solid.dynamics else {
        report(
            "outside.damping_Pa_s_m",
            solid.outside.damping != 0.0,
            "dampers resist no static displacement: add [dynamics], or leave it out".into(),
        );
        return;
    };
    report(
        "load.at_bifurcation",
        true,
        "[dynamics] follows no path of equilibria: inertia decides where the tube goes".into(),
    );
    report(
        "load.kind",
        solid.kind == LoadKind::Dead,
        "[dynamics] knows only \"follower\"".into(),
    );
    report(
        "mesh.circumferential",
        solid.ends == TubeEnds::Axial && !solid.grid.circumferential.is_multiple_of(4),
        "[dynamics] with supports.ends = \"axial\" needs a multiple of 4, so that the mesh has nodes in both planes of \
         symmetry; or clamp the ends"
            .into(),
    );
    report(
        "dynamics.step_s",
        dynamics.steps == 0,
        "expected at most dynamics.end_s".into(),
    );
    report(
        "dynamics.load_factors",
        dynamics.times.len() != dynamics.factors.len(),
        format!(
            "expected {} numbers, as many as dynamics.times_s has",
            dynamics.times.len()
        ),
    );
    report(
        "dynamics.times_s",
        dynamics.times.windows(2).any(|pair| pair[0] >= pair[1]),
        "expected ascending times".into(),
    );
}
