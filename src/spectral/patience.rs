//! How long a solution is waited for once the run is to end.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// A step that ends within this time is finished; who ends a job sends SIGKILL half a minute after SIGTERM.
const GRACE: Duration = Duration::from_secs(5);

/// Ends a while after an interrupt; without one, never.
#[derive(Debug, Default)]
pub struct Patience {
    interrupt: Arc<AtomicBool>,
    /// When the interrupt was seen first.
    seen: OnceLock<Instant>,
}

impl Patience {
    /// Until some seconds after the flag is set.
    pub fn until(interrupt: Arc<AtomicBool>) -> Self {
        Self {
            interrupt,
            seen: OnceLock::new(),
        }
    }

    /// Whether it is over; to be asked often.
    pub fn is_over(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
            && self.seen.get_or_init(Instant::now).elapsed() > GRACE
    }
}
