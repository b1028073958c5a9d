//! What the command line says about a case.

use super::Failure;
use crate::case::{Case, Preset, ResolvedCase};
use crate::output::terminal;
use std::path::Path;

/// Preset and values that replace those of a case.
#[derive(Debug, Clone, clap::Args)]
pub struct CaseArguments {
    /// Resolution and length of the run.
    #[arg(long, value_enum, default_value_t = Preset::Paper)]
    pub preset: Preset,
    /// End of the simulated time in seconds [default: time.end_s of the case].
    #[arg(long, value_name = "S")]
    end_time: Option<f64>,
    /// Number of MPI ranks of the fluid [default: fluid.ranks of the case].
    #[arg(long, value_name = "N")]
    ranks: Option<usize>,
    /// Values that replace those of the case, such as coupling.e_rel=1e-6 or fluid.transport=files.
    #[arg(long = "set", value_name = "KEY=VALUE", num_args = 1..)]
    overrides: Vec<String>,
}

impl CaseArguments {
    /// The same as words of a command line.
    pub fn to_arguments(&self) -> Vec<String> {
        let mut words = vec!["--preset".to_owned(), self.preset.to_string()];
        let mut option = |name: &str, value: String| words.extend([name.to_owned(), value]);
        self.end_time
            .iter()
            .for_each(|end| option("--end-time", format!("{end:?}")));
        self.ranks
            .iter()
            .for_each(|ranks| option("--ranks", ranks.to_string()));
        self.overrides
            .iter()
            .for_each(|pair| option("--set", pair.clone()));
        words
    }

    /// The same with one more value that replaces that of the case.
    pub fn with(mut self, key: &str, value: impl std::fmt::Display) -> Self {
        self.overrides.push(format!("{key}={value}"));
        self
    }

    /// Loads and checks the case in the folder `case`; it must fit into this machine.
    pub fn load(&self, case: &Path) -> Result<ResolvedCase, Failure> {
        let mut overrides = Vec::new();
        if let Some(end) = self.end_time {
            overrides.push(("time.end_s".to_owned(), format!("{end:?}")));
        }
        if let Some(ranks) = self.ranks {
            overrides.push(("fluid.ranks".to_owned(), ranks.to_string()));
        }
        for pair in &self.overrides {
            let (key, value) = pair.split_once('=').ok_or_else(|| {
                Failure::Input(format!(
                    "--set {pair}: expected KEY=VALUE, such as coupling.e_rel=1e-6"
                ))
            })?;
            overrides.push((key.trim().to_owned(), value.trim().to_owned()));
        }
        let case =
            Case::load(case, self.preset, &overrides).map_err(|e| Failure::Input(e.to_string()))?;
        match machine_memory() {
            Some(there) if case.memory() > there => Err(Failure::Input(format!(
                "the case needs about {:.1} GB of memory, and this machine has {:.1} GB: take fewer elements (structure.*), a lower structure.p, or fewer cells (fluid.mesh.*)",
                case.memory() / 1e9,
                there / 1e9
            ))),
            _ => Ok(case),
        }
    }
}

/// Says on standard error what makes the results of a case doubtful.
pub fn warn(case: &Case) {
    let cores = std::thread::available_parallelism().map_or(usize::MAX, usize::from);
    for warning in case.warnings(cores) {
        terminal::note(format_args!("warning: {warning}"));
    }
}

/// Memory of this machine, bytes.
pub fn machine_memory() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemTotal:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024.0)
}
