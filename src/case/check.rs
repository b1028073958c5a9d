//! Physical sense: values that are allowed one by one but do not fit each other.

mod anastomosis;
mod described;
mod flag;
mod openings;
mod own;
mod random_lumen;
mod tree;
pub(super) mod uncertain;
mod vessel;

use super::error::CaseError;
use super::stack::Stack;
use super::times::divides;
use super::tree::BETWEEN;
use super::value::shorten;
use super::{
    Blood, BloodModel, Case, FluidTimeScheme, Material, Problem, Solver, TreeKeys, Window,
};
use std::fmt::Write as _;

pub use described::TOO_SHARP;

/// A cell may bend with the vessel by this angle at most.
pub const MAX_BEND_DEG: f64 = 30.0;
/// A curved element of the native solver may bend further.
pub const MAX_ELEMENT_BEND_DEG: f64 = 45.0;
/// Most steps of a run.
const MOST_STEPS: f64 = 1e7;
/// Most steps of a period: its inflow is sampled at each of them.
const MOST_STEPS_OF_A_PERIOD: f64 = 1e6;

/// Appends what makes no sense; silent about conflicts with values that were refused already. Of the keys that
/// conflict the first is named with its place, and the one that was written last.
pub(super) fn check(case: &Case, stack: &Stack, errors: &mut Vec<CaseError>) {
    let mut report = |keys: &[&str], nonsense: bool, mut message: String| {
        if !nonsense || keys.iter().any(|key| stack.is_wrong(key)) {
            return;
        }
        let Some(entry) = stack.entry_within(keys[0]) else {
            return;
        };
        // The scheme of a preset is not read where the driver has no say in it.
        if keys == ["time.scheme"] && entry.place.is_built_in() {
            return;
        }
        // Perhaps the value that was changed is another one of them.
        if let Some(other) = stack
            .last_written(keys)
            .filter(|other| other.key != entry.key)
        {
            let _ = write!(
                message,
                " (`{}` = {} is set in {})",
                other.key,
                shorten(&other.value),
                other.place
            );
        }
        errors.push(CaseError::Nonsense {
            place: entry.place.clone(),
            key: entry.key.clone(),
            found: shorten(&entry.value),
            message,
        });
    };
    match &case.problem {
        Problem::Vessel(vessel) => vessel::check(case, vessel, &mut report),
        Problem::Flag(flag) => flag::check(case, flag, &mut report),
        Problem::UserCase(own) => own::check(case, own, &mut report),
    }
    blood(&case.blood, &mut report);
    times(case, &mut report);
    external(case, &mut report);
    discretization(case, &mut report);
    files(case, &mut report);
    sections(case, &mut report);
    uncertain::check(case, stack, &mut report);
}

/// Whether the cross-sections that are watched are of vessels, each with a name of its own.
fn sections(case: &Case, report: &mut Report<'_>) {
    let sections = case.output.section.as_deref().unwrap_or_default();
    // Also that of a wall around an OpenFOAM case.
    let tree = case.own().and_then(|own| own.tree.as_ref());
    let branches = tree.map(TreeKeys::branches);
    for (i, section) in sections.iter().enumerate() {
        let [name, branch, at] =
            ["name", "branch", "at_m"].map(|key| format!("output.section[{i}].{key}"));
        report(
            &[&at],
            case.vessel().is_none() && branches.is_none(),
            "cross-sections lie along a centre-line, which this case has none of: leave this table out, or describe the wall \
             by [tree]"
                .into(),
        );
        report(
            &[&name],
            sections[..i].iter().any(|other| other.name == section.name),
            "another cross-section has this name: choose a different one".into(),
        );
        match (&branches, &section.branch) {
            (None, found) => report(
                &[&branch],
                found.is_some(),
                "this vessel has no branches: leave it out".into(),
            ),
            (Some(known), None) => report(
                &[&at],
                true,
                format!(
                    "on which branch? Write {branch} = one of \"{}\"",
                    known.join("\", \"")
                ),
            ),
            (Some(known), Some(found)) => report(
                &[&branch],
                !known.contains(found) || found == BETWEEN,
                format!(
                    "expected a branch with an opening, one of \"{}\"",
                    tree.map(TreeKeys::names).unwrap_or_default().join("\", \"")
                ),
            ),
        }
    }
}

