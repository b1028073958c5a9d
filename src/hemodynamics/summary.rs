//! `hemodynamics.json`: the window in figures.

use super::monitor::RegionStep;
use super::periodicity::{PeriodDifference, alternating, differences};
use super::place::Place;
use super::region::{Region, RegionExtent};
use super::statistics::WindowStatistics;
use super::wall::WetSurface;
use crate::Vec3;
use crate::case::Window;
use serde::{Deserialize, Serialize};

/// The wall's measures on each face, averaged over a window.
#[derive(Debug, Clone, PartialEq)]
pub struct WallFields {
    /// Centres of the unloaded faces.
    pub places: Vec<Place>,
    /// Mean positions of the points, m.
    pub positions: Vec<Vec3>,
    /// Areas of the faces there, m².
    pub areas: Vec<f64>,
    /// Mean wall shear stress, Pa.
    pub mean_shear: Vec<Vec3>,
    /// Time-averaged wall shear stress, Pa.
    pub time_averaged: Vec<f64>,
    /// Oscillating shear index (10).
    pub oscillating: Vec<f64>,
    /// Relative residence time, 1/Pa.
    pub residence: Vec<f64>,
}

impl WallFields {
    /// The fields, if a step was seen.
    pub fn new(wall: &WetSurface, statistics: &WindowStatistics) -> Option<Self> {
        if statistics.steps == 0 {
            return None;
        }
        let moved = wall.points.iter().zip(statistics.mean_displacement());
        let positions: Vec<Vec3> = moved.map(|(x, u)| x + u).collect();
        let extents = wall.extents(&positions);
        let shear = &statistics.shear;
        Some(Self {
            places: wall.places(),
            positions,
            areas: extents.iter().map(|extent| extent.area).collect(),
            mean_shear: shear.mean(),
            time_averaged: shear.time_averaged(),
            oscillating: shear.oscillating_shear_index(),
            residence: shear.relative_residence_time(),
        })
    }
}

/// Mean and extremes of a field over a region.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FieldSummary {
    /// Mean over the area of the wall at its mean position.
    #[serde(with = "crate::numbers")]
    pub mean: f64,
    /// Smallest value of a face.
    #[serde(with = "crate::numbers")]
    pub min: f64,
    /// Largest value of a face.
    #[serde(with = "crate::numbers")]
    pub max: f64,
    /// Where the largest is.
    pub max_at: Place,
}

/// Largest value in time and space.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    /// The value.
    #[serde(with = "crate::numbers")]
    pub max: f64,
    /// When.
    pub time_s: f64,
    /// Where.
    pub at: Place,
}

/// Course over the window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// Smallest value.
    #[serde(with = "crate::numbers")]
    pub min: f64,
    /// Mean over time.
    #[serde(with = "crate::numbers")]
    pub mean: f64,
    /// Largest value.
    #[serde(with = "crate::numbers")]
    pub max: f64,
}

impl Course {
    /// Of values at equal distances in time; `None` if there are none.
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len();
        (n > 0).then(|| Self {
            min: values.iter().copied().fold(f64::INFINITY, f64::min),
            mean: values.iter().sum::<f64>() / n as f64,
            max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        })
    }
}

/// A region over the window.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct RegionSummary {
    /// Which.
    #[serde(flatten)]
    pub region: Region,
    /// Area of the wall at its mean position.
    #[serde(with = "crate::numbers")]
    pub area_m2: f64,
    /// Time-averaged wall shear stress.
    pub TAWSS_Pa: FieldSummary,
    /// Oscillating shear index.
    pub OSI: FieldSummary,
    /// Relative residence time.
    pub RRT_1_Pa: FieldSummary,
    /// Magnitude of the wall shear stress, mean over the deformed area of each step.
    pub mean_wall_shear_Pa: Course,
    /// What alternates from step to step in that mean, root mean square over the window.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alternating_wall_shear_Pa: Option<f64>,
    /// Its largest value.
    pub max_wall_shear_Pa: Peak,
    /// Largest von Mises stress.
    pub max_von_mises_Pa: Peak,
    /// Volume of the lumen; absent where the region encloses none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lumen_volume_m3: Option<Course>,
    /// Largest displacement of the wet surface.
    pub max_displacement_m: Course,
}

impl RegionSummary {
    /// Mean volume of the lumen, m³; not a number where the region encloses none.
    pub fn mean_volume(&self) -> f64 {
        self.lumen_volume_m3.map_or(f64::NAN, |volume| volume.mean)
    }
}

/// What the summary needs of the history of a run, one value a step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HistorySeries {
    /// Time at the end of the step, s.
    pub time: Vec<f64>,
    /// Inflow, m³/s.
    pub inflow: Vec<f64>,
    /// Outflow, m³/s.
    pub outflow: Vec<f64>,
    /// Mean pressure at the outlet, Pa.
    pub outlet_pressure: Vec<f64>,
    /// Largest displacement of the wet surface, m.
    pub displacement: Vec<f64>,
}

