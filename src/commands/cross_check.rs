//! `fsi-driver cross-check CASE…`: the same cases with both solvers for the blood, and how far they are from each
//! other.

use super::compare::CompareLimits;
use super::{CaseArguments, Failure};
use crate::analysis::size;
use crate::case::{Case, Native, Override, ValuePlace};
use crate::output::comparison::{Comparison, RunDifference};
use crate::output::refinement::{self, Refined};
use crate::output::report;
use crate::output::results::Results;
use crate::output::{terminal, write_atomically};
use crate::run::batch::{self, BatchRun, Board, Outcome, Worker};
use crate::run::{CaseSelection, Interrupt};
use crate::simulation::assembly::surroundings;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// The solvers, as `fluid.solver` names them; the first one is A of the comparison.
const SOLVERS: [&str; 2] = ["openfoam", "native"];
/// The same on finer meshes.
const FINER: [&str; 2] = ["openfoam-finer", "native-finer"];
/// The cells of OpenFOAM's finer mesh are shorter by this factor, as far as whole numbers allow; the native solver's
/// elements have a degree more.
const RATIO: f64 = 1.5;
/// The table of a comparison, in the folder of its case.
const TABLE: &str = "compare.csv";
/// The same on the finer meshes.
const FINER_TABLE: &str = "compare-finer.csv";
/// What refinement changes.
const REFINEMENT: &str = "refinement.csv";
/// The page about all cases.
const PAGE: &str = "cross-check.html";

/// Options of the cross-check.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folders of the cases, each with its case.toml.
    #[arg(value_name = "CASE", required = true)]
    cases: Vec<PathBuf>,
    /// Folder of the results: <case>/openfoam and <case>/native, their comparison, and a page [default:
    /// cross-check-<preset>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Run both solvers on finer meshes too (<case>/openfoam-finer, native-finer) and extrapolate.
    #[arg(long)]
    refine: bool,
    /// Runs at once [default: 1, with all cores].
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: u16,
    /// Continue an earlier cross-check in the same folder: finished runs are kept, others continue.
    #[arg(long)]
    resume: bool,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    limits: CompareLimits,
    #[command(flatten)]
    case: CaseArguments,
}

/// Runs what is not done yet and compares; exit code 1 if the solvers differ by more than is allowed.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let limits = arguments.limits.checked()?;
    let default = || PathBuf::from(format!("cross-check-{}", arguments.case.preset));
    let out = arguments.out.clone().unwrap_or_else(default);
    let selections = selections(arguments.case.selection()?)?;
    let names = names(&arguments.cases)?;
    let mut models = Vec::new();
    let mut selection_of = HashMap::new();
    for (name, folder) in names.iter().zip(&arguments.cases) {
        let mut add = |kind: &str, selection: CaseSelection| {
            let run = out.join(name).join(kind);
            let name = format!("{name}-{kind}");
            let model = BatchRun::of(name.clone(), folder.clone(), run, &selection)?;
            let finer = arguments.refine.then(|| finer(&model.case, &selection));
            models.push(model);
            selection_of.insert(name, selection);
            finer.transpose()
        };
        for ((solver, finer), selection) in SOLVERS.iter().zip(FINER).zip(&selections) {
            if let Some(selection) = add(solver, selection.clone())? {
                add(finer, selection)?;
            }
        }
    }
    for model in &models {
        surroundings::check_installed(&model.case)
            .and_then(|()| surroundings::check_folder(&model.case, &model.out))
            .map_err(|e| Failure::Input(e.to_string()))?;
    }
    if !arguments.resume {
        batch::refuse_earlier(&models)?;
    }
    for name in &names {
        let folder = out.join(name);
        std::fs::create_dir_all(&folder)
            .map_err(|e| Failure::Input(format!("cannot create {}: {e}", folder.display())))?;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = usize::from(arguments.jobs).min(models.len());
    let then = "the runs finish their time step and write a checkpoint";
    let interrupt = Interrupt::listen((!arguments.quiet).then_some(then))?;
    let notes = batch::prepare(&mut models)?;
    let board = Board::new(&models, jobs, arguments.quiet);
    notes.iter().for_each(|note| board.note(note));
    let outcomes = batch::work(&models, &interrupt, board, jobs, |model| {
        Worker::start(model, &selection_of[&model.name], (cores / jobs).max(1))
    });
    require_all(&models, &outcomes)?;
    compare(&names, &out, limits, arguments.refine)
}

/// What the user has chosen, with either solver.
fn selections(chosen: CaseSelection) -> Result<[CaseSelection; 2], Failure> {
    if chosen.given.iter().any(|given| given.key == "fluid.solver") {
        return Err(Failure::Input(
            "cross-check runs both solvers for the blood: leave out --fluid and fluid.solver"
                .into(),
        ));
    }
    Ok(SOLVERS.map(|solver| {
        let mut selection = chosen.clone();
        selection.given.push(Override {
            place: ValuePlace::Option("--fluid"),
            key: "fluid.solver".into(),
            value: solver.into(),
        });
        selection
    }))
}

