//! Which case is run: a preset, and values that replace those of its files.

use super::Failure;
use crate::analysis;
use crate::analysis::size;
use crate::case::{Case, Override, Preset, ResolvedCase, ValuePlace};
use crate::hemodynamics::FlowNumbers;
use crate::output::terminal;
use crate::processes::machine_memory;
use crate::simulation::assembly::{preflight, sideways_warning};
use std::path::Path;

/// A preset and values that replace those of a case.
#[derive(Debug, Clone)]
pub struct CaseSelection {
    /// Resolution and length of the run.
    pub preset: Preset,
    /// What the user has given.
    pub given: Vec<Override>,
    /// Keys and values that the program itself has chosen, whatever the user said.
    own: Vec<(String, String)>,
}

impl CaseSelection {
    /// What the user has given.
    pub fn new(preset: Preset, given: Vec<Override>) -> Self {
        Self {
            preset,
            given,
            own: Vec::new(),
        }
    }

    /// The same as words of a command line.
    pub fn to_arguments(&self) -> Vec<String> {
        debug_assert!(self.own.is_empty(), "they have no option");
        let mut words = vec!["--preset".to_owned(), self.preset.to_string()];
        for Override { place, key, value } in &self.given {
            words.extend(match place {
                ValuePlace::Option(name) => [(*name).to_owned(), value.clone()],
                _ => ["--set".to_owned(), format!("{key}={value}")],
            });
        }
        words
    }

    /// The same with a value that replaces that of the case and of the user.
    pub fn with(mut self, key: &str, value: impl std::fmt::Display) -> Self {
        self.own.retain(|(other, _)| other != key);
        self.own.push((key.to_owned(), value.to_string()));
        self
    }

    /// As [`read`](Self::read), and checks that the case can start: its meshes fit together, and the wall has an
    /// initial state, which takes minutes where it is hard to find.
    ///
    /// # Errors
    /// All mistakes in the case, or what makes it too large.
    pub fn load(&self, case: &Path) -> Result<ResolvedCase, Failure> {
        let case = self.read(case)?;
        if let Some(warning) = sideways_warning(&case) {
            terminal::note(format_args!("warning: {warning}"));
        }
        preflight::check(&case).map_err(|e| Failure::Input(e.to_string()))?;
        Ok(case)
    }

    /// Loads the case in the folder `case`, which must fit into this machine. No mesh is made, and
    /// no initial state of the wall.
    ///
    /// # Errors
    /// All mistakes in its keys and files, or what makes it too large.
    pub fn read(&self, case: &Path) -> Result<ResolvedCase, Failure> {
        let own = self.own.iter().map(|(key, value)| Override {
            place: ValuePlace::Command,
            key: key.clone(),
            value: value.clone(),
        });
        let overrides: Vec<Override> = self.given.iter().cloned().chain(own).collect();
        let case = Case::load_with(case, self.preset, &overrides)
            .map_err(|e| Failure::Input(e.to_string()))?;
        if let Some(there) = machine_memory().filter(|there| size::memory(&case) > *there) {
            let parts = size::memory_of(&case).into_iter();
            let largest = parts.max_by(|a, b| a.0.total_cmp(&b.0));
            return Err(Failure::Input(format!(
                "the case needs about {:.1} GB of memory, and this machine has {:.1} GB: take {}",
                size::memory(&case) / 1e9,
                there / 1e9,
                largest.map_or("less of everything", |(_, advice)| advice)
            )));
        }
        Ok(case)
    }
}

/// Says on standard error what makes the results of a case doubtful, and what in it does nothing.
pub fn warn(case: &ResolvedCase) {
    let unread = case.unread.iter().map(ToString::to_string);
    let numbers = analysis::flow_numbers(case);
    let findings = numbers.iter().flat_map(FlowNumbers::findings);
    let warnings = case.warnings(cores()).into_iter().chain(unread);
    for warning in warnings.chain(findings.map(|finding| finding.text)) {
        terminal::note(format_args!("warning: {warning}"));
    }
}

/// Cores that MPI ranks may have: those of this machine, or the tasks of a Slurm job, which may have several.
fn cores() -> usize {
    let here = std::thread::available_parallelism().map_or(usize::MAX, usize::from);
    let tasks = std::env::var("SLURM_NTASKS").ok();
    let tasks = tasks.and_then(|tasks| tasks.parse().ok());
    here.max(tasks.unwrap_or(0))
}
