//! `fsi-driver solid FILE.toml`: a tube under internal pressure, without a fluid.

use super::{Failure, results_folder};
use crate::analysis::motion::{Dynamics, TubeMotion};
use crate::analysis::solid_file::SolidFile;
use crate::analysis::tube::Tube;
use crate::case::RunEnds;
use crate::output::progress::Progress;
use crate::output::tables::CsvTable;
use crate::output::tube_results::{self, TubeSolution};
use crate::output::{terminal, write_atomically};
use crate::pfem::solution::stability::AtBifurcation;
use crate::pfem::solution::statics::StaticOptions;
use crate::pfem::{Discretization, SolidError};
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
        .unwrap_or_else(|| default_folder(&arguments.file));
    results_folder::claim(&out, MARK, arguments.force)?;
    let text = std::fs::read(&arguments.file).map_err(|e| input(&e))?;
    write_atomically(&out.join(MARK), &text).map_err(written)?;

    let solution = match &solid.dynamics {
        None => inflate(&solid, &tube, &body),
        Some(dynamics) => {
            let mut motion = TubeMotion::new(&tube, &solid.options, dynamics).map_err(failed)?;
            let history = CsvTable::create(&out.join("history.csv")).map_err(written)?;
            move_tube(&mut motion, dynamics, history, arguments.quiet)
        }
    }?;
    let seconds = clock.elapsed().as_secs_f64();
    let summary =
        tube_results::summarize(&solid, &tube, &body, &solution, seconds).map_err(failed)?;
    if !solution.steps.is_empty() {
        let curve = tube_results::curve(&solid, &tube, &body, &solution).map_err(written)?;
        write_atomically(&out.join("curve.csv"), &curve).map_err(written)?;
    }
    tube_results::write(&out, &body, &solution, &summary).map_err(written)?;
    terminal::print(tube_results::in_words(&summary, &out))?;
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

/// The folder `name-results` next to `name.toml`.
fn default_folder(file: &Path) -> PathBuf {
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

fn inflate(solid: &SolidFile, tube: &Tube, body: &Discretization) -> Result<TubeSolution, Failure> {
    let statics = StaticOptions {
        steps: solid.steps,
        at_bifurcation: solid.at_bifurcation,
        ..Default::default()
    };
    let found = tube
        .inflate(body, &solid.options, &statics, None)
        .map_err(failed)?;
    Ok(TubeSolution {
        unloaded: found.unloaded,
        displacement: found.displacement,
        factor: found.factor,
        bifurcation: found.bifurcation,
        steps: found.steps,
        stats: found.stats,
    })
}

fn move_tube(
    motion: &mut TubeMotion,
    dynamics: &Dynamics,
    mut history: CsvTable,
    quiet: bool,
) -> Result<TubeSolution, Failure> {
    let mut progress = Progress::new(RunEnds::last_only(dynamics.steps), quiet);
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
    Ok(TubeSolution {
        unloaded: Vec::new(),
        displacement: motion.structure().state().d.clone(),
        factor: dynamics.factor(dynamics.steps as f64 * dynamics.step),
        bifurcation: None,
        steps: Vec::new(),
        stats: motion.structure().stats(),
    })
}
