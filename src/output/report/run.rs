//! The page of a run.

use super::flow_field::LumenFlow;
use super::page::{Page, chart, escape, gallery, line, panel, table, warnings};
use super::quantities::{Quantity, UNKNOWN};
use super::surface::DrawnSurface;
use super::table::transposed;
use super::{
    along, case_table, initial_state, junctions, maps, openings, quantities, resolution, scene,
};
use crate::analysis;
use crate::analysis::centre_line;
use crate::analysis::size;
use crate::case::{Case, TreeKeys};
use crate::geometry::Vessel;
use crate::hemodynamics::{Region, RegionExtent, RegionName};
use crate::output::figure::{Curve, Panel, Scale};
use crate::output::results::Results;
use crate::output::tables::{HistoryRow, whole_steps};
use crate::output::wall_history::WallHistoryReader;
use crate::tabular::units::MMHG;
use fsi_numerics::twelve_digits;
use std::io;

/// Writes the page.
pub fn page(run: &Results) -> io::Result<String> {
    let name = run.case_name();
    let window = run.hemodynamics.window;
    let sizes = match (&run.vessel, &run.summary) {
        (Some(vessel), _) => format!(
            "{} fluid cells, structure of degree {} with {} elements",
            size::fluid_cells(&run.case),
            run.case.structure.p,
            Vessel::new(vessel).wall_elements(&vessel.structure)
        ),
        (None, Some(summary)) => {
            let blood = run.case.fluid.solver.pieces();
            let wall = match run.case.has_elastic_wall() {
                true => format!(
                    "structure of degree {} with {} degrees of freedom",
                    run.case.structure.p, summary.structure_dofs
                ),
                false => "a rigid wall".into(),
            };
            format!("{} fluid {blood}, {wall}", summary.fluid_cells)
        }
        (None, None) => format!("structure of degree {}", run.case.structure.p),
    };
    let lead = format!(
        "{sizes}; {} steps to t = {} s. Averages over {} s < t ≤ {} s{}.",
        run.history.len(),
        twelve_digits(run.history.last().map_or(0.0, |row| row.time_s)),
        window.start_s,
        window.end_s,
        match (run.hemodynamics.complete, run.is_going_on) {
            (true, _) => "",
            (false, true) => ", as far as they are computed",
            (false, false) => ", of which not every step was computed",
        },
    );
    let mut page = Page::new(&format!("Blood and wall of {name}"), &lead);
    if run.is_going_on {
        page.of_unfinished_run(&format!(
            "The run is going on, to t = {} s: these are its results so far. This page reloads itself each minute; \
             fsi-driver report --follow keeps it up to date.",
            run.case.time.end
        ));
    }
    let figures = warnings(&run.warnings()) + &measures(run);
    page.section("figures", "In figures", &figures);
    page.section("case", "The case", &case_table::html(run));
    if let Some(html) = initial_state::section(run)? {
        page.section("state", "The wall at t = 0", &html);
    }
    page.section("flow", "Flow, volume and pressure", &gallery(&flow(run)));
    let openings = openings::openings(run)?;
    if !openings.is_empty() {
        page.section("openings", "Openings", &gallery(&openings));
    }
    let sections = openings::sections(run)?;
    if !sections.is_empty() {
        page.section("through", "Cross-sections", &gallery(&sections));
    }
    page.section("periodicity", "Periodicity", &gallery(&periodicity(run)));
    page.section("wall", "Wall", &gallery(&wall(run)));
    let surface = DrawnSurface::of(run)?;
    if let Some(surface) = &surface {
        let html = format!(
            "<p>The wet surface over the evaluated window. Drag to rotate, scroll to zoom.</p>\n{}",
            scene::viewer(surface, surface.widest_frame())
        );
        page.section("view", "The wall in three dimensions", &html);
        page.section("pictures", "Deformed wall", &gallery(&pictures(surface)));
    }
    if let (Some(surface), Some(keys)) =
        (&surface, run.case.own().and_then(|own| own.tree.as_ref()))
    {
        let html = junctions::html(keys, surface)?;
        if !html.is_empty() {
            page.section("junctions", "Where branches meet", &html);
        }
    }
    unrolled(run, &name, &mut page)?;
    if let Some(flow) = LumenFlow::of(run)? {
        let cuts = super::flow_cut::cuts(run, &flow);
        page.section("cuts", "Blood in a longitudinal cut", &gallery(&cuts));
        let sections = super::flow_sections::sections(run, &flow);
        page.section("sections", "Blood in cross-sections", &gallery(&sections));
    }
    if let Some(html) = resolution::section(run)? {
        page.section("resolution", "How well the flow is resolved", &html);
    }
    let html = left_over(run) + &gallery(&effort(run));
    page.section("effort", "Coupling", &html);
    Ok(page.to_html())
}

