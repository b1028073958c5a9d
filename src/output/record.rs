//! What a run writes while it advances, and the summary at its end.

use super::beats::Beats;
use super::field_series::FieldSeries;
use super::fluid_fields;
use super::opening_summary::OpeningSummary;
use super::probes::{Probes, fluid_rows};
use super::run_files::RunFiles;
use super::tables::{CsvTable, HistoryRow, IterationRow, OpeningRow, SectionRow};
use super::vtu::VtuSeries;
use super::wall_record::{WallMemory, WallRecord, WallRecordSettings};
use super::write_atomically;
use crate::Vec3;
use crate::analysis;
use crate::case::{Case, Windows};
use crate::coupling::{Iteration, Step};
use crate::fluid::{Fluid, FluidStep, OpeningReport};
use crate::hemodynamics::cross_section::{CrossSection, CrossSectionPlace, SweptVolumes, observe};
use crate::hemodynamics::{Agreement, Monitor, Resolution, Steadiness, WallState};
use crate::pfem::solid::StressPeak;
use crate::pfem::{SolidError, Structure};
use crate::processes::peak_memory;
use crate::simulation::assembly::surroundings::fields_to_open;
use crate::simulation::assembly::{CoupledModel, Unloading};
use crate::simulation::observer::{AcceptedStep, AcceptedWall, FailedAttempt, Observer};
use crate::simulation::totals::{Seconds, Totals};
use fsi_numerics::twelve_digits;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

/// What a record needs to continue after the last accepted step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordMemory {
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
    /// Bytes of `openings.csv`.
    pub openings: u64,
    /// Bytes of `sections.csv`, and what is known of the cross-sections.
    #[serde(default)]
    pub sections: (u64, SweptVolumes),
    /// Times (s) and files of the wall's grids.
    pub grids: Vec<(f64, String)>,
    /// The same of the blood's.
    pub fluid_grids: Vec<(f64, String)>,
    /// What is known of the wall.
    pub wall: WallMemory,
}

/// `summary.json`: the run in figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct RunSummary {
    /// Version of the program.
    pub version: String,
    /// The OpenFOAM that computed the blood, its number first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub openfoam: Option<String>,
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
    /// Where the unloaded shape of the wall comes from, if it is not the given one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unloading: Option<Unloading>,
    /// Whether its flow is resolved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resolution: Option<Resolution>,
    /// Whether it has become steady, if its inputs are constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steadiness: Option<Steadiness>,
    /// How well its last two beats agree, if it runs until they do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub periodic: Option<Agreement>,
    /// What passes through each opening over the window that the run evaluates.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub openings: Vec<OpeningSummary>,
    /// Figures of all steps.
    #[serde(flatten)]
    pub totals: Totals,
    /// Mean number of coupling iterations per step.
    pub mean_coupling_iterations: f64,
    /// Seconds per step, all parts.
    pub seconds_per_step: f64,
    /// Largest memory of the driver.
    pub driver_peak_memory_MB: f64,
    /// Largest memory of the fluid's processes, as far as seen.
    pub fluid_peak_memory_MB: f64,
}

/// Watches a run: writes its tables, the wall's fields, and what is known of the wet surface.
pub struct Record {
    settings: RecordSettings,
    history: CsvTable,
    iterations: CsvTable,
    probes: Option<(Probes<Structure>, CsvTable)>,
    fluid_probes: Option<CsvTable>,
    openings: CsvTable,
    sections: Option<Sections>,
    fields: FieldSeries,
    fluid_fields: Option<VtuSeries>,
    wall: WallRecord,
    /// Volume of the whole mesh at the end of the last step, m³.
    volume: f64,
}

/// The cross-sections that are watched.
struct Sections {
    all: Vec<CrossSection>,
    table: CsvTable,
    swept: SweptVolumes,
}

impl Sections {
    /// Those of a run, if there are any, with their table.
    fn new(
        settings: &RecordSettings,
        swept: SweptVolumes,
        table: impl FnOnce(&Path) -> io::Result<CsvTable>,
    ) -> io::Result<Option<Self>> {
        let wall = settings.wall.monitor.wall();
        let section = |place: &CrossSectionPlace| {
            let found = CrossSection::new(wall, place);
            found.ok_or_else(|| {
                io::Error::other(format!(
                    "the cross-section {:?} does not part the wall",
                    place.name
                ))
            })
        };
        let all: Vec<CrossSection> = (settings.section_places.iter())
            .map(section)
            .collect::<Result<_, _>>()?;
        if all.is_empty() {
            return Ok(None);
        }
        let table = table(&settings.sections)?;
        Ok(Some(Self { all, table, swept }))
    }