/// A selection with a finer mesh of its solver.
fn finer(case: &Case, selection: &CaseSelection) -> Result<CaseSelection, Failure> {
    let Some(vessel) = case.vessel() else {
        let reason = "cross-check is for vessels, and the case has a flag in a channel";
        return Err(Failure::Input(reason.into()));
    };
    let Native { degree, .. } = vessel.fluid.native;
    let mesh = &vessel.fluid.mesh;
    let longer = |number: usize| (number as f64 * RATIO).round() as usize;
    let numbers = [
        ("fluid.native.degree", degree + 1),
        ("fluid.mesh.core", longer(mesh.core)),
        ("fluid.mesh.radial", longer(mesh.radial)),
        ("fluid.mesh.axial_extension", longer(mesh.axial_extension)),
        (
            "fluid.mesh.axial_per_section",
            longer(mesh.axial_per_section),
        ),
    ];
    let mut selection = selection.clone();
    for (key, number) in numbers {
        selection.given.retain(|given| given.key != key);
        selection.given.push(Override {
            place: ValuePlace::Set,
            key: key.into(),
            value: number.to_string(),
        });
    }
    Ok(selection)
}

/// Names of the cases' folders, each once.
fn names(cases: &[PathBuf]) -> Result<Vec<String>, Failure> {
    let mut names: Vec<String> = Vec::new();
    for case in cases {
        let there = case
            .canonicalize()
            .map_err(|e| Failure::Input(format!("cannot read {}: {e}", case.display())))?;
        let name = there.file_name().unwrap_or_default().to_string_lossy();
        if names.iter().any(|other| *other == name) {
            return Err(Failure::Input(format!(
                "two cases are called {name}: their results would share a folder; check them one after the other, with --out"
            )));
        }
        names.push(name.into_owned());
    }
    Ok(names)
}

/// Refuses to compare while a run is missing.
fn require_all(models: &[BatchRun], outcomes: &[Outcome]) -> Result<(), Failure> {
    let again = "--resume continues";
    let failed: Vec<String> = (models.iter().zip(outcomes))
        .filter_map(|(model, outcome)| match outcome {
            Outcome::Failed(reason) => Some(format!("{}: {reason}", model.name)),
            _ => None,
        })
        .collect();
    if !failed.is_empty() {
        return Err(Failure::Run(format!("{}\n{again}", failed.join("\n"))));
    }
    if outcomes.iter().any(|outcome| *outcome != Outcome::Done) {
        return Err(Failure::Interrupted(format!(
            "not all runs are done; {again}"
        )));
    }
    Ok(())
}

/// Compares the runs of each case and writes the page.
fn compare(names: &[String], out: &Path, limits: [f64; 3], refine: bool) -> Result<(), Failure> {
    let mut compared = Vec::new();
    let mut refined: Vec<(String, Vec<Refined>)> = Vec::new();
    let mut beyond = Vec::new();
    for name in names {
        let folder = out.join(name);
        let load = |solver: &str| {
            Results::load(&folder.join(solver)).map_err(|e| Failure::Run(e.to_string()))
        };
        let both = |solvers: [&str; 2]| {
            let [first, second] = [load(solvers[0])?, load(solvers[1])?];
            let cells = size::fluid_cells(&first.case);
            let comparison = Comparison::new(&first, &second, limits)
                .map_err(|e| Failure::Run(e.to_string()))?
                .called(["OpenFOAM", "native"]);
            Ok::<_, Failure>((comparison, cells as f64))
        };
        let (comparison, cells) = both(SOLVERS)?;
        if refine {
            let (finer, more) = both(FINER)?;
            let rows = refinement::refinement(&comparison, &finer, (more / cells).cbrt());
            refinement::write(&rows, &folder.join(REFINEMENT)).map_err(written)?;
            finer
                .write_table(&folder.join(FINER_TABLE))
                .map_err(written)?;
            refined.push((name.clone(), rows));
        }
        terminal::print(format_args!("{name}: A OpenFOAM, B native\n{comparison}"))?;
        comparison.write(&folder, TABLE).map_err(written)?;
        let differences = comparison.differences.iter();
        let names = differences
            .filter(|d| d.is_beyond())
            .map(RunDifference::name);
        beyond.extend(names.map(|what| format!("{name}: {what}")));
        compared.push((name.clone(), comparison));
    }
    let page = out.join(PAGE);
    write_atomically(
        &page,
        report::of_comparisons(&compared, &refined).as_bytes(),
    )
    .map_err(written)?;
    terminal::print(format_args!("{} shows them\n", page.display()))?;
    if beyond.is_empty() {
        return Ok(());
    }
    Err(Failure::Run(format!(
        "the solvers differ by more than is allowed in:\n{}",
        beyond.join("\n")
    )))
}

fn written(error: std::io::Error) -> Failure {
    Failure::Run(format!("cannot write the comparison: {error}"))
}
