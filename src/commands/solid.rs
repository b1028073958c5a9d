//! `fsi-driver solid FILE.toml`: a tube under internal pressure, without a fluid.

use super::{Failure, results_folder};
use crate::Vec3;
use crate::analysis::motion::{Dynamics, Motion};
use crate::analysis::solid_file::SolidFile;
use crate::analysis::tube::{self, Tube};
use crate::output::progress::Progress;
use crate::output::stress_fields::stress_fields;
use crate::output::tables::Table;
use crate::output::terminal::{self, PrintError};
use crate::output::vtu::{Cells, Grid, Values};
use crate::output::write_atomically;
use crate::pfem::evaluation::samples::Sampler;
use crate::pfem::solution::stability::{AtBifurcation, Bifurcation};
use crate::pfem::solution::statics::{LoadStep, StaticOptions};
use crate::pfem::solution::stats::Stats;
use crate::pfem::{Discretization, SolidError};
use crate::processes::peak_memory;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A copy of the file; its presence marks a folder as one that this command made.
const MARK: &str = "solid.toml";

/// Options of the analysis.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The tube: geometry, materials, mesh, ansatz space, load, supports; an example stands in docs/solid.toml.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Folder of the results [default: the file's name with `-results` instead of its ending].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace earlier results in the same folder.
    #[arg(long)]
    force: bool,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
}

/// `summary.json`.
#[derive(Debug, Serialize)]
#[allow(non_snake_case, reason = "the keys carry the units")]
struct Summary {
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
    pressure_Pa: f64,
    /// Pressure at which a static analysis lost its stability.
    buckling_pressure_Pa: Option<f64>,
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

/// Inflates the tube of a file and writes what came out.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let clock = Instant::now();
    let input = |e: &dyn std::fmt::Display| Failure::Input(e.to_string());
    let solid = SolidFile::load(&arguments.file).map_err(|e| input(&e))?;
    let tube = solid.tube();
    let body = tube.discretize(&solid.options).map_err(|e| input(&e))?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| beside(&arguments.file));
    results_folder::claim(&out, MARK, arguments.force)?;
    let text = std::fs::read(&arguments.file).map_err(|e| input(&e))?;
    write_atomically(&out.join(MARK), &text).map_err(written)?;

    let solution = match &solid.dynamics {
        None => inflate(&solid, &tube, &body),
        Some(dynamics) => {
            let mut motion = Motion::new(&tube, &solid.options, dynamics).map_err(failed)?;
            let history = Table::create(&out.join("history.csv")).map_err(written)?;
            move_tube(&mut motion, dynamics, history, arguments.quiet)
        }
    }?;
    let summary = summarize(&solid, &tube, &body, &solution, clock).map_err(failed)?;
    if !solution.steps.is_empty() {
        let curve = curve(&solid, &tube, &body, &solution).map_err(written)?;
        write_atomically(&out.join("curve.csv"), &curve).map_err(written)?;
    }
    write(&out, &body, &solution, &summary)?;
    print(&summary, &out)?;
    match (summary.buckling_pressure_Pa, solid.at_bifurcation) {
        (Some(pressure), AtBifurcation::Stop) => Err(Failure::Run(format!(
            "the tube loses its stability at {pressure:.1} Pa of {:.1} Pa. The results in {} are those of {:.1} Pa, the last \
             stable equilibrium found, and buckling_mode.vtu shows where it goes. load.at_bifurcation = \"switch\" \
             follows the stable path, \"continue\" the unstable one",
            solid.pressure,
            out.display(),
            summary.pressure_Pa,
        ))),
        _ => Ok(()),
    }
}

/// The folder `name-results` beside `name.toml`.
fn beside(file: &Path) -> PathBuf {
    let mut name = file.file_stem().unwrap_or_default().to_owned();
    name.push("-results");
    file.with_file_name(name)
}

fn failed(error: SolidError) -> Failure {
    Failure::Run(error.to_string())
}

fn written(error: impl std::fmt::Display) -> Failure {
    Failure::Run(format!("the results could not be written: {error}"))
}

/// The last displacement and the way to it.
struct Solution {
    /// Without pressures, ends moved apart; of a static analysis.
    unloaded: Vec<f64>,
    displacement: Vec<f64>,
    /// Share of the full pressure.
    factor: f64,
    bifurcation: Option<Bifurcation>,
    /// Of a static analysis.
    steps: Vec<LoadStep>,
    stats: Stats,
}

