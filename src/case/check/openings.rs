//! Whether what is prescribed where the blood enters and leaves fits together, and the files with curves can be read.

use super::Report;
use crate::{
    BloodVessel, Case, ConditionKeys, FlowCurve, Inlet, InletCondition, Outlet, OutletCondition,
    Start, VesselSide,
};

pub(super) fn check(case: &Case, vessel: &BloodVessel, report: &mut Report<'_>) {
    list(case, vessel, report);
    if vessel.listed(VesselSide::Start).is_none() {
        if vessel.condition_at(VesselSide::Start).is_flow() {
            inflow(case, vessel, report);
        }
        if let Some(keys) = &vessel.inlet {
            inlet(case, vessel, keys, report);
        }
    }
    if let (None, Some(keys)) = (vessel.listed(VesselSide::End), &vessel.outlet) {
        outlet(case, vessel, keys, report);
    }
}

/// The tables `[[opening]]`, and whether their conditions go together.
fn list(case: &Case, vessel: &BloodVessel, report: &mut Report<'_>) {
    let Some(list) = &vessel.opening else {
        return;
    };
    let names: Vec<String> = (vessel.opening_keys().iter())
        .map(|opening| opening.name().to_owned())
        .collect();
    for (i, opening) in list.iter().enumerate() {
        let before = &list[..i];
        report(
            &[&format!("opening[{i}].end")],
            before.iter().any(|other| other.end == opening.end),
            "a vessel has one opening at each end, and this end has one already".into(),
        );
        report_name(i, opening.name(), &names, report);
        let mistakes = opening.condition.mistakes(opening.end, case.time.period);
        for (names, reason) in mistakes {
            let keys: Vec<String> = (names.iter())
                .map(|name| format!("opening[{i}].{name}"))
                .collect();
            let keys: Vec<&str> = keys.iter().map(String::as_str).collect();
            report(&[&keys[..], &["time.period_s"]].concat(), true, reason);
        }
        let is_curve = matches!(opening.condition.file(), Some(("pressure_file", _)));
        let file = format!("opening[{i}].pressure_file");
        let (_, beginning) = vessel.start_pressure();
        report(
            &["initial.start", &file],
            is_curve
                && vessel.start() == Start::Equilibrium
                && beginning == format!("opening[{i}].pressure_Pa"),
            "a pressure that changes in time gives no equilibrium to start from: write \"ramp\", or pressure_Pa".into(),
        );
    }
    let [start, end] = VesselSide::ALL.map(|end| vessel.condition_at(end));
    let key = vessel.opening_key(VesselSide::End, "condition");
    report(
        &[&key],
        start.is_flow() && end.is_flow(),
        "a flow at each end leaves no pressure: expected \"pressure\", \"resistance\" or \"windkessel\" at one of them".into(),
    );
    if let ConditionKeys::FlowSplit { fraction } = end {
        report(
            &[&vessel.opening_key(VesselSide::End, "fraction")],
            !start.is_flow() && fraction >= 1.0,
            "what enters under a pressure and leaves here alone says nothing of the flow: expected less than 1".into(),
        );
    }
}

/// Names become those of patches.
fn report_name(i: usize, name: &str, names: &[String], report: &mut Report<'_>) {
    let is_word = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    let is_taken = name.starts_with("wall") || names.iter().filter(|n| *n == name).count() > 1;
    report(
        &[&format!("opening[{i}].name")],
        !is_word || is_taken,
        "expected a name of its own of letters, digits, - and _ that begins with a letter, and not with \"wall\": patches of \
         OpenFOAM's mesh are called so"
            .into(),
    );
}

fn inflow(case: &Case, vessel: &BloodVessel, report: &mut Report<'_>) {
    let inflow = &vessel.inflow;
    report(
        &["inflow.systole_s", "time.period_s"],
        inflow.systole > case.time.period && inflow.file.is_none(),
        format!(
            "the pulse must fit into time.period_s = {:?}",
            case.time.period
        ),
    );
    of_file(
        "inflow",
        inflow.file.is_some(),
        [inflow.unit.is_some(), inflow.file_period.is_some()],
        report,
    );
    match FlowCurve::new(inflow, case.time.period) {
        Err(error) => report(&["inflow.file", "time.period_s"], true, error.to_string()),
        Ok(curve) => report(
            &["inflow.mean_m3_s"],
            inflow.mean.is_some() && !curve.has_mean(),
            FlowCurve::NO_MEAN.into(),
        ),
    }
}

