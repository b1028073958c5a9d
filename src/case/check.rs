//! Physical sense: values that are allowed one by one but do not fit each other.

mod flag;

use super::error::CaseError;
use super::stack::Stack;
use super::value::shorten;
use super::{Case, Extension, Material, Solver, Window, flow_curve::FlowCurve};
use crate::interpolation::BicubicSurface;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// The imperfection must leave at least this share of the artery's inner radius.
const LEAST_LUMEN: f64 = 0.2;
/// Most steps of a run.
const MOST_STEPS: f64 = 1e7;
/// Most steps of a period: its inflow is sampled at each of them.
const MOST_STEPS_OF_A_PERIOD: f64 = 1e6;
/// A cell of the rigid extension may bend by this angle at most.
const MAX_BEND_DEG: f64 = 30.0;
/// A curved element of the native solver may bend further.
const MAX_ELEMENT_BEND_DEG: f64 = 45.0;

/// Appends what makes no sense; silent about conflicts with values that were refused already. Of the keys that
/// conflict the first is named with its place, and the one that was written last.
pub(super) fn check(case: &Case, stack: &Stack, errors: &mut Vec<CaseError>) {
    let mut report = |keys: &[&str], nonsense: bool, mut message: String| {
        if !nonsense || keys.iter().any(|key| stack.is_wrong(key)) {
            return;
        }
        let Some(entry) = stack.entry(keys[0]) else {
            return;
        };
        // Perhaps the value that was changed is another one of them.
        if let Some(other) = stack
            .last_written(keys)
            .filter(|other| other.key != keys[0])
        {
            let _ = write!(
                message,
                " (`{}` = {} stands in {})",
                other.key,
                shorten(&other.value),
                other.place
            );
        }
        errors.push(CaseError::Nonsense {
            place: entry.place.clone(),
            key: keys[0].to_owned(),
            found: shorten(&entry.value),
            message,
        });
    };
    match &case.flag {
        Some(flag) => flag::check(case, flag, &mut report),
        None => vessel(case, &mut report),
    }
    times(case, &mut report);
    discretization(case, &mut report);
    files(case, &mut report);
}

type Report<'a> = dyn FnMut(&[&str], bool, String) + 'a;

fn vessel(case: &Case, report: &mut Report<'_>) {
    let g = &case.geometry;
    let d_max = case.model.d_max;
    let most = (1.0 - LEAST_LUMEN) * g.artery_inner_radius;
    report(
        &["model.d_max_m", "geometry.artery_inner_radius_m"],
        d_max > most,
        format!(
            "the imperfection closes the lumen: at most {most:.4e} m, {:.0} % of geometry.artery_inner_radius_m = {:?}",
            100.0 * (1.0 - LEAST_LUMEN),
            g.artery_inner_radius
        ),
    );
    let surface = BicubicSurface::new(&g.imperfection);
    let (largest, ..) = surface.maximum();
    let (smallest, u, v) = surface.minimum();
    report(
        &["geometry.imperfection", "model.d_max_m"],
        largest <= 0.0 && d_max > 0.0,
        "all support values are zero, so no surface can reach model.d_max_m; raise one".into(),
    );
    report(
        &["geometry.imperfection"],
        smallest < -1e-9 * largest,
        format!(
            "the spline dips to {:.3} of its maximum at {:.0} % of the artery's length and {:.0}° around, but equation (17) needs \
             d >= 0: make the support values near there less different",
            smallest / largest,
            100.0 * u,
            360.0 * v
        ),
    );
    let section = g.graft_length.min(g.artery_length);
    report(
        &[
            "geometry.blend_length_m",
            "geometry.graft_length_m",
            "geometry.artery_length_m",
        ],
        0.5 * g.blend_length > section,
        format!(
            "half of the blend must fit into each section: at most {:?} m",
            2.0 * section
        ),
    );
    let radius = g.graft_inner_radius;
    match case.model.extension {
        Extension::Straight => {}
        Extension::Arc => {
            let bend = g.extension_length / g.arc_angle_deg.to_radians();
            report(
                &[
                    "geometry.arc_angle_deg",
                    "geometry.extension_length_m",
                    "geometry.graft_inner_radius_m",
                ],
                bend <= radius,
                format!(
                    "the arc's radius {bend:.3e} m (extension_length_m over the angle) must exceed the lumen's, \
                     geometry.graft_inner_radius_m = {radius:?}: take a smaller angle or a longer extension"
                ),
            );
        }
        Extension::Helix => helix(case, report),
    }
}