fn inflate(solid: &SolidFile, tube: &Tube, body: &Discretization) -> Result<Solution, Failure> {
    let statics = StaticOptions {
        steps: solid.steps,
        at_bifurcation: solid.at_bifurcation,
        ..Default::default()
    };
    let found = tube
        .inflate(body, &solid.options, &statics, None)
        .map_err(failed)?;
    Ok(Solution {
        unloaded: found.unloaded,
        displacement: found.displacement,
        factor: found.factor,
        bifurcation: found.bifurcation,
        steps: found.steps,
        stats: found.stats,
    })
}

fn move_tube(
    motion: &mut Motion,
    dynamics: &Dynamics,
    mut history: Table,
    quiet: bool,
) -> Result<Solution, Failure> {
    let mut progress = Progress::new(dynamics.steps as u64, quiet);
    for step in 1..=dynamics.steps as u64 {
        let clock = Instant::now();
        let moment = motion.advance().map_err(failed)?;
        let seconds = clock.elapsed().as_secs_f64();
        progress.step(
            step,
            moment.time_s,
            moment.newton_iterations,
            moment.residual,
            seconds,
        );
        history.append(&[moment]).map_err(written)?;
    }
    progress.finish();
    Ok(Solution {
        unloaded: Vec::new(),
        displacement: motion.structure().state().d.clone(),
        factor: dynamics.factor(dynamics.steps as f64 * dynamics.step),
        bifurcation: None,
        steps: Vec::new(),
        stats: motion.structure().stats(),
    })
}

fn summarize(
    solid: &SolidFile,
    tube: &Tube,
    body: &Discretization,
    solution: &Solution,
    clock: Instant,
) -> Result<Summary, SolidError> {
    let d = &solution.displacement;
    let measures = tube::measure(body, &solid.options, d)?;
    let stats = &solution.stats;
    Ok(Summary {
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
        total_s: clock.elapsed().as_secs_f64(),
        peak_memory_MB: peak_memory(std::process::id()).unwrap_or(0.0) / 1e6,
    })
}

/// `curve.csv`: pressure and mean radii at mid-length, from the tube without pressures, ends moved apart, through every
/// load step.
fn curve(
    solid: &SolidFile,
    tube: &Tube,
    body: &Discretization,
    solution: &Solution,
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

fn write(
    out: &Path,
    body: &Discretization,
    solution: &Solution,
    summary: &Summary,
) -> Result<(), Failure> {
    let displacement = &solution.displacement;
    let centres: Vec<Centre> = tube::fields(body, &[0.0], displacement)
        .map_err(failed)?
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
    let mut table = Table::create(&out.join("von_mises.csv")).map_err(written)?;
    table.append(&centres).map_err(written)?;

    let sampler = Sampler::new(body, (body.space.max_degree() + 1).min(8)).map_err(failed)?;
    let samples = sampler.sample(body, displacement).map_err(failed)?;
    let stresses = stress_fields(&samples);
    Grid {
        points: &sampler.points,
        cells: Cells::Hexes(&sampler.hexes),
        point_data: stresses.point_data(&samples),
        cell_data: vec![
            ("layer", Values::Integers(&sampler.regions)),
            ("element", Values::Integers(&sampler.element_of_hex)),
        ],
    }
    .write(&out.join("tube.vtu"))
    .map_err(written)?;
    if let Some(bifurcation) = &solution.bifurcation {
        let before = sampler.displacement(body, &bifurcation.displacement);
        let mode = sampler.displacement(body, &bifurcation.mode);
        Grid {
            points: &sampler.points,
            cells: Cells::Hexes(&sampler.hexes),
            point_data: vec![
                ("displacement_m", Values::Vectors(&before)),
                ("mode", Values::Vectors(&mode)),
            ],
            cell_data: vec![("layer", Values::Integers(&sampler.regions))],
        }
        .write(&out.join("buckling_mode.vtu"))
        .map_err(written)?;
    }
    // Last, so that a folder with a summary is complete.
    let json = serde_json::to_string_pretty(summary).map_err(written)?;
    write_atomically(&out.join("summary.json"), json.as_bytes()).map_err(written)
}

fn print(summary: &Summary, out: &Path) -> Result<(), PrintError> {
    let s = summary;
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
    terminal::print(text)
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
