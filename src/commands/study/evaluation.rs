//! The tables of a study: measures, what samples of uncertain inputs say, and what is compared with them.

use super::Arguments;
use crate::commands::{Failure, report as report_command, tables};
use crate::output::report::{self, CONTROL, ExportForm, MeasuredValue, TOTAL, Uncertainty};
use crate::output::results::Results;
use crate::output::{terminal, write_atomically};
use std::path::Path;

/// Parameters and measures of the runs of a study, in its folder.
const MEASURES: &str = "measures.csv";

/// Writes all that is asked for of the runs that are done; `samples` is how many there should be, of a study of
/// samples.
pub(super) fn write(
    arguments: &Arguments,
    runs: &[Results],
    out: &Path,
    samples: Option<usize>,
) -> Result<(), Failure> {
    write_measures(runs, out)?;
    let (Some(all), Some(run)) = (samples, runs.first()) else {
        return Ok(());
    };
    // Its polynomials take longer than all the tables.
    let Some(found) = uncertainty(runs, out)? else {
        return Ok(());
    };
    write_uncertainty(&found, run, all, out, &arguments.export)?;
    if let Some(cheap) = &arguments.control {
        write_control(&found, runs, out, cheap)?;
    }
    if !arguments.refined.is_empty() {
        write_total(&found, run, out, arguments)?;
    }
    Ok(())
}

/// What the runs of the study in a folder say of its inputs, if these were sampled.
fn uncertainty(runs: &[Results], folder: &Path) -> Result<Option<Uncertainty>, Failure> {
    let found = Uncertainty::of(&runs.iter().collect::<Vec<_>>(), folder);
    found.map_err(|e| Failure::Run(e.to_string()))
}

/// Writes parameters and measures of the runs that are done.
fn write_measures(runs: &[Results], out: &Path) -> Result<(), Failure> {
    if runs.is_empty() {
        return Ok(());
    }
    let table = report::measures(&runs.iter().collect::<Vec<_>>());
    write_atomically(&out.join(MEASURES), table.to_csv().as_bytes())
        .map_err(|e| Failure::Run(format!("cannot write {e}")))
}

/// Writes what the samples that are done say of the inputs, and says how many they are.
fn write_uncertainty(
    found: &Uncertainty,
    run: &Results,
    all: usize,
    out: &Path,
    export: &[ExportForm],
) -> Result<(), Failure> {
    let tables = found.tables(run).into_iter();
    let tables = tables.map(|(name, table)| (name.to_owned(), table.to_csv()));
    let exported = export.iter().flat_map(|form| found.export(*form));
    for (name, text) in tables.chain(exported) {
        let path = out.join(name);
        let folder = path.parent().unwrap_or(out);
        std::fs::create_dir_all(folder)
            .and_then(|()| write_atomically(&path, text.as_bytes()))
            .map_err(|e| Failure::Run(format!("cannot write {e}")))?;
    }
    terminal::note(format_args!(
        "indices and moments are of {} of {all} samples: {}",
        found.used(),
        out.display()
    ));
    Ok(())
}

/// Writes the means with the runs of a cheaper study as control variates.
fn write_control(
    found: &Uncertainty,
    runs: &[Results],
    out: &Path,
    cheap: &Path,
) -> Result<(), Failure> {
    let study = report_command::study(cheap, Results::load)?;
    let cheaper = uncertainty(&study.runs, cheap)?;
    let cheaper =
        cheaper.ok_or_else(|| Failure::Run(format!("{} has no samples", cheap.display())))?;
    let costs = [runs, &study.runs].map(|runs| {
        let seconds = runs
            .iter()
            .flat_map(|run| &run.history)
            .map(|row| row.wall_s);
        seconds.sum::<f64>() / runs.len() as f64
    });
    let table = found.controlled_by(&cheaper, costs);
    let table = table.map_err(|e| Failure::Input(format!("--control {}: {e}", cheap.display())))?;
    let path = out.join(CONTROL);
    write_atomically(&path, table.to_csv().as_bytes())
        .map_err(|e| Failure::Run(format!("cannot write {e}")))?;
    terminal::print(format_args!("{}", table.to_markdown()))?;
    Ok(())
}

/// Writes numerical uncertainties beside those by the inputs.
fn write_total(
    found: &Uncertainty,
    sample: &Results,
    out: &Path,
    arguments: &Arguments,
) -> Result<(), Failure> {
    let load = |path: &str| {
        let run = Results::load(Path::new(path));
        run.map_err(|e| Failure::Input(format!("--refined: {e}")))
    };
    let series = tables::refinement_series(&arguments.refined, "--refined ", load)?;
    let measured: Vec<MeasuredValue> = (arguments.measured.iter())
        .map(|text| measured_value(text, found))
        .collect::<Result<_, _>>()?;
    let table = found.total(&sample.case, &series, &measured);
    let table = table.map_err(|e| Failure::Input(format!("--refined: {e}")))?;
    write_atomically(&out.join(TOTAL), table.to_csv().as_bytes())
        .map_err(|e| Failure::Run(format!("cannot write {e}")))?;
    terminal::print(format_args!("{}", table.to_markdown()))?;
    Ok(())
}

fn measured_value(text: &str, study: &Uncertainty) -> Result<MeasuredValue, Failure> {
    let wrong = |what: &str| Failure::Input(format!("--measured '{text}': {what}"));
    let parts = text.rsplit_once('=').and_then(|(name, numbers)| {
        let (value, uncertainty) = numbers.split_once(',')?;
        let numbers = [value, uncertainty].map(|x| x.trim().parse::<f64>().ok());
        Some((name.trim(), numbers[0]?, numbers[1]?))
    });
    match parts {
        Some((name, value, uncertainty)) if value.is_finite() && uncertainty >= 0.0 => {
            Ok(MeasuredValue {
                measure: study
                    .measure_called(name)
                    .map_err(|e| wrong(&e))?
                    .to_owned(),
                value,
                uncertainty,
            })
        }
        _ => Err(wrong(
            "expected MEASURE=VALUE,UNCERTAINTY with numbers, such as 'inlet pressure, highest=120,2'",
        )),
    }
}