fn helix(case: &Case, report: &mut Report<'_>) {
    const KEYS: [&str; 3] = [
        "geometry.helix_radius_m",
        "geometry.extension_length_m",
        "geometry.graft_inner_radius_m",
    ];
    let g = &case.geometry;
    let (a, length, lumen) = (g.helix_radius, g.extension_length, g.graft_inner_radius);
    let rise_squared = length.powi(2) - (TAU * a).powi(2);
    if rise_squared <= 0.0 {
        let most = length / TAU;
        report(
            &KEYS,
            true,
            format!(
                "one turn is longer than geometry.extension_length_m = {length:?}: less than {most:.3e} m"
            ),
        );
        return;
    }
    let bend = (length / TAU).powi(2) / a;
    report(
        &KEYS,
        bend <= lumen,
        format!(
            "the helix bends with the radius {bend:.3e} m, which must exceed geometry.graft_inner_radius_m = {lumen:?}"
        ),
    );
    // Distance of the two ends of a turn, measured across the vessel.
    let apart = rise_squared.sqrt() * TAU * a / length;
    report(
        &KEYS,
        apart <= 2.0 * lumen,
        format!(
            "neighbouring turns are {apart:.3e} m apart, which must exceed the diameter {:.3e} m: take a longer \
             extension, or another radius",
            2.0 * lumen
        ),
    );
}

/// Whether `b` is a multiple of `a` up to rounding.
fn divides(a: f64, b: f64) -> bool {
    let times = b / a;
    times.round() >= 1.0 && (times - times.round()).abs() <= 1e-6 * times.round()
}

fn times(case: &Case, report: &mut Report<'_>) {
    let step = case.time.step;
    let period = case.time.period;
    let whole = divides(step, period);
    let example = period / 500.0;
    report(
        &["time.step_s", "time.period_s"],
        !whole,
        format!("expected a whole part of time.period_s = {period:?}, such as {example:?}"),
    );
    let limits = [
        ("time.end_s", case.time.end, MOST_STEPS),
        ("time.period_s", period, MOST_STEPS_OF_A_PERIOD),
    ];
    if let Some((key, duration, most)) = limits
        .into_iter()
        .find(|(_, duration, most)| duration / step > most * (1.0 + 1e-6))
    {
        report(
            &["time.step_s", key],
            true,
            format!(
                "{:.1e} steps until {key} = {duration:?} are more than a run can take: expected {:e} s or more, for at \
                 most {most:e} steps",
                duration / step,
                duration / most
            ),
        );
    }
    for (key, value) in [
        ("time.end_s", case.time.end),
        (
            "output.structure_interval_s",
            case.output.structure_interval,
        ),
        ("output.fluid_interval_s", case.output.fluid_interval),
        ("output.window_start_s", Window::of(case).start_s),
        ("output.window_end_s", Window::of(case).end_s),
    ] {
        report(
            &[key, "time.step_s"],
            whole && value > 0.0 && !divides(step, value),
            format!("expected a multiple of time.step_s = {step:?}"),
        );
    }
    let window = Window::of(case);
    let empty = window.end_s < window.start_s + 0.5 * step;
    let end = format!(
        "expected more than the start of the window, {:?} s",
        window.start_s
    );
    report(
        &["output.window_end_s", "output.window_start_s"],
        empty,
        end,
    );
    let start = format!(
        "expected less than the end of the window, {:?} s",
        window.end_s
    );
    let start_alone = empty && case.output.window_end.is_none();
    report(&["output.window_start_s", "time.end_s"], start_alone, start);
    report(
        &["inflow.systole_s", "time.period_s"],
        case.inflow.systole > case.time.period && case.inflow.file.is_none(),
        format!(
            "the pulse must fit into time.period_s = {:?}",
            case.time.period
        ),
    );
}