/// The wall on the unrolled vessel, or on each unrolled branch of a tree.
fn unrolled(run: &Results, name: &str, page: &mut Page) -> io::Result<()> {
    if run.vessel.is_some() && !run.faces.is_empty() {
        page.section(
            "maps",
            "On the unrolled wall",
            &gallery(&maps::of_run(run, name)),
        );
        page.section(
            "radius",
            "Radius of the lumen at chosen times",
            &gallery(&radii(run)?),
        );
    }
    if run.case.own().is_some_and(|own| own.tree.is_some()) {
        let branches = maps::parts(run)?;
        if !branches.is_empty() {
            let html = gallery(&along::figures(run, &branches));
            page.section("along", "Along the branches", &html);
            let html = gallery(&maps::of_branches(run, &branches));
            page.section("maps", "On the unrolled branches", &html);
        }
    }
    Ok(())
}

fn column(run: &Results, value: fn(&HistoryRow) -> f64, unit: f64) -> Vec<(f64, f64)> {
    let rows = run.history.iter();
    rows.map(|row| (row.time_s, value(row) / unit)).collect()
}

/// More regions than these are rows of their table: as columns they would not fit on a page.
const MOST_COLUMNS: usize = 5;

/// A row for each measure of the hemodynamics, a column for each region; or the other way round.
fn measures(run: &Results) -> String {
    let regions = &run.hemodynamics.regions;
    if regions.is_empty() {
        return "<p>The run has not come to the evaluated window yet.</p>\n".into();
    }
    let are_rows = regions.len() > MOST_COLUMNS;
    let mut heads = vec![if are_rows { "region" } else { "measure" }.to_owned()];
    heads.extend(regions.iter().map(|r| {
        let name = escape(&r.region.name.to_string());
        match &r.region.extent {
            RegionExtent::Along { from_m, to_m } => {
                format!("{name}<br>{:.2} mm to {:.2} mm", 1e3 * from_m, 1e3 * to_m)
            }
            RegionExtent::Box { box_m: [a, b] } => {
                let side = |i: usize| format!("{:.4} to {:.4}", a[i].min(b[i]), a[i].max(b[i]));
                let [x, y, z] = [0, 1, 2].map(side);
                format!("{name}<br>x {x}, y {y}, z {z} m").replace('-', "\u{2212}")
            }
            RegionExtent::Branch {
                patch,
                from_m,
                to_m,
            } => {
                let branch = branch_of(&run.case, patch).unwrap_or_else(|| patch.clone());
                let end = match to_m {
                    Some(to_m) => format!("to {:.2} mm", 1e3 * to_m),
                    None => "on".into(),
                };
                format!(
                    "{name}<br>{} from {:.2} mm {end}",
                    escape(&branch),
                    1e3 * from_m
                )
            }
            RegionExtent::Patch { patch } => match branch_of(&run.case, patch) {
                Some(_) => name,
                None => format!("{name}<br>patch {}", escape(patch)),
            },
            RegionExtent::Whole {} => name,
        }
    }));
    let row = |quantity: &Quantity| -> Option<Vec<String>> {
        let cells: Vec<String> = (regions.iter())
            .map(|region| (quantity.show)(region))
            .collect();
        // Branches of a tree have no volume of their own.
        let is_known = cells.iter().any(|cell| cell != UNKNOWN);
        is_known.then(|| [vec![quantity.name.to_owned()], cells].concat())
    };
    let rows = quantities::all().iter().filter_map(row).collect();
    let (heads, rows) = match are_rows {
        true => transposed(heads, rows),
        false => (heads, rows),
    };
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    table(&heads, &rows)
}