    /// Writes their rows for a step.
    fn add(&mut self, settings: &RecordSettings, state: &WallState, step: &Step) -> io::Result<()> {
        let found = observe(
            &self.all,
            settings.wall.monitor.wall(),
            state,
            &step.wall_pressure,
            &step.fluid.openings,
            &mut self.swept,
            settings.is_second_order,
        );
        let rows = settings
            .section_places
            .iter()
            .zip(found)
            .map(|(place, found)| SectionRow {
                time_s: state.time,
                section: place.name.clone(),
                flow_m3_s: found.flow,
                p_Pa: found.pressure,
                area_m2: found.area,
            });
        self.table.append(&rows.collect::<Vec<_>>())
    }
}

/// What a record needs to know before the first step.
#[derive(Debug, Clone)]
pub struct RecordSettings {
    /// `history.csv`.
    pub history: PathBuf,
    /// `iterations.csv`.
    pub iterations: PathBuf,
    /// `probes.csv`.
    pub probes: PathBuf,
    /// Points of the unloaded wet surface that are followed, m.
    pub probe_points: Vec<Vec3>,
    /// Centres of the fluid's faces on the unloaded wall, m.
    pub face_centres: Vec<Vec3>,
    /// `fluid-probes.csv`.
    pub fluid_probes: PathBuf,
    /// Points in the blood that are watched, m.
    pub fluid_probe_points: Vec<[f64; 3]>,
    /// `openings.csv`.
    pub openings: PathBuf,
    /// `structure.pvd`.
    pub structure: PathBuf,
    /// Interval in which the wall's fields are written, s.
    pub structure_interval: f64,
    /// `fluid.pvd`, for a fluid that does not leave its fields on disk itself.
    pub fluid_fields: Option<PathBuf>,
    /// The wet surface.
    pub wall: WallRecordSettings,
    /// What tells whether its beats repeat themselves, if that ends the run.
    pub beats: Option<Beats>,
    /// `sections.csv`.
    pub sections: PathBuf,
    /// The cross-sections that are watched.
    pub section_places: Vec<CrossSectionPlace>,
    /// Whether the blood's time derivatives are of second order.
    pub is_second_order: bool,
    /// Volume of the rigid extension, m³.
    pub rigid_volume: f64,
    /// Volume of the whole fluid mesh at rest, m³.
    pub volume: f64,
}

impl RecordSettings {
    /// Of the run of a case into `files`.
    pub fn of(case: &Case, files: &RunFiles, model: &CoupledModel) -> Self {
        let interface = model.coupling.fluid.interface();
        let mesh = model.own_mesh.as_ref();
        let (points, faces) = (&interface.points, &interface.faces);
        let wall = analysis::wet_surface(case, points, faces, mesh, &model.branch_lines);
        Self {
            history: files.history(),
            iterations: files.iterations(),
            probes: files.probes(),
            probe_points: case.output.probes.iter().map(|&x| x.into()).collect(),
            face_centres: interface.face_centres.clone(),
            fluid_probes: files.fluid_probes(),
            fluid_probe_points: case.output.fluid_probes.clone(),
            openings: files.openings(),
            structure: files.structure(),
            structure_interval: case.output.structure_interval,
            fluid_fields: (fields_to_open(case.fluid.solver, &files.fluid()).is_none())
                .then(|| files.fluid_fields()),
            wall: WallRecordSettings {
                regions: files.regions(),
                history: case.output.wall_history.then(|| files.wall_history()),
                monitor: Monitor::new(wall, &analysis::regions(case), mesh),
                windows: Windows::of(case),
                time_step: case.time.step,
            },
            beats: Beats::of(case, files),
            sections: files.sections(),
            section_places: analysis::cross_sections(case),
            is_second_order: model.is_second_order,
            rigid_volume: model.rigid_volume,
            volume: model.volume,
        }
    }

    fn has_fluid_probes(&self) -> bool {
        !self.fluid_probe_points.is_empty()
    }

    fn find_probes(&self, solid: &Structure) -> Result<Probes<Structure>, SolidError> {
        Probes::new(self.probe_points.clone(), solid, &self.face_centres)
    }
}

