//! `fsi-driver tables PAGE…`: the tables of a page of Markdown, made again from stored runs.

use super::{Failure, report};
use crate::output::figure::Figure;
use crate::output::marked_text;
use crate::output::report::{
    PageTable, RefinedPair, RefinementSeries, agreement, changes, coupling, distributions,
    key_figures, uncertainty,
};
use crate::output::results::Results;
use crate::output::validation::Validation;
use crate::output::{terminal, write_atomically};
use crate::paper;
use std::path::{Path, PathBuf};

/// What a mark may ask for.
const KINDS: &str = "expected `models STUDY` (a column for each run in a folder), `findings STUDY` (what the paper found, and what the \
                     study), `differences STUDY STUDY` (runs of the same name), `changes RUN STUDY` (each run against one), \
                     `coupling RUN…` (sizes and coupling iterations), \
                     `agreement COARSE FINE COARSE FINE` (studies with one solver, then with the other; and `first:BEFORE,AFTER` or `second:BEFORE,AFTER` \
                     for what else was refined with one of them), `uncertainty RUN NAME=RUN,RUN…` \
                     (what was refined, from coarse to fine), `measured FILE RUN…` (runs compared with an experiment), \
                     `measured:SERIES FILE RUN…` (point by point, _ for a space in the name), `statistics FILE RUN…` (its statistics \
                     over time; `statistics:refined` for two runs or more, refined by the same factor from each to the next), or `samples:FILE STUDY STUDY MEASURE…` \
                     (the distribution of measures over samples, and where the runs of another study lie, also drawn as \
                     FILE.svg, _ for a space in the name); folders as seen from the page's";

/// Options of the tables.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Pages with places for tables: between <!-- table: KIND FOLDER… --> and <!-- end of table -->.
    #[arg(value_name = "PAGE", required = true)]
    pages: Vec<PathBuf>,
    /// Write nothing; exit code 1 if a table is not what its runs say.
    #[arg(long)]
    check: bool,
}

/// A page and what it should be.
struct Filled<'a> {
    page: &'a Path,
    before: String,
    after: String,
    tables: usize,
    /// What is drawn of the tables, each with its file.
    figures: Vec<(PathBuf, Figure)>,
}

/// Makes all tables, then writes the pages that have changed.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let filled = arguments.pages.iter().map(|page| fill(page));
    let filled: Vec<Filled> = filled.collect::<Result<_, _>>()?;
    let is_changed = |filled: &&Filled| filled.before != filled.after;
    if arguments.check {
        let changed: Vec<String> = (filled.iter().filter(is_changed))
            .map(|filled| filled.page.display().to_string())
            .collect();
        return match changed.is_empty() {
            true => Ok(()),
            false => Err(Failure::Run(format!(
                "the tables are not what their runs say; `fsi-driver tables {0}` writes them again",
                changed.join(" ")
            ))),
        };
    }
    for filled in filled.iter().filter(is_changed) {
        write_atomically(filled.page, filled.after.as_bytes())
            .map_err(|e| Failure::Run(format!("cannot write {e}")))?;
    }
    for (file, figure) in filled.iter().flat_map(|filled| &filled.figures) {
        write_atomically(&file.with_extension("svg"), figure.to_svg().as_bytes())
            .map_err(|e| Failure::Run(format!("cannot write {e}")))?;
    }
    for filled in &filled {
        let state = match is_changed(&filled) {
            true => "written",
            false => "unchanged",
        };
        let (page, tables) = (filled.page.display(), filled.tables);
        terminal::print(format_args!("{page}: {tables} table(s), {state}\n"))?;
    }
    Ok(())
}

fn fill(page: &Path) -> Result<Filled<'_>, Failure> {
    let before = std::fs::read_to_string(page)
        .map_err(|e| Failure::Input(format!("cannot read {}: {e}", page.display())))?;
    let folder = page.parent().unwrap_or(Path::new(""));
    let reason = |failure| match failure {
        Failure::Input(reason) | Failure::Run(reason) | Failure::Interrupted(reason) => reason,
    };
    let mut figures = Vec::new();
    let content = |words: &[&str]| table(folder, words, &mut figures).map_err(reason);
    let (after, tables) = marked_text::fill(&before, content)
        .map_err(|e| Failure::Input(format!("{}: {e}", page.display())))?;
    if tables == 0 {
        return Err(Failure::Input(format!(
            "{} has no place for a table: write `<!-- table: KIND FOLDER -->` and `<!-- end of table -->` on lines of their own; {KINDS}",
            page.display()
        )));
    }
    Ok(Filled {
        page,
        before,
        after,
        tables,
        figures,
    })
}