/// Courses and periodicity of the whole vessel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct VesselSummary {
    /// Inflow.
    pub Q_in_m3_s: Course,
    /// Outflow.
    pub Q_out_m3_s: Course,
    /// Mean pressure at the outlet.
    pub p_out_Pa: Course,
    /// Largest displacement of the wet surface.
    pub max_displacement_m: Course,
}

/// Differences between successive periods of the whole run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Periodicity {
    /// Of the outflow, m³/s.
    pub outflow: Vec<PeriodDifference>,
    /// Of the largest displacement, m.
    pub max_displacement: Vec<PeriodDifference>,
}

/// `hemodynamics.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HemodynamicsSummary {
    /// What was asked for: start < t <= end.
    pub window: Window,
    /// Steps of it that were seen.
    pub steps: usize,
    /// Whether these are all.
    pub complete: bool,
    /// Whether it is a whole number of periods, without which time averages depend on where it begins.
    pub whole_periods: bool,
    /// The whole vessel over the window; absent if no step of it was seen.
    pub vessel: Option<VesselSummary>,
    /// Its parts.
    pub regions: Vec<RegionSummary>,
    /// How far the run is from repeating itself.
    pub periodicity: Periodicity,
}

/// A share of the wall shear that is obvious in a curve.
const MUCH: f64 = 0.01;

impl HemodynamicsSummary {
    /// Summarizes a run with steps of `step` (s) and periods of `period` (s).
    pub fn new(
        wall: &WetSurface,
        regions: &[Region],
        statistics: &WindowStatistics,
        rows: &[RegionStep],
        series: &HistorySeries,
        [step, period]: [f64; 2],
    ) -> Self {
        let window = statistics.window;
        let beats = (window.end_s - window.start_s) / period;
        let fields = WallFields::new(wall, statistics);
        let part = |region: &Region| {
            let inside =
                |row: &&RegionStep| row.region == region.name && window.contains(row.time_s, step);
            let rows: Vec<_> = rows.iter().filter(inside).collect();
            region_summary(wall, region, fields.as_ref()?, &rows, step)
        };
        let per_period = (period / step).round() as usize;
        Self {
            window,
            steps: statistics.steps,
            complete: statistics.is_complete(),
            whole_periods: beats.round() >= 1.0 && (beats - beats.round()).abs() < 1e-6,
            vessel: vessel_summary(series, window, step),
            regions: regions.iter().filter_map(part).collect(),
            periodicity: Periodicity {
                outflow: differences(&series.outflow, per_period, period),
                max_displacement: differences(&series.displacement, per_period, period),
            },
        }
    }

    /// A sentence about what alternates from step to step, if it is more than 1 % of the mean wall shear of a region;
    /// of whole periods only, because a start from rest is not smooth.
    pub fn alternates(&self) -> Option<String> {
        if !(self.complete && self.whole_periods) {
            return None;
        }
        let share = |region: &RegionSummary| {
            let share = region.alternating_wall_shear_Pa? / region.mean_wall_shear_Pa.mean;
            Some((share, region.region.name))
        };
        let shares = self.regions.iter().filter_map(share);
        let (share, region) = shares
            .filter(|(share, _)| *share > MUCH)
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(format!(
            "the mean wall shear stress alternates from step to step, by {:.1} % in the region {region}: that can grow from beat to beat; \
             structure.time_scheme = \"bossak\" damps it, and shorter steps do where that is set (docs/coupling.md)",
            100.0 * share
        ))
    }

    /// A region, if the vessel has it.
    pub fn region(&self, name: &str) -> Option<&RegionSummary> {
        self.regions.iter().find(|r| r.region.name.as_str() == name)
    }
}

fn vessel_summary(series: &HistorySeries, window: Window, step: f64) -> Option<VesselSummary> {
    let inside = |values: &[f64]| -> Vec<f64> {
        let pairs = series.time.iter().zip(values);
        let chosen = pairs.filter(|(t, _)| window.contains(**t, step));
        chosen.map(|(_, value)| *value).collect()
    };
    Some(VesselSummary {
        Q_in_m3_s: Course::of(&inside(&series.inflow))?,
        Q_out_m3_s: Course::of(&inside(&series.outflow))?,
        p_out_Pa: Course::of(&inside(&series.outlet_pressure))?,
        max_displacement_m: Course::of(&inside(&series.displacement))?,
    })
}

