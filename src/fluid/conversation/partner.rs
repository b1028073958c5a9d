//! A flow solver in a process of its own and the conversation with it: started, waited for, asked, ended, never
//! orphaned.

use super::session::{Session, Terms};
use super::transport::{Listener, Patience, TransportError};
use crate::Vec3;
use crate::fluid::{FluidCost, FluidEffort, FluidError, FluidTrial, FluidUsage, require_finite};
use crate::processes::{self, Process};
use rustix::process::Signal;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Starting may take longer than an answer: a solver reads and checks its mesh.
const START_LIMIT: Duration = Duration::from_secs(120);
/// An answer may take this many times as long as the longest so far.
const ANSWER_GROWTH: u32 = 50;
/// Time for the solver to end by itself after STOP.
const STOP_GRACE: Duration = Duration::from_secs(5);

/// How to begin a conversation.
pub(crate) struct Beginning<'a> {
    /// What messages call the solver.
    pub name: &'a str,
    /// Where it will call.
    pub listener: Listener,
    /// What it must confirm.
    pub terms: &'a Terms,
    /// The state that it is to take up; empty for the one that it starts in.
    pub state: &'a [u8],
    /// Longest time to wait for an answer, unless one has taken more than a fiftieth of it already.
    pub answer_limit: Duration,
    /// Ends every wait when set.
    pub interrupt: &'a Arc<AtomicBool>,
}

/// A solver at the other end of a connection. When the value is dropped, it has ended, if it was started from here.
pub(crate) struct Partner {
    name: String,
    answer_limit: Duration,
    interrupt: Arc<AtomicBool>,
    /// The longest that an answer has taken.
    longest: Duration,
    /// Whether it was given something to solve.
    is_at_work: bool,
    /// Whether it was told to go.
    is_over: bool,
    // Dropped in this order: the connection is closed before the process is ended for good.
    session: Session,
    /// None if it was not started by the driver.
    process: Option<Process>,
    /// CPU time that the process took to start, s.
    start_seconds: f64,
}

impl Partner {
    /// Starts the solver by `command`, with what it says in `log`, and shakes hands with it. Call it from a thread that
    /// lives as long as the run.
    ///
    /// # Errors
    /// If it cannot be started, ends, does not call or is not the one that was expected.
    pub fn start(
        beginning: Beginning<'_>,
        command: Command,
        death_signal: Signal,
        log: &Path,
    ) -> Result<Self, FluidError> {
        let program = PathBuf::from(command.get_program());
        let process = Process::start(command, log, death_signal).map_err(|error| {
            FluidError::Died(format!("cannot start {}: {error}", program.display()))
        })?;
        let limit = beginning.answer_limit.max(START_LIMIT);
        Self::meet(beginning, Some(process), limit)
    }

    /// Waits for a solver that is started separately, as long as it takes, and shakes hands with it.
    ///
    /// # Errors
    /// If it is not the one that was expected, or the wait was ended.
    pub fn wait_for(beginning: Beginning<'_>) -> Result<Self, FluidError> {
        Self::meet(beginning, None, Duration::MAX)
    }

    fn meet(
        beginning: Beginning<'_>,
        mut process: Option<Process>,
        limit: Duration,
    ) -> Result<Self, FluidError> {
        let Beginning {
            name,
            listener,
            terms,
            state,
            answer_limit,
            interrupt,
        } = beginning;
        let mut ended = || process.as_mut().is_some_and(Process::has_ended);
        let mut patience = Patience::new(limit, interrupt, &mut ended);
        let session = listener
            .accept(&mut patience)
            .and_then(|transport| Session::shake_hands(transport, terms, state, &mut patience));
        match session {
            Ok(session) => Ok(Self {
                name: name.to_owned(),
                answer_limit,
                interrupt: interrupt.clone(),
                longest: Duration::ZERO,
                is_at_work: false,
                is_over: false,
                session,
                start_seconds: (process.as_ref())
                    .map_or(0.0, |process| processes::cpu_seconds(process.id())),
                process,
            }),
            Err(error) => Err(explain(name, error, process.as_mut())),
        }
    }

    /// What is known from the handshake.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// From now on answers are waited for whatever happens to the interrupt.
    pub fn outlast_interrupts(&mut self) {
        self.interrupt = Arc::default();
    }

    /// One exchange.
    ///
    /// # Errors
    /// If there was no answer, or not the one that was expected: the solver is lost.
    pub fn talk<T>(
        &mut self,
        exchange: impl FnOnce(&mut Session, &mut Patience) -> Result<T, TransportError>,
    ) -> Result<T, FluidError> {
        let process = &mut self.process;
        let mut ended = || process.as_mut().is_some_and(Process::has_ended);
        let limit = self.answer_limit.max(self.longest * ANSWER_GROWTH);
        let mut patience = Patience::new(limit, &self.interrupt, &mut ended);
        let asked = Instant::now();
        let answer = exchange(&mut self.session, &mut patience)
            .map_err(|error| explain(&self.name, error, self.process.as_mut()))?;
        self.longest = self.longest.max(asked.elapsed());
        Ok(answer)
    }

