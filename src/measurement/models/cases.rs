//! Real coupled cases, each run with every model: one row after the other, and those that are there already not again.

use super::results::Measured;
use super::variant::Variant;
use crate::case::{BloodVessel, ResolvedCase};
use crate::geometry::Vessel;
use crate::output::{terminal, write_atomically};
use crate::run::{CHECKPOINT_IS_WRITTEN, CaseSelection, Earlier, Failure, Interrupt, RunRequest};
use serde::Serialize;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Stations along the vessel and points around it where the displacement histories are compared.
const PROBES: [usize; 2] = [9, 4];

/// Rows are compared with a run of the case's own settings whose residual is below this share of the limits.
const REFERENCE: f64 = 0.1;

/// Which rows, and where.
pub struct Plan<'a> {
    /// Folder of the results.
    pub out: &'a Path,
    /// Rows, in their order.
    pub variants: Vec<Variant>,
    /// Number of time steps, if not to the end of the case.
    pub steps: Option<usize>,
    /// Preset and values that replace those of the cases.
    pub selection: &'a CaseSelection,
}

/// A row of the table.
#[derive(Debug, Serialize)]
struct CaseRow {
    model: &'static str,
    reuse_steps: usize,
    surrogate: bool,
    complete: bool,
    steps: usize,
    mean_iterations: f64,
    max_iterations: f64,
    mean_iterations_by_residual: f64,
    max_iterations_by_residual: usize,
    /// Steps that were accepted with a residual above the tolerance.
    steps_above_residual: usize,
    fluid_s_per_step: f64,
    structure_s_per_step: f64,
    s_per_step: f64,
    failed_attempts: usize,
    difference: Option<f64>,
}

impl Plan<'_> {
    /// Checks all runs first, then computes those that are missing, and writes `<name>.csv` and `<name>.md` of each
    /// case after every row.
    pub fn run(&self, cases: &[PathBuf]) -> Result<(), Failure> {
        let mut runs = Vec::new();
        for path in cases {
            let base = self.selection.load(path)?;
            let mut chosen = self.selection.clone();
            if let Some(vessel) = base.vessel() {
                chosen = chosen.with("output.probes_m", probes(vessel));
            }
            if let Some(steps) = self.steps {
                let end = steps as f64 * base.time.step;
                chosen = chosen.with("time.end_s", format!("{end:?}"));
            }
            let tight = |limit: f64| format!("{:?}", REFERENCE * limit);
            let reference = (chosen.clone())
                .with("coupling.e_rel", tight(base.coupling.e_rel))
                .with("coupling.e_abs_m", tight(base.coupling.e_abs))
                .with("coupling.criterion", "residual")
                .load(path)?;
            let cases = self.variants.iter().map(|variant| {
                let case = variant.arguments(&chosen, &base).load(path)?;
                Ok((*variant, case))
            });
            runs.push((path, reference, cases.collect::<Result<Vec<_>, Failure>>()?));
        }
        let interrupt = Interrupt::listen(Some(CHECKPOINT_IS_WRITTEN))?;
        for (path, reference, cases) in &runs {
            self.table(path, reference, cases, &interrupt)?;
        }
        Ok(())
    }

    fn table(
        &self,
        path: &Path,
        reference: &ResolvedCase,
        cases: &[(Variant, ResolvedCase)],
        interrupt: &Interrupt,
    ) -> Result<(), Failure> {
        let name = format!("{}-{}", folder_name(path), self.selection.preset);
        let folder = self.out.join(&name);
        let mut rows: Vec<(Variant, Measured)> = Vec::new();
        terminal::print(format_args!("{name}\n"))?;
        let measure = |name: &str, case: &ResolvedCase| {
            let run = folder.join(name);
            if let Some(measured) = finished(&run, case)? {
                return Ok(measured);
            }
            compute(path, case, &run, interrupt)?;
            finished(&run, case)?
                .ok_or_else(|| Failure::Run(format!("{} has left no summary.json", run.display())))
        };
        let reference = measure("reference", reference)?;
        for (variant, case) in cases {
            rows.push((*variant, measure(&variant.name(), case)?));
            let table = table(&rows, &reference);
            let newest = markdown(&table[table.len() - 1..]);
            terminal::print(format_args!("{newest}\n"))?;
            let written = |error: std::io::Error| {
                Failure::Run(format!("cannot write the comparison: {error}"))
            };
            let file = |extension: &str| self.out.join(format!("{name}.{extension}"));
            write_atomically(&file("csv"), csv(&table).map_err(written)?.as_bytes())
                .and_then(|()| {
                    write_atomically(
                        &file("md"),
                        (HEAD.to_owned() + &markdown(&table)).as_bytes(),
                    )
                })
                .map_err(written)?;
        }
        Ok(())
    }
}

