//! What `new` says of the user's files and of mistakes in them, in the words of its options: the case with the keys is
//! not written yet.

use super::{ProposalError, ProposalInput};
use crate::case::{CaseError, CaseErrors, FlowCurve, FlowUnit, LineReading, PeriodicTable};
use crate::polydata::PolyData;
use std::f64::consts::PI;
use std::path::Path;

/// Parts of messages about keys, and what they are among the options.
const OPTIONS: [(&str, &str); 17] = [
    (
        "tree.lumen_unit, or tree.unit of the lines",
        "--lumen-unit, or --unit of the lines",
    ),
    ("tree.lumen_unit", "--lumen-unit"),
    ("tree.lumen", "--lumen"),
    ("tree.lines", "--from"),
    ("tree.outlets", "--names"),
    (
        "vessel.lumen_unit, or vessel.unit of the line",
        "--lumen-unit, or --unit of the line",
    ),
    (
        "give its own period as `file_period_s` next to the file, and it is stretched",
        "--flow-period S says how long a period of the file is, and stretches it",
    ),
    ("vessel.branch = ", "--branch "),
    ("leave out vessel.branch", "leave out --branch"),
    ("inflow.unit", "--flow-unit"),
    ("(vessel.unit)", "(--unit)"),
    ("(tree.unit)", "(--unit)"),
    ("vessel.unit, vessel.lumen_unit", "--unit, --lumen-unit"),
    ("vessel.lumen names", "--lumen takes"),
    ("vessel.lumen_unit", "--lumen-unit"),
    ("vessel.unit", "--unit"),
    ("vessel.smoothing_m", "--smoothing"),
];
/// Mean velocities (m/s) in the lumen at the peak of the flow that vessels have.
const VELOCITIES: [f64; 2] = [5e-3, 5.0];
/// Beyond these no vessel is, whatever its state.
const IMPOSSIBLE: [f64; 2] = [1e-5, 50.0];
/// Radii (m) of arteries that people compute.
const RADII: [f64; 2] = [2e-4, 0.02];

/// The input with the unit of the line, if its file says it, and what was understood of the files, a line each.
///
/// # Errors
/// What is wrong with a file.
pub fn files(input: &ProposalInput) -> Result<(ProposalInput, Vec<String>), ProposalError> {
    let mut input = input.clone();
    let mut remarks = Vec::new();
    if let Some(path) = &input.line {
        let reading = LineReading::of(path, input.branch.as_deref());
        let reading = reading
            .map_err(|e| format!("--from {}: {}", path.display(), in_options(&e.to_string())))?;
        input.unit = input.unit.or(reading.unit);
        remarks.push(format!(
            "read      {}: {}",
            path.display(),
            reading.understood
        ));
    }
    if let (Some(path), Some(_)) = (&input.lumen, &input.line) {
        let data = PolyData::read(path).map_err(|e| format!("--lumen {}: {e}", path.display()))?;
        remarks.push(format!(
            "read      {}: {} triangles",
            path.display(),
            data.triangles.len()
        ));
    }
    Ok((input, remarks))
}

/// Mistakes of a case that was never written: the options to blame, and no lines.
pub fn mistakes(errors: &CaseErrors, input: &ProposalInput, trial: &Path) -> String {
    let folder = format!("{}/", trial.display());
    let shown = |path: &Option<std::path::PathBuf>| {
        path.as_ref()
            .map_or(String::new(), |path| format!(" {}", path.display()))
    };
    let told = errors.0.iter().map(|error| {
        let CaseError::Nonsense { key, message, .. } = error else {
            return in_options(&error.to_string().replace(&folder, ""));
        };
        let option = match key.as_str() {
            key if key.starts_with("vessel.lumen") && input.lumen.is_some() => {
                format!("--lumen{}: ", shown(&input.lumen))
            }
            key if key.starts_with("tree.lumen") && input.lumen.is_some() => {
                format!("--lumen{}: ", shown(&input.lumen))
            }
            "tree.outlets" => "--names: ".into(),
            "tree.smoothing_m" if input.smoothing.is_some() => "--smoothing: ".into(),
            key if key.starts_with("tree.opening") && key.contains(".flow") => {
                format!("--flow{}: ", shown(&input.flow))
            }
            key if key.starts_with("tree.") && input.line.is_some() => {
                format!("--from {}: ", input.shown_lines())
            }
            "vessel.radius_m" if input.radius.is_some() => "--radius: ".into(),
            key if key.starts_with("vessel.") && input.line.is_some() => {
                format!("--from{}: ", shown(&input.line))
            }
            key if key.starts_with("inflow.") && input.flow.is_some() => {
                format!("--flow{}: ", shown(&input.flow))
            }
            _ => String::new(),
        };
        // What else stands in which file, and the name of the file, which the option has already.
        let message = message
            .split(" (`")
            .next()
            .unwrap_or(message)
            .replace(&folder, "");
        let names = [&input.line, &input.lumen, &input.flow]
            .into_iter()
            .flatten()
            .filter_map(|path| path.file_name());
        let message = names.fold(message, |message, name| {
            let rest = message.strip_prefix(&*name.to_string_lossy());
            let rest = rest.and_then(|rest| rest.strip_prefix(':'));
            match rest.map(|rest| rest.strip_prefix(' ').ok_or(rest)) {
                Some(Ok(rest)) if !option.is_empty() => rest.to_owned(),
                // The number of a line follows.
                Some(Err(rest)) if !option.is_empty() => format!("line {rest}"),
                _ => message,
            }
        });
        format!("{option}{}", in_options(&message))
    });
    let told: Vec<String> = told.collect();
    told.join("\n")
}

