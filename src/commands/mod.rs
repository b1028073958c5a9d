//! The command line: one file per subcommand; short, reads like the README.

mod bench;
mod calibrate;
mod case_arguments;
mod check;
mod check_fluid;
mod compare;
mod convergence;
mod couple_test;
mod cross_check;
mod hemodynamics;
mod keys;
mod new;
mod preview;
mod quantity;
mod report;
mod results_folder;
mod run;
mod shell;
mod solid;
mod study;
mod tables;
mod validate;
mod wall;
mod windkessel;

use clap::error::ErrorKind;
use clap::{ArgMatches, CommandFactory, FromArgMatches, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

use crate::output::terminal;
use crate::run::Failure;
use case_arguments::CaseArguments;

/// Fluid-structure interaction of arteries: p-version finite elements for the wall, OpenFOAM for the blood.
///
/// Without a subcommand it runs a coupled case.
#[derive(Debug, Parser)]
#[command(
    name = "fsi-driver",
    version,
    args_conflicts_with_subcommands = true,
    arg_required_else_help = true
)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    /// Folder of the case, with its case.toml, or that file.
    #[arg(long, value_name = "DIR")]
    case: Option<PathBuf>,
    #[command(flatten)]
    how: run::How,
    #[command(flatten)]
    chosen: CaseArguments,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Runs a coupled case, as --case DIR does.
    #[command(hide = true)]
    Run(run::InFolder),
    /// Writes a commented case for a vessel of your own, from a centre-line and a surface if you have them.
    New(new::Arguments),
    /// Draws a vessel before anything is computed: lumen, wall, sections, layers, fibres and meshes.
    Preview(preview::Arguments),
    /// Checks a case and all that it reads, and says how large it is; writes nothing.
    Check(check::Arguments),
    /// Tests your own fluid solver against the protocol, by playing the driver.
    CheckFluid(check_fluid::Arguments),
    /// Measures where the seconds of a coupled time step go.
    Bench(bench::Arguments),
    /// Compares acceleration models and predictors on problems with a known answer, or the models on cases.
    CoupleTest(couple_test::Arguments),
    /// Inflates a tube: statics, or dynamics under a given pressure; needs no flow solver.
    Solid(solid::Arguments),
    /// Runs all models, several at once; shows one table of progress.
    Study(study::Arguments),
    /// Finds the likeliest inputs with which measures of a study are what they should be, and confirms them by a run.
    Calibrate(calibrate::Arguments),
    /// Compares two runs of the same model; exit code 1 beyond the limits.
    Compare(compare::Arguments),
    /// Runs cases with both solvers for the blood and compares them; exit code 1 beyond the limits.
    CrossCheck(cross_check::Arguments),
    /// Writes one self-contained page about a run or a study.
    Report(report::Arguments),
    /// Compares runs with measured data.
    Validate(validate::Arguments),
    /// Regenerates the tables of Markdown pages from stored runs.
    Tables(tables::Arguments),
    /// Evaluates the wall shear of a run again, over any window of time.
    Hemodynamics(hemodynamics::Arguments),
    /// Proposes a windkessel that turns a given flow into given pressures.
    Windkessel(windkessel::Arguments),
    /// Lists the keys of a case with meaning, range, default and origin.
    Keys(keys::Arguments),
    /// Prints the script by which a shell completes commands and options.
    Completions(shell::Completions),
    /// Prints the manual page, or writes those of all commands into a folder.
    Man(shell::Manual),
    /// The paper's convergence study of the structural solver, with its figures 7 to 10.
    Convergence(convergence::Arguments),
}

/// Parses the command line and runs the command. Exit code 0: done; 1: a solver failed; 2: the input or the
/// installation is at fault, nothing was written; 130: interrupted.
pub fn main() -> ExitCode {
    keep_freed_memory();
    let outcome = match parsed() {
        Ok(line) => execute(line),
        Err(mistake) if mistake.use_stderr() => mistake.exit(),
        Err(help) if help.kind() == ErrorKind::DisplayVersion => shell::version(),
        Err(help) => terminal::print(help.render()).map_err(Failure::from),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            terminal::note(&failure);
            failure.exit_code()
        }
    }
}

/// Vectors of some megabytes live for one iteration. The C library would give each back to the system and get the next
/// one page by page, which takes a twentieth of a run.
#[allow(unsafe_code)]
fn keep_freed_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const TRIM_THRESHOLD: i32 = -1;
        const MMAP_THRESHOLD: i32 = -3;
        unsafe extern "C" {
            fn mallopt(parameter: i32, value: i32) -> i32;
        }
        // SAFETY: declared as in malloc.h; no other thread is running yet.
        unsafe {
            mallopt(TRIM_THRESHOLD, i32::MAX);
            mallopt(MMAP_THRESHOLD, 1 << 30);
        }
    }
}

/// The command line. A number below zero is the value of an option, though hardly ever a good one, and no option.
fn parsed() -> clap::error::Result<CommandLine> {
    fn with_numbers(command: clap::Command) -> clap::Command {
        let names: Vec<String> = (command.get_subcommands())
            .map(|sub| sub.get_name().to_owned())
            .collect();
        let command = command.mut_args(|arg| match arg.get_action().takes_values() {
            true => arg.allow_negative_numbers(true),
            false => arg,
        });
        (names.iter()).fold(command, |all, name| all.mut_subcommand(name, with_numbers))
    }
    let mut command = with_numbers(CommandLine::command());
    let matches: ArgMatches = command.try_get_matches_from_mut(std::env::args_os())?;
    CommandLine::from_arg_matches(&matches).map_err(|mistake| mistake.format(&mut command))
}

fn execute(line: CommandLine) -> Result<(), Failure> {
    match (line.command, line.case) {
        (Some(Command::Run(arguments)), _) => run::in_folder(&arguments),
        (Some(Command::New(arguments)), _) => new::run(&arguments),
        (Some(Command::Preview(arguments)), _) => preview::run(&arguments),
        (Some(Command::Check(arguments)), _) => check::run(&arguments),
        (Some(Command::CheckFluid(arguments)), _) => check_fluid::run(&arguments),
        (Some(Command::Bench(arguments)), _) => bench::run(&arguments),
        (Some(Command::CoupleTest(arguments)), _) => couple_test::run(&arguments),
        (Some(Command::Solid(arguments)), _) => solid::run(&arguments),
        (Some(Command::Study(arguments)), _) => study::run(&arguments),
        (Some(Command::Calibrate(arguments)), _) => calibrate::run(&arguments),
        (Some(Command::Compare(arguments)), _) => compare::run(&arguments),
        (Some(Command::CrossCheck(arguments)), _) => cross_check::run(&arguments),
        (Some(Command::Report(arguments)), _) => report::run(&arguments),
        (Some(Command::Validate(arguments)), _) => validate::run(&arguments),
        (Some(Command::Tables(arguments)), _) => tables::run(&arguments),
        (Some(Command::Hemodynamics(arguments)), _) => hemodynamics::run(&arguments),
        (Some(Command::Windkessel(arguments)), _) => windkessel::run(&arguments),
        (Some(Command::Keys(arguments)), _) => keys::run(&arguments),
        (Some(Command::Completions(arguments)), _) => shell::completions(&arguments),
        (Some(Command::Man(arguments)), _) => shell::manual(&arguments),
        (Some(Command::Convergence(arguments)), _) => convergence::run(&arguments),
        (None, Some(case)) => run::run(&case, &line.how, &line.chosen),
        (None, None) => Err(Failure::Input(
            "which case? fsi-driver --case DIR runs one; fsi-driver --help lists what else there is".into(),
        )),
    }
}
