//! Every acceleration model and predictor on the problems with a known answer, without a flow solver.

use super::plot;
use crate::coupling::predictor::Extrapolation;
use crate::coupling::reference::combinations::{Combination, problems};
use crate::coupling::reference::{History, Reference};
use crate::output::terminal;
use crate::run::Failure;
use rayon::prelude::*;
use serde::Serialize;
use std::fs;
use std::io;
use std::path::Path;

/// A row of `couple_test.csv`.
#[derive(Debug, Serialize)]
struct ReferenceRow<'a> {
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

/// Runs every combination of settings on every problem until the relative residual of each step is below the
/// `tolerance`; prints mean and largest numbers of iterations, writes the table and the plots into the folder `out`.
///
/// # Errors
/// If something cannot be written.
pub fn compare(out: &Path, tolerance: f64) -> Result<(), Failure> {
    let unwritten = |error: io::Error| {
        let folder = out.display();
        Failure::Run(format!(
            "the study could not be written to {folder}: {error}; choose another --out"
        ))
    };
    fs::create_dir_all(out).map_err(unwritten)?;
    let table = csv::Writer::from_path(out.join("couple_test.csv"));
    let mut table = table.map_err(|e| unwritten(e.into()))?;
    for (index, problem) in problems().iter().enumerate() {
        let exact = problem.exact();
        let results: Vec<(Combination, History)> = Combination::all()
            .into_par_iter()
            .map(|trial| {
                let mut problem = problems().swap_remove(index);
                (trial, trial.run(problem.as_mut(), tolerance))
            })
            .collect();
        let difference = |history: &History| history.difference(&exact);
        write(out, &mut table, problem.as_ref(), &results, difference).map_err(unwritten)?;
        terminal::print(shown(problem.as_ref(), &results, difference))?;
    }
    table.flush().map_err(unwritten)
}

/// Adds a row for each trial and draws the residuals.
fn write(
    out: &Path,
    table: &mut csv::Writer<fs::File>,
    problem: &dyn Reference,
    results: &[(Combination, History)],
    difference: impl Fn(&History) -> f64,
) -> io::Result<()> {
    for (trial, history) in results {
        table.serialize(ReferenceRow {
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
    plot::residuals(&out.join(file), problem.name(), results)
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
