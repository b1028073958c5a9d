//! What the analysis of a tube leaves: figures, tables, fields.

use super::stress_fields::stress_fields;
use super::tables::CsvTable;
use super::vtu::{Cells, Values, VtuGrid};
use super::write_atomically;
use crate::Vec3;
use crate::analysis::solid_file::SolidFile;
use crate::analysis::tube::{self, Tube};
use crate::pfem::evaluation::samples::Sampler;
use crate::pfem::solution::stability::Bifurcation;
use crate::pfem::solution::statics::LoadStep;
use crate::pfem::solution::stats::Stats;
use crate::pfem::{Discretization, SolidError};
use crate::processes::peak_memory;
use serde::Serialize;
use std::io;
use std::path::Path;

/// `summary.json`.
#[derive(Debug, Serialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
pub struct TubeSummary {
    /// Displacement coefficients, held ones included.
    dofs: usize,
    /// Those that are not held: the size of the linear systems.
    free_dofs: usize,
    /// Of the whole tube, without the springs around it.
    strain_energy_J: f64,
    /// Of the springs around the tube.
    spring_energy_J: f64,
    /// Gauss points per direction that the energy and the Jacobians were evaluated with.
    energy_quadrature_points: [usize; 3],
    /// Pressure at which the displacement was found.
    pub pressure_Pa: f64,
    /// Pressure at which a static analysis lost its stability.
    pub buckling_pressure_Pa: Option<f64>,
    /// Of all load or time steps.
    newton_iterations: usize,
    /// Relative residuals of each load step of a static analysis.
    newton_residuals: Vec<Vec<f64>>,
    /// Inner surface, interfaces, outer surface; mean over the circumference at mid-length.
    radial_displacement_m: Vec<f64>,
    min_jacobian: f64,
    max_jacobian: f64,
    /// Largest at the quadrature points of the energy.
    max_von_mises_Pa: f64,
    /// Largest principal Cauchy stress at these points.
    max_principal_Pa: f64,
    /// Wall-clock seconds in residuals and tangents.
    assembly_s: f64,
    /// Wall-clock seconds in factorizations and substitutions.
    solve_s: f64,
    total_s: f64,
    peak_memory_MB: f64,
}

/// A row of `von_mises.csv`.
#[derive(Serialize)]
#[allow(non_snake_case, reason = "the headers carry the units")]
struct Centre {
    element: usize,
    layer: usize,
    x_m: f64,
    y_m: f64,
    z_m: f64,
    displacement_x_m: f64,
    displacement_y_m: f64,
    displacement_z_m: f64,
    von_mises_Pa: f64,
    max_principal_Pa: f64,
    hoop_stress_Pa: f64,
    axial_stress_Pa: f64,
}

/// The last displacement and the way to it.
pub struct TubeSolution {
    /// Without pressures, ends moved apart; of a static analysis.
    pub unloaded: Vec<f64>,
    /// Coefficients at the end.
    pub displacement: Vec<f64>,
    /// Share of the full pressure.
    pub factor: f64,
    /// Where stability was lost.
    pub bifurcation: Option<Bifurcation>,
    /// Of a static analysis.
    pub steps: Vec<LoadStep>,
    /// What it cost.
    pub stats: Stats,
}

/// A solution in figures, found in `seconds`.
///
/// # Errors
/// If an element is inside out.
pub fn summarize(
    solid: &SolidFile,
    tube: &Tube,
    body: &Discretization,
    solution: &TubeSolution,
    seconds: f64,
) -> Result<TubeSummary, SolidError> {
    let d = &solution.displacement;
    let measures = tube::measure(body, &solid.options, d)?;
    let stats = &solution.stats;
    Ok(TubeSummary {
        dofs: body.coefficients(),
        free_dofs: body.degrees_of_freedom(),
        strain_energy_J: measures.energy,
        spring_energy_J: body.spring_energy(d),
        energy_quadrature_points: tube::fine_rule(&solid.options),
        pressure_Pa: solution.factor * solid.pressure,
        buckling_pressure_Pa: (solution.bifurcation.as_ref())
            .map(|bifurcation| bifurcation.factor * solid.pressure),
        newton_iterations: stats.iterations,
        newton_residuals: (solution.steps.iter())
            .map(|step| step.residuals.clone())
            .collect(),
        radial_displacement_m: tube.radial_displacement(body, d),
        min_jacobian: measures.extremes.min_jacobian,
        max_jacobian: measures.extremes.max_jacobian,
        max_von_mises_Pa: measures.extremes.von_mises,
        max_principal_Pa: measures.extremes.max_principal,
        assembly_s: stats.assembly_s + stats.residual_s,
        solve_s: stats.factorization_s + stats.substitution_s,
        total_s: seconds,
        peak_memory_MB: peak_memory(std::process::id()).unwrap_or(0.0) / 1e6,
    })
}

/// `curve.csv`: pressure and mean radii at mid-length, from the tube without pressures, ends moved apart, through every
/// load step.
pub fn curve(
    solid: &SolidFile,
    tube: &Tube,
    body: &Discretization,
    solution: &TubeSolution,
) -> Result<Vec<u8>, csv::Error> {
    let radii = solid.radii();
    let names = surfaces(&radii).map(|(name, _)| format!("{}_radius_m", name.replace(' ', "_")));
    let mut table = csv::Writer::from_writer(Vec::new());
    table.write_record(std::iter::once("pressure_Pa".into()).chain(names))?;
    let steps = &solution.steps;
    let loaded = steps.iter().map(|step| (step.factor, &step.displacement));
    for (factor, d) in std::iter::once((0.0, &solution.unloaded)).chain(loaded) {
        let moved = radii.iter().zip(tube.radial_displacement(body, d));
        let row: Vec<f64> = std::iter::once(factor * solid.pressure)
            .chain(moved.map(|(r, u)| r + u))
            .collect();
        table.serialize(row)?;
    }
    table.into_inner().map_err(|e| e.into_error().into())
}