    /// Asks for the answer to a trial displacement: [`Fluid::solve`](crate::fluid::Fluid::solve).
    ///
    /// # Errors
    /// As [`Partner::talk`]; a displacement that is not finite is not sent.
    pub fn solve(
        &mut self,
        displacement: &[Vec3],
        time_step: f64,
        effort: FluidEffort,
    ) -> Result<FluidTrial, FluidError> {
        require_finite(displacement)?;
        self.is_at_work = true;
        let solved = self
            .talk(|session, patience| session.solve(displacement, time_step, effort, patience))?;
        Ok(FluidTrial {
            tractions: solved.tractions,
            cost: FluidCost {
                sweeps: solved.correctors,
                residual: solved.pressure_residual,
            },
        })
    }

    /// Whether it was given something to solve.
    pub fn is_at_work(&self) -> bool {
        self.is_at_work
    }

    /// Number of the process, if it was started from here.
    pub fn process_id(&self) -> Option<u32> {
        self.process.as_ref().map(Process::id)
    }

    /// Whether the process is known to have ended.
    pub fn has_ended(&mut self) -> bool {
        self.process.as_mut().is_some_and(Process::has_ended)
    }

    /// Ends the process now, or asks the solver to go if the driver did not start it.
    pub fn end_now(&mut self) {
        match &mut self.process {
            Some(process) => process.end(Duration::ZERO),
            None => drop(self.say_goodbye()),
        }
    }

    /// Sends STOP and waits for the end of the process; what was found of it.
    pub fn end(&mut self, limit: Duration) -> Result<String, String> {
        self.say_goodbye().map_err(|error| error.to_string())?;
        match self.ended_within(limit)? {
            Some(0) => Ok(String::new()),
            code => Err(how(code)),
        }
    }

    /// Does something to the solver after which it must end, with an exit code that is not 0.
    pub fn inject_fault(
        &mut self,
        fault: impl FnOnce(&mut Session, &mut Patience) -> Result<(), TransportError>,
        limit: Duration,
    ) -> Result<String, String> {
        self.is_over = true;
        self.talk(fault).map_err(|error| error.to_string())?;
        match self.ended_within(limit)? {
            Some(code) if code != 0 => Ok(how(Some(code))),
            code => Err(how(code)),
        }
    }

    /// The exit code of the process; none if a signal ended it.
    fn ended_within(&mut self, limit: Duration) -> Result<Option<i32>, String> {
        let process = (self.process.as_mut()).ok_or("it was not started from here")?;
        match process.wait(limit) {
            true => Ok(process.exit_code()),
            false => Err(format!("it is still there after {} s", limit.as_secs())),
        }
    }

    /// Sends STOP, once.
    fn say_goodbye(&mut self) -> Result<(), TransportError> {
        if std::mem::replace(&mut self.is_over, true) {
            return Ok(());
        }
        // The interrupt that may have ended the run must not end this shutdown.
        let interrupt = AtomicBool::new(false);
        let process = &mut self.process;
        let mut ended = || process.as_mut().is_some_and(Process::has_ended);
        let limit = Duration::from_secs(1);
        let mut patience = Patience::new(limit, &interrupt, &mut ended);
        self.session.stop(&mut patience)
    }

    /// What the process has used.
    pub fn usage(&self) -> FluidUsage {
        self.process_id()
            .map_or_else(FluidUsage::default, |process| FluidUsage {
                cpu_seconds: processes::cpu_seconds(process) - self.start_seconds,
                peak_memory: processes::peak_memory_of_all(process),
            })
    }
}

impl Drop for Partner {
    fn drop(&mut self) {
        if self.has_ended() {
            return; // and another one may be talking over the same files
        }
        let asked = self.say_goodbye();
        // A solver that is amid a long solution does not hear: do not wait for it after an interrupt.
        let grace = if asked.is_err() || self.interrupt.load(Ordering::Relaxed) {
            Duration::from_millis(500)
        } else {
            STOP_GRACE
        };
        if let Some(process) = &mut self.process {
            process.end(grace);
        }
    }
}

fn how(code: Option<i32>) -> String {
    match code {
        Some(code) => format!("exit code {code}"),
        None => "ended by a signal".into(),
    }
}

/// What happened, how the process ended, and the last lines that it printed.
fn explain(name: &str, error: TransportError, process: Option<&mut Process>) -> FluidError {
    if matches!(error, TransportError::Interrupted) {
        return FluidError::Interrupted;
    }
    let Some(process) = process else {
        return FluidError::Died(format!("{name}: {error}"));
    };
    if !matches!(error, TransportError::TimedOut(_)) {
        // A connection that breaks is the first sign of a death; how it came is known a moment later.
        process.wait(Duration::from_secs(2));
    }
    match process.died_of_arithmetic() {
        true => FluidError::Diverged(format!(
            "{name}: the flow diverged until a number overflowed; {}",
            process.exit_report()
        )),
        false => FluidError::Died(format!("{name}: {error}; {}", process.exit_report())),
    }
}
