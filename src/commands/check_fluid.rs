//! `fsi-driver check-fluid -- COMMAND…`: whether a user-supplied fluid solver follows the protocol.

use super::{CaseArguments, Failure};
use crate::fluid::FluidError;
use crate::fluid::conversation::conformance::{self, RuleFinding};
use crate::output::terminal;
use crate::run::Interrupt;
use crate::simulation::assembly::{self, Workplace, surroundings};
use std::path::PathBuf;

/// Options of the check.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Folder of a case, whose wall and values the solver is given, and whose fluid.command is checked where none
    /// follows [default: the straight vessel of the defaults].
    #[arg(long = "case", value_name = "DIR")]
    folder: Option<PathBuf>,
    #[command(flatten)]
    case: CaseArguments,
    /// The solver and its arguments, after `--`.
    #[arg(last = true, value_name = "COMMAND")]
    command: Vec<String>,
}

/// Starts the solver several times, plays the driver, and prints what was found.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let workplace = tempfile::Builder::new()
        .prefix("fsi-check-fluid-")
        .tempdir()
        .map_err(|e| Failure::Run(format!("no folder for the check: {e}")))?;
    let root = workplace.path();
    let folder = match &arguments.folder {
        Some(folder) => folder.clone(),
        None => {
            let case = "extends = \"defaults\"\n[model]\nextension = \"straight\"\nd_max_m = 0.0\n";
            let written = std::fs::write(root.join("case.toml"), case);
            written.map_err(|e| Failure::Run(format!("no file for the check: {e}")))?;
            root.to_owned()
        }
    };
    let mut selection = arguments.case.selection()?;
    if !arguments.command.is_empty() {
        let words = arguments.command.iter().map(|word| format!("{word:?}"));
        let words = words.collect::<Vec<_>>().join(", ");
        selection = selection.with("fluid.command", format!("[{words}]"));
        selection = selection.with("fluid.solver", "external");
    }
    let case = selection.load(&folder)?;
    if case.fluid.command.is_empty() {
        return Err(Failure::Input(
            "check-fluid: there is no solver to check: write it after `--`, or fluid.command into a case that --case names".into(),
        ));
    }
    surroundings::check_installed(&case).map_err(|e| Failure::Input(e.to_string()))?;
    let interrupt = Interrupt::listen(None)?;
    let case_file = root.join("case.resolved.toml");
    std::fs::write(&case_file, case.to_toml_string())
        .map_err(|e| Failure::Run(format!("cannot prepare the check: {e}")))?;
    let workplace = Workplace {
        folder: root.join("openfoam"),
        log: root.join("openfoam.log"),
        case_file,
        interrupt: interrupt.of_the_start(),
        tell: None,
    };
    let settings = assembly::external_settings(&case, workplace)
        .map_err(|e| Failure::Input(format!("{}: {e}", e.key)))?;
    // Without reading them one still gets the exit code.
    let mut tell =
        |finding: &RuleFinding| drop(terminal::print(format_args!("{}\n", line(finding))));
    let findings = conformance::examine(&settings, &mut tell);
    let findings = findings.map_err(|error| match error {
        FluidError::Interrupted => Failure::Interrupted("the check is not complete".into()),
        error => Failure::Run(error.to_string()),
    })?;
    interrupt.stop_listening()?;
    let (all, wrong) = (
        findings.len(),
        findings.iter().filter(|f| f.found.is_err()).count(),
    );
    match wrong {
        0 => Ok(terminal::print(format_args!(
            "{all} checks, all passed: this solver can be the fluid of a case\n"
        ))?),
        _ => Err(Failure::Run(format!(
            "{wrong} of {all} checks failed; of-adapter/PROTOCOL.md says what is expected"
        ))),
    }
}

fn line(finding: &RuleFinding) -> String {
    let (word, detail) = match &finding.found {
        Ok(detail) => ("ok   ", detail),
        Err(detail) => ("WRONG", detail),
    };
    match detail.is_empty() {
        true => format!("{word} {}", finding.what),
        false => format!("{word} {}: {detail}", finding.what),
    }
}
