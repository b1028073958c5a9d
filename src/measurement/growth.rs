//! How the cost of a step grows with the meshes: finer and finer ones of the same case, as table and plot.

use super::budget::Budget;
use super::{BudgetReport, Measurement};
use crate::case::{BloodVessel, ResolvedCase};
use crate::output::figure::{Curve, Figure, Marker, Panel, Scale};
use crate::output::{terminal, write_atomically};
use crate::run::{CaseSelection, Failure, Interrupt};
use std::fs;
use std::io;
use std::path::Path;

/// Resolution of the fluid over that of the case, in each direction: half to sixteen times its cells.
const FLUID: [f64; 5] = [0.8, 1.0, 1.45, 2.0, 2.5];
/// Of the structure, along the vessel and around it.
const STRUCTURE: [f64; 4] = [0.7, 1.0, 1.35, 2.0];

/// Measures every size: the fluid with the coarsest structure and the structure with the coarsest fluid. Leaves the
/// figures of each (`fluid-0.8-structure-0.7.json`), `growth.csv`, `growth.svg` and `growth.png`.
pub fn measure(
    measurement: &Measurement<'_>,
    case: &ResolvedCase,
    folder: &Path,
    interrupt: &Interrupt,
) -> Result<(), Failure> {
    let Some(vessel) = case.vessel() else {
        return Err(Failure::Input(format!(
            "--growth: {} is a flag in a channel, and the sizes are those of a vessel's meshes; give a case with a vessel",
            measurement.case.display()
        )));
    };
    let fluids = FLUID.map(|fluid| (fluid, STRUCTURE[0])).into_iter();
    let structures = STRUCTURE[1..].iter().map(|&size| (FLUID[0], size));
    let chosen: Vec<(String, CaseSelection)> = (fluids.chain(structures))
        .map(|(fluid, structure)| {
            let selection = scaled(measurement.selection, vessel, fluid, structure);
            (format!("fluid-{fluid}-structure-{structure}"), selection)
        })
        .collect();
    // All of them are looked at before the first one is computed.
    let sizes = chosen.iter().map(|(name, selection)| {
        let of_size = Measurement {
            selection,
            ..*measurement
        };
        (name, of_size)
    });
    let sizes: Vec<_> = sizes.collect();
    for (_, measurement) in &sizes {
        measurement.warm_case()?;
    }
    let failed = |e: io::Error| Failure::Run(format!("cannot write {}: {e}", folder.display()));
    fs::create_dir_all(folder).map_err(failed)?;
    let mut reports = Vec::new();
    for (name, measurement) in &sizes {
        let file = folder.join(format!("{name}.json"));
        let report = if file.exists() {
            BudgetReport::read(&file)?
        } else {
            let warm = folder.join(name);
            let report = measurement.take(&warm, interrupt)?;
            report.write(&file)?;
            fs::remove_dir_all(&warm).map_err(failed)?;
            report
        };
        terminal::print(format_args!("{}\n", report.table(None)))?;
        reports.push(report);
    }
    let (fluid, structure) = reports.split_at(FLUID.len());
    let structure: Vec<_> = fluid[..1].iter().chain(structure).collect();
    let figure = figure(&fluid.iter().collect::<Vec<_>>(), &structure);
    figure.write(&folder.join("growth")).map_err(failed)?;
    let table = table(&reports).map_err(failed)?;
    write_atomically(&folder.join("growth.csv"), &table).map_err(failed)
}

/// The case with finer (or coarser) meshes.
fn scaled(
    selection: &CaseSelection,
    vessel: &BloodVessel,
    fluid: f64,
    structure: f64,
) -> CaseSelection {
    let (cells, native, elements) = (&vessel.fluid.mesh, &vessel.fluid.native, &vessel.structure);
    let times = |number: usize, factor: f64| (number as f64 * factor).round();
    // The mesh of the solver that is not used changes nothing.
    #[rustfmt::skip]
    let sizes = [
        ("fluid.mesh.core", times(cells.core, fluid)),
        ("fluid.mesh.radial", times(cells.radial, fluid)),
        ("fluid.mesh.axial_extension", times(cells.axial_extension, fluid)),
        ("fluid.mesh.axial_per_section", times(cells.axial_per_section, fluid)),
        ("fluid.native.core", times(native.core, fluid)),
        ("fluid.native.radial", times(native.radial, fluid)),
        ("fluid.native.axial_extension", times(native.axial_extension, fluid)),
        ("fluid.native.axial_per_section", times(native.axial_per_section, fluid)),
        ("structure.circumferential", times(elements.circumferential, structure)),
        ("structure.axial_per_section", times(elements.axial_per_section, structure)),
    ];
    sizes
        .into_iter()
        .fold(selection.clone(), |selection, (key, value)| {
            selection.with(key, value)
        })
}