/// What a mark asks for, in Markdown; folders begin at `folder`. What is drawn of it goes into `figures`.
fn table(
    folder: &Path,
    words: &[&str],
    figures_drawn: &mut Vec<(PathBuf, Figure)>,
) -> Result<String, Failure> {
    let study = |path: &str, load| {
        let study = report::study(&folder.join(path), load)?;
        match study.missing.is_empty() {
            true => Ok(study),
            false => Err(Failure::Input(study.missing.join("\n"))),
        }
    };
    let figures = |path: &str| study(path, Results::load_figures).map(ordered);
    let run = |path: &str| {
        let run = Results::load_figures(&folder.join(path));
        run.map_err(|e| Failure::Input(e.to_string()))
    };
    let table = match words {
        ["models", path] => {
            let study = figures(path)?;
            key_figures(&study.iter().collect::<Vec<_>>()).transposed()
        }
        ["findings", path] => {
            let study = study(path, Results::load)?;
            if !paper::PaperStudy::is_that_of(&study) {
                return Err(Failure::Input(format!(
                    "{path} holds runs of other cases than the paper's models: its findings are about those alone"
                )));
            }
            paper::findings::plain(&paper::PaperStudy::new(study))
        }
        ["differences", first, second] => {
            differences(&figures(first)?, &figures(second)?, [first, second])?.transposed()
        }
        ["changes", one, others] => {
            let (one, others) = (run(one)?, figures(others)?);
            let pairs: Vec<_> = others.iter().map(|other| (&one, other)).collect();
            changes(&pairs).transposed()
        }
        ["coupling", runs @ ..] if !runs.is_empty() => {
            // A flag has no page of its own, but couples as well.
            let load = |path: &&str| Results::load_figures_of_any(&folder.join(path));
            let runs: Result<Vec<Results>, _> = runs.iter().map(load).collect();
            let runs = runs.map_err(|e| Failure::Input(e.to_string()))?;
            coupling(&runs.iter().collect::<Vec<_>>()).transposed()
        }
        [
            "agreement",
            coarse_a,
            fine_a,
            coarse_b,
            fine_b,
            other_refinements @ ..,
        ] => {
            let names = [*coarse_a, *fine_a, *coarse_b, *fine_b];
            let [a, b, c, d] = names.map(figures);
            let mut others = [Vec::new(), Vec::new()];
            for text in other_refinements {
                let (solver, before, after) = refinement_of(text)?;
                others[solver].push([figures(before)?, figures(after)?]);
            }
            agreement_of([&a?, &b?, &c?, &d?], &others, names)?
        }
        ["uncertainty", base, series @ ..] if !series.is_empty() => {
            uncertainty(&run(base)?, &refinement_series(series, "", run)?)
        }
        ["measured", file, runs @ ..] if !runs.is_empty() => {
            validation(folder, file, runs)?.summary()
        }
        ["statistics", file, runs @ ..] if !runs.is_empty() => {
            statistics(folder, file, runs, false)?
        }
        ["statistics:refined", file, runs @ ..] if runs.len() > 1 => {
            statistics(folder, file, runs, true)?
        }
        [kind, file, runs @ ..] if kind.starts_with("measured:") && !runs.is_empty() => {
            let series = kind.trim_start_matches("measured:").replace('_', " ");
            let validation = validation(folder, file, runs)?;
            validation.points(&series)?
        }
        [kind, samples, others, measures @ ..]
            if kind.starts_with("samples:") && !measures.is_empty() =>
        {
            let file = folder.join(kind.trim_start_matches("samples:"));
            let (table, figure) =
                distributions(&folder.join(samples), &folder.join(others), measures)
                    .map_err(|e| Failure::Input(e.to_string()))?;
            figures_drawn.push((file, figure));
            table.transposed()
        }
        _ => {
            return Err(Failure::Input(format!(
                "`{}` is not a table; {KINDS}",
                words.join(" ")
            )));
        }
    };
    Ok(table.to_markdown())
}