fn discretization(case: &Case, report: &mut Report<'_>) {
    let s = &case.structure;
    if let Some(points) = s.quadrature_points {
        let message = format!("structure.p = {} needs at least {} points", s.p, s.p);
        report(
            &["structure.quadrature_points", "structure.p"],
            points < s.p,
            message,
        );
    }
    if let Some(degree) = s.p_geometry {
        let message = format!(
            "a mapping of higher degree than structure.p = {} strains the wall when it turns (section 2.4)",
            s.p
        );
        report(
            &["structure.p_geometry", "structure.p"],
            degree > s.p,
            message,
        );
        let message = format!(
            "straight edges need at least 12 elements around, not {}: raise either",
            s.circumferential
        );
        report(
            &["structure.p_geometry", "structure.circumferential"],
            degree == 1 && s.circumferential < 12,
            message,
        );
    }
    let g = &case.geometry;
    let (key, what, cells, most_deg) = match case.fluid.solver {
        Solver::OpenFoam => {
            let cells = case.fluid.mesh.axial_extension;
            ("fluid.mesh.axial_extension", "cell", cells, MAX_BEND_DEG)
        }
        Solver::Native => {
            let elements = case.fluid.native.axial_extension;
            (
                "fluid.native.axial_extension",
                "element",
                elements,
                MAX_ELEMENT_BEND_DEG,
            )
        }
    };
    let length = g.extension_length;
    report(
        &[key, "geometry.extension_length_m"],
        (length > 0.0) != (cells > 0),
        format!(
            "a rigid extension of the length {length:?} m with {cells} {what}s along it: both or neither must be zero"
        ),
    );
    let (ranks, slices) = (case.fluid.ranks, case.fluid.mesh.slices());
    report(
        &["fluid.ranks", "fluid.mesh.axial_per_section"],
        case.flag.is_none() && ranks > slices,
        format!(
            "each MPI rank takes a slice of the vessel, and there are {slices} cells along it: at most {slices}"
        ),
    );
    let turn = match case.model.extension {
        Extension::Straight => 0.0,
        Extension::Arc => g.arc_angle_deg,
        // κ L with κ = a/(a² + b²) and L = 2π √(a² + b²).
        Extension::Helix => 360.0 * (TAU * g.helix_radius / g.extension_length).min(1.0),
    };
    let least = (turn / most_deg).ceil() as usize;
    report(
        &[key, "model.extension", "geometry.arc_angle_deg"],
        cells < least,
        format!(
            "the extension turns by {turn:.0}°, and the {what}s may turn by {most_deg}° each at most: at least {least} {what}s"
        ),
    );
    for (name, material) in [
        ("graft", &case.wall.graft),
        ("media", &case.wall.media),
        ("adventitia", &case.wall.adventitia),
    ] {
        if let Material::NeoHooke { mu, kappa } | Material::HolzapfelGasserOgden { mu, kappa, .. } =
            material
        {
            let (key, mu_key) = (
                format!("wall.{name}.kappa_Pa"),
                format!("wall.{name}.mu_Pa"),
            );
            let message = format!(
                "expected more than 2/3 of {mu_key} = {mu:?}: Poisson's ratio would not be positive"
            );
            report(&[&key, &mu_key], *kappa <= 2.0 / 3.0 * mu, message);
        }
    }
}

fn files(case: &Case, report: &mut Report<'_>) {
    let templates = &case.fluid.templates;
    report(
        &["fluid.templates"],
        !templates.is_dir(),
        format!(
            "there is no folder {}; expected the OpenFOAM dictionaries, such as openfoam-case/base",
            templates.display()
        ),
    );
    if case.inflow.file.is_some()
        && let Err(error) = FlowCurve::new(&case.inflow, case.time.period)
    {
        report(&["inflow.file", "time.period_s"], true, error.to_string());
    }
}