/// The branch of a tree whose wall is this patch.
fn branch_of(case: &Case, patch: &str) -> Option<String> {
    let tree = case.own()?.tree.as_ref()?;
    let mut pairs = tree.walls().into_iter().zip(tree.branches());
    let found = pairs.find(|(wall, _)| wall == patch);
    found.map(|(_, branch)| branch)
}

const MILLILITRE: f64 = 1e-6;

/// Flow in and out, and their difference compared with the rate of change of the lumen volume.
pub(super) fn flow_panel(run: &Results) -> Panel {
    let inflow = column(run, |row| row.Q_in_m3_s, MILLILITRE);
    let outflow = column(run, |row| row.Q_out_m3_s, MILLILITRE);
    let pairs = inflow.iter().zip(&outflow);
    let gap = pairs.map(|(a, b)| (a.0, a.1 - b.1)).collect();
    // Central differences, as in the paper.
    let derivative = column(run, |row| row.lumen_volume_m3, MILLILITRE)
        .windows(3)
        .map(|w| (w[1].0, (w[2].1 - w[0].1) / (w[2].0 - w[0].0)))
        .collect();
    let curves = vec![
        line("inflow", openings::COLOURS[0], inflow),
        line("outflow", openings::COLOURS[1], outflow),
        line("inflow − outflow", 3, gap),
        Curve {
            open: true,
            ..line("dV/dt", 0, derivative)
        },
    ];
    panel("flow", "time / s", "flow / (ml/s)", curves)
}

/// Mean pressures at inlet and outlet, of a tree at its first outlet.
pub(super) fn pressure_panel(run: &Results) -> Panel {
    let pressure = |value| column(run, value, MMHG);
    let tree = run.case.own().and_then(|own| own.tree.as_ref());
    let names = tree.map_or_else(Vec::new, TreeKeys::open_names);
    let name = |i: usize, usual| names.get(i).map_or(usual, String::as_str);
    let (inlet, outlet) = (name(0, "inlet"), name(1, "outlet"));
    let curves = vec![
        line(inlet, openings::COLOURS[0], pressure(|row| row.p_in_Pa)),
        line(outlet, openings::COLOURS[1], pressure(|row| row.p_out_Pa)),
    ];
    panel("pressure", "time / s", "pressure / mmHg", curves)
}

pub(crate) fn flow(run: &Results) -> Vec<String> {
    let volume = column(run, |row| row.lumen_volume_m3, MILLILITRE);
    let mut charts = vec![
        chart(
            "flow",
            "Flow in and out, and their difference compared with the rate of change of the lumen volume (central differences).",
            flow_panel(run),
        ),
        chart(
            "volume",
            "Volume of the lumen of the deformable part.",
            panel(
                "lumen volume",
                "time / s",
                "volume / ml",
                vec![line("", 2, volume)],
            ),
        ),
        chart(
            "pressure",
            "Mean pressures at inlet and outlet.",
            pressure_panel(run),
        ),
    ];
    // What a user-supplied OpenFOAM case prescribes knows of no ramp.
    let ramp = &run.case.ramp;
    if run.vessel.is_some() && ramp.duration > 0.0 {
        let share = |row: &HistoryRow| (row.time_s, ramp.factor(row.time_s));
        let ramps = run.history.iter().map(share).collect();
        charts.push(chart(
            "ramp",
            "Factor of inflow and outlet pressure at the start.",
            panel("ramp", "time / s", "factor / 1", vec![line("", 2, ramps)]),
        ));
    }
    charts
}

