//! A model at work: a run in a process of its own.

use super::models::{BatchRun, Outcome};
use crate::processes::Process;
use crate::run::CaseSelection;
use crate::run::status::RunStatus;
use rustix::process::Signal;
use std::io;
use std::process::Command;
use std::time::Duration;

/// A run in a process of its own, which ends when this one does.
pub struct Worker {
    process: Process,
    log: std::path::PathBuf,
    asked_to_end: bool,
}

impl Worker {
    /// Starts or resumes the run of a model. Call it from a thread that lives as long as the study.
    ///
    /// # Errors
    /// If this program is not found, or the process or its log cannot be made.
    pub fn start(model: &BatchRun, chosen: &CaseSelection, threads: usize) -> io::Result<Self> {
        let mut command = Command::new(std::env::current_exe()?);
        command
            .arg("--case")
            .arg(&model.folder)
            .arg("--out")
            .arg(&model.out)
            .args(chosen.to_arguments());
        if model.status != RunStatus::Absent {
            command.arg("--resume");
        }
        if std::env::var_os("RAYON_NUM_THREADS").is_none() {
            command.env("RAYON_NUM_THREADS", threads.to_string());
        }
        let log = model.log();
        // Should this process be killed, the run ends in order by itself. The kernel then sends the signal once for
        // each thread of this process, and a second SIGTERM would end the run at once.
        let process = Process::start(command, &log, Signal::HUP)?;
        Ok(Self {
            process,
            log,
            asked_to_end: false,
        })
    }

    /// Asks it to write a checkpoint and end.
    pub fn interrupt(&mut self) {
        if !std::mem::replace(&mut self.asked_to_end, true) {
            self.process.signal(Signal::TERM);
        }
    }

    /// What became of it.
    pub fn outcome(&mut self) -> Outcome {
        if !self.process.has_ended() {
            return Outcome::Working;
        }
        match self.process.exit_code() {
            Some(0) => Outcome::Done,
            Some(130) => Outcome::Interrupted,
            // It may have been asked before it could listen.
            None if self.asked_to_end => Outcome::Interrupted,
            _ => Outcome::Failed(format!(
                "see {}\n{}",
                self.log.display(),
                self.process.last_lines()
            )),
        }
    }
}

impl Drop for Worker {
    /// Waits for its checkpoint.
    fn drop(&mut self) {
        if !self.process.has_ended() {
            self.interrupt();
            while !self.process.wait(Duration::from_secs(1)) {}
        }
    }
}
