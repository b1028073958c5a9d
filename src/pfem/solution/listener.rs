//! Who wants to hear how far statics have come: they take up to minutes, in whatever a command asks for.

use std::sync::OnceLock;

/// Is told what is being solved, and the share of it that is done.
pub type Listener = fn(&'static str, f64);

static LISTENER: OnceLock<Listener> = OnceLock::new();

/// From now on this one listens, for the whole process; the first one stays.
pub fn listen(listener: Listener) {
    let _ = LISTENER.set(listener);
}

pub(super) fn tell(what: &'static str, share: f64) {
    if let Some(listener) = LISTENER.get() {
        listener(what, share);
    }
}
