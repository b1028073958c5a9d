//! What a run says of its own results: whether its flow is resolved, and whether it has become steady where it should.

use crate::analysis;
use crate::case::Case;
use crate::fluid::HighestModes;
use crate::hemodynamics::resolution::jumps;
use crate::hemodynamics::summary::WallFields;
use crate::hemodynamics::{Agreement, Place, RegionStep, Resolution, Steadiness, SteadyMeasure};
use crate::output::beats::Beats;
use crate::output::opening_summary::OpeningSummary;
use crate::output::record::Record;
use crate::output::run_files::RunFiles;
use crate::output::tables::{self, CsvTable, FluidProbeRow, HistoryRow, ResolutionRow};
use std::collections::BTreeMap;
use std::io;

/// A point in the blood where it is slower than this share of its largest velocity counts as if it were as fast.
const SLOW: f64 = 0.1;

/// The judgement of a run on itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Judgement {
    /// Whether its flow is resolved.
    pub resolution: Option<Resolution>,
    /// Whether it has become steady, if its inputs are constant.
    pub steadiness: Option<Steadiness>,
    /// How well its last two beats agree, if it runs until they do.
    pub periodic: Option<Agreement>,
    /// What passes through each opening over the evaluated window.
    pub openings: Vec<OpeningSummary>,
    /// How well it is resolved at each face of the wall.
    pub faces: Vec<ResolutionRow>,
}

impl Judgement {
    /// Of a run with these files and this record.
    ///
    /// # Errors
    /// If a table cannot be read.
    pub fn of(case: &Case, files: &RunFiles, record: &Record) -> io::Result<Self> {
        if case.flag().is_some() {
            return Ok(Self::default());
        }
        let history: Vec<HistoryRow> = tables::read(&files.history())?;
        let (wall, statistics) = (record.wall().monitor().wall(), record.wall().statistics());
        let openings = tables::read(&files.openings())?;
        let openings = OpeningSummary::all(&openings, statistics.window, case.time.step);
        let measured = || {
            let within = history
                .iter()
                .filter(|row| row.time_s > statistics.window.start_s);
            let samples: Vec<[f64; 2]> = within.map(|row| [row.time_s, row.Q_in_m3_s]).collect();
            analysis::flow_numbers_of(case, &samples)
        };
        let numbers = analysis::flow_numbers(case).or_else(measured);
        let steadiness = match case.is_driven_steadily() {
            true => Steadiness::of(&measures(files, &history)?, case.ramp.duration),
            false => None,
        };
        let beats = Beats::of(case, files);
        let periodic = beats.and_then(|beats| beats.agreement().transpose());
        let periodic = periodic.transpose()?;
        let Some(fields) = WallFields::new(wall, statistics) else {
            return Ok(Self {
                steadiness,
                periodic,
                openings,
                ..Self::default()
            });
        };
        let jumps = jumps(wall, &fields);
        let row = |(face, place): (usize, &Place)| ResolutionRow {
            x_m: place.x_m,
            phi_deg: place.phi_deg,
            jump: jumps[face],
            highest_modes: statistics.modes_at_wall.get(face).map(HighestModes::share),
        };
        let finer = match case.tree() {
            Some(_) => {
                "raise tree.native.degree, tree.native.core or tree.native.radial, or shorten tree.native.length"
            }
            None => {
                "raise fluid.native.degree, fluid.native.core, fluid.native.radial or fluid.native.axial_per_section"
            }
        };
        let resolution = Resolution::new(numbers, &fields, &jumps, statistics, finer);
        Ok(Self {
            faces: fields.places.iter().enumerate().map(row).collect(),
            resolution: Some(resolution),
            steadiness,
            periodic,
            openings,
        })
    }

    /// Writes `resolution.csv`.
    pub fn write(&self, files: &RunFiles) -> io::Result<()> {
        match self.faces.is_empty() {
            true => Ok(()),
            false => CsvTable::create(&files.resolution())?.append(&self.faces),
        }
    }

    /// What is said of it on the terminal, a line each.
    pub fn lines(&self) -> String {
        let findings = self
            .resolution
            .iter()
            .flat_map(|resolution| &resolution.findings);
        let mut lines: String = findings
            .map(|finding| format!("warning: {}\n", finding.text))
            .collect();
        if let Some(steadiness) = &self.steadiness {
            lines += &format!("{steadiness}\n");
        }
        if let Some(agreement) = &self.periodic {
            lines += &format!("{agreement}\n");
        }
        lines
    }
}

/// What is looked at to tell whether a run has become steady.
fn measures(files: &RunFiles, history: &[HistoryRow]) -> io::Result<Vec<SteadyMeasure>> {
    let of_history = |name: &str, value: fn(&HistoryRow) -> f64| SteadyMeasure {
        name: name.into(),
        values: history.iter().map(|row| [row.time_s, value(row)]).collect(),
        size: 0.0,
    };
    let mut measures = vec![
        of_history("pressure drop", |row| row.p_in_Pa - row.p_out_Pa),
        of_history("outflow", |row| row.Q_out_m3_s),
        of_history("largest displacement", |row| row.max_displacement_m),
    ];
    let regions: Vec<RegionStep> = tables::read(&files.regions())?;
    let mut by_region: BTreeMap<String, SteadyMeasure> = BTreeMap::new();
    for row in &regions {
        let name = format!("mean wall shear stress in the region {}", row.region);
        let measure = by_region
            .entry(name.clone())
            .or_insert_with(|| SteadyMeasure {
                name,
                values: Vec::new(),
                size: 0.0,
            });
        measure.values.push([row.time_s, row.mean_wall_shear_Pa]);
    }
    measures.extend(by_region.into_values());
    measures.extend(of_probes(files)?);
    Ok(measures)
}

/// Speeds at the points that are watched in the blood.
fn of_probes(files: &RunFiles) -> io::Result<Vec<SteadyMeasure>> {
    if !files.fluid_probes().is_file() {
        return Ok(Vec::new());
    }
    let rows: Vec<FluidProbeRow> = tables::read(&files.fluid_probes())?;
    let speed =
        |row: &FluidProbeRow| (row.ux_m_s.powi(2) + row.uy_m_s.powi(2) + row.uz_m_s.powi(2)).sqrt();
    let last = rows.last().map_or(0.0, |row| row.time_s);
    let fastest = rows.iter().filter(|row| row.time_s == last).map(speed);
    let size = SLOW * fastest.fold(0.0, f64::max);
    let mut by_probe: BTreeMap<usize, SteadyMeasure> = BTreeMap::new();
    for row in rows.iter().filter(|row| speed(row).is_finite()) {
        let measure = by_probe.entry(row.probe).or_insert_with(|| SteadyMeasure {
            name: format!("velocity at ({}, {}, {}) m", row.x_m, row.y_m, row.z_m),
            values: Vec::new(),
            size,
        });
        measure.values.push([row.time_s, speed(row)]);
    }
    Ok(by_probe.into_values().collect())
}
