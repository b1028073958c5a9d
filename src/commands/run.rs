//! `fsi-driver --case DIR`: a coupled run.

use super::Failure;
use super::run_folder::RunFolder;
use crate::Vec3;
use crate::case::{self, Case, Preset, ResolvedCase};
use crate::coupling::acceleration::{self, Acceleration, Filter, Identity};
use crate::coupling::convergence::Criterion;
use crate::coupling::predictor::Predictor;
use crate::coupling::transfer::Transfer;
use crate::coupling::{Coupling, CouplingError, Settings, flatten};
use crate::fluid::openfoam::case_files::CaseFiles;
use crate::fluid::openfoam::session::Terms;
use crate::fluid::openfoam::{OpenFoam, OpenFoamSettings, install};
use crate::fluid::{Fluid, FluidEffort, FluidError};
use crate::geometry::Vessel;
use crate::output::probes::Probes;
use crate::output::progress::{Progress, human};
use crate::output::record::{Record, RecordSettings, Summary, WallPeaks, peak_memory};
use crate::output::tables::Table;
use crate::output::vtu::{Grid, Values};
use crate::output::write_atomically;
use crate::pfem::mapping::MappingKind;
use crate::pfem::newton::NewtonOptions;
use crate::pfem::samples::{Sampler, Samples};
use crate::pfem::structure::Trial;
use crate::pfem::supports::Support;
use crate::pfem::{SolidError, Space, SpaceKind, Structure, StructureOptions, discretization};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Options of a coupled run.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the case, with its case.toml.
    #[arg(long, value_name = "DIR")]
    case: PathBuf,
    /// Resolution and length of the run.
    #[arg(long, value_enum, default_value_t = Preset::Paper)]
    preset: Preset,
    /// Folder of the results [default: <case>/run-<preset>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// End of the simulated time in seconds [default: time.end_s of the case].
    #[arg(long, value_name = "S")]
    end_time: Option<f64>,
    /// Number of MPI ranks of the fluid [default: fluid.ranks of the case].
    #[arg(long, value_name = "N")]
    ranks: Option<usize>,
    /// Values that replace those of the case, such as coupling.e_rel=1e-6 or fluid.transport=files.
    #[arg(long = "set", value_name = "KEY=VALUE", num_args = 1..)]
    overrides: Vec<String>,
    /// Replace the results of an earlier run in the same folder.
    #[arg(long)]
    force: bool,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
}

/// Runs a coupled case from its first to its last time step.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let case = load(arguments)?;
    install::check(case.fluid.ranks).map_err(|e| Failure::Input(e.to_string()))?;
    let interrupt =
        interrupt_flag().map_err(|e| Failure::Run(format!("cannot listen to signals: {e}")))?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| arguments.case.join(format!("run-{}", arguments.preset)));
    let folder = RunFolder::create(&out, arguments.force)?;
    write_atomically(&folder.resolved_case(), case.to_toml_string().as_bytes()).map_err(written)?;

    let clock = Instant::now();
    let mut run = assemble(&case, &folder, interrupt.clone(), arguments)?;
    let steps = case.steps();
    if !arguments.quiet {
        eprintln!(
            "{}: {} fluid cells, {} structural degrees of freedom, {steps} steps; ready in {:.1} s",
            arguments.case.display(),
            run.cells,
            run.coupling.solid.body().degrees_of_freedom(),
            clock.elapsed().as_secs_f64(),
        );
    }
    let outcome = advance(&mut run, &case, steps, &interrupt, arguments.quiet);
    conclude(run, outcome, &folder, arguments.quiet)
}

/// Everything that a running case consists of.
struct Run {
    coupling: Coupling<OpenFoam, Structure>,
    sampler: Sampler,
    record: Record,
    probes: Option<Probes<Structure>>,
    cells: usize,
    fluid_peak_memory: f64,
}

