//! What a run writes while it advances, and the summary at its end.

use super::tables::{FluidProbeRow, HistoryRow, IterationRow, ProbeRow, Table};
use super::vtu::Series;
use super::wall_record::{WallMemory, WallRecord, WallRecordSettings};
use super::write_atomically;
use crate::coupling::{Iteration, Step};
use crate::processes::peak_memory;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};
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
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
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

/// The figures of a run so far; a resumed run continues them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct Totals {
    /// Accepted time steps.
    pub steps: usize,
    /// Time at the end of the last accepted step.
    pub time_s: f64,
    /// Coupling iterations of all accepted attempts.
    pub coupling_iterations: usize,
    /// Outer correctors of the fluid in these iterations, without the final one of each step.
    pub fluid_correctors: usize,
    /// Largest number of coupling iterations of a step.
    pub max_coupling_iterations: usize,
    /// Attempts at a step that failed.
    pub failed_attempts: usize,
    /// How often OpenFOAM died or fell silent and was started again.
    pub fluid_restarts: usize,
    /// How often the run was resumed.
    pub resumed: usize,
    /// Outlet pressure at the end of the last step.
    #[serde(with = "crate::numbers")]
    pub p_out_Pa: f64,
    /// Wall-clock time of the accepted steps alone.
    pub steps_s: f64,
    /// Wall-clock time of the steps and its parts, without steps that were lost.
    pub wall_s: f64,
    /// The parts.
    pub seconds: Seconds,
    /// Seconds of `rest_s` that writing checkpoints took.
    pub checkpoint_s: f64,
    /// Largest mismatch of the resultant force between the two surfaces, relative to the sum of |load|.
    #[serde(with = "crate::numbers")]
    pub max_force_mismatch: f64,
}

/// What a record needs to continue after the last accepted step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Figures so far.
    pub totals: Totals,
    /// Volume of the whole fluid mesh, m³.
    pub volume: f64,
    /// Bytes of `history.csv`.
    pub history: u64,
    /// Bytes of `iterations.csv`.
    pub iterations: u64,
    /// Bytes of `probes.csv`.
    pub probes: u64,
    /// Bytes of `fluid-probes.csv`.
    pub fluid_probes: u64,
    /// Times (s) and files of the wall's grids.
    pub grids: Vec<(f64, String)>,
    /// What is known of the wall.
    pub wall: WallMemory,
}

/// `summary.json`: the run in figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct Summary {
    /// Version of the program.
    pub version: String,
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
    /// Figures of all steps.
    #[serde(flatten)]
    pub totals: Totals,
    /// Mean number of coupling iterations a step.
    pub mean_coupling_iterations: f64,
    /// Seconds per step, all parts.
    pub seconds_per_step: f64,
    /// Largest memory of the driver.
    pub driver_peak_memory_MB: f64,
    /// Largest memory of the fluid's processes, as far as seen.
    pub fluid_peak_memory_MB: f64,
}

/// Writes the tables and the series of a run, row by row.
pub struct Record {
    settings: RecordSettings,
    history: Table,
    iterations: Table,
    probes: Option<Table>,
    fluid_probes: Option<Table>,
    /// The wall over time.
    pub structure: Series,
    /// The wet surface over time.
    pub wall: WallRecord,
    /// Volume of the whole mesh at the end of the last step, m³.
    volume: f64,
    started: Instant,
    /// Figures so far, up to the start of this process for the wall-clock time as a whole.
    pub totals: Totals,
}

