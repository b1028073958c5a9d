//! Who wants to hear what is being prepared before the first step, and how far it is: that takes up to minutes, in
//! whatever a command asks for.

use std::sync::OnceLock;

/// Is told what is being done, and the share of it that is done, if that is known; with the share 1 it has ended.
pub type Listener = fn(&'static str, Option<f64>);

static LISTENER: OnceLock<Listener> = OnceLock::new();

/// From now on this one listens, for the whole process; the first one stays.
pub fn listen(listener: Listener) {
    let _ = LISTENER.set(listener);
}

/// The share of something that is done.
pub fn tell(what: &'static str, share: f64) {
    hear(what, Some(share));
}

fn hear(what: &'static str, share: Option<f64>) {
    if let Some(listener) = LISTENER.get() {
        listener(what, share);
    }
}

/// Work of unknown length, which ends when this is dropped.
#[must_use]
pub struct Work(&'static str);

impl Work {
    /// It begins.
    pub fn begin(what: &'static str) -> Self {
        hear(what, None);
        Self(what)
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        tell(self.0, 1.0);
    }
}