fn load(arguments: &Arguments) -> Result<ResolvedCase, Failure> {
    let mut overrides = Vec::new();
    if let Some(end) = arguments.end_time {
        overrides.push(("time.end_s".to_owned(), format!("{end:?}")));
    }
    if let Some(ranks) = arguments.ranks {
        overrides.push(("fluid.ranks".to_owned(), ranks.to_string()));
    }
    for pair in &arguments.overrides {
        let (key, value) = pair.split_once('=').ok_or_else(|| {
            Failure::Input(format!(
                "--set {pair}: expected KEY=VALUE, such as coupling.e_rel=1e-6"
            ))
        })?;
        overrides.push((key.trim().to_owned(), value.trim().to_owned()));
    }
    Case::load(&arguments.case, arguments.preset, &overrides)
        .map_err(|e| Failure::Input(e.to_string()))
}

/// Set by Ctrl-C, SIGTERM and SIGHUP; a second one ends the process at once (OpenFOAM then ends by itself).
fn interrupt_flag() -> std::io::Result<Arc<AtomicBool>> {
    let flag = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::flag::register_conditional_shutdown(signal, 130, flag.clone())?;
        signal_hook::flag::register(signal, flag.clone())?;
    }
    Ok(flag)
}

fn assemble(
    case: &Case,
    folder: &RunFolder,
    interrupt: Arc<AtomicBool>,
    arguments: &Arguments,
) -> Result<Run, Failure> {
    let vessel = Vessel::new(case);
    let mesh = vessel.fluid_mesh(&case.fluid.mesh);
    let solid = structure(case, &vessel).map_err(run_failure)?;
    mesh.write(&folder.openfoam()).map_err(written)?;
    CaseFiles {
        templates: &case.fluid.templates,
        blood: &case.blood,
        inflow: &case.inflow,
        windkessel: &case.windkessel,
        ramp: &case.ramp,
        time: &case.time,
        ranks: case.fluid.ranks,
    }
    .write(&folder.openfoam())
    .map_err(run_failure)?;
    let fluid = OpenFoam::start(OpenFoamSettings {
        case: folder.openfoam(),
        log: folder.openfoam_log(),
        ranks: case.fluid.ranks,
        transport: case.fluid.transport,
        answer_limit: Duration::from_secs_f64(case.fluid.answer_limit),
        terms: Terms {
            start_time: 0.0,
            time_step: case.time.step,
            interface: None,
        },
        interrupt,
    })
    .map_err(run_failure)?;
    let transfer = Transfer::new(fluid.interface(), &solid).map_err(run_failure)?;
    let volumes = mesh.cell_volumes();
    let rigid = volumes.len() / case.fluid.mesh.slices() * case.fluid.mesh.axial_extension;
    let record = Record::create(&RecordSettings {
        history: &folder.history(),
        iterations: &folder.iterations(),
        structure: &folder.structure(),
        case: &arguments.case,
        time_step: case.time.step,
        // Cells are numbered cross-section by cross-section, those of the extension first.
        rigid_volume: volumes[..rigid].iter().sum(),
        volume: volumes.iter().sum(),
        fluid_cells: volumes.len(),
        structure_dofs: solid.body().degrees_of_freedom(),
    })
    .map_err(written)?;
    let probes = probes(case, folder, &solid)?;
    // As many pieces per element and direction as the degree, so that its curves can be seen.
    let sampler = Sampler::new(solid.body(), case.structure.p + 1).map_err(run_failure)?;
    let rest = flatten(&vec![Vec3::zeros(); fluid.interface().points.len()]);
    let coupling = Coupling {
        fluid,
        solid,
        transfer,
        acceleration: acceleration(&case.coupling),
        predictor: Predictor::new(case.coupling.predictor, rest),
        criterion: Criterion {
            relative: case.coupling.e_rel,
            absolute: case.coupling.e_abs,
            max_iterations: case.coupling.max_iterations,
        },
        settings: Settings {
            time_step: case.time.step,
            fluid_effort: FluidEffort {
                max_correctors: case.fluid.max_correctors,
                pressure_residual: case.fluid.pressure_residual,
            },
            newton_tolerance: case.structure.newton_tolerance,
        },
    };
    Ok(Run {
        coupling,
        sampler,
        record,
        probes,
        cells: volumes.len(),
        fluid_peak_memory: 0.0,
    })
}