impl Record {
    /// Creates the files.
    ///
    /// # Errors
    /// If they cannot be written, or a probe does not lie on the wall.
    pub fn create(settings: RecordSettings, solid: &Structure) -> Result<Self, RecordError> {
        let probes = match settings.probe_points.is_empty() {
            true => None,
            false => Some((
                settings.find_probes(solid)?,
                CsvTable::create(&settings.probes)?,
            )),
        };
        let series = VtuSeries::new(settings.structure.clone())?;
        let fluid_fields = settings.fluid_fields.clone().map(VtuSeries::new);
        let mut fields = FieldSeries::new(series, settings.structure_interval, solid)?;
        fields.begin(solid)?;
        Ok(Self {
            history: CsvTable::create(&settings.history)?,
            iterations: CsvTable::create(&settings.iterations)?,
            probes,
            fluid_probes: (settings.has_fluid_probes())
                .then(|| CsvTable::create(&settings.fluid_probes))
                .transpose()?,
            openings: CsvTable::create(&settings.openings)?,
            sections: Sections::new(&settings, SweptVolumes::default(), CsvTable::create)?,
            fields,
            fluid_fields: fluid_fields.transpose()?,
            wall: WallRecord::create(settings.wall.clone())?,
            volume: settings.volume,
            settings,
        })
    }

    /// Continues the files of an earlier run; what was written after `memory` is cut off.
    ///
    /// # Errors
    /// As [`Record::create`].
    pub fn resume(
        settings: RecordSettings,
        solid: &Structure,
        memory: RecordMemory,
    ) -> Result<Self, RecordError> {
        let probes = match settings.probe_points.is_empty() {
            true => None,
            false => Some((
                settings.find_probes(solid)?,
                CsvTable::resume(&settings.probes, memory.probes)?,
            )),
        };
        let series = VtuSeries::resume(settings.structure.clone(), memory.grids)?;
        let fluid_fields =
            (settings.fluid_fields.clone()).map(|path| VtuSeries::resume(path, memory.fluid_grids));
        Ok(Self {
            history: CsvTable::resume(&settings.history, memory.history)?,
            iterations: CsvTable::resume(&settings.iterations, memory.iterations)?,
            probes,
            fluid_probes: (settings.has_fluid_probes())
                .then(|| CsvTable::resume(&settings.fluid_probes, memory.fluid_probes))
                .transpose()?,
            openings: CsvTable::resume(&settings.openings, memory.openings)?,
            sections: Sections::new(&settings, memory.sections.1, |path| {
                CsvTable::resume(path, memory.sections.0)
            })?,
            fields: FieldSeries::new(series, settings.structure_interval, solid)?,
            fluid_fields: fluid_fields.transpose()?,
            wall: WallRecord::resume(settings.wall.clone(), memory.wall)?,
            volume: memory.volume,
            settings,
        })
    }

    /// What is known of the wet surface.
    pub fn wall(&self) -> &WallRecord {
        &self.wall
    }

    /// The row of the history for a step.
    fn row(&self, accepted: &AcceptedStep, stresses: &[StressPeak]) -> HistoryRow {
        let (step, fluid) = (&accepted.step, &accepted.step.fluid);
        let seconds = Seconds::of(step, accepted.seconds);
        let last = step.iterations.last();
        let displacements = step.displacement.iter().map(|d| d.norm());
        let stresses = stresses.iter().map(|s| s.von_mises);
        HistoryRow {
            time_s: fluid.time,
            coupling_iterations: step.iterations.len(),
            residual: last.map_or(0.0, |last| last.measure.residual),
            fluid_s: twelve_digits(seconds.fluid_s),
            structure_s: twelve_digits(seconds.structure_s),
            Q_in_m3_s: fluid.inflow(),
            Q_out_m3_s: fluid.outflow(),
            p_in_Pa: fluid.inlet_pressure(),
            p_out_Pa: fluid.outlet_pressure(),
            lumen_volume_m3: fluid.volume - self.settings.rigid_volume,
            dVdt_m3_s: (fluid.volume - self.volume) / accepted.length,
            max_displacement_m: displacements.fold(0.0, f64::max),
            max_von_mises_Pa: stresses.fold(0.0, f64::max),
            p_windkessel_Pa: fluid.outlet_model_pressure(),
            force_mismatch: last.map_or(0.0, |last| last.force_mismatch),
            wall_velocity_mismatch_m_s: fluid.wall_velocity_mismatch,
            wall_s: accepted.seconds,
        }
    }
}

