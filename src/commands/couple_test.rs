//! `fsi-driver couple-test`: acceleration and prediction on problems with a known answer, without a flow solver; or,
//! with `--case`, every acceleration model on real coupled cases.

use super::{CaseArguments, Failure};
use crate::measurement::models::{Plan, Variant, reference};
use std::path::PathBuf;

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

/// Compares on the problems with a known answer, or on cases.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.cases.is_empty() {
        return reference::compare(&arguments.out, arguments.tolerance);
    }
    let plan = Plan {
        out: &arguments.out,
        variants: Variant::called(&arguments.only)?,
        steps: arguments.steps.map(|steps| steps as usize),
        selection: &arguments.chosen.selection()?,
    };
    plan.run(&arguments.cases)
}
