//! Which models a study has, and how far each has come.

use crate::case::ResolvedCase;
use crate::output::results::read_case;
use crate::output::run_files::RunFiles;
use crate::output::write_atomically;
use crate::run::status::RunStatus;
use crate::run::{CaseSelection, Failure};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

/// A model of the study.
#[derive(Debug)]
pub struct BatchRun {
    /// Which of all models of the study it is, from 0.
    pub number: usize,
    /// Name of its folder.
    pub name: String,
    /// Folder of the case.
    pub folder: PathBuf,
    /// Folder of the run.
    pub out: PathBuf,
    /// The case.
    pub case: ResolvedCase,
    /// What replaces values of its files.
    pub selection: CaseSelection,
    /// How far its run has come.
    pub status: RunStatus,
}

/// What became of a model so far.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// Its turn has not come.
    Waiting,
    /// It is running.
    Working,
    /// It has come to its last step.
    Done,
    /// It was asked to end, and can be resumed.
    Interrupted,
    /// It cannot go on, for this reason.
    Failed(String),
}

impl BatchRun {
    /// The model of the case in `folder`, which runs in the folder `out`.
    ///
    /// # Errors
    /// All mistakes in the case.
    pub fn of(
        name: String,
        folder: PathBuf,
        out: PathBuf,
        chosen: &CaseSelection,
    ) -> Result<Self, Failure> {
        let case = chosen.load(&folder)?;
        Ok(Self {
            number: 0,
            status: RunStatus::of(&out, &case),
            selection: chosen.clone(),
            name,
            folder,
            out,
            case,
        })
    }

    /// What is to be done with it at the start.
    pub fn outcome(&self) -> Outcome {
        match self.status {
            RunStatus::Complete => Outcome::Done,
            _ => Outcome::Waiting,
        }
    }

    /// File of what its run says.
    pub fn log(&self) -> PathBuf {
        self.out.with_file_name(format!("{}.log", self.name))
    }
}

/// A sample whose case cannot be run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImpossibleSample {
    /// Which of all models of the study it is, from 0.
    pub number: usize,
    /// Name that its folder would have.
    pub name: String,
    /// What is wrong with it.
    pub reason: String,
}

/// What a study is made of.
#[derive(Debug)]
pub struct StudyModels {
    /// Those that can be run.
    pub models: Vec<BatchRun>,
    /// The others.
    pub impossible: Vec<ImpossibleSample>,
}

/// The models in the folder `cases` whose names fit one of the patterns, by name, or the one case that the folder is;
/// each in all variants, which add something to its name. All cases must be right, or of samples some.
pub fn find(
    cases: &Path,
    patterns: &str,
    variants: &[(String, CaseSelection)],
    are_samples: bool,
    out: &Path,
) -> Result<StudyModels, Failure> {
    if cases.is_file() || cases.join("case.toml").is_file() {
        let folder = cases.canonicalize().unwrap_or_else(|_| cases.to_owned());
        let name = match cases.is_file() {
            true => folder.file_stem(),
            false => folder.file_name(),
        };
        let name = name.map(|name| name.to_string_lossy().into_owned());
        return every(
            vec![(name.unwrap_or_default(), folder)],
            variants,
            are_samples,
            out,
        );
    }
    let entries = std::fs::read_dir(cases)
        .map_err(|e| Failure::Input(format!("cannot read the folder {}: {e}", cases.display())))?;
    let folders = entries.flatten().map(|entry| entry.path());
    let mut folders: Vec<(String, PathBuf)> = folders
        .filter(|folder| folder.join("case.toml").is_file())
        .filter_map(|folder| Some((folder.file_name()?.to_str()?.to_owned(), folder)))
        .collect();
    folders.sort();
    let fits = |name: &str| patterns.split(',').any(|p| matches(p.trim(), name));
    let (models, others): (Vec<_>, Vec<_>) = folders.into_iter().partition(|(name, _)| fits(name));
    if models.is_empty() {
        let others: Vec<String> = others.into_iter().map(|(name, _)| name).collect();
        return Err(Failure::Input(format!(
            "no model in {} is called {patterns}; there are: {}",
            cases.display(),
            if others.is_empty() {
                "none".into()
            } else {
                others.join(", ")
            }
        )));
    }
    every(models, variants, are_samples, out)
}

