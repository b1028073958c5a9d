//! Command line of `fsi-driver`.
fn main() -> std::process::ExitCode {
    fsi_driver::commands::main()
}