/// Series of runs, each as NAME=RUN,RUN… with `_` for a space in the name; `option` is where they are given.
pub(super) fn refinement_series<T: AsRef<str>>(
    series: &[T],
    option: &str,
    run: impl Fn(&str) -> Result<Results, Failure>,
) -> Result<Vec<RefinementSeries>, Failure> {
    let one = |text: &T| {
        let text = text.as_ref();
        let wrong = |what: &str| Failure::Input(format!("{option}`{text}`: {what}"));
        let (name, runs) = text
            .split_once('=')
            .ok_or_else(|| wrong("expected NAME=RUN,RUN…, from coarse to fine"))?;
        let runs: Vec<Results> = runs.split(',').map(&run).collect::<Result<_, _>>()?;
        match runs.len() {
            0 | 1 => Err(wrong("a series has two runs or more")),
            _ => Ok(RefinementSeries {
                name: name.replace('_', " "),
                runs,
            }),
        }
    };
    series.iter().map(one).collect()
}

/// Runs compared with an experiment; file and folders begin at `folder`.
fn validation(folder: &Path, file: &str, runs: &[&str]) -> Result<Validation, Failure> {
    let runs: Vec<PathBuf> = runs.iter().map(|run| folder.join(run)).collect();
    Ok(Validation::read(&folder.join(file), &runs)?)
}

/// The statistics over time of a file beside those of runs, which may be a series that is refined.
fn statistics(
    folder: &Path,
    file: &str,
    runs: &[&str],
    is_refined: bool,
) -> Result<PageTable, Failure> {
    let table = validation(folder, file, runs)?.statistics(is_refined);
    table.ok_or_else(|| {
        Failure::Input(format!(
            "{file} has no statistics over time: no column `statistic`"
        ))
    })
}

/// The runs of a study, those of the paper in its order.
fn ordered(study: crate::output::report::Study) -> Vec<Results> {
    match paper::PaperStudy::is_that_of(&study) {
        true => paper::PaperStudy::new(study).into_runs(),
        false => study.runs,
    }
}

/// The run of this name.
fn named<'a>(runs: &'a [Results], name: &str) -> Option<&'a Results> {
    runs.iter().find(|run| run.name() == name)
}

/// Of `first:BEFORE,AFTER` or `second:BEFORE,AFTER` whether it is the first solver (0) or the second, and the two
/// studies.
fn refinement_of(text: &str) -> Result<(usize, &str, &str), Failure> {
    let solver = |word| ["first", "second"].iter().position(|name| *name == word);
    let parts = text.split_once(':').and_then(|(word, studies)| {
        let (before, after) = studies.split_once(',')?;
        Some((solver(word)?, before, after))
    });
    parts.ok_or_else(|| {
        Failure::Input(format!(
            "`{text}` is neither first:BEFORE,AFTER nor second:BEFORE,AFTER; {KINDS}"
        ))
    })
}

/// Runs of the same name in all four studies: two meshes with one solver, two with the other; with those of that name
/// before and after something else was refined with either.
fn agreement_of(
    studies: [&[Results]; 4],
    other_refinements: &[Vec<[Vec<Results>; 2]>; 2],
    names: [&str; 4],
) -> Result<PageTable, Failure> {
    let [coarse_a, fine_a, coarse_b, fine_b] = studies;
    let pair = |fine: &'_ Results| {
        let name = fine.name();
        let other_refinements = other_refinements.each_ref().map(|pairs| {
            let pairs = pairs.iter();
            pairs
                .filter_map(|[before, after]| Some([named(before, &name)?, named(after, &name)?]))
                .collect()
        });
        Some(RefinedPair {
            first: [named(coarse_a, &name)?, named(fine_a, &name)?],
            second: [named(coarse_b, &name)?, named(fine_b, &name)?],
            other_refinements,
        })
    };
    let pairs: Vec<RefinedPair> = fine_a.iter().filter_map(pair).collect();
    match pairs.is_empty() {
        false => Ok(agreement(&pairs, [names[0], names[2]])),
        true => Err(Failure::Input(format!(
            "no run has the same name in {}",
            names.join(", ")
        ))),
    }
}

/// Runs of the same name in both studies.
fn differences(
    first: &[Results],
    second: &[Results],
    names: [&str; 2],
) -> Result<PageTable, Failure> {
    let with = |run| Some((run, named(second, &Results::name(run))?));
    let pairs: Vec<(&Results, &Results)> = first.iter().filter_map(with).collect();
    match pairs.is_empty() {
        false => Ok(changes(&pairs)),
        true => Err(Failure::Input(format!(
            "no run in {} has the name of one in {}",
            names[0], names[1]
        ))),
    }
}