impl Observer<Structure> for Record {
    type Memory = RecordMemory;

    fn accepted(
        &mut self,
        accepted: &AcceptedStep,
        wall: &AcceptedWall<Structure>,
    ) -> io::Result<()> {
        let (time, step) = (accepted.time(), &accepted.step);
        self.fields.add(accepted, wall.solid)?;
        if let (Some(series), Some(field)) = (&mut self.fluid_fields, &accepted.step.fluid.field) {
            fluid_fields::add(series, time, field)?;
        }
        if let Some((probes, table)) = &mut self.probes {
            table.append(&probes.rows(wall.solid, step))?;
        }
        if let Some(table) = &mut self.fluid_probes {
            let points = &self.settings.fluid_probe_points;
            table.append(&fluid_rows(time, points, &accepted.step.fluid.probes))?;
        }
        self.openings.append(&opening_rows(&step.fluid))?;
        let state = WallState::new(time, &step.fluid.wall_shear, &step.displacement);
        if let Some(sections) = &mut self.sections {
            sections.add(&self.settings, &state, step)?;
        }
        let lumen = step.fluid.volume - self.settings.rigid_volume;
        let modes = accepted.step.fluid.element_modes.as_ref();
        self.wall.step(&state, modes, wall.stresses, lumen)?;
        let rows = iteration_rows(time, accepted.attempt, &step.iterations);
        self.iterations.append(&rows)?;
        self.history.append(&[self.row(accepted, wall.stresses)])?;
        self.volume = step.fluid.volume;
        Ok(())
    }

    fn failed(&mut self, failed: &FailedAttempt) -> io::Result<()> {
        let rows = iteration_rows(failed.time, failed.attempt, failed.iterations);
        self.iterations.append(&rows)
    }

    fn has_seen_enough(&self) -> io::Result<bool> {
        let Some(beats) = &self.settings.beats else {
            return Ok(false);
        };
        Ok(beats.agreement()?.is_some_and(|found| found.is_reached()))
    }

    fn memory(&self) -> io::Result<RecordMemory> {
        let length = |table: Option<&CsvTable>| table.map_or(Ok(0), CsvTable::sync);
        Ok(RecordMemory {
            volume: self.volume,
            history: self.history.sync()?,
            iterations: self.iterations.sync()?,
            probes: length(self.probes.as_ref().map(|(_, table)| table))?,
            fluid_probes: length(self.fluid_probes.as_ref())?,
            openings: self.openings.sync()?,
            sections: match &self.sections {
                Some(sections) => (sections.table.sync()?, sections.swept.clone()),
                None => Default::default(),
            },
            grids: self.fields.entries().to_vec(),
            fluid_grids: (self.fluid_fields.iter())
                .flat_map(|series| series.entries().to_vec())
                .collect(),
            wall: self.wall.memory()?,
        })
    }

    fn files(&self, memory: &RecordMemory) -> Vec<(PathBuf, u64)> {
        let settings = &self.settings;
        let mut files = vec![
            (settings.history.clone(), memory.history),
            (settings.iterations.clone(), memory.iterations),
            (settings.probes.clone(), memory.probes),
            (settings.fluid_probes.clone(), memory.fluid_probes),
            (settings.openings.clone(), memory.openings),
            (settings.sections.clone(), memory.sections.0),
            (settings.wall.regions.clone(), memory.wall.regions),
        ];
        let wall = settings.wall.history.clone();
        files.extend(wall.map(|path| (path, memory.wall.history)));
        files
    }

    fn rewind(&mut self, memory: RecordMemory) -> io::Result<()> {
        let settings = &self.settings;
        self.history = CsvTable::resume(&settings.history, memory.history)?;
        self.iterations = CsvTable::resume(&settings.iterations, memory.iterations)?;
        if let Some((_, table)) = &mut self.probes {
            *table = CsvTable::resume(&settings.probes, memory.probes)?;
        }
        if let Some(table) = &mut self.fluid_probes {
            *table = CsvTable::resume(&settings.fluid_probes, memory.fluid_probes)?;
        }
        self.openings = CsvTable::resume(&settings.openings, memory.openings)?;
        if let Some(sections) = &mut self.sections {
            sections.table = CsvTable::resume(&settings.sections, memory.sections.0)?;
            sections.swept = memory.sections.1;
        }
        self.fields
            .rewind(settings.structure.clone(), memory.grids)?;
        if let Some(path) = settings.fluid_fields.clone() {
            self.fluid_fields = Some(VtuSeries::resume(path, memory.fluid_grids)?);
        }
        self.wall = WallRecord::resume(settings.wall.clone(), memory.wall)?;
        self.volume = memory.volume;
        Ok(())
    }
}

