//! `fsi-driver couple-test`: acceleration and prediction on problems with a known answer, without a flow solver; or,
//! with `--case`, every acceleration model on real coupled cases.

mod cases;
mod measure;
mod plot;
mod variant;

use super::{CaseArguments, Failure};
use crate::coupling::predictor::Extrapolation;
use crate::coupling::reference::study::{Combination, problems};
use crate::coupling::reference::{History, Reference};
use crate::output::terminal;
use rayon::prelude::*;
use serde::Serialize;
use std::fs;
use std::io;
use std::path::PathBuf;
use variant::Variant;

/// Options of the study.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the results: tables, plots of the residual, and the runs of cases. Tables of cases go on there.
    #[arg(long, value_name = "DIR", default_value = "couple-test")]
    out: PathBuf,
    /// Relative residual at which a step of the problems with a known answer has converged.
    #[arg(long, value_name = "R", default_value_t = 1e-6)]
    tolerance: f64,
    /// Run these cases with every model instead: takes long, and may be interrupted and started again.
    #[arg(long = "case", value_name = "DIR", num_args = 1..)]
    cases: Vec<PathBuf>,
    /// Only these rows of the table of cases, such as iqn_ls-10 or aitken-surrogate.
    #[arg(long, value_name = "ROW", num_args = 1.., requires = "cases")]
    only: Vec<String>,
    /// Number of time steps of the cases [default: to their end].
    #[arg(long, value_name = "N", requires = "cases", conflicts_with = "end_time", value_parser = clap::value_parser!(u32).range(1..))]
    steps: Option<u32>,
    #[command(flatten)]
    chosen: CaseArguments,
}

impl Arguments {
    /// The rows that were asked for.
    fn variants(&self) -> Result<Vec<Variant>, Failure> {
        let all = Variant::all();
        if self.only.is_empty() {
            return Ok(all);
        }
        let find = |name: &String| {
            let found = all.iter().find(|variant| variant.name() == *name);
            found.copied().ok_or_else(|| {
                let names: Vec<_> = all.iter().map(|variant| variant.name()).collect();
                Failure::Input(format!(
                    "--only {name}: there is no such row; expected some of {}",
                    names.join(", ")
                ))
            })
        };
        self.only.iter().map(find).collect()
    }
}

/// A row of `couple_test.csv`.
#[derive(Debug, Serialize)]
struct Row<'a> {
    problem: &'a str,
    model: &'a str,
    reuse_steps: usize,
    surrogate: bool,
    predictor: &'a str,
    converged: bool,
    mean_iterations: f64,
    max_iterations: usize,
    /// Largest difference to the exact solution over the largest displacement.
    difference_to_exact: f64,
}

/// Runs every combination of settings on every problem; prints mean and largest numbers of iterations, writes the
/// table and the plots.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if !arguments.cases.is_empty() {
        let plan = cases::Plan {
            out: &arguments.out,
            variants: arguments.variants()?,
            steps: arguments.steps.map(|steps| steps as usize),
            chosen: &arguments.chosen,
        };
        return plan.run(&arguments.cases);
    }
    let unwritten = |error: io::Error| {
        let folder = arguments.out.display();
        Failure::Run(format!(
            "the study could not be written to {folder}: {error}; choose another --out"
        ))
    };
    fs::create_dir_all(&arguments.out).map_err(unwritten)?;
    let table = csv::Writer::from_path(arguments.out.join("couple_test.csv"));
    let mut table = table.map_err(|e| unwritten(e.into()))?;
    for (index, problem) in problems().iter().enumerate() {
        let exact = problem.exact();
        let results: Vec<(Combination, History)> = Combination::all()
            .into_par_iter()
            .map(|trial| {
                let mut problem = problems().swap_remove(index);
                (trial, trial.run(problem.as_mut(), arguments.tolerance))
            })
            .collect();
        let difference = |history: &History| history.difference(&exact);
        write(
            arguments,
            &mut table,
            problem.as_ref(),
            &results,
            difference,
        )
        .map_err(unwritten)?;
        terminal::print(shown(problem.as_ref(), &results, difference))?;
    }
    table.flush().map_err(unwritten)
}

/// Adds a row for each trial and draws the residuals.
fn write(
    arguments: &Arguments,
    table: &mut csv::Writer<fs::File>,
    problem: &dyn Reference,
    results: &[(Combination, History)],
    difference: impl Fn(&History) -> f64,
) -> io::Result<()> {
    for (trial, history) in results {
        table.serialize(Row {
            problem: problem.name(),
            model: trial.kind.name(),
            reuse_steps: trial.reuse,
            surrogate: trial.surrogate,
            predictor: trial.extrapolation.name(),
            converged: history.converged,
            mean_iterations: history.mean(),
            max_iterations: history.most(),
            difference_to_exact: difference(history),
        })?;
    }
    let file = format!("residual_{}.svg", problem.name().replace(' ', "_"));
    plot::residuals(&arguments.out.join(file), problem.name(), results)
}

/// A line for each model, reuse and surrogate, a column for each predictor.
fn shown(
    problem: &dyn Reference,
    results: &[(Combination, History)],
    difference: impl Fn(&History) -> f64,
) -> String {
    let mut text = format!(
        "{}, {} steps: mean (largest) number of coupling iterations\n  {:<14}{:>3}  {:<9}",
        problem.name(),
        problem.steps(),
        "model",
        "q",
        "surrogate"
    );
    for extrapolation in Extrapolation::ALL {
        text += &format!("{:>16}", extrapolation.name());
    }
    text += &format!("{:>22}\n", "difference to exact");
    for line in results.chunks(Extrapolation::ALL.len()) {
        let trial = &line[0].0;
        let surrogate = if trial.surrogate { "yes" } else { "no" };
        let (model, reuse) = (trial.kind.name(), trial.reuse);
        text += &format!("  {model:<14}{reuse:>3}  {surrogate:<9}");
        for (_, history) in line {
            let figure = if history.converged {
                format!("{:.2} ({})", history.mean(), history.most())
            } else {
                "diverged".into()
            };
            text += &format!("{figure:>16}");
        }
        let worst = line
            .iter()
            .map(|(_, history)| difference(history))
            .fold(0.0, f64::max);
        text += &format!("{worst:>22.1e}\n");
    }
    text + "\n"
}
