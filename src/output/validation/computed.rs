//! What a run has recorded where something was measured.

use crate::Vec3;
use crate::case::measured::{
    MeasuredPoint, MeasuredQuantity, MeasuredSeries, Measurements, Recorder,
};
use crate::files::{Fault, fault};
use crate::output::function_object::{self, Forces};
use crate::output::results::Results;
use crate::output::tables::{self, FluidProbeRow, ProbeRow, SectionRow};
use crate::output::time_statistics::statistic;
use fsi_numerics::twelve_digits;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;

/// A probe lies at a measured point if it is no further away than this (m).
const SAME_PLACE: f64 = 1e-9;
/// A row counts for a time from which it is no further than this share of a step.
const SAME_TIME: f64 = 0.51;

/// What a run has at the measured points.
pub struct Computed {
    /// Name of the run.
    pub name: String,
    /// A value for each point of each series.
    pub values: Vec<Vec<f64>>,
    /// Of each series of statistics what was recorded (time in s, value) where its first point counts.
    pub over_time: Vec<Vec<(f64, f64)>>,
}

/// A value at a place and time of a run.
struct Sample {
    place: [f64; 3],
    time: f64,
    value: f64,
}

impl Computed {
    /// From the probes of a run.
    ///
    /// # Errors
    /// That the run has not recorded what was measured, in words.
    pub fn read(folder: &Path, measured: &Measurements) -> Result<Self, Fault> {
        let run = Results::load_figures_of_any(folder).map_err(|e| e.to_string())?;
        let recorded = Recorded {
            wall: read(&run.files.probes())?,
            blood: read(&run.files.fluid_probes())?,
            sections: read(&run.files.sections())?,
            forces: forces(&run, measured)?,
        };
        let series = || measured.series.iter();
        let values = series().map(|series| computed(&run, &recorded, series));
        let over_time = series().map(|series| match series.is_over_time() {
            true => {
                let samples = recorded.samples(series);
                counted(&run, &series.points[0], &samples)
            }
            false => Vec::new(),
        });
        Ok(Self {
            name: run.name(),
            values: values.collect::<Result<_, _>>()?,
            over_time: over_time.collect(),
        })
    }
}

/// The rows of a table of probes; none if the run has recorded nothing at points.
fn read<T: DeserializeOwned>(table: &Path) -> Result<Vec<T>, Fault> {
    match table.is_file() {
        true => tables::read(table).map_err(|e| fault!("cannot read {e}")),
        false => Ok(Vec::new()),
    }
}

/// What the function objects have added up that a file of measurements names, by their names.
fn forces(run: &Results, measured: &Measurements) -> Result<HashMap<String, Forces>, Fault> {
    let mut forces = HashMap::new();
    let is_force =
        |series: &&MeasuredSeries| series.quantity.recorder() == Recorder::FunctionObject;
    for series in measured.series.iter().filter(is_force) {
        let name = series.recorded_by();
        if !forces.contains_key(name) {
            let folder = run.files.function_object(name);
            forces.insert(name.to_owned(), function_object::forces(&folder)?);
        }
    }
    Ok(forces)
}

/// What a run has recorded at points and cross-sections, and what function objects have added up.
struct Recorded {
    wall: Vec<ProbeRow>,
    blood: Vec<FluidProbeRow>,
    sections: Vec<SectionRow>,
    forces: HashMap<String, Forces>,
}

fn is_at(sample: &Sample, point: &MeasuredPoint) -> bool {
    let away = Vec3::from(sample.place) - Vec3::from(point.place);
    away.norm() <= SAME_PLACE
}

/// What counts for a statistic: time (s) and value of the samples at its place from its time on.
fn counted(run: &Results, point: &MeasuredPoint, samples: &[Sample]) -> Vec<(f64, f64)> {
    let from = point.time.unwrap_or(0.0) - SAME_TIME * run.case.time.step;
    let counts = |sample: &&Sample| is_at(sample, point) && sample.time >= from;
    let counted = samples.iter().filter(counts);
    counted.map(|sample| (sample.time, sample.value)).collect()
}

