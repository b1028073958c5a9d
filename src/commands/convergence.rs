//! `fsi-driver convergence`: the study of section 4.1 and its figures 7 to 10.

use super::Failure;
use crate::output::terminal;
use crate::paper::convergence::cases::TestCase;
use crate::paper::convergence::computation;
use crate::paper::convergence::plan::Plan;
use std::path::PathBuf;

/// Options of the study.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of the results. A study that was interrupted goes on there.
    #[arg(long, value_name = "DIR", default_value = "convergence")]
    out: PathBuf,
    /// Which test case.
    #[arg(long, value_enum, default_value_t = TestCaseChoice::All)]
    study: TestCaseChoice,
    /// Low degrees and an easier reference: about a minute.
    #[arg(long)]
    quick: bool,
}

/// Which test cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum TestCaseChoice {
    /// Circular shaped artery: figures 7 and 8.
    Circular,
    /// Idealized bypass graft: figure 9.
    Graft,
    /// Irregular shaped artery: figure 10.
    Irregular,
    /// All three.
    All,
}

impl TestCaseChoice {
    fn cases(self) -> &'static [TestCase] {
        match self {
            TestCaseChoice::Circular => &[TestCase::Circular],
            TestCaseChoice::Graft => &[TestCase::Graft],
            TestCaseChoice::Irregular => &[TestCase::Irregular],
            TestCaseChoice::All => &TestCase::ALL,
        }
    }
}

/// Runs the study, or what is left of it.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let plans: Vec<Plan> = arguments
        .study
        .cases()
        .iter()
        .map(|&case| Plan::new(case, arguments.quick))
        .collect();
    let found = computation::run(&plans, &arguments.out, arguments.quick)?;
    terminal::print(format_args!(
        "{} rows and the figures are in {}\n",
        found.rows,
        arguments.out.display()
    ))?;
    match found.failures {
        0 => Ok(()),
        1 => Err(Failure::Run(
            "1 computation failed; it is tried again when the command is".into(),
        )),
        n => Err(Failure::Run(format!(
            "{n} computations failed; they are tried again when the command is"
        ))),
    }
}
