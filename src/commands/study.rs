//! `fsi-driver study`: many models, each a run of its own, several at once.

mod evaluation;

use super::{CaseArguments, Failure};
use crate::case::{Unread, ValuePlace};
use crate::output::report::{ExportForm, SAMPLES};
use crate::output::results::Results;
use crate::output::terminal;
use crate::run::batch::{
    self, BatchRun, Board, ImpossibleSample, Outcome, Samples, StudyModels, Variation, Worker,
};
use crate::run::{CaseSelection, Interrupt};
use crate::simulation::assembly::surroundings;
use crate::uncertainty::Design;
use std::path::{Path, PathBuf};

/// Cases that are checked without a word.
const MOST_SILENT: usize = 16;

/// Options of the study.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder with the folders of the models, or one case (its folder, or its file).
    #[arg(long, value_name = "DIR", default_value = "openfoam-case")]
    cases: PathBuf,
    /// Names of the models, with * for anything, ? for any letter and [ab] for one of them; several with commas. One
    /// case needs none.
    #[arg(long, value_name = "PATTERN", default_value = "[SHA]-*")]
    models: String,
    /// Runs each model with each of these values, such as 'vessel.material[media].k1_Pa=500,1000' or '…=*0.8,*1.2' of
    /// what the case has; 'KEY+KEY=…' changes keys together, to one value or to 'VALUE:VALUE'. Given several times,
    /// with all combinations.
    #[arg(long = "sweep", value_name = "KEY=VALUE,VALUE…")]
    sweeps: Vec<String>,
    /// Runs each model as it is, and with each value of each --sweep alone, not in all combinations.
    #[arg(long, requires = "sweeps")]
    one_at_a_time: bool,
    /// Runs each model with each row of a table, whose first line has keys as --sweep does, and perhaps `name`; or one
    /// case at samples of its [[uncertain]] inputs: N of Sobol's sequence (sobol:N) or of a Latin hypercube (lhs:N), or
    /// as many as a polynomial of degree D asks for (pce:D).
    #[arg(
        long,
        value_name = "FILE.csv|sobol:N|lhs:N|pce:D",
        conflicts_with = "sweeps"
    )]
    samples: Option<PathBuf>,
    /// Adds N samples to a study of [[uncertain]] inputs in the same folder: those that it has are kept.
    #[arg(long, value_name = "N", conflicts_with_all = ["sweeps", "samples"], value_parser = clap::value_parser!(u32).range(1..))]
    extend: Option<u32>,
    /// Writes the samples and what they gave for other programs too: salib.json for SALib, easyvvuq/ for EasyVVUQ. With
    /// --resume of a study that is done, nothing is computed.
    #[arg(long, value_name = "FORM", value_delimiter = ',')]
    export: Vec<ExportForm>,
    /// Folder of a study of the same inputs in cheaper runs, which has these samples and more: writes control.csv, the
    /// means with the cheaper runs as control variates.
    #[arg(long, value_name = "STUDY", conflicts_with = "part")]
    control: Option<PathBuf>,
    /// What refining one thing says of the numerical uncertainty: runs of the case with its inputs at their means, the
    /// first as it is sampled, later ones finer, each by the same factor. Once for each thing. Writes
    /// total-uncertainty.csv, with numerical uncertainties and those by the inputs side by side (ASME V&V 20).
    #[arg(long, value_name = "NAME=RUN,RUN…", conflicts_with = "part")]
    refined: Vec<String>,
    /// With --refined: what a measure is in an experiment, and its standard uncertainty, such as
    /// 'inlet pressure, highest=120,2' in the unit of moments.csv.
    #[arg(long, value_name = "MEASURE=VALUE,UNCERTAINTY", requires = "refined")]
    measured: Vec<String>,
    /// Runs only every Nth model, from the Kth on: the parts of a study can work on different machines in one folder.
    #[arg(long, value_name = "K/N", value_parser = Part::parse)]
    part: Option<Part>,
    /// Models at once [default: as many as fit into the cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Folder of the results, a folder for each model [default: <cases>/study-<preset>].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Continue an earlier study in the same folder: finished models are kept, others continue from their newest
    /// checkpoint, those whose case has changed start again next to their earlier results.
    #[arg(long)]
    resume: bool,
    /// Show no progress.
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    case: CaseArguments,
}

/// Every `of`th model, from this one on, counted from 0.
#[derive(Debug, Clone, Copy)]
struct Part {
    first: usize,
    of: usize,
}

impl Part {
    fn parse(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/');
        let numbers = numbers.and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match numbers {
            Some((k, n)) if (1..=n).contains(&k) => Ok(Self {
                first: k - 1,
                of: n,
            }),
            _ => Err("expected K/N with K from 1 to N, such as 1/8".to_owned()),
        }
    }

    /// Keeps its models.
    fn keep(self, study: &mut StudyModels) -> Result<(), Failure> {
        let is_in = |number: usize| number % self.of == self.first;
        study.models.retain(|model| is_in(model.number));
        study.impossible.retain(|sample| is_in(sample.number));
        match study.models.is_empty() {
            true => Err(Failure::Input(format!(
                "--part {}/{}: the study has fewer models: nothing is left for this part",
                self.first + 1,
                self.of
            ))),
            false => Ok(()),
        }
    }
}