/// Why the record of a run could not be begun.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// A file could not be written.
    #[error("cannot write the results: {0}")]
    Io(#[from] io::Error),
    /// The structure could not be evaluated, at a probe for example.
    #[error(transparent)]
    Solid(#[from] SolidError),
}

/// What a summary says of a run besides its figures.
#[derive(Debug, Clone)]
pub struct Ending {
    /// `complete`, `interrupted` or `failed`.
    pub status: &'static str,
    /// Why it did not complete.
    pub reason: Option<String>,
    /// Folder of the case.
    pub case: PathBuf,
    /// The OpenFOAM that computed the blood.
    pub openfoam: Option<String>,
    /// Cells of the fluid.
    pub fluid_cells: usize,
    /// Degrees of freedom of the structure.
    pub structure_dofs: usize,
    /// Where the unloaded shape of the wall comes from, if it is not the given one.
    pub unloading: Option<Unloading>,
    /// Whether its flow is resolved.
    pub resolution: Option<Resolution>,
    /// Whether it has become steady, if its inputs are constant.
    pub steadiness: Option<Steadiness>,
    /// How well its last two beats agree, if it runs until they do.
    pub periodic: Option<Agreement>,
    /// What passes through each opening.
    pub openings: Vec<OpeningSummary>,
    /// Largest memory of the fluid's processes, as far as seen, bytes.
    pub fluid_peak_memory: f64,
}

impl RunSummary {
    /// Of a run that came to this `ending` with these `totals`.
    pub fn new(ending: Ending, mut totals: Totals) -> Self {
        let s = &mut totals.seconds;
        s.rest_s = totals.wall_s - s.fluid_s - s.structure_s - s.coupling_s;
        let parts = [
            &mut s.fluid_s,
            &mut s.structure_s,
            &mut s.coupling_s,
            &mut s.rest_s,
        ];
        let wholes = [
            &mut totals.steps_s,
            &mut totals.wall_s,
            &mut totals.checkpoint_s,
        ];
        for seconds in parts.into_iter().chain(wholes) {
            *seconds = twelve_digits(*seconds);
        }
        let steps = totals.steps.max(1) as f64;
        Self {
            version: env!("CARGO_PKG_VERSION").into(),
            openfoam: ending.openfoam,
            status: ending.status.into(),
            reason: ending.reason,
            case: ending.case.display().to_string(),
            fluid_cells: ending.fluid_cells,
            structure_dofs: ending.structure_dofs,
            unloading: ending.unloading,
            resolution: ending.resolution,
            steadiness: ending.steadiness,
            periodic: ending.periodic,
            openings: ending.openings,
            mean_coupling_iterations: totals.coupling_iterations as f64 / steps,
            seconds_per_step: totals.wall_s / steps,
            totals,
            driver_peak_memory_MB: peak_memory(std::process::id()).unwrap_or(0.0) / 1e6,
            fluid_peak_memory_MB: ending.fluid_peak_memory / 1e6,
        }
    }

    /// Writes `summary.json`.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let text = serde_json::to_string_pretty(self).map_err(io::Error::other)?;
        write_atomically(path, text.as_bytes())
    }
}

fn opening_rows(step: &FluidStep) -> Vec<OpeningRow> {
    let row = |opening: &OpeningReport| OpeningRow {
        time_s: step.time,
        opening: opening.name.clone(),
        flow_m3_s: opening.flow,
        p_Pa: opening.mean_pressure,
        p_model_Pa: opening.model_pressure,
    };
    step.openings.iter().map(row).collect()
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
            fluid_s: twelve_digits(iteration.fluid_seconds),
            structure_s: twelve_digits(iteration.structure_seconds),
            coupling_s: twelve_digits(iteration.coupling_seconds),
        }
    };
    iterations.iter().map(row).collect()
}
