//! Ctrl-C, SIGTERM and SIGHUP: the first one ends the run in order, the second one at once. One that is ignored when
//! the program starts, as `nohup` has it with SIGHUP, stays ignored.

use super::Failure;
use crate::output::terminal;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

/// What a run does first when it is asked to end.
pub const CHECKPOINT_IS_WRITTEN: &str =
    "the time step is finished, or given up if it takes long, and a checkpoint written";
/// What it does as long as it has taken no step.
pub const START_IS_ABANDONED: &str = "the start is given up";

/// The signals that end a run.
fn signals() -> Vec<i32> {
    let ignored = ignored_signals();
    let heeded = |signal: &i32| ignored & (1 << (signal - 1)) == 0;
    [SIGINT, SIGTERM, SIGHUP]
        .into_iter()
        .filter(heeded)
        .collect()
}

/// A bit for each signal that this process ignores: handlers that are registered here show none. No signal where the
/// system does not say.
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

/// Whether the user asked the run to end.
#[derive(Debug, Clone)]
pub struct Interrupt {
    asked: Arc<AtomicBool>,
    /// What is done first, to be said when it happens; nothing is printed without.
    then: Arc<Mutex<Option<&'static str>>>,
}

impl Interrupt {
    /// Listens from now on, and then says what is done first, if there is something to say (see also [`Self::then`]).
    /// (When the process ends at once, OpenFOAM ends by itself.)
    pub fn listen(then: Option<&'static str>) -> Result<Self, Failure> {
        Self::register(then).map_err(cannot_listen)
    }

    fn register(then: Option<&'static str>) -> std::io::Result<Self> {
        let flag = Arc::new(AtomicBool::new(false));
        let signals = signals();
        for &signal in &signals {
            // A hangup may come more than once: from a terminal and its shell, each thread of a study that is killed.
            if signal != SIGHUP {
                signal_hook::flag::register_conditional_shutdown(signal, 130, flag.clone())?;
            }
            signal_hook::flag::register(signal, flag.clone())?;
        }
        let mut heard = Signals::new(signals)?;
        let words = Arc::new(Mutex::new(then));
        let said = words.clone();
        std::thread::spawn(move || {
            let signal = heard.forever().next();
            let words = said.lock().ok().and_then(|words| *words);
            if let (Some(_), Some(then)) = (signal, words) {
                terminal::note(format_args!(
                    "\ninterrupted: {then}; a second time ends everything at once"
                ));
            }
        });
        Ok(Self {
            asked: flag,
            then: words,
        })
    }

    /// From now on something else is done first, unless nothing was to be said.
    pub fn then(&self, what: &'static str) {
        if let Ok(mut words) = self.then.lock() {
            *words = words.and(Some(what));
        }
    }

    /// From now on a signal ends the process at once, as one does that has come already.
    pub fn stop_listening(self) -> Result<(), Failure> {
        let always = Arc::new(AtomicBool::new(true));
        for signal in signals() {
            signal_hook::flag::register_conditional_shutdown(signal, 130, always.clone())
                .map_err(cannot_listen)?;
        }
        match self.asked() {
            true => Err(Failure::Interrupted("nothing was written".into())),
            false => Ok(()),
        }
    }

    /// Has it been asked?
    pub fn asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// The flag that ends the wait for a solver that is starting.
    pub fn of_the_start(&self) -> Arc<AtomicBool> {
        self.asked.clone()
    }
}

fn cannot_listen(error: std::io::Error) -> Failure {
    Failure::Run(format!("cannot listen to signals: {error}"))
}