/// Runs all models that are not done yet.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let out = arguments.out.clone().unwrap_or_else(|| {
        let folder = format!("study-{}", arguments.case.preset);
        match arguments.cases.is_file() {
            true => arguments.cases.with_extension("").join(folder),
            false => arguments.cases.join(folder),
        }
    });
    let selection = arguments.case.selection()?;
    let samples = samples(arguments, &out, &selection)?;
    refuse_without_samples(arguments, samples.is_some())?;
    let StudyModels {
        mut models,
        impossible,
    } = models(arguments, &out, &selection, samples.as_ref())?;
    let inputs = |number: usize| match &samples {
        Some(samples) => format!(" ({})", samples.told(number)),
        None => String::new(),
    };
    let told = |sample: &ImpossibleSample| {
        let reason = sample.reason.trim_start_matches("error: ");
        format!("{}{}: {reason}", sample.name, inputs(sample.number))
    };
    let impossible: Vec<String> = impossible.iter().map(told).collect();
    let all = models.len() + impossible.len();
    if !impossible.is_empty() {
        terminal::note(format_args!(
            "warning: {} of {all} samples cannot be run, and count as failed\n{}",
            impossible.len(),
            impossible.join("\n")
        ));
    }
    admit(arguments, &models)?;
    std::fs::create_dir_all(&out)
        .map_err(|e| Failure::Input(format!("cannot create {}: {e}", out.display())))?;
    if let Some(samples) = &samples {
        samples.keep(&out)?;
    }
    let outcomes = work(arguments, &mut models)?;
    let runs: Vec<Results> = (models.iter().zip(&outcomes))
        .filter(|(_, outcome)| **outcome == Outcome::Done)
        .filter_map(|(model, _)| Results::load(&model.out).ok())
        .collect();
    if arguments.part.is_none() {
        evaluation::write(arguments, &runs, &out, samples.is_some().then_some(all))?;
    }
    conclude(&models, &outcomes, impossible, &out, &runs, &inputs)
}

/// The models that the arguments ask for.
fn models(
    arguments: &Arguments,
    out: &Path,
    selection: &CaseSelection,
    samples: Option<&Samples>,
) -> Result<StudyModels, Failure> {
    let variants = match samples {
        Some(samples) => samples.variants(selection),
        None => {
            let variation = Variation {
                sweeps: &arguments.sweeps,
                one_at_a_time: arguments.one_at_a_time,
                samples: arguments.samples.as_deref(),
            };
            variation.variants(selection)?
        }
    };
    if variants.len() > MOST_SILENT && !arguments.quiet {
        terminal::note(format_args!("checking {} cases", variants.len()));
    }
    let (cases, are_samples) = (&arguments.cases, samples.is_some());
    let mut study = batch::find(cases, &arguments.models, &variants, are_samples, out)?;
    refuse_unread(&study.models)?;
    if let Some(part) = arguments.part {
        part.keep(&mut study)?;
    }
    Ok(study)
}

/// Refuses models for which something is missing here, or that are there already.
fn admit(arguments: &Arguments, models: &[BatchRun]) -> Result<(), Failure> {
    for model in models {
        surroundings::check_installed(&model.case)
            .and_then(|()| surroundings::check_folder(&model.case, &model.out))
            .map_err(|e| Failure::Input(e.to_string()))?;
    }
    match arguments.resume || arguments.extend.is_some() {
        true => batch::refuse_farther(models),
        false => batch::refuse_earlier(models),
    }
}

/// Runs the models, several at once; returns what became of each.
fn work(arguments: &Arguments, models: &mut [BatchRun]) -> Result<Vec<Outcome>, Failure> {
    let ranks = models.iter().map(|m| m.case.fluid.ranks).max().unwrap_or(1);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let jobs = arguments.jobs.map_or(cores.div_ceil(ranks), usize::from);
    let jobs = jobs.min(models.len());
    let then = "the models that have begun finish their time step and write a checkpoint";
    let interrupt = Interrupt::listen((!arguments.quiet).then_some(then))?;
    let notes = batch::prepare(models)?;
    let board = Board::new(models, jobs, arguments.quiet);
    notes.iter().for_each(|note| board.note(note));
    let threads = (cores / jobs).max(1);
    Ok(batch::work(models, &interrupt, board, jobs, |model| {
        Worker::start(model, &model.selection, threads)
    }))
}

