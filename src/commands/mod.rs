//! One file per subcommand; short, reads like the README.
/// Parses the command line and runs the command; returns the exit code.
pub fn main() -> std::process::ExitCode {
    std::process::ExitCode::SUCCESS
}
