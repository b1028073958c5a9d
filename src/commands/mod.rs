//! One file per subcommand; short, reads like the README.

pub mod couple_test;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Debug, Parser)]
struct CommandLine {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Compares acceleration models and predictors on problems with a known answer; needs no flow solver.
    CoupleTest(couple_test::Arguments),
}

/// Parses the command line and runs the command; returns the exit code.
pub fn main() -> ExitCode {
    let Command::CoupleTest(arguments) = CommandLine::parse().command;
    match couple_test::run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
