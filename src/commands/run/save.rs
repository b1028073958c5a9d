//! Checkpoints of a run: written, found, compared with the case, gone back to.

use super::assemble::Run;
use super::{run_failure, written};
use crate::case::Case;
use crate::checkpoint::{Checkpoint, Found, Mark, StoreError};
use crate::commands::Failure;
use crate::commands::run_folder::RunFolder;
use crate::fluid::{Fluid, FluidMemory};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::Path;
use std::time::Instant;

/// Keys (or tables) that may change when a run is resumed: they have no influence on the steps that were done, or,
/// like the files, are compared by their content.
const MAY_CHANGE: &[&str] = &[
    "time.end_s",
    "time.max_halvings",
    "output.structure_interval_s",
    "output.fluid_interval_s",
    "output.checkpoint_interval_min",
    "output.window_start_s",
    "output.window_end_s",
    "fluid.answer_limit_s",
    "fluid.transport",
    "fluid.templates",
    "inflow.file",
    "coupling.max_iterations",
    "structure.newton_max_iterations",
];

impl Run {
    /// Whether the last accepted step is in a checkpoint.
    pub fn is_saved(&self) -> bool {
        let step = self.record.totals.steps;
        self.cadence.done() == 0 && self.folder.checkpoints().path(step).exists()
    }

    /// Writes a checkpoint of the last accepted step, whose fields OpenFOAM has written, and removes what nobody needs
    /// any more.
    pub fn save(&mut self) -> Result<(), Failure> {
        let clock = Instant::now();
        let failed = |what: &dyn std::fmt::Display| {
            Failure::Run(format!("cannot write a checkpoint: {what}"))
        };
        let fluid = self.coupling.fluid.memory().map_err(|e| failed(&e))?;
        let checkpoint = self.checkpoint(fluid).map_err(|e| failed(&e))?;
        let kept = self
            .folder
            .checkpoints()
            .write(&checkpoint)
            .map_err(|e| failed(&e))?;
        let (time_step, interval) = (self.case.time.step, self.case.output.fluid_interval);
        let wanted = |time: f64| {
            let step = (time / time_step).round() as usize;
            step == 0 || kept.contains(&step) || super::advance::is_due(step, time_step, interval)
        };
        let done = checkpoint.time() + 0.5 * time_step;
        (self.coupling.fluid)
            .discard(&|time| time < done && wanted(time))
            .map_err(run_failure)?;
        self.saved = Instant::now();
        self.record.totals.checkpoint_s += clock.elapsed().as_secs_f64();
        Ok(())
    }

    fn checkpoint(&self, mut fluid: FluidMemory) -> io::Result<Checkpoint> {
        let root = self.folder.root();
        let record = self.record.memory()?;
        let mut files = Vec::new();
        for (path, length) in [
            (self.folder.history(), record.history),
            (self.folder.iterations(), record.iterations),
            (self.folder.probes(), record.probes),
            (self.folder.regions(), record.wall.regions),
            (self.folder.wall_history(), record.wall.history),
        ] {
            if length == 0 {
                continue;
            }
            files.push(Mark::of(root, below(root, &path), Some(length))?);
        }
        for file in &mut fluid.files {
            *file = below(root, file).to_owned();
            files.push(Mark::of(root, file, None)?);
        }
        Ok(Checkpoint {
            case: self.case.to_toml_string(),
            inputs: inputs(&self.case)?,
            files,
            fluid,
            coupling: self.coupling.memory(),
            structure: self.coupling.solid.memory(),
            cadence: self.cadence,
            record,
        })
    }

    /// Gives fluid, wall and coupling the state of a checkpoint.
    pub fn recall(&mut self, checkpoint: &Checkpoint) -> Result<(), Failure> {
        let mut fluid = checkpoint.fluid.clone();
        for file in &mut fluid.files {
            *file = self.folder.root().join(&*file);
        }
        self.coupling.fluid.recall(&fluid).map_err(run_failure)?;
        self.cadence = checkpoint.cadence;
        // Before the coupling remembers: another length makes it forget.
        self.coupling
            .set_time_step(self.case.time.step / self.cadence.parts() as f64);
        self.coupling
            .recall(checkpoint.coupling.clone())
            .map_err(run_failure)?;
        self.coupling
            .solid
            .recall(checkpoint.structure.clone())
            .map_err(run_failure)
    }

    /// Goes back to a checkpoint of this run.
    pub fn go_back(&mut self, checkpoint: &Checkpoint) -> Result<(), Failure> {
        self.recall(checkpoint)?;
        self.record
            .rewind(checkpoint.record.clone())
            .map_err(written)
    }
}

