//! The conversation with a flow solver in a separate process: `of-adapter/PROTOCOL.md`.
//!
//! [`protocol`] knows the messages, [`transport`] carries them, [`session`] knows what may be said when, and
//! [`partner`] is a session together with the process at its other end.

pub mod conformance;
pub(crate) mod partner;
pub mod protocol;
pub mod session;
pub mod transport;
