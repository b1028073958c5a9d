//! What a run computed, in a table: vessel, walls, blood, what flows in and out, meshes, date and version.

use super::page::{escape, significant, table};
use crate::analysis::case_figures::CaseFigures;
use crate::analysis::size;
use crate::case::{Case, Material, VesselSide};
use crate::geometry::Vessel;
use crate::output::results::Results;
use crate::tabular::units::MMHG;
use std::time::UNIX_EPOCH;

const SECONDS_OF_A_DAY: u64 = 86_400;

/// The table, as HTML.
pub fn html(run: &Results) -> String {
    let mut rows = Vec::new();
    if let Some(figures) = CaseFigures::of(&run.case) {
        vessel(&run.case, &figures, &mut rows);
        flow(&run.case, &figures, &mut rows);
    }
    meshes(run, &mut rows);
    if let Some(date) = date(run) {
        rows.push(("date".into(), date));
    }
    if let Some(summary) = &run.summary {
        rows.push(("version".into(), format!("fsi-driver {}", summary.version)));
    }
    let rows: Vec<Vec<String>> = (rows.into_iter())
        .map(|(name, value): (String, String)| {
            vec![escape(&name), format!("<span>{}</span>", escape(&value))]
        })
        .collect();
    table(&["case", ""], &rows)
}

type Rows = Vec<(String, String)>;

/// Shape and walls.
fn vessel(case: &Case, figures: &CaseFigures, rows: &mut Rows) {
    let Some(keys) = case.vessel() else {
        return;
    };
    let [least, mean, most] = figures.radii.map(|r| significant(1e3 * r, 3));
    rows.push((
        "lumen".into(),
        format!(
            "radius {mean} mm on average ({least} to {most}), {} mm long",
            significant(1e3 * figures.length, 3)
        ),
    ));
    let geometry = Vessel::new(keys);
    for section in geometry.elastic_sections() {
        let layer = |(material, thickness): (usize, f64)| {
            let name = &geometry.material_names()[material];
            format!(
                "{} mm {name} ({})",
                significant(1e3 * thickness, 3),
                law(&geometry.materials()[material])
            )
        };
        let layers: Vec<String> = geometry.layers_of(section).into_iter().map(layer).collect();
        if !keys.is_rigid() {
            rows.push((format!("wall of {}", section.name), layers.join("; ")));
        }
    }
    for wall in &figures.walls {
        if let (Some(speed), Some(distension)) = (wall.wave_speed, wall.distension) {
            rows.push((
                format!("pulse waves in {}", wall.name),
                format!(
                    "{} m/s at the mean pressure, distension {} %, as a long tube held along its axis",
                    significant(speed, 3),
                    significant(100.0 * distension, 2)
                ),
            ));
        }
    }
}

/// A material's parameters.
fn law(material: &Material) -> String {
    let kpa = |value: f64| significant(1e-3 * value, 3);
    match material {
        Material::NeoHooke { mu, .. } => format!("Neo-Hooke, mu {} kPa", kpa(*mu)),
        Material::HolzapfelGasserOgden {
            mu,
            k1,
            k2,
            fibre_angle_deg,
            ..
        } => format!(
            "Holzapfel, Gasser and Ogden, mu {} kPa, k1 {} kPa, k2 {k2}, {fibre_angle_deg}°",
            kpa(*mu),
            kpa(*k1)
        ),
        Material::SaintVenantKirchhoff {
            youngs_modulus,
            poisson_ratio,
            ..
        } => {
            format!(
                "Saint Venant and Kirchhoff, E {} kPa, nu {poisson_ratio}",
                kpa(*youngs_modulus)
            )
        }
        Material::LinearElastic {
            youngs_modulus,
            poisson_ratio,
        } => format!(
            "linear elastic, E {} kPa, nu {poisson_ratio}",
            kpa(*youngs_modulus)
        ),
    }
}

/// Blood, inflow and what is downstream of the outlet.
fn flow(case: &Case, figures: &CaseFigures, rows: &mut Rows) {
    let Some(keys) = case.vessel() else {
        return;
    };
    let blood = &case.blood;
    rows.push((
        "blood".into(),
        format!(
            "{} kg/m³, {} mPa s",
            blood.density,
            significant(1e3 * blood.viscosity, 3)
        ),
    ));
    if let Some(flow) = figures.flow {
        rows.push((
            "inflow".into(),
            format!(
                "{} ml/min on average, at most {} ml/s; period {} s",
                significant(6e7 * flow.mean, 3),
                significant(1e6 * flow.peak, 3),
                case.time.period
            ),
        ));
        let [mean, peak] = flow.reynolds.map(|number| significant(number, 3));
        rows.push((
            "Reynolds number".into(),
            format!("{mean} on average, at most {peak}, where it is narrowest"),
        ));
        rows.push(("Womersley number".into(), significant(figures.womersley, 3)));
    }
    for opening in keys
        .opening_keys()
        .iter()
        .filter(|it| it.end == VesselSide::End)
    {
        rows.push((opening.name().to_owned(), opening.condition.to_string()));
    }
    if let Some(pressures) = figures
        .pressures
        .filter(|pressures| pressures.highest != 0.0)
    {
        rows.push((
            "pressure to be expected".into(),
            format!(
                "{} mmHg on average ({} to {}){}",
                significant(pressures.mean / MMHG, 3),
                significant(pressures.lowest / MMHG, 3),
                significant(pressures.highest / MMHG, 3),
                figures.as_tubes()
            ),
        ));
    }
}

fn meshes(run: &Results, rows: &mut Rows) {
    let solver = run.case.fluid.solver;
    let cells = run
        .summary
        .as_ref()
        .map_or(size::fluid_cells(&run.case), |summary| summary.fluid_cells);
    let size = match cells {
        0 => String::new(), // of a run that goes on, not known yet
        cells => format!("{cells} {}, ", solver.pieces()),
    };
    rows.push(("fluid".into(), format!("{size}solver {solver}")));
    if let Some(summary) = run.summary.as_ref().filter(|_| run.case.has_elastic_wall()) {
        let p = run.case.structure.p;
        rows.push((
            "structure".into(),
            format!("{} degrees of freedom, degree {p}", summary.structure_dofs),
        ));
    }
    let time = &run.case.time;
    rows.push((
        "time".into(),
        format!("{} of {} s", run.case.steps_told(), time.step),
    ));
}

/// When the run ended: year, month and day of its summary, in UTC.
fn date(run: &Results) -> Option<String> {
    let changed = std::fs::metadata(run.files.summary())
        .ok()?
        .modified()
        .ok()?;
    let days = changed.duration_since(UNIX_EPOCH).ok()?.as_secs() / SECONDS_OF_A_DAY;
    let [year, month, day] = civil(days);
    Some(format!("{year}-{month:02}-{day:02}"))
}

/// Year, month and day of so many days after 1970-01-01: Hinnant's algorithm, in eras of 400 years from March 1 on.
fn civil(days: u64) -> [u64; 3] {
    let days = days + 719_468;
    let (era, of_era) = (days / 146_097, days % 146_097);
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let shifted = (5 * of_year + 2) / 153;
    let day = of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 {
        shifted + 3
    } else {
        shifted - 9
    };
    [year + 400 * era + u64::from(month <= 2), month, day]
}

#[cfg(test)]
mod tests {
    use super::civil;

    #[test]
    fn days_are_dates() {
        for (days, date) in [
            (0, [1970, 1, 1]),
            (59, [1970, 3, 1]),
            (11_016, [2000, 2, 29]),
            (20_783, [2026, 11, 26]),
        ] {
            assert_eq!(civil(days), date);
        }
    }
}