/// What is of a file needs one.
fn of_file(table: &str, has_file: bool, [unit, period]: [bool; 2], report: &mut Report<'_>) {
    for (name, is_there) in [("unit", unit), ("file_period_s", period)] {
        report(
            &[&format!("{table}.{name}")],
            is_there && !has_file,
            format!("this is of the file {table}.file, and there is none: leave it out"),
        );
    }
}

fn inlet(case: &Case, vessel: &BloodVessel, keys: &Inlet, report: &mut Report<'_>) {
    let Inlet {
        profile,
        pressure,
        file,
        unit,
        file_period,
        ..
    } = keys;
    let read = |end| vessel.condition_at(end).read(end, case.time.period);
    of_file(
        "inlet",
        file.is_some(),
        [unit.is_some(), file_period.is_some()],
        report,
    );
    match keys.condition.unwrap_or_default() {
        InletCondition::Flow => {
            for (key, is_there) in [
                ("inlet.pressure_Pa", pressure.is_some()),
                ("inlet.file", file.is_some()),
            ] {
                report(
                    &[key],
                    is_there,
                    "the flow of [inflow] is prescribed at the inlet: write inlet.condition = \"pressure\", or leave this out"
                        .into(),
                );
            }
        }
        InletCondition::Pressure => {
            report(
                &["inlet.condition"],
                pressure.is_none() && file.is_none(),
                "needs the pressure: add inlet.pressure_Pa, or inlet.file with a curve".into(),
            );
            report(
                &["inlet.pressure_Pa", "inlet.file"],
                pressure.is_some() && file.is_some(),
                "there is inlet.file as well: leave out one of the two".into(),
            );
            report(
                &["inlet.profile"],
                profile.is_some(),
                "the profile follows from the pressure: leave it out, or write inlet.condition = \"flow\"".into(),
            );
            if let Err(error) = read(VesselSide::Start) {
                report(&["inlet.file", "time.period_s"], true, error.to_string());
            }
        }
    }
}

fn outlet(case: &Case, vessel: &BloodVessel, keys: &Outlet, report: &mut Report<'_>) {
    let Outlet {
        resistance,
        pressure,
        file,
        unit,
        file_period,
        ..
    } = keys;
    let condition = keys.condition.unwrap_or_default();
    let read = |end| vessel.condition_at(end).read(end, case.time.period);
    of_file(
        "outlet",
        file.is_some(),
        [unit.is_some(), file_period.is_some()],
        report,
    );
    let is = |wanted: OutletCondition| condition == wanted;
    #[rustfmt::skip]
    let keys = [
        ("outlet.resistance_Pa_s_m3", resistance.is_some(), is(OutletCondition::Resistance)),
        ("outlet.pressure_Pa", pressure.is_some(), !is(OutletCondition::Windkessel)),
        ("outlet.file", file.is_some(), is(OutletCondition::Pressure)),
    ];
    for (key, is_there, belongs) in keys {
        report(
            &[key, "outlet.condition"],
            is_there && !belongs,
            format!(
                "this does not belong to the outlet's condition {:?}: leave it out, or choose another outlet.condition",
                condition.name()
            ),
        );
    }
    report(
        &["outlet.condition"],
        is(OutletCondition::Resistance) && resistance.is_none(),
        "needs the resistance: add outlet.resistance_Pa_s_m3".into(),
    );
    if !is(OutletCondition::Pressure) {
        return;
    }
    report(
        &["outlet.condition"],
        pressure.is_none() && file.is_none(),
        "needs the pressure: add outlet.pressure_Pa, or outlet.file with a curve".into(),
    );
    report(
        &["outlet.pressure_Pa", "outlet.file"],
        pressure.is_some() && file.is_some(),
        "there is outlet.file as well: leave out one of the two".into(),
    );
    report(
        &["initial.start", "outlet.file"],
        file.is_some() && vessel.start() == Start::Equilibrium,
        "a pressure that changes in time gives no equilibrium to start from: write \"ramp\", or outlet.pressure_Pa".into(),
    );
    if let Err(error) = read(VesselSide::End) {
        report(&["outlet.file", "time.period_s"], true, error.to_string());
    }
}