/// Whether the blood has what its model needs, and nothing else.
fn blood(blood: &Blood, report: &mut Report<'_>) {
    use BloodModel::{CarreauYasuda, Casson, Newtonian, PowerLaw};
    let model = blood.model.unwrap_or_default();
    #[rustfmt::skip]
    let keys = [
        ("zero_shear_viscosity_Pa_s", blood.at_rest, &[CarreauYasuda][..], &[Casson, PowerLaw][..]),
        ("relaxation_time_s", blood.relaxation_time, &[CarreauYasuda], &[]),
        ("exponent", blood.exponent, &[CarreauYasuda, PowerLaw], &[]),
        ("yasuda_exponent", blood.yasuda, &[], &[CarreauYasuda]),
        ("yield_stress_Pa", blood.yield_stress, &[Casson], &[]),
        ("consistency_Pa_sn", blood.consistency, &[PowerLaw], &[]),
    ];
    for (name, value, needed, allowed) in keys {
        let key = format!("blood.{name}");
        report(
            &["blood.model"],
            value.is_none() && needed.contains(&model),
            format!("{:?} needs {key}", model.name()),
        );
        report(
            &[&key, "blood.model"],
            value.is_some() && !needed.contains(&model) && !allowed.contains(&model),
            format!(
                "{} has no such parameter: leave it out, or choose another blood.model",
                match model {
                    Newtonian => "blood of one viscosity",
                    model => model.name(),
                }
            ),
        );
    }
    report(
        &["blood.zero_shear_viscosity_Pa_s", "blood.viscosity_Pa_s"],
        blood
            .at_rest
            .is_some_and(|at_rest| at_rest < blood.viscosity),
        format!(
            "expected at least blood.viscosity_Pa_s = {:?}, that at high rates of shear",
            blood.viscosity
        ),
    );
}

/// What only a user-supplied fluid solver may and must have.
fn external(case: &Case, report: &mut Report<'_>) {
    let fluid = &case.fluid;
    report(
        &["fluid.await", "fluid.command"],
        fluid.is_awaited && !fluid.command.is_empty(),
        "the driver either starts the fluid or waits for it: leave out this or fluid.command"
            .into(),
    );
    if fluid.solver != Solver::External {
        return;
    }
    report(
        &["fluid.solver"],
        fluid.command.is_empty() && !fluid.is_awaited,
        "needs the program, fluid.command = [\"python3\", \"my_fluid.py\"], or fluid.await = true"
            .into(),
    );
    report(
        &["time.scheme"],
        case.time.scheme == FluidTimeScheme::Bdf2,
        "your own fluid solver chooses its time integration and never sees this key: leave it out"
            .into(),
    );
    report(
        &["fluid.ranks"],
        fluid.ranks > 1,
        "fluid.command starts the MPI ranks of your own fluid solver, such as [\"mpirun\", \"-np\", \"2\", …]: \
         expected 1"
            .into(),
    );
    report(
        &["output.fluid_probes_m"],
        !case.output.fluid_probes.is_empty(),
        "your own fluid solver is not asked for values at points: expected none".into(),
    );
    report(
        &["output.measured"],
        case.output.measured.is_some() && !case.output.fluid_probes.is_empty(),
        "your own fluid solver is not asked for values at points: expected measurements of the wall only".into(),
    );
    let Some(vessel) = case.vessel() else {
        return;
    };
    let is_loaded = vessel.equilibrium_pressure() != 0.0
        || vessel.image_pressure() != 0.0
        || vessel.axial_stretch() != 1.0;
    for key in ["initial.start", "initial.axial_stretch"] {
        report(
            &[key],
            is_loaded,
            "your own fluid solver starts with the unloaded wall: leave out the table [initial]"
                .into(),
        );
    }
}

type Report<'a> = dyn FnMut(&[&str], bool, String) + 'a;

fn material(table: &str, material: &Material, report: &mut Report<'_>) {
    if let Some((keys, message)) = material.nonsense(table) {
        report(&[&keys[0], &keys[1]], true, message);
    }
}

impl Material {
    /// What in its parameters makes no sense together: the keys to blame in the table of a file that has them, the
    /// first the one to change, and what would be right.
    pub fn nonsense(&self, table: &str) -> Option<([String; 2], String)> {
        match self {
            // That of Neo-Hooke's is Lamé's first parameter: Poisson's ratio is positive with any.
            Self::HolzapfelGasserOgden { mu, kappa, .. } if *kappa <= 2.0 / 3.0 * mu => {
                let keys = ["kappa_Pa", "mu_Pa"].map(|name| format!("{table}.{name}"));
                let message = format!(
                    "expected more than 2/3 of {} = {mu:?}: Poisson's ratio would not be positive",
                    keys[1]
                );
                Some((keys, message))
            }
            _ => None,
        }
    }
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
    report(
        &["time.end_s", "time.step_s"],
        whole && case.time.end < 0.5 * step,
        format!("expected a time.step_s = {step:?} at least"),
    );
    let window = Window::of(case);
    let empty = window.end_s < window.start_s + 0.5 * step;
    let end = format!(
        "expected more than the start of the window, {:?} s",
        window.start_s
    );
    for (key, given) in [
        ("output.window_start_s", case.output.window_start),
        ("output.window_end_s", case.output.window_end),
    ] {
        report(
            &[key, "time.until_periodic"],
            given.is_some() && case.until_periodic().is_some(),
            "the window of a run that ends when it is periodic (time.until_periodic) is its last whole beat: leave it out".into(),
        );
    }
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
}