/// What the run in this folder has measured, if it is one of this case and has ended.
fn finished(run: &Path, case: &ResolvedCase) -> Result<Option<Measured>, Failure> {
    let same = fs::read_to_string(run.join("case.resolved.toml"))
        .is_ok_and(|text| text == case.to_toml_string());
    if !same {
        return Ok(None);
    }
    Measured::read(run, case.coupling.e_rel)
        .map_err(|e| Failure::Run(format!("cannot read the results in {}: {e}", run.display())))
}

/// Runs the case, from a checkpoint if there is one. A run that fails is a row as well.
fn compute(
    path: &Path,
    case: &ResolvedCase,
    run: &Path,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let begun = run.join("case.resolved.toml").exists();
    let order = RunRequest {
        path,
        case,
        out: run,
        earlier: if begun {
            Earlier::Resume
        } else {
            Earlier::Keep
        },
        quiet: true,
    };
    fs::create_dir_all(run.parent().unwrap_or(run))
        .map_err(|e| Failure::Input(format!("cannot create {}: {e}", run.display())))?;
    match order.execute(interrupt.clone()) {
        Err(Failure::Run(reason)) => {
            terminal::note(format_args!("{}: {reason}", run.display()));
            Ok(())
        }
        outcome => outcome,
    }
}

/// Points of the unloaded lumen's surface all over the deformable part, as a value of `output.probes_m`.
fn probes(vessel: &BloodVessel) -> String {
    let vessel = Vessel::new(vessel);
    let [along, around] = PROBES;
    let mut points = Vec::new();
    for i in 1..=along {
        let x = vessel.end() * i as f64 / (along + 1) as f64;
        for j in 0..around {
            let phi = TAU * j as f64 / around as f64;
            let r = vessel.lumen_radius(x, phi);
            let point = vessel
                .centre_line()
                .frame(x)
                .point(r * phi.cos(), r * phi.sin());
            points.push([point.x, point.y, point.z]);
        }
    }
    format!("{points:?}")
}

/// Rows with the difference of their displacement histories to the reference.
fn table(rows: &[(Variant, Measured)], reference: &Measured) -> Vec<CaseRow> {
    rows.iter()
        .map(|(variant, m)| CaseRow {
            model: variant.kind.name(),
            reuse_steps: variant.reuse,
            surrogate: variant.surrogate,
            complete: m.complete,
            steps: m.steps,
            mean_iterations: m.by_criterion[0],
            max_iterations: m.by_criterion[1],
            mean_iterations_by_residual: m.by_residual.mean,
            max_iterations_by_residual: m.by_residual.most,
            steps_above_residual: m.by_residual.open,
            fluid_s_per_step: m.seconds[0],
            structure_s_per_step: m.seconds[1],
            s_per_step: m.seconds[2],
            failed_attempts: m.failed,
            difference: (m.complete && reference.complete).then(|| m.difference(reference)),
        })
        .collect()
}

const HEAD: &str = "\
| model | q | surrogate | steps | iterations (14) | by residual | fluid, s | structure, s | all, s | failed | difference |
| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |
";

/// Mean (largest) numbers of iterations per step, and seconds per step.
fn markdown(rows: &[CaseRow]) -> String {
    let mut text = String::new();
    for row in rows {
        let steps = if row.complete {
            row.steps.to_string()
        } else {
            format!("stopped after {}", row.steps)
        };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {steps} | {:.2} ({}) | {}{:.2} ({}) | {:.2} | {:.2} | {:.2} | {} | {} |",
            row.model,
            row.reuse_steps,
            if row.surrogate { "yes" } else { "no" },
            row.mean_iterations,
            row.max_iterations,
            if row.steps_above_residual > 0 {
                "≥ "
            } else {
                ""
            },
            row.mean_iterations_by_residual,
            row.max_iterations_by_residual,
            row.fluid_s_per_step,
            row.structure_s_per_step,
            row.s_per_step,
            row.failed_attempts,
            row.difference.map_or("–".into(), |d| format!("{d:.1e}")),
        );
    }
    text
}

fn csv(rows: &[CaseRow]) -> std::io::Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.serialize(row))?;
    let bytes = writer.into_inner().map_err(|e| e.into_error())?;
    String::from_utf8(bytes).map_err(std::io::Error::other)
}

/// The last part of a path that names something: `S-0.25` of `openfoam-case/S-0.25/.`.
fn folder_name(path: &Path) -> String {
    let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    whole.file_name().map_or_else(
        || "case".to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}
