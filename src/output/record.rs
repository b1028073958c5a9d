//! What a run writes while it advances, and the summary at its end.

use super::tables::{HistoryRow, IterationRow, Table};
use super::vtu::Series;
use super::write_atomically;
use crate::coupling::{Iteration, Step};
use serde::Serialize;
use std::io;
use std::path::Path;
use std::time::Instant;

/// Largest values of the wall at the end of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WallPeaks {
    /// Largest displacement of the wet surface, m.
    pub displacement: f64,
    /// Largest von Mises stress at the quadrature points, Pa.
    pub von_mises: f64,
}

/// Seconds of wall-clock time by where they went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Seconds {
    /// In the fluid, the final corrector of each step included.
    pub fluid_s: f64,
    /// In the structure.
    pub structure_s: f64,
    /// In transfer and acceleration.
    pub coupling_s: f64,
    /// In output and everything else.
    pub rest_s: f64,
}

/// `summary.json`: the run in figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct Summary {
    /// Version of the program.
    pub version: &'static str,
    /// `complete`, `interrupted` or `failed`.
    pub status: String,
    /// Why it did not complete.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Folder of the case.
    pub case: String,
    /// Cells of the fluid.
    pub fluid_cells: usize,
    /// Degrees of freedom of the structure.
    pub structure_dofs: usize,
    /// Accepted time steps.
    pub steps: usize,
    /// Time at the end of the last accepted step.
    pub time_s: f64,
    /// Coupling iterations of all steps.
    pub coupling_iterations: usize,
    /// Mean number of coupling iterations a step.
    pub mean_coupling_iterations: f64,
    /// Largest number of coupling iterations of a step.
    pub max_coupling_iterations: usize,
    /// Outlet pressure at the end of the last step.
    pub p_out_Pa: f64,
    /// Wall-clock time of the steps and its parts.
    pub wall_s: f64,
    /// The parts.
    pub seconds: Seconds,
    /// Seconds per step, all parts.
    pub seconds_per_step: f64,
    /// Largest mismatch of the resultant force between the two surfaces, relative to the sum of |load|.
    pub max_force_mismatch: f64,
    /// Largest memory of the driver.
    pub driver_peak_memory_MB: f64,
    /// Largest memory of the fluid's processes, as far as seen.
    pub fluid_peak_memory_MB: f64,
}

/// Writes the tables and the series of a run, row by row.
pub struct Record {
    history: Table,
    iterations: Table,
    /// The wall over time.
    pub structure: Series,
    time_step: f64,
    /// Volume of the rigid extension, m³.
    rigid_volume: f64,
    /// Volume of the whole mesh at the end of the last step, m³.
    volume: f64,
    started: Instant,
    summary: Summary,
}

/// What a record needs to know before the first step.
#[derive(Debug, Clone)]
pub struct RecordSettings<'a> {
    /// `history.csv`.
    pub history: &'a Path,
    /// `iterations.csv`.
    pub iterations: &'a Path,
    /// `structure.pvd`.
    pub structure: &'a Path,
    /// Folder of the case.
    pub case: &'a Path,
    /// Length of a time step, s.
    pub time_step: f64,
    /// Volume of the rigid extension, m³.
    pub rigid_volume: f64,
    /// Volume of the whole fluid mesh at rest, m³.
    pub volume: f64,
    /// Cells of the fluid.
    pub fluid_cells: usize,
    /// Degrees of freedom of the structure.
    pub structure_dofs: usize,
}

impl Record {
    /// Creates the files.
    pub fn create(settings: &RecordSettings) -> io::Result<Self> {
        Ok(Self {
            history: Table::create(settings.history)?,
            iterations: Table::create(settings.iterations)?,
            structure: Series::new(settings.structure.to_owned())?,
            time_step: settings.time_step,
            rigid_volume: settings.rigid_volume,
            volume: settings.volume,
            started: Instant::now(),
            summary: Summary {
                version: env!("CARGO_PKG_VERSION"),
                status: "running".into(),
                reason: None,
                case: settings.case.display().to_string(),
                fluid_cells: settings.fluid_cells,
                structure_dofs: settings.structure_dofs,
                steps: 0,
                time_s: 0.0,
                coupling_iterations: 0,
                mean_coupling_iterations: 0.0,
                max_coupling_iterations: 0,
                p_out_Pa: 0.0,
                wall_s: 0.0,
                seconds: Seconds::default(),
                seconds_per_step: 0.0,
                max_force_mismatch: 0.0,
                driver_peak_memory_MB: 0.0,
                fluid_peak_memory_MB: 0.0,
            },
        })
    }

