//! Seconds per step, by part, and their comparison.

use crate::analysis::size;
use crate::case::Case;
use crate::fluid::FluidUsage;
use crate::output::write_atomically;
use crate::pfem::solution::stats::Stats;
use crate::processes::{cpu_seconds, peak_memory};
use crate::run::{CoupledRun, Failure};
use crate::simulation::totals::Totals;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Means over the measured steps; seconds of wall-clock time unless the name says CPU.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct Budget {
    pub coupling_iterations: f64,
    /// Outer correctors.
    pub fluid_correctors: f64,
    pub newton_iterations: f64,
    pub factorizations: f64,
    pub step_s: f64,
    /// The fluid as the driver sees it: from the question to the answer.
    pub fluid_s: f64,
    /// What the fluid says of its own seconds, by part: `fluid_momentum_s` and others.
    #[serde(flatten)]
    pub fluid_parts: BTreeMap<String, f64>,
    pub structure_s: f64,
    pub structure_residual_s: f64,
    pub structure_substitution_s: f64,
    pub structure_assembly_s: f64,
    pub structure_factorization_s: f64,
    pub structure_rest_s: f64,
    /// Transfer between the surfaces and acceleration.
    pub coupling_s: f64,
    /// Stresses, tables, fields, checkpoints.
    pub output_s: f64,
    pub fluid_cpu_s: f64,
    pub driver_cpu_s: f64,
    pub driver_peak_memory_MB: f64,
    pub fluid_peak_memory_MB: f64,
}

impl Budget {
    /// Names, values, and whether they are parts of `step_s`, of whom the share is shown.
    fn rows(&self) -> Vec<(String, f64, bool)> {
        let row = |(name, value, is_share): (&str, f64, bool)| (name.to_owned(), value, is_share);
        let mut rows = Vec::from(
            [
                ("coupling iterations", self.coupling_iterations, false),
                ("fluid correctors", self.fluid_correctors, false),
                ("Newton iterations", self.newton_iterations, false),
                ("factorizations", self.factorizations, false),
                ("step, s", self.step_s, true),
                ("  fluid, s", self.fluid_s, true),
            ]
            .map(row),
        );
        // `fluid_mesh_motion_s` is shown as `mesh motion, s`.
        rows.extend(self.fluid_parts.iter().map(|(key, seconds)| {
            let part = key.trim_start_matches("fluid_").trim_end_matches("_s");
            (format!("    {}, s", part.replace('_', " ")), *seconds, true)
        }));
        rows.extend(
            [
                ("  structure, s", self.structure_s, true),
                ("    residual, s", self.structure_residual_s, true),
                ("    substitution, s", self.structure_substitution_s, true),
                ("    assembly, s", self.structure_assembly_s, true),
                ("    factorization, s", self.structure_factorization_s, true),
                ("    rest, s", self.structure_rest_s, true),
                ("  transfer and acceleration, s", self.coupling_s, true),
                ("  output, s", self.output_s, true),
                ("fluid, CPU s", self.fluid_cpu_s, false),
                ("driver, CPU s", self.driver_cpu_s, false),
                ("driver, MB", self.driver_peak_memory_MB, false),
                ("fluid, MB", self.fluid_peak_memory_MB, false),
            ]
            .map(row),
        );
        rows
    }
}

/// What was measured, and on what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BudgetReport {
    pub version: String,
    pub case: String,
    pub preset: String,
    pub fluid_cells: usize,
    pub structure_dofs: usize,
    pub ranks: usize,
    pub threads: usize,
    /// Time of the warm state.
    pub from_s: f64,
    pub steps: usize,
    pub per_step: Budget,
}