pub(crate) fn periodicity(run: &Results) -> Vec<String> {
    let beat = (run.case.time.period / run.case.time.step).round() as usize;
    let against_previous_beat = |value: fn(&HistoryRow) -> f64| -> Vec<(f64, f64)> {
        let size = run
            .history
            .iter()
            .map(|row| value(row).abs())
            .fold(0.0, f64::max);
        let rows = whole_steps(&run.history, run.case.time.step);
        let pairs = rows.iter().zip(rows.iter().skip(beat));
        pairs
            .map(|(before, now)| (now.time_s, (value(now) - value(before)).abs() / size))
            .collect()
    };
    let curves = vec![
        line(
            "outflow",
            openings::COLOURS[1],
            against_previous_beat(|row| row.Q_out_m3_s),
        ),
        line(
            "largest displacement",
            0,
            against_previous_beat(|row| row.max_displacement_m),
        ),
    ];
    if curves[0].points.is_empty() {
        return vec!["<p>The run is not longer than a period.</p>\n".into()];
    }
    let panel = Panel {
        scales: [Scale::Linear, Scale::Logarithmic],
        ..panel(
            "difference to the period before",
            "time / s",
            "difference / largest value",
            curves,
        )
    };
    let agreement = run.summary.as_ref().and_then(|it| it.periodic.as_ref());
    let said = agreement.map(|found| format!("<p>{}.</p>\n", escape(&found.to_string())));
    let chart = chart(
        "periodicity",
        "Absolute difference between successive periods, relative to the largest value of the run.",
        panel,
    );
    said.into_iter().chain([chart]).collect()
}

fn wall(run: &Results) -> Vec<String> {
    let region = |name: RegionName, value: fn(&crate::hemodynamics::RegionStep) -> f64| {
        let rows = run.regions.iter().filter(|row| row.region == name);
        rows.map(|row| (row.time_s, value(row)))
            .filter(|(_, value)| value.is_finite())
            .collect::<Vec<_>>()
    };
    // The paper's three from the last one on; others from the first.
    let named = [analysis::MID_ARTERY, analysis::ARTERY, analysis::BYPASS];
    let colour = |(number, region): (usize, &Region)| {
        let known = named.iter().position(|name| *name == region.name.as_str());
        1 + known.unwrap_or(number % 6)
    };
    let regions = analysis::regions(&run.case);
    let by_region = |value: fn(&crate::hemodynamics::RegionStep) -> f64| {
        // Dashed, since the middle is a part of the artery and often has the artery's own value; or as there are more
        // regions than colours.
        let some = regions.iter().enumerate().map(|(number, found)| Curve {
            open: found.name.as_str() == analysis::MID_ARTERY || number / 6 % 2 == 1,
            ..line(
                &found.name.to_string(),
                colour((number, found)),
                region(found.name, value),
            )
        });
        some.filter(|curve| !curve.points.is_empty()).collect()
    };
    let mut charts = vec![
        chart(
            "displacement",
            "Largest displacement of the wet surface.",
            panel(
                "displacement",
                "time / s",
                "displacement / mm",
                by_region(|row| 1e3 * row.max_displacement_m),
            ),
        ),
        chart(
            "von-mises",
            "Largest von Mises stress at the quadrature points.",
            panel(
                "von Mises stress",
                "time / s",
                "stress / kPa",
                by_region(|row| 1e-3 * row.max_von_mises_Pa),
            ),
        ),
        chart(
            "principal-stress",
            "Largest principal stress (Cauchy) at the quadrature points.",
            panel(
                "largest principal stress",
                "time / s",
                "stress / kPa",
                by_region(|row| 1e-3 * row.max_principal_Pa),
            ),
        ),
        chart(
            "mean-wall-shear",
            "Magnitude of the wall shear stress, mean over the deformed area.",
            panel(
                "mean wall shear stress",
                "time / s",
                "stress / Pa",
                by_region(|row| row.mean_wall_shear_Pa),
            ),
        ),
        chart(
            "max-wall-shear",
            "Largest wall shear stress.",
            panel(
                "largest wall shear stress",
                "time / s",
                "stress / Pa",
                by_region(|row| row.max_wall_shear_Pa),
            ),
        ),
    ];
    let stretches: Vec<Curve> = by_region(|row| row.max_fibre_stretch.unwrap_or(f64::NAN));
    if !stretches.is_empty() {
        let about = "Largest stretch of fibres at the quadrature points.";
        let panel = panel("fibre stretch", "time / s", "stretch", stretches);
        charts.insert(3, chart("fibre-stretch", about, panel));
    }
    charts
}