pub(super) fn in_options(message: &str) -> String {
    let replaced = |message: String, (key, option): &(&str, &str)| message.replace(key, option);
    OPTIONS.iter().fold(message.to_owned(), replaced)
}

/// What is remarkable about a flow (largest, m³/s) in a lumen of this mean radius (m), and what was understood of its
/// file.
///
/// # Errors
/// If it cannot be meant.
pub fn plausible(
    input: &ProposalInput,
    curve: &FlowCurve,
    [mean, largest]: [f64; 2],
    radius: f64,
) -> Result<Vec<String>, ProposalError> {
    let mut remarks = Vec::new();
    if let Some(table) = curve.table()
        && let Some(path) = &input.flow
    {
        remarks.push(format!(
            "read      {}: {}",
            path.display(),
            table.understood()
        ));
        flow(path, table, [mean, largest], radius, &mut remarks)?;
    }
    let [thin, wide] = RADII;
    if !(thin..=wide).contains(&radius) && (input.line.is_some() || input.radius.is_some()) {
        remarks.push(format!(
            "warning: a radius of {:.3} mm is {} than that of the arteries which are computed: is the unit of the lengths right?",
            1e3 * radius,
            if radius > wide { "larger" } else { "smaller" }
        ));
    }
    Ok(remarks)
}

fn flow(
    path: &Path,
    table: &PeriodicTable,
    [mean, largest]: [f64; 2],
    radius: f64,
    remarks: &mut Vec<String>,
) -> Result<(), ProposalError> {
    let file = path.display();
    if mean < 0.0 && mean.abs() > 0.01 * largest {
        return Err(ProposalError::Input(format!(
            "--flow {file}: the mean flow is {:.0} ml/min: the blood runs backwards, out of the inlet. Values that enter must be \
             positive: change their sign, or call the file x.flow if it is one of SimVascular's 3-D solver; --reverse turns the \
             centre-line round",
            6e7 * mean
        )));
    }
    let velocity = largest / (PI * radius * radius);
    if (VELOCITIES[0]..=VELOCITIES[1]).contains(&velocity) || largest == 0.0 {
        return Ok(());
    }
    let of_unit = |unit: &FlowUnit| {
        let velocity = velocity / table.unit() * unit.si();
        (VELOCITIES[0]..=VELOCITIES[1]).contains(&velocity)
    };
    let likely: Vec<&str> = FlowUnit::ALL
        .into_iter()
        .filter(of_unit)
        .map(FlowUnit::name)
        .collect();
    let advice = match likely.is_empty() {
        true => "is the unit of the lengths right?".to_owned(),
        false => format!("is it in {}? (--flow-unit)", likely.join(" or ")),
    };
    let found = format!(
        "the flow reaches {:.3e} ml/s, a mean velocity of {velocity:.3e} m/s in a lumen of {:.2} mm radius, which no vessel has: {advice}",
        1e6 * largest,
        1e3 * radius
    );
    let is_impossible = !(IMPOSSIBLE[0]..=IMPOSSIBLE[1]).contains(&velocity);
    if is_impossible || table.is_unit_assumed() {
        return Err(ProposalError::Input(format!("--flow {file}: {found}")));
    }
    remarks.push(format!("warning: {found}"));
    Ok(())
}
