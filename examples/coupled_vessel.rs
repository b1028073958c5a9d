//! A coupled run from a Rust program: `cargo run --release --example coupled_vessel [FOLDER]`.
//!
//! Two time steps of the case S-0.25 on a small mesh, with OpenFOAM for the blood. The folder then holds what
//! `fsi-driver --case openfoam-case/S-0.25` would leave in it, but for the evaluation at the end.

use fsi_driver::case::{Case, Preset, RunEnds};
use fsi_driver::output::progress::Progress;
use fsi_driver::output::record::{Record, RecordSettings};
use fsi_driver::output::run_files::RunFiles;
use fsi_driver::simulation::assembly::CoupledModel;
use fsi_driver::simulation::{Checkpoints, Simulation};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1);
    let folder = folder.map_or_else(|| "coupled-vessel".into(), PathBuf::from);
    run(folder)
}

fn run(folder: PathBuf) -> Result<(), Box<dyn Error>> {
    let small = [
        ("time.end_s", "0.004"),
        ("structure.axial_per_section", "2"),
        ("fluid.mesh.axial_extension", "4"),
        ("fluid.mesh.axial_per_section", "6"),
    ];
    let small = small.map(|(key, value)| (key.into(), value.into()));
    let sources = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    std::fs::create_dir_all(&folder)?;
    let files = RunFiles::new(&folder);

    let case = Case::load(&sources.join("openfoam-case/S-0.25"), Preset::Demo, &small)?;
    let model = CoupledModel::new(&case, files.workplace(), None)?;
    let settings = RecordSettings::of(&case, &files, &model);
    let record = Record::create(settings, &model.coupling.solid)?;
    let progress = Progress::new(RunEnds::of(&case), false);
    let mut simulation = Simulation::of(&case, model.coupling, (record, progress))
        .with_checkpoints(Checkpoints::of(&case, files.checkpoints())?);
    simulation.run(&|| false)?;

    let totals = simulation.totals();
    let (time, pressure) = (totals.time_s, totals.p_out_Pa);
    println!("t = {time} s: {pressure:.1} Pa at the outlet");
    Ok(())
}
