//! A process of another program: started with a log, watched, ended, never orphaned.

use rustix::process::{
    Pid, Signal, getpid, getppid, kill_process, kill_process_group, set_parent_process_death_signal,
};
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Lines of the log that an error shows.
const TAIL_LINES: usize = 12;
/// Time between SIGTERM and SIGKILL.
const TERM_LIMIT: Duration = Duration::from_secs(3);

/// A running solver.
pub struct Process {
    child: Child,
    log: PathBuf,
    status: Option<ExitStatus>,
}

impl Process {
    /// Starts `command` with its output at the end of the file `log`.
    ///
    /// The process has a group of its own, so that Ctrl-C in a terminal reaches the driver only, which then ends the
    /// solver in order. Should the driver be killed, the kernel ends the solver: it sends `death_signal` when the
    /// *thread* that called this function ends, so call it from one that lives as long as the run.
    pub fn start(mut command: Command, log: &Path, death_signal: Signal) -> io::Result<Self> {
        let output = File::options().create(true).append(true).open(log);
        let output =
            output.map_err(|e| io::Error::new(e.kind(), format!("{}: {e}", log.display())))?;
        command
            .stdin(Stdio::null())
            .stdout(output.try_clone()?)
            .stderr(output)
            .process_group(0);
        die_with_parent(&mut command, death_signal);
        let child = command.spawn()?;
        Ok(Self {
            child,
            log: log.to_owned(),
            status: None,
        })
    }

    /// Number of the process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Has it ended?
    pub fn has_ended(&mut self) -> bool {
        if self.status.is_none() {
            self.status = self.child.try_wait().ok().flatten();
        }
        self.status.is_some()
    }

    /// Waits until it has ended, but not longer than `limit`.
    pub fn wait(&mut self, limit: Duration) -> bool {
        let since = Instant::now();
        while !self.has_ended() {
            if since.elapsed() > limit {
                return false;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        true
    }

    /// Ends it: waits for `grace`, then SIGTERM, at last SIGKILL, to all of its group: it may be a script around the
    /// solver.
    pub fn end(&mut self, grace: Duration) {
        if self.wait(grace) {
            return;
        }
        // Not yet waited for, so the number is still this child's.
        let pid = Pid::from_child(&self.child);
        let _ = kill_process_group(pid, Signal::TERM);
        if !self.wait(TERM_LIMIT) {
            let _ = kill_process_group(pid, Signal::KILL);
            self.status = self.child.wait().ok();
        }
    }

    /// Has it ended, and well?
    pub fn succeeded(&mut self) -> bool {
        self.has_ended() && self.status.is_some_and(|status| status.success())
    }

    /// Has it ended because a number overflowed? `mpirun` says so of its ranks by its exit code.
    pub fn died_of_arithmetic(&mut self) -> bool {
        let fpe = Signal::FPE.as_raw();
        let status = self.has_ended().then_some(self.status).flatten();
        status
            .is_some_and(|status| status.signal() == Some(fpe) || status.code() == Some(128 + fpe))
    }

    /// Its exit code, if it has ended with one.
    pub fn exit_code(&mut self) -> Option<i32> {
        self.has_ended().then_some(self.status).flatten()?.code()
    }

    /// Sends it a signal, if it has not ended.
    pub fn signal(&mut self, signal: Signal) {
        if !self.has_ended() {
            // Not yet waited for, so the number is still this child's.
            let _ = kill_process(Pid::from_child(&self.child), signal);
        }
    }

    /// The last lines of its log.
    pub fn last_lines(&self) -> String {
        tail(&self.log)
    }

    /// How it ended and the last lines that it printed, for an error.
    pub fn exit_report(&mut self) -> String {
        let end = match self.has_ended().then_some(self.status).flatten() {
            Some(status) => format!("it ended with {status}"),
            None => "it is still running".to_owned(),
        };
        format!(
            "{end}; the last lines of {}:\n{}",
            self.log.display(),
            tail(&self.log)
        )
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.end(Duration::ZERO);
    }
}

/// The child dies with the calling thread, even if it was killed before the child could ask for that.
#[allow(unsafe_code)]
fn die_with_parent(command: &mut Command, signal: Signal) {
    let parent = getpid();
    let ask = move || {
        set_parent_process_death_signal(Some(signal))?;
        if getppid() == Some(parent) {
            Ok(())
        } else {
            Err(io::Error::other("the driver has ended"))
        }
    };
    // SAFETY: between fork and exec, `ask` makes two system calls; it neither allocates nor takes a lock. (An error is
    // allocated only when the driver is dead already and the child is about to end.)
    unsafe {
        command.pre_exec(ask);
    }
}

/// The last lines of a file, indented.
pub fn tail(path: &Path) -> String {
    let read = || -> io::Result<String> {
        let mut file = File::open(path)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(4096)))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    };
    let text = read().unwrap_or_else(|error| error.to_string());
    let lines: Vec<_> = text
        .lines()
        .filter(|line| !line.trim().is_empty())
        .collect();
    let last = &lines[lines.len().saturating_sub(TAIL_LINES)..];
    last.iter().map(|line| format!("    {line}\n")).collect()
}
