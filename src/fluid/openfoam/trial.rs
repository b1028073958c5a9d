//! OpenFOAM started for trial, to know whether it takes the templates.

use super::prepared::Prepared;
use super::probes::Sampling;
use super::{OpenFoam, OpenFoamSettings};
use crate::Vec3;
use crate::case::TransportKind;
use crate::fluid::conversation::session::Terms;
use crate::fluid::{Fluid, FluidEffort, FluidError, Wanted};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// With these words OpenFOAM complains of what it reads; other errors may be of the moment.
const REFUSAL: &str = "FOAM FATAL IO ERROR";
/// Most letters of a complaint: OpenFOAM lists all types that it has.
const MOST_LETTERS: usize = 600;

/// Starts OpenFOAM in a folder that is gone afterwards, on one rank, and has it begin the first step with the wall at
/// rest; where points in the blood are watched, it finishes the step and reports them. `interrupt` ends the trial when
/// set.
///
/// # Errors
/// [`FluidError::Interrupted`], or why OpenFOAM could not be started, or what it refused to read, with the file of the
/// templates and the line.
pub fn start(
    prepared: &Prepared<'_>,
    sampling: Sampling,
    interrupt: Arc<AtomicBool>,
) -> Result<(), FluidError> {
    let failed = |error: std::io::Error| FluidError::Died(error.to_string());
    let folder = tempfile::Builder::new().prefix("fsi-trial-").tempdir();
    let folder = folder.map_err(|e| FluidError::Died(format!("no folder for a trial: {e}")))?;
    // As OpenFOAM will name it.
    let root = folder.path().canonicalize().map_err(failed)?;
    let (case, log) = (root.join("openfoam"), root.join("openfoam.log"));
    let prepared = prepared.clone().on_one_rank();
    (prepared.write(&case)).map_err(|e| FluidError::Died(e.to_string()))?;
    let time_step = prepared.time_step();
    let watched = !sampling.points.is_empty();
    let started = OpenFoam::start(OpenFoamSettings {
        case: case.clone(),
        log: log.clone(),
        ranks: 1,
        transport: TransportKind::Socket,
        answer_limit: Duration::from_secs(300),
        terms: Terms {
            start_time: 0.0,
            time_step,
            interface: None,
        },
        sampling,
        interrupt,
    });
    let complaint = || complaint(&log, &case, prepared.folder()).map(FluidError::Died);
    let mut fluid = started.map_err(|error| match error {
        FluidError::Interrupted => error,
        _ => complaint().unwrap_or(error),
    })?;
    // Schemes and solvers are read when they are needed.
    let rest = vec![Vec3::zeros(); fluid.interface().points.len()];
    let effort = FluidEffort {
        max_sweeps: 1,
        residual: 1.0,
        from_old_state: false,
    };
    match fluid.solve(&rest, time_step, effort) {
        Err(FluidError::Interrupted) => Err(FluidError::Interrupted),
        // A step that fails otherwise is tried again with more care in a run.
        Err(_) => complaint().map_or(Ok(()), Err),
        Ok(_) if watched => match fluid.accept(Wanted::default()) {
            Err(FluidError::Storage(said)) => Err(FluidError::Storage(
                said.replace(&*root.to_string_lossy(), "a trial's folder"),
            )),
            Err(FluidError::Interrupted) => Err(FluidError::Interrupted),
            Err(_) => complaint().map_or(Ok(()), Err),
            Ok(_) => Ok(()),
        },
        Ok(_) => Ok(()),
    }
}

/// What OpenFOAM refuses to read, in one line, with the paths of the templates.
fn complaint(log: &Path, case: &Path, templates: &Path) -> Option<String> {
    let log = std::fs::read(log).ok()?;
    let log = String::from_utf8_lossy(&log);
    let (_, text) = log.split_once(REFUSAL)?;
    let lines: Vec<&str> = text
        .lines()
        .take_while(|line| !line.starts_with("    From") && !line.starts_with("FOAM exiting"))
        .collect();
    // The place follows a list of all types that there are, which is cut off.
    let (place, words): (Vec<&str>, Vec<&str>) = lines
        .into_iter()
        .partition(|line| line.starts_with("file: "));
    let words = place.into_iter().map(|line| &line[6..]).chain(words);
    let words: Vec<&str> = words.flat_map(str::split_whitespace).collect();
    let said = words
        .join(" ")
        .replace(&*case.to_string_lossy(), &templates.display().to_string());
    let said = said.trim_start_matches([':', ' ']);
    let mut short: String = said.chars().take(MOST_LETTERS).collect();
    if short.len() < said.len() {
        short.push('…');
    }
    Some(short)
}