    /// Adds the rows of an accepted step, which took `wall_seconds` so far; returns the row of the history.
    pub fn step(
        &mut self,
        step: &Step,
        peaks: WallPeaks,
        wall_seconds: f64,
    ) -> io::Result<HistoryRow> {
        let seconds = seconds_of(step, wall_seconds);
        let last = step
            .iterations
            .last()
            .expect("a step has at least one iteration");
        let fluid = &step.fluid;
        let row = HistoryRow {
            time_s: fluid.time,
            coupling_iterations: step.iterations.len(),
            residual: last.measure.residual,
            fluid_s: seconds.fluid_s,
            structure_s: seconds.structure_s,
            Q_in_m3_s: fluid.inflow,
            Q_out_m3_s: fluid.outflow,
            p_in_Pa: fluid.inlet_pressure,
            p_out_Pa: fluid.outlet_pressure,
            lumen_volume_m3: fluid.volume - self.rigid_volume,
            dVdt_m3_s: (fluid.volume - self.volume) / self.time_step,
            max_displacement_m: peaks.displacement,
            max_von_mises_Pa: peaks.von_mises,
            p_windkessel_Pa: fluid.windkessel_pressure,
            force_mismatch: last.force_mismatch,
            wall_velocity_mismatch_m_s: fluid.wall_velocity_mismatch,
            wall_s: wall_seconds,
        };
        let iterations: Vec<_> = step
            .iterations
            .iter()
            .map(|i| iteration_row(fluid.time, i))
            .collect();
        self.iterations.append(&iterations)?;
        self.history.append(std::slice::from_ref(&row))?;
        self.volume = fluid.volume;
        self.count(&row, &seconds);
        Ok(row)
    }

    fn count(&mut self, row: &HistoryRow, seconds: &Seconds) {
        let s = &mut self.summary;
        s.steps += 1;
        s.time_s = row.time_s;
        s.coupling_iterations += row.coupling_iterations;
        s.mean_coupling_iterations = s.coupling_iterations as f64 / s.steps as f64;
        s.max_coupling_iterations = s.max_coupling_iterations.max(row.coupling_iterations);
        s.p_out_Pa = row.p_out_Pa;
        s.seconds.fluid_s += seconds.fluid_s;
        s.seconds.structure_s += seconds.structure_s;
        s.seconds.coupling_s += seconds.coupling_s;
        s.max_force_mismatch = s.max_force_mismatch.max(row.force_mismatch);
    }

    /// Writes `summary.json` with the final `status`, and the reason if the run did not complete; returns it.
    pub fn finish(
        mut self,
        path: &Path,
        status: &str,
        reason: Option<String>,
        fluid_peak_memory: f64,
    ) -> io::Result<Summary> {
        let s = &mut self.summary;
        s.status = status.into();
        s.reason = reason;
        s.wall_s = self.started.elapsed().as_secs_f64();
        s.seconds.rest_s =
            s.wall_s - s.seconds.fluid_s - s.seconds.structure_s - s.seconds.coupling_s;
        s.seconds_per_step = s.wall_s / s.steps.max(1) as f64;
        s.driver_peak_memory_MB = peak_memory("self").unwrap_or(0.0) / 1e6;
        s.fluid_peak_memory_MB = fluid_peak_memory / 1e6;
        write_atomically(
            path,
            serde_json::to_string_pretty(s)
                .map_err(io::Error::other)?
                .as_bytes(),
        )?;
        Ok(self.summary)
    }
}

fn seconds_of(step: &Step, wall_seconds: f64) -> Seconds {
    let sum = |part: fn(&Iteration) -> f64| step.iterations.iter().map(part).sum::<f64>();
    let fluid_s = sum(|i| i.fluid_seconds) + step.accept_seconds;
    let structure_s = sum(|i| i.structure_seconds);
    let coupling_s = sum(|i| i.coupling_seconds);
    Seconds {
        fluid_s,
        structure_s,
        coupling_s,
        rest_s: wall_seconds - fluid_s - structure_s - coupling_s,
    }
}

fn iteration_row(time: f64, iteration: &Iteration) -> IterationRow {
    let Iteration {
        number,
        measure,
        columns,
        correctors,
        pressure_residual,
        ..
    } = *iteration;
    IterationRow {
        time_s: time,
        iteration: number,
        change: measure.change,
        change_rms_m: measure.change_rms,
        residual: measure.residual,
        residual_rms_m: measure.residual_rms,
        columns,
        correctors,
        pressure_residual,
        force_mismatch: iteration.force_mismatch,
        fluid_s: iteration.fluid_seconds,
        structure_s: iteration.structure_seconds,
        coupling_s: iteration.coupling_seconds,
    }
}

/// Largest resident memory so far of the process with this id (or `self`), bytes; `None` if it is gone.
pub fn peak_memory(process: &str) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0)
}