/// Refuses options that need samples of uncertain inputs, or all of them.
fn refuse_without_samples(arguments: &Arguments, has_samples: bool) -> Result<(), Failure> {
    if arguments.part.is_some() && !arguments.export.is_empty() {
        return Err(Failure::Input(
            "--export: a part of a study has no measures: leave out --part once all parts are done"
                .to_owned(),
        ));
    }
    if let Some(cheap) = &arguments.control
        && !(has_samples && cheap.join(SAMPLES).is_file())
    {
        return Err(Failure::Input(format!(
            "--control {}: both must be studies of [[uncertain]] inputs, and that folder holds no {SAMPLES}, or this study has \
             no --samples",
            cheap.display()
        )));
    }
    if !has_samples && !arguments.refined.is_empty() {
        return Err(Failure::Input(
            "--refined: only a study of [[uncertain]] inputs has uncertainties to compare with: add --samples, or --resume for \
             one that is there"
                .to_owned(),
        ));
    }
    if !has_samples && !arguments.export.is_empty() {
        return Err(Failure::Input(
            "--export: only a study of [[uncertain]] inputs can be exported: add --samples, or --resume for one that is there"
                .to_owned(),
        ));
    }
    Ok(())
}

/// The samples of uncertain inputs that are asked for, or that an earlier study in the folder has.
fn samples(
    arguments: &Arguments,
    out: &Path,
    selection: &CaseSelection,
) -> Result<Option<Samples>, Failure> {
    let given = arguments.samples.as_deref().and_then(Path::to_str);
    let design = match given.filter(|text| Design::is_meant(text)) {
        Some(text) => Some(
            text.parse()
                .map_err(|e| Failure::Input(format!("--samples {e}")))?,
        ),
        None if arguments.extend.is_some() || arguments.resume && given.is_none() => {
            Samples::design_in(out)?.filter(|_| arguments.sweeps.is_empty())
        }
        None => None,
    };
    let design: Option<Design> = match (design, arguments.extend) {
        (Some(design), Some(more)) => Some(design.extended(more as usize)),
        (None, Some(_)) => {
            return Err(Failure::Input(format!(
                "--extend: {} holds no {SAMPLES}, the samples of a study: begin it with --samples, or name its folder with \
                 --out",
                out.display()
            )));
        }
        (design, None) => design,
    };
    let Some(design) = design else {
        return Ok(None);
    };
    let path = &arguments.cases;
    if !path.is_file() && !path.join("case.toml").is_file() {
        return Err(Failure::Input(format!(
            "--samples {design}: samples are of one case, and {} is not the folder of one (it holds no case.toml): name one \
             with --cases",
            path.display()
        )));
    }
    Samples::new(&selection.load(path)?, path, design).map(Some)
}

/// Refuses a sweep over a key that does nothing in one of the models: its runs would all be the same.
fn refuse_unread(models: &[BatchRun]) -> Result<(), Failure> {
    for model in models {
        let is_swept =
            |unread: &&Unread| (unread.keys.iter()).any(|(_, place)| *place == ValuePlace::Sweep);
        if let Some(unread) = model.case.unread.iter().find(is_swept) {
            return Err(Failure::Input(format!(
                "{}: {unread}; its runs would all be the same",
                model.name
            )));
        }
    }
    Ok(())
}

/// Names of runs whose histories are the same though their cases are not, each with the first of its kind.
fn alike(runs: &[Results]) -> Vec<(String, String)> {
    let figures = |run: &Results| -> Vec<[u64; 4]> {
        let rows = run.history.iter();
        rows.map(|row| {
            [
                row.Q_out_m3_s,
                row.p_in_Pa,
                row.p_out_Pa,
                row.max_displacement_m,
            ]
            .map(f64::to_bits)
        })
        .collect()
    };
    let all: Vec<_> = runs.iter().map(figures).collect();
    let first = |i: usize| (0..i).find(|j| all[*j] == all[i] && runs[*j].case != runs[i].case);
    let pairs = (0..runs.len()).filter_map(|i| Some((first(i)?, i)));
    pairs
        .map(|(first, i)| (runs[first].name(), runs[i].name()))
        .collect()
}

/// Says what became of the models; `inputs` are the words for those of a sample, `impossible` samples that cannot be
/// run.
fn conclude(
    models: &[BatchRun],
    outcomes: &[Outcome],
    impossible: Vec<String>,
    out: &Path,
    runs: &[Results],
    inputs: &dyn Fn(usize) -> String,
) -> Result<(), Failure> {
    let cannot = impossible.len();
    let mut failed = impossible;
    failed.extend(
        (models.iter().zip(outcomes)).filter_map(|(model, outcome)| match outcome {
            Outcome::Failed(reason) => {
                Some(format!("{}{}: {reason}", model.name, inputs(model.number)))
            }
            _ => None,
        }),
    );
    let done = outcomes.iter().filter(|o| **o == Outcome::Done).count();
    for (name, other) in alike(runs) {
        terminal::note(format_args!(
            "warning: {other} has the history of {name} to the last digit: what differs in their cases does nothing"
        ));
    }
    let (all, shown) = (models.len() + cannot, out.display());
    let again = "--resume continues them";
    if done == all {
        return Ok(terminal::print(format_args!(
            "all {all} models are done: {shown}; fsi-driver report {shown} shows them\n"
        ))?);
    }
    if failed.is_empty() {
        return Err(Failure::Interrupted(format!(
            "{done} of {all} models are done in {shown}; {again}"
        )));
    }
    Err(Failure::Run(format!(
        "{} of {all} models failed in {shown}, {done} are done; {again}\n{}",
        failed.len(),
        failed.join("\n")
    )))
}