fn region_summary(
    wall: &WetSurface,
    region: &Region,
    fields: &WallFields,
    rows: &[&RegionStep],
    step: f64,
) -> Option<RegionSummary> {
    let shares = wall.shares(region);
    let area: f64 = shares
        .iter()
        .map(|(f, share)| share * fields.areas[*f])
        .sum();
    // Of a region that has no half face, all that it has count.
    let enough = shares.iter().map(|(_, share)| *share).fold(0.0, f64::max);
    let enough = enough.min(0.5);
    let field = |values: &[f64]| {
        let mut found = FieldSummary {
            mean: 0.0,
            min: f64::INFINITY,
            max: f64::NEG_INFINITY,
            max_at: Place::default(),
        };
        for &(face, share) in &shares {
            let value = values[face];
            found.mean += share * fields.areas[face] / area * value;
            if share >= enough {
                found.min = found.min.min(value);
                if value > found.max {
                    (found.max, found.max_at) = (value, fields.places[face]);
                }
            }
        }
        found
    };
    // Where steps were halved, there are rows between the whole ones.
    let whole = |row: &&&RegionStep| {
        let steps = row.time_s / step;
        (steps - steps.round()).abs() < 1e-3
    };
    let values = |value: fn(&RegionStep) -> f64| -> Vec<f64> {
        let rows = rows.iter().filter(whole);
        rows.map(|row| value(row)).collect()
    };
    let course = |value: fn(&RegionStep) -> f64| Course::of(&values(value));
    let peak = |value: fn(&RegionStep) -> f64, at: fn(&RegionStep) -> Place| {
        let row = rows.iter().max_by(|a, b| value(a).total_cmp(&value(b)))?;
        Some(Peak {
            max: value(row),
            time_s: row.time_s,
            at: at(row),
        })
    };
    Some(RegionSummary {
        region: region.clone(),
        area_m2: area,
        TAWSS_Pa: field(&fields.time_averaged),
        OSI: field(&fields.oscillating),
        RRT_1_Pa: field(&fields.residence),
        mean_wall_shear_Pa: course(|row| row.mean_wall_shear_Pa)?,
        alternating_wall_shear_Pa: alternating(&values(|row| row.mean_wall_shear_Pa)),
        max_wall_shear_Pa: peak(|row| row.max_wall_shear_Pa, RegionStep::place_of_wall_shear)?,
        max_von_mises_Pa: peak(|row| row.max_von_mises_Pa, RegionStep::place_of_von_mises)?,
        lumen_volume_m3: course(|row| row.lumen_volume_m3).filter(|volume| !volume.mean.is_nan()),
        max_displacement_m: course(|row| row.max_displacement_m)?,
    })
}

impl RegionSummary {
    /// A place as people find it: along and around a tube, in space where the wall is none.
    pub fn told(&self, at: Place) -> String {
        match (&self.region.extent, at.position_m) {
            (RegionExtent::Along { .. }, _) | (_, None) => {
                format!("x = {:.1} mm, φ = {:.0}°", 1e3 * at.x_m, at.phi_deg)
            }
            (_, Some(at)) => {
                // Of what is rounded to zero the sign says nothing.
                let [x, y, z] = at.map(|x| (1e4 * x).round() / 10.0 + 0.0);
                format!("({x:.1}, {y:.1}, {z:.1}) mm")
            }
        }
    }
}

impl std::fmt::Display for HemodynamicsSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Window { start_s, end_s } = self.window;
        let seen = match (self.steps, self.complete) {
            (0, _) => ", of which no step was computed yet",
            (_, false) => ", of which not every step was computed",
            (_, true) if !self.whole_periods => ", which is not a whole number of periods",
            _ => "",
        };
        writeln!(f, "wall shear over {start_s} s < t <= {end_s} s{seen}")?;
        for region in &self.regions {
            let (tawss, osi) = (region.TAWSS_Pa, region.OSI);
            writeln!(
                f,
                "{:<11} TAWSS {:.4} Pa (at most {:.4}), OSI {:.5} (at most {:.5} at {})",
                region.region.name.to_string(),
                tawss.mean,
                tawss.max,
                osi.mean,
                osi.max,
                region.told(osi.max_at)
            )?;
        }
        match self.alternates() {
            Some(sentence) => writeln!(f, "warning: {sentence}"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a run before it was looked for, which has none.
    fn summary() -> HemodynamicsSummary {
        let text = include_str!("../../docs/results/native/S-0.5/hemodynamics.json");
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn strong_alternation_is_reported_with_its_region() {
        let mut summary = summary();
        assert_eq!(summary.alternates(), None);
        for (region, share) in summary.regions.iter_mut().zip([0.004, 0.02, 0.015]) {
            region.alternating_wall_shear_Pa = Some(share * region.mean_wall_shear_Pa.mean);
        }
        let sentence = summary.alternates().unwrap();
        assert!(
            sentence.contains("by 2.0 % in the region artery:"),
            "{sentence}"
        );
        let shown = summary.to_string();
        assert!(
            shown.ends_with(&format!("warning: {sentence}\n")),
            "{shown}"
        );
        for region in &mut summary.regions {
            region.alternating_wall_shear_Pa = Some(0.009 * region.mean_wall_shear_Pa.mean);
        }
        assert_eq!(summary.alternates(), None);
        summary.regions[0].alternating_wall_shear_Pa = Some(1.0);
        assert!(summary.alternates().is_some());
        summary.whole_periods = false;
        assert_eq!(summary.alternates(), None, "a start is not smooth");
    }
}