/// What a run has at each point of a series.
fn computed(
    run: &Results,
    recorded: &Recorded,
    series: &MeasuredSeries,
) -> Result<Vec<f64>, Fault> {
    let (table, key) = match series.quantity.recorder() {
        Recorder::WallProbe => (run.files.probes(), "the point in output.probes_m"),
        Recorder::BloodProbe => (
            run.files.fluid_probes(),
            "the point in output.fluid_probes_m",
        ),
        Recorder::Section => (
            run.files.sections(),
            "the cross-section of its name in output.section",
        ),
        Recorder::FunctionObject => (
            run.files.function_object(series.recorded_by()),
            "a function object of the type `forces` in the templates",
        ),
    };
    let samples = recorded.samples(series);
    let last = samples.iter().map(|sample| sample.time).fold(0.0, f64::max);
    let at = |point: &MeasuredPoint| {
        let mut here = samples
            .iter()
            .filter(|sample| is_at(sample, point))
            .peekable();
        if let (Some(kind), Some(_)) = (point.statistic, here.peek()) {
            let counted = counted(run, point, &samples);
            return statistic(kind, &counted).ok_or_else(|| {
                fault!(
                    "{} has {} rows of `{}` from t = {} s on, to {} s: not enough for its {}",
                    table.display(),
                    counted.len(),
                    series.name,
                    point.time.unwrap_or(0.0),
                    twelve_digits(last),
                    kind.name()
                )
            });
        }
        let time = point.time.unwrap_or(last);
        let away = |sample: &Sample| (sample.time - time).abs();
        let nearest = here.min_by(|a, b| away(a).total_cmp(&away(b)));
        let Some(nearest) = nearest else {
            return Err(fault!(
                "{} has no probe at {:?} m, where `{}` was measured: give the file to the case as output.measured, or {key}, and \
                 compute the run again",
                table.display(),
                point.place,
                series.name
            ));
        };
        match away(nearest) <= SAME_TIME * run.case.time.step {
            true => Ok(nearest.value),
            false => Err(fault!(
                "{} has no row at t = {time} s, where `{}` was measured; it reaches {} s",
                table.display(),
                series.name,
                twelve_digits(last)
            )),
        }
    };
    let mut values: Vec<f64> = series.points.iter().map(at).collect::<Result<_, _>>()?;
    if series.quantity.is_difference() {
        let first = values[0];
        values.iter_mut().for_each(|value| *value -= first);
    }
    Ok(values)
}

impl Recorded {
    /// All that was recorded of a series' quantity; what sections and function objects have stands at the
    /// place of the first of its points.
    fn samples(&self, series: &MeasuredSeries) -> Vec<Sample> {
        use MeasuredQuantity::*;
        let quantity = series.quantity;
        let of_the_wall = |row: &ProbeRow| Sample {
            place: [row.x_m, row.y_m, row.z_m],
            time: row.time_s,
            value: match quantity {
                WallShear => Vec3::new(
                    row.wall_shear_x_Pa,
                    row.wall_shear_y_Pa,
                    row.wall_shear_z_Pa,
                )
                .norm(),
                DisplacementX => row.ux_m,
                DisplacementY => row.uy_m,
                DisplacementZ => row.uz_m,
                _ => row.p_Pa,
            },
        };
        let of_the_blood = |row: &FluidProbeRow| Sample {
            place: [row.x_m, row.y_m, row.z_m],
            time: row.time_s,
            value: match quantity {
                VelocityX => row.ux_m_s,
                VelocityY => row.uy_m_s,
                VelocityZ => row.uz_m_s,
                Speed => Vec3::new(row.ux_m_s, row.uy_m_s, row.uz_m_s).norm(),
                _ => row.p_Pa,
            },
        };
        let of_a_section = |row: &SectionRow| {
            let value = match quantity {
                SectionPressure => Some(row.p_Pa),
                SectionRadiusDifference => Some((row.area_m2 / PI).sqrt()),
                _ => row.flow_m3_s,
            };
            value.map(|value| Sample {
                place: series.points[0].place,
                time: row.time_s,
                value,
            })
        };
        match quantity.recorder() {
            Recorder::WallProbe => self.wall.iter().map(of_the_wall).collect(),
            Recorder::BloodProbe => self.blood.iter().map(of_the_blood).collect(),
            Recorder::Section => (self.sections.iter())
                .filter(|row| row.section == series.recorded_by())
                .filter_map(of_a_section)
                .collect(),
            Recorder::FunctionObject => (self.forces.get(series.recorded_by()).into_iter())
                .flatten()
                .map(|(time, force)| Sample {
                    place: series.points[0].place,
                    time: *time,
                    value: match quantity {
                        ForceX => force[0],
                        ForceY => force[1],
                        _ => force[2],
                    },
                })
                .collect(),
        }
    }
}