/// The newest whole checkpoint in a folder; none if the run had not begun.
pub fn find(folder: &RunFolder) -> Result<Option<Found>, Failure> {
    match folder.checkpoints().newest() {
        Ok(found) => Ok(Some(found)),
        Err(StoreError::None(_)) if fs::metadata(folder.history()).map_or(0, |f| f.len()) == 0 => {
            Ok(None)
        }
        Err(error) => Err(Failure::Input(format!(
            "{error}\nThe run cannot be resumed; start it again with --force."
        ))),
    }
}

/// Refuses to resume another case than that of the checkpoint.
pub fn compare(checkpoint: &Checkpoint, case: &Case) -> Result<(), Failure> {
    let mut changed = changed_keys(&checkpoint.case, &case.to_toml_string(), MAY_CHANGE);
    let now = inputs(case).map_err(|e| Failure::Input(format!("cannot read the case: {e}")))?;
    let paths = |marks: &[Mark]| -> BTreeSet<String> {
        marks.iter().map(|mark| mark.path.clone()).collect()
    };
    for path in paths(&checkpoint.inputs).union(&paths(&now)) {
        let find = |marks: &[Mark]| marks.iter().find(|mark| mark.path == *path).cloned();
        if find(&checkpoint.inputs) != find(&now) {
            changed.push(format!("the content of {path}"));
        }
    }
    if changed.is_empty() {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "the case is not the one that is to be resumed; give the same --preset and --set, or start again with --force. Changed:\n  {}",
        changed.join("\n  ")
    )))
}

/// Keys with different values, with both, except for those (or whole tables) that may change.
pub fn changed_keys(before: &str, now: &str, may_change: &[&str]) -> Vec<String> {
    let read = |text: &str| toml::from_str::<toml::Table>(text).unwrap_or_default();
    let mut changed = Vec::new();
    compare_tables(&read(before), &read(now), "", may_change, &mut changed);
    changed
}

fn compare_tables(
    before: &toml::Table,
    now: &toml::Table,
    above: &str,
    may_change: &[&str],
    changed: &mut Vec<String>,
) {
    let names: BTreeSet<&String> = before.keys().chain(now.keys()).collect();
    for name in names {
        let key = format!("{above}{name}");
        if may_change.contains(&key.as_str()) {
            continue;
        }
        match (before.get(name), now.get(name)) {
            (Some(toml::Value::Table(before)), Some(toml::Value::Table(now))) => {
                compare_tables(before, now, &format!("{key}."), may_change, changed);
            }
            (before, now) if before != now => {
                let shown = |value: Option<&toml::Value>| {
                    value.map_or("absent".into(), ToString::to_string)
                };
                changed.push(format!(
                    "{key}: {} in the run, {} now",
                    shown(before),
                    shown(now)
                ));
            }
            _ => {}
        }
    }
}

/// The files that a case names.
fn inputs(case: &Case) -> io::Result<Vec<Mark>> {
    let mut marks = Vec::new();
    let templates = &case.fluid.templates;
    let mut folders = vec![templates.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let mut mark = Mark::of(templates, below(templates, &path), None)?;
                mark.path = format!("fluid.templates/{}", mark.path);
                marks.push(mark);
            }
        }
    }
    if let Some(file) = &case.inflow.file {
        let mut mark = Mark::of(Path::new(""), file, None)?;
        mark.path = "inflow.file".into();
        marks.push(mark);
    }
    marks.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(marks)
}

fn below<'a>(root: &Path, path: &'a Path) -> &'a Path {
    path.strip_prefix(root).unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::{MAY_CHANGE, changed_keys};

    #[test]
    fn changed_keys_are_named_with_both_values_unless_they_may_change() {
        let before = "[time]\nstep_s = 0.002\nend_s = 1.0\n[output]\nfluid_interval_s = 1\n[wall.media]\nk2 = 3.5\n";
        let now = "[time]\nstep_s = 0.001\nend_s = 2.0\n[output]\nfluid_interval_s = 2\n[wall.media]\nk1 = 2.0\n";
        assert_eq!(
            changed_keys(before, now, MAY_CHANGE),
            [
                "time.step_s: 0.002 in the run, 0.001 now",
                "wall.media.k1: absent in the run, 2.0 now",
                "wall.media.k2: 3.5 in the run, absent now",
            ]
        );
        assert_eq!(changed_keys(before, before, &[]), Vec::<String>::new());
    }
}