pub(crate) fn pictures(surface: &DrawnSurface) -> Vec<String> {
    let frame = surface.widest_frame();
    let at = format!("at t = {:.3} s", surface.times[frame]);
    [
        (
            "Displacement",
            format!("Displacement of the wet surface {at}."),
        ),
        (
            "Von Mises",
            format!("Von Mises stress at the inner side of the wall {at}."),
        ),
        (
            "Largest principal",
            format!("Largest principal stress at the inner side of the wall {at}."),
        ),
        (
            "Oscillating",
            format!("Oscillating shear index on the wall as it is {at}."),
        ),
        (
            "Time-averaged",
            format!("Time-averaged wall shear stress on the wall as it is {at}."),
        ),
    ]
    .into_iter()
    .filter_map(|(name, caption)| {
        let field = surface.field(name)?;
        Some(scene::picture(surface, field, frame, &caption))
    })
    .collect()
}

/// Times (s) at these shares of the last period, or of all of a run that is shorter, rounded to steps that were done.
fn chosen_times(end: f64, period: f64, step: f64) -> Vec<f64> {
    let start = (end - period).max(0.0);
    let times = [0.0, 0.2, 0.4, 0.7].map(|share| start + share * (end - start));
    let mut steps: Vec<f64> = times.map(|t| (t / step).round().max(1.0)).to_vec();
    steps.dedup();
    steps.into_iter().map(|n| n * step).collect()
}

/// Maps of the radius at four times of the last period.
fn radii(run: &Results) -> io::Result<Vec<String>> {
    let path = run.files.wall_history();
    if !path.is_file() {
        return Ok(vec!["<p>The run has not kept its wall.</p>\n".into()]);
    }
    let (end, period, step) = (
        run.hemodynamics.window.end_s,
        run.case.time.period,
        run.case.time.step,
    );
    let wanted = chosen_times(end, period, step);
    let reader = WallHistoryReader::open(&path)?;
    let wall = reader.wall.clone().around(centre_line(&run.case));
    let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
    for state in reader {
        let state = state?;
        if wanted.iter().any(|t| (t - state.time).abs() < 0.5 * step) {
            let radii = wall.radii(&wall.displaced(&state.displacement));
            found.push((state.time, radii.iter().map(|r| 1e3 * r).collect()));
        }
    }
    Ok(maps::radii(run, &wall.places(), &found))
}

/// What accepted steps left of the fluid's equations, of mass and of the force on the wall.
fn left_over(run: &Results) -> String {
    let Some(totals) = run.summary.as_ref().map(|summary| &summary.totals) else {
        return String::new();
    };
    // Earlier versions did not know
    if totals.max_fluid_residual == 0.0 {
        return String::new();
    }
    format!(
        "<p>{} of {} steps ended with a residual of the fluid above <code>fluid.pressure_residual</code> = {}; the largest is {:.1e}. \
         A step lost at most {:.1e} of the flow, and the wall missed at most {:.1e} of the fluid's force.</p>\n",
        totals.unfinished_steps,
        totals.steps,
        run.case.fluid.pressure_residual,
        totals.max_fluid_residual,
        totals.max_mass_lost,
        totals.max_force_mismatch
    )
}

fn effort(run: &Results) -> Vec<String> {
    let seconds = |value: fn(&HistoryRow) -> f64| column(run, value, 1.0);
    vec![
        chart(
            "iterations",
            "Coupling iterations of each time step.",
            panel(
                "coupling iterations",
                "time / s",
                "iterations / 1",
                vec![line(
                    "",
                    2,
                    column(run, |row| row.coupling_iterations as f64, 1.0),
                )],
            ),
        ),
        chart(
            "seconds",
            "Wall-clock time of each time step.",
            panel(
                "time per step",
                "time / s",
                "wall-clock time / s",
                vec![
                    line("whole step", 0, seconds(|row| row.wall_s)),
                    line("fluid", 2, seconds(|row| row.fluid_s)),
                    line("structure", 1, seconds(|row| row.structure_s)),
                ],
            ),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::chosen_times;
    use approx::assert_relative_eq;

    #[test]
    fn times_are_spread_over_the_last_period_or_a_short_run() {
        let close = |found: Vec<f64>, expected: &[f64]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            assert_relative_eq!(found[..], expected[..], epsilon = 1e-12);
        };
        close(chosen_times(3.0, 1.0, 0.002), &[2.0, 2.2, 2.4, 2.7]);
        close(chosen_times(0.1, 1.0, 0.002), &[0.002, 0.02, 0.04, 0.07]);
        close(chosen_times(0.006, 1.0, 0.002), &[0.002, 0.004]);
    }
}
