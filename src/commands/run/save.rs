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
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Keys (or tables) that may change when a run is resumed: they have no influence on the steps that were done, or,
/// like the files, are compared by their content.
const MAY_CHANGE: &[&str] = &[
    "time.end_s",
    "time.max_halvings",
    "output.title",
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
            (self.folder.fluid_probes(), record.fluid_probes),
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
        Err(error) => {
            let state = folder.checkpoints().newest_without(&table_names(folder));
            Err(Failure::Input(match state {
                Ok(_) => format!(
                    "{error}\nRestore such a file from a copy, or go on without its rows until now: --resume --new-tables sets it aside and begins it anew."
                ),
                Err(_) => {
                    format!("{error}\nThe run cannot be resumed; start it again with --force.")
                }
            }))
        }
    }
}

/// Sets tables that are missing, or not what they were at the `checkpoint`, aside and says what is wrong with each; the
/// checkpoint then knows none of their rows.
pub fn without_tables(
    folder: &RunFolder,
    mut checkpoint: Checkpoint,
) -> Result<(Checkpoint, Vec<String>), Failure> {
    let root = folder.root();
    let (mut lost, record) = (Vec::new(), &mut checkpoint.record);
    for (path, length) in [
        (folder.history(), &mut record.history),
        (folder.iterations(), &mut record.iterations),
        (folder.probes(), &mut record.probes),
        (folder.fluid_probes(), &mut record.fluid_probes),
        (folder.regions(), &mut record.wall.regions),
        (folder.wall_history(), &mut record.wall.history),
    ] {
        let name = below(root, &path).display().to_string();
        let mut marks = checkpoint.files.iter().filter(|mark| mark.path == name);
        let Some(flaw) = marks.find_map(|mark| mark.check(root).err()) else {
            continue;
        };
        set_aside(&path).map_err(|e| Failure::Input(format!("cannot rename {name}: {e}")))?;
        lost.push(flaw.to_string());
        *length = 0;
    }
    Ok((checkpoint, lost))
}

/// Renames a file, if it is there, to a name that is free.
fn set_aside(path: &Path) -> io::Result<()> {
    let name = |n: usize| PathBuf::from(format!("{}.damaged-{n}", path.display()));
    let free = (1..).map(name).find(|name| !name.exists());
    match fs::rename(path, free.expect("some number is free")) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        renamed => renamed,
    }
}

/// The files of a run that grow by rows: results, without which a state is whole.
pub fn table_names(folder: &RunFolder) -> Vec<String> {
    let tables = [
        folder.history(),
        folder.iterations(),
        folder.probes(),
        folder.fluid_probes(),
        folder.regions(),
        folder.wall_history(),
    ];
    let names = tables.iter().map(|path| below(folder.root(), path));
    names.map(|name| name.display().to_string()).collect()
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
