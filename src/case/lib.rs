//! Reads and checks `case.toml`: model, materials, boundary conditions, numerics. Does not know how anything is solved.
//!
//! In the files every name carries its unit (`mu_Pa`, `time.step_s`); in these types all values are SI.
//!
//! A case is a stack of layers, and what lies on top counts: the file that `extends` names (all parameters with unit
//! and origin: `openfoam-case/defaults.toml`, which is built into the program as "defaults"), the preset found there,
//! the case's own values, `--set key=value`. A vessel of your own is a folder anywhere with a file `case.toml`:
//! ```toml
//! extends = "defaults"
//!
//! [geometry]
//! graft_inner_radius_m = 4.0e-3
//! artery_inner_radius_m = 3.0e-3
//! ```
//! ```
//! use fsi_case::{Case, Preset};
//! # fn main() -> Result<(), fsi_case::CaseErrors> {
//! let overrides = [("time.end_s".to_owned(), "0.5".to_owned())];
//! let case = Case::load("openfoam-case/S-0.25".as_ref(), Preset::Demo, &overrides)?;
//! let vessel = case.anastomosis().expect("no other vessel, and no flag");
//! assert_eq!((vessel.model.d_max, case.time.end), (0.25e-3, 0.5));
//! # Ok(())
//! # }
//! ```

mod anastomosis;
mod blood;
mod blood_vessel;
mod centre_line;
mod check;
mod conditions;
mod curve_file;
pub mod defaults;
mod earlier;
mod error;
mod flag;
mod flow_curve;
pub mod identity;
mod json_schema;
mod keys;
mod law;
mod load;
mod lumen;
mod measure;
pub mod measured;
mod opening;
mod openings;
mod own;
mod periodic_table;
mod problem;
mod random_lumen;
mod relative;
mod run_ends;
pub mod schema;
pub mod source;
pub mod spelling;
pub mod stack;
pub mod table;
mod templates;
mod text_file;
mod times;
mod tree;
mod tree_files;
mod tree_lines;
mod tree_lumen;
mod uncertain;
pub mod value;
mod vessel;
mod vessel_path;
mod warnings;
mod window;
mod write;

// For the paths that the macros of this crate write, here as in the crates that use them.
extern crate self as fsi_case;

use fsi_data::{curve, files, interpolation, polydata, tabular, uncertainty};
use fsi_numerics::Vec3;

pub use anastomosis::*;
pub use blood::{Blood, BloodModel, Rheology};
pub use blood_vessel::*;
pub use centre_line::{LineReading, LineSurvey, lines_of_tree, listed};
pub use check::{MAX_BEND_DEG, MAX_ELEMENT_BEND_DEG, TOO_SHARP};
pub use curve_file::TableError;
pub use error::{CaseError, CaseErrors, ValuePlace};
pub use flag::{Flag, FlagMesh};
pub use flow_curve::FlowCurve;
pub use identity::CaseIdentity;
pub use keys::*;
pub use load::Unread;
pub use load::{Override, Preset, ResolvedCase};
pub use measure::*;
pub use opening::*;
pub use openings::*;
pub use own::*;
pub use periodic_table::PeriodicTable;
pub use problem::{Problem, ProblemKind};
pub use random_lumen::{RandomLumen, RandomWall};
pub use run_ends::RunEnds;
pub use schema::Only;
pub use tree::*;
pub use uncertain::{Correlation, DistributionKind, Uncertain, inputs};
pub use vessel::*;
pub use vessel_path::RIGID_SHARE;
pub use window::{Window, Windows};

impl CouplingSettings {
    /// The relaxation factor that was given, or a good one: a surrogate knows how far to go, but not exactly.
    pub fn relaxation(&self) -> f64 {
        self.relaxation.unwrap_or(match self.surrogate {
            SurrogateModel::None => 0.1,
            SurrogateModel::Tube | SurrogateModel::OpenTube | SurrogateModel::Potential => 0.9,
        })
    }
}

impl Case {
    /// Number of time steps.
    pub fn steps(&self) -> usize {
        (self.time.end / self.time.step).round() as usize
    }

    /// Number of time steps of a beat.
    pub fn steps_of_a_beat(&self) -> usize {
        (self.time.period / self.time.step).round() as usize
    }

    /// How little a beat must differ from the one before for the run to end, if it may end so.
    pub fn until_periodic(&self) -> Option<f64> {
        let limit = self.time.until_periodic?;
        self.has_beats().then_some(limit)
    }

    /// Whether anything that drives the blood changes with the beat.
    pub fn has_beats(&self) -> bool {
        self.flag().is_none() && !self.is_driven_steadily()
    }

    /// The number of time steps in words.
    pub fn steps_told(&self) -> String {
        let ends = RunEnds::of(self);
        match ends.from(0) {
            last if last == ends.last() => format!("{last} steps"),
            first => format!("{first} to {} steps", ends.last()),
        }
    }
}
