//! Ctrl-C, SIGTERM and SIGHUP: the first one ends the run in order, the second one at once.

use super::Failure;
use crate::output::terminal;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::iterator::Signals;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a run does first when it is asked to end.
pub const A_RUN_IS_SAVED: &str = "the time step is finished and a checkpoint written";

const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];

/// Whether somebody asked the run to end.
#[derive(Debug, Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on, and then says what is done first, if there is something to say. (When the process ends at
    /// once, OpenFOAM ends by itself.)
    pub fn listen(then: Option<&'static str>) -> Result<Self, Failure> {
        Self::register(then).map_err(cannot_listen)
    }

    fn register(then: Option<&'static str>) -> std::io::Result<Self> {
        let flag = Arc::new(AtomicBool::new(false));
        for signal in SIGNALS {
            // Who hangs up may do so more than once: a terminal and its shell, each thread of a study that is killed.
            if signal != SIGHUP {
                signal_hook::flag::register_conditional_shutdown(signal, 130, flag.clone())?;
            }
            signal_hook::flag::register(signal, flag.clone())?;
        }
        let mut heard = Signals::new(SIGNALS)?;
        std::thread::spawn(move || {
            if let (Some(_), Some(then)) = (heard.forever().next(), then) {
                terminal::note(format_args!(
                    "\ninterrupted: {then}; a second time ends everything at once"
                ));
            }
        });
        Ok(Self(flag))
    }

    /// From now on a signal ends the process at once, as one does that has come already.
    pub fn stop_listening(self) -> Result<(), Failure> {
        let always = Arc::new(AtomicBool::new(true));
        for signal in SIGNALS {
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
        self.0.load(Ordering::Relaxed)
    }

    /// The flag that ends the wait for a solver that is starting.
    pub fn of_the_start(&self) -> Arc<AtomicBool> {
        self.0.clone()
    }
}

fn cannot_listen(error: std::io::Error) -> Failure {
    Failure::Run(format!("cannot listen to signals: {error}"))
}