/// Each model in all variants.
fn every(
    models: Vec<(String, PathBuf)>,
    variants: &[(String, CaseSelection)],
    are_samples: bool,
    out: &Path,
) -> Result<StudyModels, Failure> {
    let pairs: Vec<_> = (models.iter())
        .flat_map(|model| variants.iter().map(move |variant| (model, variant)))
        .collect();
    let checked: Vec<_> = (pairs.par_iter().enumerate())
        .map(|(number, ((name, folder), (more, chosen)))| {
            let name = format!("{name}{more}");
            match BatchRun::of(name.clone(), folder.clone(), out.join(&name), chosen) {
                Ok(run) => Ok(BatchRun { number, ..run }),
                Err(failure) => Err(ImpossibleSample {
                    number,
                    name,
                    reason: failure.to_string(),
                }),
            }
        })
        .collect();
    let (models, impossible): (Vec<_>, Vec<_>) = checked.into_iter().partition(Result::is_ok);
    let found = StudyModels {
        models: models.into_iter().filter_map(Result::ok).collect(),
        impossible: impossible.into_iter().filter_map(Result::err).collect(),
    };
    if found.impossible.is_empty() || are_samples && !found.models.is_empty() {
        return Ok(found);
    }
    // What is wrong with all variants alike is said once.
    let mut wrong: Vec<String> = Vec::new();
    for model in &found.impossible {
        let folder = &pairs[model.number].0.1;
        let told = format!("{}: {}", folder.display(), model.reason);
        for line in told.lines() {
            if !wrong.iter().any(|said| said == line) {
                wrong.push(line.to_owned());
            }
        }
    }
    Err(Failure::Input(wrong.join("\n")))
}

/// Refuses a folder with runs in it.
pub fn refuse_earlier(models: &[BatchRun]) -> Result<(), Failure> {
    match models.iter().find(|model| model.out.exists()) {
        Some(model) => Err(Failure::Input(format!(
            "{} exists already; continue the study with --resume, or choose another folder with --out",
            model.out.display()
        ))),
        None => Ok(()),
    }
}

/// Refuses to go on with runs that are farther than they should come.
pub fn refuse_farther(models: &[BatchRun]) -> Result<(), Failure> {
    let farther = models.iter().filter_map(|model| match &model.status {
        RunStatus::Beyond(reason) => Some(format!("{}: {reason}", model.name)),
        _ => None,
    });
    match farther.collect::<Vec<_>>() {
        farther if farther.is_empty() => Ok(()),
        farther => Err(Failure::Input(farther.join("\n"))),
    }
}

/// Moves the runs of changed cases aside, and says so; those that are done learn which measures their cases now ask
/// for.
pub fn prepare(models: &mut [BatchRun]) -> Result<Vec<String>, Failure> {
    let mut notes = Vec::new();
    for model in models {
        if model.status == RunStatus::Complete {
            let files = RunFiles::new(&model.out);
            if read_case(&files).is_ok_and(|case| case.measures() != model.case.measures()) {
                let text = model.case.to_toml_string();
                write_atomically(&files.resolved_case(), text.as_bytes())
                    .map_err(|e| Failure::Run(format!("cannot write {e}")))?;
            }
        }
        let RunStatus::Changed(_) = model.status else {
            continue;
        };
        let aside = (1..)
            .map(|n| {
                model
                    .out
                    .with_file_name(format!("{}.before-{n}", model.name))
            })
            .find(|path| !path.exists())
            .expect("there are endless numbers");
        std::fs::rename(&model.out, &aside)
            .map_err(|e| Failure::Input(format!("cannot rename {}: {e}", model.out.display())))?;
        notes.push(format!(
            "{}: its case has changed, so it starts again; the earlier results are in {}",
            model.name,
            aside.display()
        ));
        model.status = RunStatus::Absent;
    }
    Ok(notes)
}

/// Whether a name fits a pattern with `*` (anything), `?` (a letter) and `[…]` (one of these letters).
fn matches(pattern: &str, name: &str) -> bool {
    let mut letters = name.chars();
    let Some(first) = pattern.chars().next() else {
        return name.is_empty();
    };
    let rest = &pattern[first.len_utf8()..];
    match first {
        '*' => {
            let ends = name.char_indices().map(|(i, _)| i).chain([name.len()]);
            ends.into_iter().any(|i| matches(rest, &name[i..]))
        }
        '[' if rest.contains(']') => {
            let (set, rest) = rest.split_once(']').expect("it is there");
            letters.next().is_some_and(|letter| set.contains(letter))
                && matches(rest, letters.as_str())
        }
        _ => {
            let fits = |letter: char| first == '?' || letter == first;
            letters.next().is_some_and(fits) && matches(rest, letters.as_str())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::matches;

    #[test]
    fn patterns_choose_models_as_a_shell_does() {
        let all = ["A-0.0", "H-0.25", "H-0.5", "S-0.75", "elastic-tube"];
        let chosen = |pattern: &str| -> Vec<&str> {
            all.into_iter()
                .filter(|name| matches(pattern, name))
                .collect()
        };
        assert_eq!(chosen("[SHA]-*"), ["A-0.0", "H-0.25", "H-0.5", "S-0.75"]);
        assert_eq!(chosen("H-*"), ["H-0.25", "H-0.5"]);
        assert_eq!(chosen("?-0.?"), ["A-0.0", "H-0.5"]);
        assert_eq!(chosen("*5"), ["H-0.25", "H-0.5", "S-0.75"]);
        assert_eq!(chosen("S-0.7"), Vec::<&str>::new());
        assert_eq!(chosen("[S"), Vec::<&str>::new());
    }
}
