//! What a run writes of its wall while it advances: `regions.csv`, `wall.bin`, and the statistics over the window.

use super::tables::CsvTable;
use super::wall_history::{WallHistory, WallHistoryError, WallHistoryReader};
use crate::case::{Window, Windows};
use crate::fluid::ElementModes;
use crate::hemodynamics::{Monitor, WallState, WallStress, WetSurface, WindowStatistics};
use crate::pfem::solid::StressPeak;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

/// What it needs to know before the first step.
#[derive(Debug, Clone)]
pub struct WallRecordSettings {
    /// `regions.csv`.
    pub regions: PathBuf,
    /// `wall.bin`, if it is wanted.
    pub history: Option<PathBuf>,
    /// The wall with its regions.
    pub monitor: Monitor,
    /// The windows of the statistics.
    pub windows: Windows,
    /// Length of a time step, s; some may be shorter.
    pub time_step: f64,
}

/// What it needs to continue after the last accepted step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WallMemory {
    /// The statistics so far.
    pub statistics: WindowStatistics,
    /// Bytes of `regions.csv`.
    pub regions: u64,
    /// Bytes of `wall.bin`.
    pub history: u64,
}

/// Follows the wall step by step.
pub struct WallRecord {
    settings: WallRecordSettings,
    regions: CsvTable,
    history: Option<WallHistory>,
    statistics: WindowStatistics,
}

impl WallRecord {
    /// Creates the files.
    pub fn create(settings: WallRecordSettings) -> io::Result<Self> {
        let wall = settings.monitor.wall();
        let create = |path: &PathBuf| WallHistory::create(path, wall);
        Ok(Self {
            regions: CsvTable::create(&settings.regions)?,
            history: settings.history.as_ref().map(create).transpose()?,
            statistics: nothing(&settings, settings.windows.at(0.0)),
            settings,
        })
    }

    /// Continues the files of an earlier run; what was written after `memory` is cut off. If the window is another one
    /// now, its statistics are gathered from the stored steps; without them only the steps to come count.
    pub fn resume(settings: WallRecordSettings, memory: WallMemory) -> io::Result<Self> {
        let wall = settings.monitor.wall();
        let resume = |path: &PathBuf| WallHistory::resume(path, wall, memory.history);
        let regions = CsvTable::resume(&settings.regions, memory.regions)?;
        let history = settings.history.as_ref().map(resume).transpose()?;
        let window = settings.windows.at(memory.statistics.reached());
        let statistics = match &settings.history {
            _ if memory.statistics.window == window => memory.statistics,
            Some(path) => {
                let gathered = gather(path, window, settings.time_step, &[]);
                gathered.map_err(io::Error::other)?.1
            }
            None => nothing(&settings, window),
        };
        Ok(Self {
            settings,
            regions,
            history,
            statistics,
        })
    }

    /// What is needed to continue later; everything so far is on the disk when this returns.
    pub fn memory(&self) -> io::Result<WallMemory> {
        Ok(WallMemory {
            statistics: self.statistics.clone(),
            regions: self.regions.sync()?,
            history: self.history.as_ref().map_or(Ok(0), WallHistory::sync)?,
        })
    }

    /// Adds the end of a step with the highest modes of the fluid's elements, the largest stress of each of the wall's,
    /// and the volume (m³) of the lumen within the wall.
    pub fn step(
        &mut self,
        state: &WallState,
        modes: Option<&ElementModes>,
        stresses: &[StressPeak],
        lumen: f64,
    ) -> io::Result<()> {
        let longest = self.settings.time_step;
        let window = self.settings.windows.at(state.time);
        if self.statistics.window != window {
            let reached = self.statistics.reached();
            self.statistics = nothing(&self.settings, window).after(reached);
        }
        self.statistics.add(state, modes, longest);
        if let Some(history) = &mut self.history {
            history.append(state)?;
        }
        let stress = |peak: &StressPeak| WallStress {
            middle: peak.element,
            von_mises: peak.von_mises,
            max_principal: peak.max_principal,
            max_hoop: peak.max_hoop,
            max_axial: peak.max_axial,
            max_fibre_stretch: peak.max_fibre_stretch,
            position: peak.position,
        };
        let stresses: Vec<_> = stresses.iter().map(stress).collect();
        self.regions
            .append(&self.settings.monitor.observe(state, &stresses, lumen))
    }

    /// What was gathered so far.
    pub fn statistics(&self) -> &WindowStatistics {
        &self.statistics
    }

    /// The wall with its regions.
    pub fn monitor(&self) -> &Monitor {
        &self.settings.monitor
    }
}

fn nothing(settings: &WallRecordSettings, window: Window) -> WindowStatistics {
    let wall = settings.monitor.wall();
    WindowStatistics::new(window, wall.faces.len(), wall.points.len())
}

/// The unloaded wall of a stored history and the statistics over `window`, for steps of at most `time_step` (s).
///
/// # Errors
/// If the file is damaged, or lacks one of the `times` (s) that the run has reached since the file begins.
pub fn gather(
    path: &Path,
    window: Window,
    time_step: f64,
    times: &[f64],
) -> Result<(WetSurface, WindowStatistics), WallHistoryError> {
    let mut reader = WallHistoryReader::open(path)?;
    let (faces, points) = (reader.wall.faces.len(), reader.wall.points.len());
    let mut statistics = WindowStatistics::new(window, faces, points);
    let mut reached = times.iter().copied().peekable();
    let mut begun = false;
    for state in reader.by_ref() {
        let state = state?;
        // A file that was started again has no record of earlier steps.
        while reached
            .next_if(|t| *t == state.time || !begun && *t < state.time)
            .is_some()
        {}
        begun = true;
        statistics.add(&state, None, time_step);
    }
    match reached.next() {
        Some(time) => Err(reader.ends_before(time)),
        None => Ok((reader.wall, statistics)),
    }
}