/// The points whose motion is asked for; no file without them.
fn probes(
    case: &Case,
    folder: &RunFolder,
    solid: &Structure,
) -> Result<Option<Probes<Structure>>, Failure> {
    let points: Vec<Vec3> = case.output.probes.iter().map(|&x| x.into()).collect();
    if points.is_empty() {
        return Ok(None);
    }
    let table = Table::create(&folder.probes()).map_err(written)?;
    let probes = Probes::new(points, solid, table)
        .map_err(|e| Failure::Run(format!("output.probes_m: {e}")))?;
    Ok(Some(probes))
}

/// The wall of a vessel: clamped at both ends, loaded from the inside.
fn structure(case: &Case, vessel: &Vessel) -> Result<Structure, SolidError> {
    let settings = &case.structure;
    let mut discretization =
        discretization::Options::new(Space::isotropic(SpaceKind::Trunk, settings.p));
    if let Some(degree) = settings.p_geometry {
        discretization.mapping = MappingKind::Blended(degree);
    }
    if let Some(points) = settings.quadrature_points {
        discretization.quadrature_points = [points; 3];
    }
    let materials = [&case.wall.graft, &case.wall.media, &case.wall.adventitia].map(Clone::clone);
    let options = StructureOptions {
        discretization,
        density: case.wall.density,
        damping: case.wall.damping,
        time_scheme: settings.time_scheme,
        newton: NewtonOptions {
            max_iterations: settings.newton_max_iterations,
            ..NewtonOptions::default()
        },
        wet_surface: "inner".into(),
        supports: vec![
            Support::Clamped("start".into()),
            Support::Clamped("end".into()),
        ],
    };
    Structure::new(&vessel.solid_mesh(settings), &materials, &options)
}

fn acceleration(settings: &case::Coupling) -> Box<dyn Acceleration> {
    let numerics = acceleration::Settings {
        relaxation: settings.relaxation,
        reuse: settings.reuse_steps,
        filter: Filter {
            dependence: settings.filter,
            // What is smaller than the accepted error is noise of the solvers, not a column.
            resolution: settings.e_rel,
        },
        max_columns: 200,
    };
    settings.acceleration.build(&numerics, Box::new(Identity))
}

/// Takes the steps one by one; ends early at an interrupt or a failure.
fn advance(
    run: &mut Run,
    case: &Case,
    steps: usize,
    interrupt: &AtomicBool,
    quiet: bool,
) -> Result<(), Failure> {
    let mut progress = Progress::new(steps as u64, quiet);
    for step in 1..=steps {
        if interrupt.load(Ordering::Relaxed) {
            return Err(Failure::Interrupted(String::new()));
        }
        let clock = Instant::now();
        let due = |interval: f64| step == steps || is_due(step, case.time.step, interval);
        let mut wall = None;
        let mut moved = Vec::new();
        let sampler = due(case.output.structure_interval).then_some(&run.sampler);
        let outcome = run
            .coupling
            .step(due(case.output.fluid_interval), |solid, trial| {
                wall = Some(inspect(solid, trial, sampler));
                if let Some(probes) = &run.probes {
                    moved = probes.displacement(solid, trial);
                }
            });
        let accepted = outcome.map_err(|e| match e {
            CouplingError::Fluid(FluidError::Interrupted) => Failure::Interrupted(String::new()),
            e => Failure::Run(format!(
                "step {step} (t = {:.6} s): {e}",
                step as f64 * case.time.step
            )),
        })?;
        let (von_mises, samples) = wall
            .expect("an accepted step has been inspected")
            .map_err(run_failure)?;
        if let Some(samples) = samples {
            run.record
                .structure
                .add(accepted.fluid.time, &grid(&run.sampler, &samples))
                .map_err(written)?;
        }
        if let Some(probes) = &mut run.probes {
            probes
                .append(accepted.fluid.time, &moved)
                .map_err(written)?;
        }
        let displacement = accepted
            .displacement
            .iter()
            .map(|d| d.norm())
            .fold(0.0, f64::max);
        let peaks = WallPeaks {
            displacement,
            von_mises,
        };
        let row = run
            .record
            .step(&accepted, peaks, clock.elapsed().as_secs_f64())
            .map_err(written)?;
        let memory = peak_memory(&run.coupling.fluid.process_id().to_string());
        run.fluid_peak_memory = run.fluid_peak_memory.max(memory.unwrap_or(0.0));
        progress.step(
            row.time_s,
            row.coupling_iterations,
            row.residual,
            row.wall_s,
        );
    }
    progress.finish();
    Ok(())
}

