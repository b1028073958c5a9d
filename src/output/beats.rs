//! Whether a beat ends as it began, from its tables: what they say does not depend on resumptions.

use super::run_files::RunFiles;
use super::tables::{self, HistoryRow, OpeningRow};
use crate::case::Case;
use crate::hemodynamics::periodicity::BeatMeasure;
use crate::hemodynamics::{Agreement, RegionStep};
use std::collections::BTreeMap;
use std::io;

/// What is needed to compare what a run has come to with what was a beat earlier.
#[derive(Debug, Clone)]
pub struct Beats {
    files: RunFiles,
    limit: f64,
    /// s
    step: f64,
    /// Steps of a beat.
    beat: usize,
}

impl Beats {
    /// Of the run of a case in these files; none if it does not run until it is periodic.
    pub fn of(case: &Case, files: &RunFiles) -> Option<Self> {
        Some(Self {
            files: files.clone(),
            limit: case.until_periodic()?,
            step: case.time.step,
            beat: case.steps_of_a_beat(),
        })
    }

    /// How well they agree; none before there is anything to compare.
    ///
    /// # Errors
    /// If a table cannot be read.
    pub fn agreement(&self) -> io::Result<Option<Agreement>> {
        let history: Vec<HistoryRow> = tables::read(&self.files.history())?;
        let history = tables::whole_steps(&history, self.step);
        let column = |name: &str, value: fn(&HistoryRow) -> f64| BeatMeasure {
            name: name.into(),
            curves: vec![history.iter().map(|row| value(row)).collect()],
        };
        let openings: Vec<OpeningRow> = tables::read(&self.files.openings())?;
        let of_openings = |name: &str, value: fn(&OpeningRow) -> f64| {
            let rows = openings.iter();
            let rows = rows.map(|row| (row.opening.clone(), row.time_s, value(row)));
            BeatMeasure {
                name: name.into(),
                curves: self.curves(rows).into_values().collect(),
            }
        };
        let regions: Vec<RegionStep> = tables::read(&self.files.regions())?;
        let rows = regions.iter();
        let shear = rows.map(|row| (row.region.to_string(), row.time_s, row.mean_wall_shear_Pa));
        let mut measures = vec![
            column("the volume of the lumen", |row| row.lumen_volume_m3),
            column("the largest displacement", |row| row.max_displacement_m),
            of_openings("the flows through the openings", |row| row.flow_m3_s),
            of_openings("the pressures at the openings", |row| row.p_Pa),
        ];
        let shear = self.curves(shear).into_iter();
        measures.extend(shear.map(|(region, curve)| BeatMeasure {
            name: format!("the mean wall shear stress of the region {region}"),
            curves: vec![curve],
        }));
        Ok(Agreement::of(&measures, self.beat, self.step, self.limit))
    }

    /// Values by name, without those between whole steps.
    fn curves(&self, rows: impl Iterator<Item = (String, f64, f64)>) -> BTreeMap<String, Vec<f64>> {
        let mut curves: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for (name, _, value) in rows.filter(|(_, time, _)| tables::is_whole(*time, self.step)) {
            curves.entry(name).or_default().push(value);
        }
        curves
    }
}