/// CPU seconds of a fluid in processes of its own; one within the driver's shares that one's, and has wall-clock
/// seconds.
fn fluid_seconds(report: &BudgetReport) -> f64 {
    let Budget {
        fluid_cpu_s,
        fluid_s,
        ..
    } = report.per_step;
    if fluid_cpu_s > 0.0 {
        fluid_cpu_s
    } else {
        fluid_s
    }
}

/// CPU seconds, which other programs on the machine do not change, wherever there are such.
fn figure(fluid: &[&BudgetReport], structure: &[&BudgetReport]) -> Figure {
    let cells = |report: &BudgetReport| report.fluid_cells as f64;
    let unknowns = |report: &BudgetReport| report.structure_dofs as f64;
    Figure {
        columns: 2,
        panels: vec![
            panel(
                "fluid",
                "cells",
                [
                    curve(fluid, "a step", cells, fluid_seconds),
                    curve(fluid, "a corrector", cells, |report| {
                        fluid_seconds(report) / report.per_step.fluid_correctors
                    }),
                ],
            ),
            panel(
                "driver",
                "degrees of freedom of the structure",
                [
                    curve(structure, "a step", unknowns, |report| {
                        report.per_step.driver_cpu_s
                    }),
                    curve(structure, "a Newton iteration", unknowns, |report| {
                        report.per_step.driver_cpu_s / report.per_step.newton_iterations
                    }),
                ],
            ),
        ],
    }
}

fn panel(title: &str, x_label: &str, curves: [Curve; 2]) -> Panel {
    let mut curves = Vec::from(curves);
    for (colour, curve) in curves.iter_mut().enumerate() {
        curve.colour = colour;
    }
    Panel {
        title: title.into(),
        x_label: x_label.into(),
        y_label: "s".into(),
        scales: [Scale::Logarithmic; 2],
        curves,
    }
}

/// A curve whose name says the power by which it grows.
fn curve(
    reports: &[&BudgetReport],
    name: &str,
    size: impl Fn(&BudgetReport) -> f64,
    seconds: impl Fn(&BudgetReport) -> f64,
) -> Curve {
    let points: Vec<_> = (reports.iter())
        .map(|report| (size(report), seconds(report)))
        .collect();
    Curve {
        name: format!("{name} ∝ n^{{{:.2}}}", exponent(&points)),
        points,
        colour: 0,
        marker: Some(Marker::Circle),
        open: false,
    }
}

/// The power of a fit `y = c xⁿ`, by least squares of the logarithms.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|(x, _)| x.ln()), mean(|(_, y)| y.ln()));
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
        (points.iter())
            .map(|(a, b)| of(a.ln() - x, b.ln() - y))
            .sum()
    };
    sum(&|a, b| a * b) / sum(&|a, _| a * a)
}

fn table(reports: &[BudgetReport]) -> io::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "fluid_cells",
        "structure_dofs",
        "coupling_iterations",
        "correctors",
        "newton_iterations",
        "fluid_s",
        "fluid_cpu_s",
        "driver_cpu_s",
        "fluid_MB",
        "driver_MB",
    ])?;
    for report in reports {
        let means = &report.per_step;
        writer.serialize((
            report.fluid_cells,
            report.structure_dofs,
            means.coupling_iterations,
            report.per_step.fluid_correctors,
            means.newton_iterations,
            means.fluid_s,
            means.fluid_cpu_s,
            means.driver_cpu_s,
            means.fluid_peak_memory_MB,
            means.driver_peak_memory_MB,
        ))?;
    }
    writer.into_inner().map_err(|e| e.into_error())
}

#[cfg(test)]
mod tests {
    use super::exponent;

    #[test]
    fn the_exponent_of_a_power_law() {
        let points = [1e3, 5e3, 2e5].map(|x: f64| (x, 0.3 * x.powf(1.25)));
        assert!((exponent(&points) - 1.25).abs() < 1e-12);
    }
}