/// Largest von Mises stress (Pa) of an accepted trial, and its fields if they are wanted.
fn inspect(
    solid: &Structure,
    trial: &Trial,
    sampler: Option<&Sampler>,
) -> Result<(f64, Option<Samples>), SolidError> {
    let (von_mises, _) = solid.max_von_mises(trial)?;
    let samples = sampler
        .map(|s| s.sample(solid.body(), &trial.state.d))
        .transpose()?;
    Ok((von_mises, samples))
}

fn grid<'a>(sampler: &'a Sampler, samples: &'a Samples) -> Grid<'a> {
    Grid {
        points: &sampler.points,
        hexes: &sampler.hexes,
        point_data: vec![
            ("displacement_m", Values::Vectors(&samples.displacement)),
            ("von_mises_Pa", Values::Scalars(&samples.von_mises)),
        ],
        cell_data: vec![
            ("material", Values::Integers(&sampler.regions)),
            ("element", Values::Integers(&sampler.element_of_hex)),
        ],
    }
}

/// Whether the end of `step` is a multiple of `interval`, or the first step end after one.
fn is_due(step: usize, time_step: f64, interval: f64) -> bool {
    let passed = |step: usize| (step as f64 * time_step / interval * (1.0 + 1e-9)).floor();
    passed(step) > passed(step - 1)
}

/// Ends OpenFOAM, writes the summary, and names the files.
fn conclude(
    run: Run,
    outcome: Result<(), Failure>,
    folder: &RunFolder,
    quiet: bool,
) -> Result<(), Failure> {
    let Run {
        coupling,
        record,
        fluid_peak_memory,
        ..
    } = run;
    drop(coupling); // ends OpenFOAM

    let (status, reason) = match &outcome {
        Ok(()) => ("complete", None),
        Err(failure @ Failure::Interrupted(_)) => ("interrupted", Some(failure.to_string())),
        Err(failure) => ("failed", Some(failure.to_string())),
    };
    let summary = record
        .finish(&folder.summary(), status, reason, fluid_peak_memory)
        .map_err(written)?;
    match outcome {
        Ok(()) => {
            if !quiet {
                print!("{}", farewell(&summary, folder));
            }
            Ok(())
        }
        Err(Failure::Interrupted(_)) => Err(Failure::Interrupted(format!(
            "{} steps (t = {:.4} s) are in {}",
            summary.steps,
            summary.time_s,
            folder.root().display()
        ))),
        Err(failure) => Err(failure),
    }
}

fn farewell(summary: &Summary, folder: &RunFolder) -> String {
    let shown = |path: PathBuf| path.display().to_string();
    format!(
        "{} steps to t = {:.4} s in {}: {:.2} coupling iterations a step (at most {}), outlet pressure {:.0} Pa\n\
         \n\
         {:<44} a row a time step: flow, pressure, volume, displacement, stress\n\
         {:<44} a row a coupling iteration\n\
         {:<44} the run in figures\n\
         {:<44} the wall over time: open it in ParaView\n\
         {:<44} the blood over time: open it in ParaView\n\
         {:<44} every value that was used\n",
        summary.steps,
        summary.time_s,
        human(summary.wall_s),
        summary.mean_coupling_iterations,
        summary.max_coupling_iterations,
        summary.p_out_Pa,
        shown(folder.history()),
        shown(folder.iterations()),
        shown(folder.summary()),
        shown(folder.structure()),
        shown(folder.openfoam().join("fluid.foam")),
        shown(folder.resolved_case()),
    )
}

fn run_failure(error: impl std::fmt::Display) -> Failure {
    Failure::Run(error.to_string())
}

fn written(error: std::io::Error) -> Failure {
    Failure::Run(format!("cannot write the results: {error}"))
}

#[cfg(test)]
mod tests {
    use super::is_due;

    #[test]
    fn output_is_due_once_per_interval_despite_rounding() {
        let due = |interval: f64| (1..=1500).filter(|&n| is_due(n, 0.002, interval)).count();
        assert_eq!(
            (due(0.002), due(0.02), due(0.1), due(0.003)),
            (1500, 150, 30, 1000)
        );
    }
}
