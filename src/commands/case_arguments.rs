//! What the command line says about a case.

use super::Failure;
use crate::case::{Case, Override, Place, Preset, ResolvedCase};
use crate::output::terminal;
use crate::simulation::assembly::preflight;
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
    /// Who solves for the blood: openfoam or native [default: fluid.solver of the case, or openfoam].
    #[arg(long, value_name = "SOLVER")]
    fluid: Option<String>,
    /// Number of MPI ranks of the fluid [default: fluid.ranks of the case].
    #[arg(long, value_name = "N")]
    ranks: Option<usize>,
    /// Values that replace those of the case, such as coupling.e_rel=1e-6 or fluid.transport=files.
    #[arg(long = "set", value_name = "KEY=VALUE", num_args = 1..)]
    overrides: Vec<String>,
    /// Keys and values that the program itself has chosen, whatever the user said.
    #[arg(skip)]
    own: Vec<(String, String)>,
}

impl CaseArguments {
    /// The same as words of a command line.
    pub fn to_arguments(&self) -> Vec<String> {
        let mut words = vec!["--preset".to_owned(), self.preset.to_string()];
        let mut option = |name: &str, value: String| words.extend([name.to_owned(), value]);
        self.end_time
            .iter()
            .for_each(|end| option("--end-time", format!("{end:?}")));
        self.fluid
            .iter()
            .for_each(|solver| option("--fluid", solver.clone()));
        self.ranks
            .iter()
            .for_each(|ranks| option("--ranks", ranks.to_string()));
        self.overrides
            .iter()
            .for_each(|pair| option("--set", pair.clone()));
        debug_assert!(self.own.is_empty(), "they have no option");
        words
    }

    /// The same with a value that replaces that of the case and of the options.
    pub fn with(mut self, key: &str, value: impl std::fmt::Display) -> Self {
        self.own.retain(|(other, _)| other != key);
        self.own.push((key.to_owned(), value.to_string()));
        self
    }

    /// The values that replace those of the case.
    fn overrides(&self) -> Result<Vec<Override>, Failure> {
        let given = |place, key: &str, value: &str| Override {
            place,
            key: key.trim().to_owned(),
            value: value.trim().to_owned(),
        };
        let mut overrides = Vec::new();
        if let Some(end) = self.end_time {
            let place = Place::Option("--end-time");
            overrides.push(given(place, "time.end_s", &format!("{end:?}")));
        }
        if let Some(solver) = &self.fluid {
            overrides.push(given(Place::Option("--fluid"), "fluid.solver", solver));
        }
        if let Some(ranks) = self.ranks {
            let place = Place::Option("--ranks");
            overrides.push(given(place, "fluid.ranks", &ranks.to_string()));
        }
        for pair in &self.overrides {
            let (key, value) = pair.split_once('=').ok_or_else(|| {
                Failure::Input(format!(
                    "--set {pair}: expected KEY=VALUE, such as coupling.e_rel=1e-6"
                ))
            })?;
            overrides.push(given(Place::Set, key, value));
        }
        let own = self.own.iter();
        overrides.extend(own.map(|(key, value)| given(Place::Command, key, value)));
        Ok(overrides)
    }

    /// Loads and checks the case in the folder `case`; it must fit into this machine.
    pub fn load(&self, case: &Path) -> Result<ResolvedCase, Failure> {
        let case = Case::load_with(case, self.preset, &self.overrides()?)
            .map_err(|e| Failure::Input(e.to_string()))?;
        if let Some(there) = machine_memory().filter(|there| case.memory() > *there) {
            let parts = case.memory_of().into_iter();
            let largest = parts.max_by(|a, b| a.0.total_cmp(&b.0));
            return Err(Failure::Input(format!(
                "the case needs about {:.1} GB of memory, and this machine has {:.1} GB: take {}",
                case.memory() / 1e9,
                there / 1e9,
                largest.map_or("less of everything", |(_, advice)| advice)
            )));
        }
        preflight::check(&case).map_err(|e| Failure::Input(e.to_string()))?;
        Ok(case)
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