/// What a record needs to know before the first step.
#[derive(Debug, Clone)]
pub struct RecordSettings {
    /// `history.csv`.
    pub history: PathBuf,
    /// `iterations.csv`.
    pub iterations: PathBuf,
    /// `probes.csv`, if there are probes.
    pub probes: Option<PathBuf>,
    /// `fluid-probes.csv`, if there are some in the blood.
    pub fluid_probes: Option<PathBuf>,
    /// `structure.pvd`.
    pub structure: PathBuf,
    /// The wet surface.
    pub wall: WallRecordSettings,
    /// Folder of the case.
    pub case: PathBuf,
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
    pub fn create(settings: RecordSettings) -> io::Result<Self> {
        Ok(Self {
            history: Table::create(&settings.history)?,
            iterations: Table::create(&settings.iterations)?,
            probes: settings.probes.as_deref().map(Table::create).transpose()?,
            fluid_probes: (settings.fluid_probes.as_deref())
                .map(Table::create)
                .transpose()?,
            structure: Series::new(settings.structure.clone())?,
            wall: WallRecord::create(settings.wall.clone())?,
            volume: settings.volume,
            started: Instant::now(),
            totals: Totals::default(),
            settings,
        })
    }

    /// Continues the files of an earlier run; what was written after `memory` is cut off.
    pub fn resume(settings: RecordSettings, memory: Memory) -> io::Result<Self> {
        Ok(Self {
            history: Table::resume(&settings.history, memory.history)?,
            iterations: Table::resume(&settings.iterations, memory.iterations)?,
            probes: (settings.probes.as_deref())
                .map(|path| Table::resume(path, memory.probes))
                .transpose()?,
            fluid_probes: (settings.fluid_probes.as_deref())
                .map(|path| Table::resume(path, memory.fluid_probes))
                .transpose()?,
            structure: Series::resume(settings.structure.clone(), memory.grids)?,
            wall: WallRecord::resume(settings.wall.clone(), memory.wall)?,
            volume: memory.volume,
            started: Instant::now(),
            totals: memory.totals,
            settings,
        })
    }

    /// Goes back to the state of `memory`; only the failures since then are remembered.
    pub fn rewind(&mut self, memory: Memory) -> io::Result<()> {
        let Totals {
            failed_attempts,
            fluid_restarts,
            ..
        } = self.totals;
        *self = Self::resume(self.settings.clone(), memory)?;
        self.totals.failed_attempts = failed_attempts;
        self.totals.fluid_restarts = fluid_restarts;
        Ok(())
    }

    /// What is needed to continue later; everything so far is on the disk when this returns.
    pub fn memory(&self) -> io::Result<Memory> {
        self.history.sync()?;
        self.iterations.sync()?;
        self.probes.iter().try_for_each(Table::sync)?;
        self.fluid_probes.iter().try_for_each(Table::sync)?;
        let length = |path: &Path| std::fs::metadata(path).map(|file| file.len());
        Ok(Memory {
            totals: Totals {
                wall_s: self.wall_seconds(),
                ..self.totals.clone()
            },
            volume: self.volume,
            history: length(&self.settings.history)?,
            iterations: length(&self.settings.iterations)?,
            probes: self.settings.probes.as_deref().map_or(Ok(0), length)?,
            fluid_probes: (self.settings.fluid_probes.as_deref()).map_or(Ok(0), length)?,
            grids: self.structure.entries().to_vec(),
            wall: self.wall.memory()?,
        })
    }

    fn wall_seconds(&self) -> f64 {
        self.totals.wall_s + self.started.elapsed().as_secs_f64()
    }