impl BudgetReport {
    /// Writes the figures as JSON.
    pub fn write(&self, path: &Path) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self).expect("plain data can be written");
        write_atomically(path, text.as_bytes())
            .map_err(|e| Failure::Run(format!("cannot write {e}")))
    }

    /// Reads figures that [`BudgetReport::write`] has written.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let wrong = |what: &dyn std::fmt::Display| {
            Failure::Input(format!(
                "{}: {what}; give a file that --json has written",
                path.display()
            ))
        };
        let text = fs::read_to_string(path).map_err(|e| wrong(&e))?;
        serde_json::from_str(&text).map_err(|e| wrong(&e))
    }

    /// Refuses to compare what cannot be compared.
    pub fn check(&self, preset: &str, case: &Case) -> Result<(), Failure> {
        let cells = size::fluid_cells(case);
        if (self.preset.as_str(), self.fluid_cells) == (preset, cells) {
            return Ok(());
        }
        Err(Failure::Input(format!(
            "--compare: the figures are of {} fluid cells (preset {}), the case has {cells} (preset {preset}); measure both with the same case",
            self.fluid_cells, self.preset
        )))
    }

    /// A table, with the `old` figures and their ratio if there are any.
    pub fn table(&self, old: Option<&Self>) -> String {
        let mut text = format!(
            "{} with --preset {}: {} fluid cells, {} structural degrees of freedom, {} rank(s), {} thread(s); mean of {} steps from t = {:.4} s\n\n{:<32}{:>10}{:>8}",
            self.case,
            self.preset,
            self.fluid_cells,
            self.structure_dofs,
            self.ranks,
            self.threads,
            self.steps,
            self.from_s,
            "per step",
            "now",
            "share"
        );
        text += if old.is_some() {
            "       old   now/old\n"
        } else {
            "\n"
        };
        let before = old.map(|report| report.per_step.rows());
        for (name, value, is_share) in self.per_step.rows() {
            let share = match is_share {
                true => format!("{:.1} %", 100.0 * value / self.per_step.step_s),
                false => String::new(),
            };
            let _ = write!(text, "{name:<32}{value:>10.4}{share:>8}");
            let old = (before.iter().flatten()).find(|row| row.0 == name);
            if let Some(&(_, old, _)) = old {
                let ratio = if old == 0.0 { f64::NAN } else { value / old };
                let _ = write!(text, "{old:>10.4}{ratio:>10.2}");
            }
            text.push('\n');
        }
        text
    }
}

/// Counters at the start of the measurement.
pub struct Meter {
    totals: Totals,
    stats: Stats,
    fluid: FluidUsage,
    fluid_parts: Vec<(String, f64)>,
    /// With that of the fluid's processes.
    cpu_seconds: f64,
}

impl Meter {
    /// From now on.
    pub fn start(run: &CoupledRun) -> Self {
        Self {
            totals: run.simulation.totals(),
            stats: run.simulation.coupling.solid.stats(),
            fluid: run.simulation.fluid_usage(),
            fluid_parts: run.simulation.fluid_seconds().to_vec(),
            cpu_seconds: cpu_seconds(std::process::id()),
        }
    }

    /// The means over all steps until now.
    pub fn stop(self, run: &CoupledRun) -> Budget {
        let (before, after) = (&self.totals, &run.simulation.totals());
        let steps = (after.steps - before.steps) as f64;
        let mean = |before: f64, after: f64| (after - before) / steps;
        let count = |before: usize, after: usize| (after - before) as f64 / steps;
        let seconds = |part: fn(&Totals) -> f64| mean(part(before), part(after));
        let (s0, s1) = (self.stats, run.simulation.coupling.solid.stats());
        let stats = |part: fn(&Stats) -> f64| mean(part(&s0), part(&s1));

        let mut budget = Budget {
            coupling_iterations: count(before.coupling_iterations, after.coupling_iterations),
            fluid_correctors: count(before.fluid_correctors, after.fluid_correctors),
            newton_iterations: count(s0.iterations, s1.iterations),
            factorizations: count(s0.factorizations, s1.factorizations),
            step_s: seconds(|t| t.steps_s),
            fluid_s: seconds(|t| t.seconds.fluid_s),
            structure_s: seconds(|t| t.seconds.structure_s),
            structure_residual_s: stats(|s| s.residual_s),
            structure_substitution_s: stats(|s| s.substitution_s),
            structure_assembly_s: stats(|s| s.assembly_s),
            structure_factorization_s: stats(|s| s.factorization_s),
            coupling_s: seconds(|t| t.seconds.coupling_s),
            fluid_cpu_s: mean(
                self.fluid.cpu_seconds,
                run.simulation.fluid_usage().cpu_seconds,
            ),
            driver_peak_memory_MB: peak_memory(std::process::id()).unwrap_or(0.0) / 1e6,
            fluid_peak_memory_MB: run.simulation.fluid_usage().peak_memory / 1e6,
            ..Budget::default()
        };
        let all = mean(self.cpu_seconds, cpu_seconds(std::process::id()));
        budget.driver_cpu_s = all - budget.fluid_cpu_s;
        let mut rest = budget.fluid_s;
        for (part, after) in run.simulation.fluid_seconds() {
            let before = self.fluid_parts.iter().find(|(name, _)| name == part);
            let seconds = mean(before.map_or(0.0, |(_, seconds)| *seconds), *after);
            rest -= seconds;
            let key = format!("fluid_{}_s", part.replace(' ', "_"));
            budget.fluid_parts.insert(key, seconds);
        }
        // Assembly of the equations, fluxes, exchange.
        budget.fluid_parts.insert("fluid_rest_s".into(), rest);
        budget.structure_rest_s = budget.structure_s
            - budget.structure_residual_s
            - budget.structure_substitution_s
            - budget.structure_assembly_s
            - budget.structure_factorization_s;
        budget.output_s = budget.step_s - budget.fluid_s - budget.structure_s - budget.coupling_s;
        budget
    }
}
