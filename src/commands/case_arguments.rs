//! What the command line says about a case.

use super::Failure;
use crate::case::{Override, Preset, ResolvedCase, ValuePlace};
use crate::run::CaseSelection;
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
    /// Solver for the blood: openfoam or native [default: fluid.solver of the case, or openfoam].
    #[arg(long, value_name = "SOLVER")]
    fluid: Option<String>,
    /// Number of MPI ranks of the fluid [default: fluid.ranks of the case].
    #[arg(long, value_name = "N")]
    ranks: Option<usize>,
    /// Values that replace those of the case, such as coupling.e_rel=1e-6 or fluid.transport=files.
    #[arg(long = "set", value_name = "KEY=VALUE", num_args = 1..)]
    overrides: Vec<String>,
}

impl CaseArguments {
    /// The case that they select.
    pub fn selection(&self) -> Result<CaseSelection, Failure> {
        let given = |place, key: &str, value: &str| Override {
            place,
            key: key.trim().to_owned(),
            value: value.trim().to_owned(),
        };
        let mut overrides = Vec::new();
        if let Some(end) = self.end_time {
            let place = ValuePlace::Option("--end-time");
            overrides.push(given(place, "time.end_s", &format!("{end:?}")));
        }
        if let Some(solver) = &self.fluid {
            overrides.push(given(ValuePlace::Option("--fluid"), "fluid.solver", solver));
        }
        if let Some(ranks) = self.ranks {
            let place = ValuePlace::Option("--ranks");
            overrides.push(given(place, "fluid.ranks", &ranks.to_string()));
        }
        for pair in &self.overrides {
            let (key, value) = pair.split_once('=').ok_or_else(|| {
                Failure::Input(format!(
                    "--set {pair}: expected KEY=VALUE, such as coupling.e_rel=1e-6"
                ))
            })?;
            overrides.push(given(ValuePlace::Set, key, value));
        }
        Ok(CaseSelection::new(self.preset, overrides))
    }

    /// Loads and checks the case in the folder `case`; it must fit into this machine.
    pub fn load(&self, case: &Path) -> Result<ResolvedCase, Failure> {
        self.selection()?.load(case)
    }
}