    /// Adds the rows of the accepted `attempt` at a step, or a part of one, `time_step` (s) long, which took
    /// `wall_seconds` so far; returns the row of the history.
    pub fn step(
        &mut self,
        step: &Step,
        time_step: f64,
        attempt: usize,
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
            Q_in_m3_s: fluid.inflow(),
            Q_out_m3_s: fluid.outflow(),
            p_in_Pa: fluid.inlet_pressure(),
            p_out_Pa: fluid.outlet_pressure(),
            lumen_volume_m3: fluid.volume - self.settings.rigid_volume,
            dVdt_m3_s: (fluid.volume - self.volume) / time_step,
            max_displacement_m: peaks.displacement,
            max_von_mises_Pa: peaks.von_mises,
            p_windkessel_Pa: fluid.outlet_model_pressure(),
            force_mismatch: last.force_mismatch,
            wall_velocity_mismatch_m_s: fluid.wall_velocity_mismatch,
            wall_s: wall_seconds,
        };
        self.iterations
            .append(&iteration_rows(fluid.time, attempt, &step.iterations))?;
        self.history.append(std::slice::from_ref(&row))?;
        self.volume = fluid.volume;
        self.count(&row, &seconds);
        let correctors = step.iterations.iter().map(|i| i.fluid_cost.sweeps as usize);
        self.totals.fluid_correctors += correctors.sum::<usize>();
        Ok(row)
    }

    /// Adds the rows of the probes in the blood at an accepted step.
    pub fn fluid_probes(&mut self, rows: &[FluidProbeRow]) -> io::Result<()> {
        let mut table = self.fluid_probes.iter_mut();
        table.try_for_each(|table| table.append(rows))
    }

    /// Adds the rows of the probes at an accepted step.
    pub fn probes(&mut self, rows: &[ProbeRow]) -> io::Result<()> {
        self.probes
            .as_mut()
            .map_or(Ok(()), |table| table.append(rows))
    }

    /// Adds the rows of a failed `attempt` at the step that ends at `time` (s).
    pub fn failed_attempt(
        &mut self,
        time: f64,
        attempt: usize,
        iterations: &[Iteration],
    ) -> io::Result<()> {
        self.totals.failed_attempts += 1;
        self.iterations
            .append(&iteration_rows(time, attempt, iterations))
    }

    fn count(&mut self, row: &HistoryRow, seconds: &Seconds) {
        let t = &mut self.totals;
        t.time_s = row.time_s;
        t.coupling_iterations += row.coupling_iterations;
        t.max_coupling_iterations = t.max_coupling_iterations.max(row.coupling_iterations);
        t.p_out_Pa = row.p_out_Pa;
        t.steps_s += row.wall_s;
        t.seconds.fluid_s += seconds.fluid_s;
        t.seconds.structure_s += seconds.structure_s;
        t.seconds.coupling_s += seconds.coupling_s;
        t.max_force_mismatch = t.max_force_mismatch.max(row.force_mismatch);
    }

    /// The run in figures, with its `status`, and the reason if it did not complete.
    pub fn summary(&self, status: &str, reason: Option<String>, fluid_peak_memory: f64) -> Summary {
        let mut totals = self.totals.clone();
        totals.wall_s = self.wall_seconds();
        let s = &mut totals.seconds;
        s.rest_s = totals.wall_s - s.fluid_s - s.structure_s - s.coupling_s;
        let steps = totals.steps.max(1) as f64;
        Summary {
            version: env!("CARGO_PKG_VERSION").into(),
            status: status.into(),
            reason,
            case: self.settings.case.display().to_string(),
            fluid_cells: self.settings.fluid_cells,
            structure_dofs: self.settings.structure_dofs,
            mean_coupling_iterations: totals.coupling_iterations as f64 / steps,
            seconds_per_step: totals.wall_s / steps,
            totals,
            driver_peak_memory_MB: peak_memory(std::process::id()).unwrap_or(0.0) / 1e6,
            fluid_peak_memory_MB: fluid_peak_memory / 1e6,
        }
    }
}

impl Summary {
    /// Writes `summary.json`.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let text = serde_json::to_string_pretty(self).map_err(io::Error::other)?;
        write_atomically(path, text.as_bytes())
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

fn iteration_rows(time: f64, attempt: usize, iterations: &[Iteration]) -> Vec<IterationRow> {
    let row = |iteration: &Iteration| {
        let Iteration {
            number,
            measure,
            columns,
            fluid_cost,
            ..
        } = *iteration;
        IterationRow {
            time_s: time,
            attempt,
            iteration: number,
            change: measure.change,
            change_rms_m: measure.change_rms,
            residual: measure.residual,
            residual_rms_m: measure.residual_rms,
            columns,
            correctors: fluid_cost.sweeps,
            pressure_residual: fluid_cost.residual,
            force_mismatch: iteration.force_mismatch,
            fluid_s: iteration.fluid_seconds,
            structure_s: iteration.structure_seconds,
            coupling_s: iteration.coupling_seconds,
        }
    };
    iterations.iter().map(row).collect()
}