/// Writes `von_mises.csv`, `tube.vtu`, `buckling_mode.vtu` where stability was lost, and `summary.json` into the folder
/// `out`.
///
/// # Errors
/// If a file cannot be written.
pub fn write(
    out: &Path,
    body: &Discretization,
    solution: &TubeSolution,
    summary: &TubeSummary,
) -> io::Result<()> {
    let displacement = &solution.displacement;
    let centres: Vec<Centre> = tube::fields(body, &[0.0], displacement)
        .map_err(io::Error::other)?
        .into_iter()
        .enumerate()
        .map(|(element, (u, state))| {
            let x: Vec3 = body.mapping.at(element, [0.0; 3]).position;
            Centre {
                element,
                layer: body.regions()[element],
                x_m: x.x,
                y_m: x.y,
                z_m: x.z,
                displacement_x_m: u.x,
                displacement_y_m: u.y,
                displacement_z_m: u.z,
                von_mises_Pa: state.von_mises(),
                max_principal_Pa: state.principal_stresses()[0],
                hoop_stress_Pa: state.hoop_stress(),
                axial_stress_Pa: state.axial_stress(),
            }
        })
        .collect();
    let mut table = CsvTable::create(&out.join("von_mises.csv"))?;
    table.append(&centres)?;

    let sampler =
        Sampler::new(body, (body.space.max_degree() + 1).min(8)).map_err(io::Error::other)?;
    let samples = sampler
        .sample(body, displacement)
        .map_err(io::Error::other)?;
    let stresses = stress_fields(&samples);
    VtuGrid {
        points: &sampler.points,
        cells: Cells::Hexes(&sampler.hexes),
        point_data: stresses.point_data(&samples),
        cell_data: vec![
            ("layer", Values::Integers(&sampler.regions)),
            ("element", Values::Integers(&sampler.element_of_hex)),
        ],
    }
    .write(&out.join("tube.vtu"))?;
    if let Some(bifurcation) = &solution.bifurcation {
        let before = sampler.displacement(body, &bifurcation.displacement);
        let mode = sampler.displacement(body, &bifurcation.mode);
        VtuGrid {
            points: &sampler.points,
            cells: Cells::Hexes(&sampler.hexes),
            point_data: vec![
                ("displacement_m", Values::Vectors(&before)),
                ("mode", Values::Vectors(&mode)),
            ],
            cell_data: vec![("layer", Values::Integers(&sampler.regions))],
        }
        .write(&out.join("buckling_mode.vtu"))?;
    }
    // Last, so that a folder with a summary is complete.
    let json = serde_json::to_string_pretty(summary)?;
    write_atomically(&out.join("summary.json"), json.as_bytes())
}

/// The figures in words; the results are in the folder `out`.
pub fn in_words(s: &TubeSummary, out: &Path) -> String {
    let mut text = String::new();
    for (step, residuals) in s.newton_residuals.iter().enumerate() {
        let shown = residuals.iter().map(|&r| {
            if r > 0.0 {
                format!("{r:.1e}")
            } else {
                "round-off".into()
            }
        });
        let shown: Vec<String> = shown.collect();
        let residuals = shown.join(" ");
        text += &format!("load step {}:  relative residuals {residuals}\n", step + 1);
    }
    let points = s
        .energy_quadrature_points
        .map(|n| n.to_string())
        .join(" x ");
    text += &format!(
        "degrees of freedom   {} ({} of them free)\n\
         strain energy        {:.10e} J ({points} Gauss points per element)\n\
         radial displacement  at mid-length, mean around the circumference\n",
        s.dofs, s.free_dofs, s.strain_energy_J
    );
    for (surface, u) in surfaces(&s.radial_displacement_m) {
        text += &format!("  {surface:<17}  {u:.10e} m\n");
    }
    if let Some(pressure) = s.buckling_pressure_Pa {
        text += &format!("loses its stability  at {pressure:.6e} Pa (buckling_mode.vtu)\n");
    }
    text += &format!(
        "Jacobian             {:.8} to {:.8}\n\
         largest von Mises    {:.6e} Pa\n\
         largest principal    {:.6e} Pa\n\
         Newton iterations    {} ({:.2} s assembly, {:.2} s solution, {:.2} s in all, {:.0} MB)\n\
         results in           {}\n",
        s.min_jacobian,
        s.max_jacobian,
        s.max_von_mises_Pa,
        s.max_principal_Pa,
        s.newton_iterations,
        s.assembly_s,
        s.solve_s,
        s.total_s,
        s.peak_memory_MB,
        out.display()
    );
    text
}

/// Values from the inside out, each with the name of its surface.
fn surfaces(values: &[f64]) -> impl Iterator<Item = (String, f64)> + '_ {
    let name = move |i: usize| match i {
        0 => "inner surface".into(),
        i if i + 1 == values.len() => "outer surface".into(),
        i => format!("interface {i}"),
    };
    values.iter().enumerate().map(move |(i, u)| (name(i), *u))
}
