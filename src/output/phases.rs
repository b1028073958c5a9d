//! Averages over the beats of a run: `phases.csv` and `phases.pvd`.

use super::run_files::{RunFiles, draft, replace};
use super::tables::{self, HistoryRow};
use super::vtu::{Cells, Values, VtuGrid, VtuSeries};
use super::wall_history::WallHistoryReader;
use super::write_atomically;
use crate::Vec3;
use crate::analysis;
use crate::analysis::centre_line;
use crate::case::{Case, Window};
use crate::files::named;
use crate::hemodynamics::RegionStep;
use crate::hemodynamics::phases::{PhaseMean, Phases, WallPhases, phase_means};
use std::io;

/// A quantity of the history.
type HistoryQuantity = (&'static str, fn(&HistoryRow) -> f64);

const QUANTITIES: [HistoryQuantity; 9] = [
    ("Q_in_m3_s", |row| row.Q_in_m3_s),
    ("Q_out_m3_s", |row| row.Q_out_m3_s),
    ("p_in_Pa", |row| row.p_in_Pa),
    ("p_out_Pa", |row| row.p_out_Pa),
    ("p_windkessel_Pa", |row| row.p_windkessel_Pa),
    ("lumen_volume_m3", |row| row.lumen_volume_m3),
    ("dVdt_m3_s", |row| row.dVdt_m3_s),
    ("max_displacement_m", |row| row.max_displacement_m),
    ("max_von_mises_Pa", |row| row.max_von_mises_Pa),
];

/// Averages a run over the beats of a window, at each of `count` phases of the period, and writes both files `into` a
/// folder.
pub fn write(
    files: &RunFiles,
    into: &RunFiles,
    case: &Case,
    window: Window,
    count: usize,
) -> io::Result<()> {
    let phases = Phases {
        period: case.time.period,
        count,
    };
    let folder = draft(into)?;
    let drafted = RunFiles::new(folder.path());
    let columns = columns(files, case, window, phases)?;
    write_atomically(
        &drafted.phases(),
        &table(phases, &columns).map_err(io::Error::other)?,
    )?;

    let reader = WallHistoryReader::open(&files.wall_history())?;
    let wall = reader.wall.clone().around(centre_line(case));
    let mut means = WallPhases::new(phases, window, case.time.step, &wall);
    for state in reader {
        means.add(&state?);
    }
    let mut series = VtuSeries::new(drafted.wall_phases())?;
    for (end, vector, magnitude, displacement) in means.means() {
        let points: Vec<Vec3> = wall
            .points
            .iter()
            .zip(&displacement)
            .map(|(x, u)| x + u)
            .collect();
        let grid = VtuGrid {
            points: &points,
            cells: Cells::Polygons(&wall.faces),
            point_data: vec![("mean_displacement_m", Values::Vectors(&displacement))],
            cell_data: vec![
                ("mean_wall_shear_Pa", Values::Vectors(&vector)),
                ("mean_wall_shear_magnitude_Pa", Values::Scalars(&magnitude)),
            ],
        };
        series.add(end, &grid)?;
    }
    // Those of more phases.
    let former = into.wall_phases().with_extension("");
    match std::fs::remove_dir_all(&former) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(named(&former)(error)),
        _ => replace(folder.path(), into.root())?,
    }
    folder.close()
}

/// A column of the table: its name, and the mean at each phase.
type PhaseColumn = (String, Vec<Option<PhaseMean>>);

fn columns(
    files: &RunFiles,
    case: &Case,
    window: Window,
    phases: Phases,
) -> io::Result<Vec<PhaseColumn>> {
    let step = case.time.step;
    let history: Vec<HistoryRow> = tables::read(&files.history())?;
    let regions: Vec<RegionStep> = tables::read(&files.regions())?;
    let means = |times: &[f64], values: &[f64]| phase_means(phases, window, step, times, values);
    let mut columns: Vec<PhaseColumn> = Vec::new();
    let times: Vec<f64> = history.iter().map(|row| row.time_s).collect();
    for (name, quantity) in QUANTITIES {
        let values: Vec<f64> = history.iter().map(quantity).collect();
        columns.push((name.into(), means(&times, &values)));
    }
    for region in analysis::regions(case) {
        let rows: Vec<_> = regions
            .iter()
            .filter(|row| row.region == region.name)
            .collect();
        let times: Vec<f64> = rows.iter().map(|row| row.time_s).collect();
        let name = region.name.to_string().replace('-', "_");
        let mean: Vec<f64> = rows.iter().map(|row| row.mean_wall_shear_Pa).collect();
        let most: Vec<f64> = rows.iter().map(|row| row.max_wall_shear_Pa).collect();
        let volume: Vec<f64> = rows.iter().map(|row| row.lumen_volume_m3).collect();
        columns.push((format!("{name}_mean_wall_shear_Pa"), means(&times, &mean)));
        columns.push((format!("{name}_max_wall_shear_Pa"), means(&times, &most)));
        columns.push((format!("{name}_lumen_volume_m3"), means(&times, &volume)));
    }
    Ok(columns)
}

/// A row for each phase that was seen: its end within the period, the number of beats, and of each quantity the mean
/// and the standard deviation over the beats.
fn table(phases: Phases, columns: &[PhaseColumn]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let names = columns
        .iter()
        .flat_map(|(name, _)| [name.clone(), format!("{name}_std")]);
    let first = ["phase_s", "beats"].map(str::to_owned).into_iter();
    writer.write_record(first.chain(names))?;
    for phase in 0..phases.count {
        let means: Option<Vec<PhaseMean>> = columns.iter().map(|(_, means)| means[phase]).collect();
        let Some(means) = means.filter(|means| !means.is_empty()) else {
            continue;
        };
        let values = means.iter().flat_map(|mean| [mean.mean, mean.deviation]);
        writer.serialize((
            phases.end(phase),
            means[0].beats,
            values.collect::<Vec<f64>>(),
        ))?;
    }
    writer.into_inner().map_err(|e| e.into_error().into())
}
