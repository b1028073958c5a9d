//! A fluid of one's own, coupled to the p-FEM wall: `cargo run --release --example own_fluid [FOLDER]`.
//!
//! A pulse of inflow runs through the elastic tube of `openfoam-case/elastic-tube`. The blood is one-dimensional and
//! stands in `fluid.rs`, complete: that is all that a flow solver needs to take part. A run that is started again in
//! the same folder continues from its newest checkpoint, to the last digit.

pub mod fluid;

use fluid::OneDimensionalFluid;
use fsi_driver::case::{Case, Preset, ResolvedCase};
use fsi_driver::coupling::Coupling;
use fsi_driver::fluid::Fluid;
use fsi_driver::pfem::Structure;
use fsi_driver::simulation::assembly::{self, Domain};
use fsi_driver::simulation::checkpoint::{Store, StoreError};
use fsi_driver::simulation::observer::{AcceptedStep, AcceptedWall, Note, Observer};
use fsi_driver::simulation::{Checkpoints, Simulation};
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1);
    let folder = folder.map_or_else(|| "own-fluid".into(), PathBuf::from);
    let case = elastic_tube("0.002")?;
    let coupling = assembly::couple(&case, &Domain::new(&case)?, OneDimensionalFluid::new(&case))?;
    let simulation = run(&case, coupling, &folder)?;
    for row in &simulation.observer.rows {
        println!(
            "t = {:.4} s: {:.3} ml/s in, {:.3} ml/s out, {:7.1} Pa at the inlet, wall displaced by at most {:.2} µm",
            row.time,
            1e6 * row.inflow,
            1e6 * row.outflow,
            row.inlet_pressure,
            1e6 * row.displacement
        );
    }
    Ok(())
}

/// The case, which ends at `end` (s).
pub fn elastic_tube(end: &str) -> Result<ResolvedCase, Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("openfoam-case/elastic-tube");
    let values = [
        ("time.end_s", end),
        ("coupling.surrogate", "none"),
        ("output.checkpoint_interval_min", "0"),
    ];
    let values = values.map(|(key, value)| (key.into(), value.into()));
    Ok(Case::load(&folder, Preset::Demo, &values)?)
}

/// Runs the case to its end, from the newest checkpoint in the folder if there is one.
pub fn run<F: Fluid>(
    case: &Case,
    coupling: Coupling<F, Structure>,
    folder: &Path,
) -> Result<Simulation<F, Structure, Rows>, Box<dyn Error>> {
    let store = Store::new(folder);
    let checkpoint = match store.newest() {
        Ok(found) => Some(found.checkpoint),
        Err(StoreError::None(_)) => None,
        Err(error) => return Err(error.into()),
    };
    let mut simulation = Simulation::of(case, coupling, Rows::default())
        .with_checkpoints(Checkpoints::of(case, store)?);
    if let Some(checkpoint) = checkpoint {
        simulation.resume(&checkpoint)?;
        simulation.observer.rewind(checkpoint.observer)?;
    }
    simulation.run(&|| false)?;
    Ok(simulation)
}

/// An observer that keeps one row per time step.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Rows {
    /// The rows.
    pub rows: Vec<Row>,
    /// Messages to the user.
    pub notes: Vec<String>,
}

/// The end of a time step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// s
    pub time: f64,
    /// m³/s
    pub inflow: f64,
    /// m³/s
    pub outflow: f64,
    /// Pa
    pub inlet_pressure: f64,
    /// m³
    pub volume: f64,
    /// m
    pub displacement: f64,
}

impl Observer<Structure> for Rows {
    type Memory = Self;

    fn accepted(&mut self, accepted: &AcceptedStep, _: &AcceptedWall<Structure>) -> io::Result<()> {
        let (step, fluid) = (&accepted.step, &accepted.step.fluid);
        self.rows.push(Row {
            time: fluid.time,
            inflow: fluid.inflow(),
            outflow: fluid.outflow(),
            inlet_pressure: fluid.inlet_pressure(),
            volume: fluid.volume,
            displacement: step
                .displacement
                .iter()
                .map(|d| d.norm())
                .fold(0.0, f64::max),
        });
        Ok(())
    }

    fn note(&mut self, note: &Note) {
        let (Note::Rescue(text) | Note::Slow { text, .. } | Note::Notice { text, .. }) = note;
        self.notes.push(text.clone());
    }

    fn memory(&self) -> io::Result<Self> {
        Ok(self.clone())
    }

    fn rewind(&mut self, memory: Self) -> io::Result<()> {
        self.rows = memory.rows;
        Ok(())
    }
}
