//! The messages of `of-adapter/PROTOCOL.md` and their bytes.
//!
//! Nothing that was received is trusted: [`WireFrame::decode`] looks at the sixteen bytes before the payload,
//! [`Expected::check`] compares the announced length with the one the message must have in this session, and only then
//! is the payload read and decoded, every number of which must be finite.

pub use from_fluid::{
    Accepted, Expected, FromFluid, Hello, MAX_HELLO, MAX_STATE, OpeningReport, OpeningTerms, Solved,
};
pub use to_fluid::ToFluid;

mod from_fluid;
mod to_fluid;

/// Version of `PROTOCOL.md` that this module implements.
pub const VERSION: u16 = 3;
/// Bytes before the payload.
pub const FRAME_SIZE: usize = 16;
/// Longest text of a FAILURE, bytes.
pub const MAX_FAILURE_TEXT: u64 = 4096;

const MAGIC: [u8; 4] = *b"FSIP";

/// Kinds of messages by their number on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum MessageKind {
    /// Fluid to driver: interface, start time, time step.
    Hello = 1,
    /// Driver to fluid: what it understood of the hello.
    Welcome = 2,
    /// Driver to fluid: trial displacement.
    Solve = 3,
    /// Fluid to driver: tractions of that trial.
    Solved = 4,
    /// Driver to fluid: keep the last trial.
    Accept = 5,
    /// Fluid to driver: report of the finished step.
    Accepted = 6,
    /// Driver to fluid: end.
    Stop = 7,
    /// Either way: why the sender ends.
    Failure = 8,
    /// Driver to fluid: a state that is not needed any more.
    Discard = 9,
}

impl MessageKind {
    fn from_number(number: u16) -> Option<Self> {
        use MessageKind::*;
        [
            Hello, Welcome, Solve, Solved, Accept, Accepted, Stop, Failure, Discard,
        ]
        .into_iter()
        .find(|&kind| kind as u16 == number)
    }
}

impl std::fmt::Display for MessageKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&format!("{self:?}").to_uppercase())
    }
}

/// Why a message was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProtocolError {
    /// Not a message at all.
    #[error("the fluid sent bytes that are not a message")]
    Foreign,
    /// Another version.
    #[error(
        "the fluid speaks protocol version {found}, this driver speaks {VERSION}; build both from the same source (of-adapter/setup.sh)"
    )]
    Version {
        /// The version it speaks.
        found: u16,
    },
    /// A kind that does not exist.
    #[error("the fluid sent a message of unknown kind {0}")]
    UnknownKind(u16),
    /// A kind that does not belong here.
    #[error("expected {expected} from the fluid, found {found}")]
    Unexpected {
        /// What should have come.
        expected: MessageKind,
        /// What came.
        found: MessageKind,
    },
    /// A payload of the wrong length.
    #[error("{kind} of the fluid has {found} bytes, expected {expected}")]
    Length {
        /// The message.
        kind: MessageKind,
        /// Bytes it must have.
        expected: String,
        /// Bytes it announces or has.
        found: u64,
    },
    /// Infinite or not a number.
    #[error("{kind} of the fluid holds a {what} that is not finite")]
    NotFinite {
        /// The message.
        kind: MessageKind,
        /// Which number.
        what: String,
    },
    /// A face that is none.
    #[error("HELLO of the fluid: face {face} {reason}")]
    Face {
        /// Index of the face.
        face: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// An opening that is none.
    #[error("HELLO of the fluid: opening {opening} {reason}")]
    Opening {
        /// Index of the opening.
        opening: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// Driver and fluid mean different problems.
    #[error("driver and fluid do not fit: {0}")]
    Mismatch(String),
    /// The fluid gave up.
    #[error("the fluid reports: {0}")]
    Failure(String),
}

/// The sixteen bytes before the payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WireFrame {
    /// Kind of the message.
    pub kind: MessageKind,
    /// Length of the payload, bytes; not yet checked.
    pub length: u64,
}

impl WireFrame {
    /// Decodes the frame; refuses foreign bytes, other versions and unknown kinds.
    pub fn decode(bytes: &[u8; FRAME_SIZE]) -> Result<Self, ProtocolError> {
        if bytes[..4] != MAGIC {
            return Err(ProtocolError::Foreign);
        }
        let version = u16::from_le_bytes([bytes[4], bytes[5]]);
        if version != VERSION {
            return Err(ProtocolError::Version { found: version });
        }
        let number = u16::from_le_bytes([bytes[6], bytes[7]]);
        let kind = MessageKind::from_number(number).ok_or(ProtocolError::UnknownKind(number))?;
        let mut length = [0; 8];
        length.copy_from_slice(&bytes[8..]);
        Ok(Self {
            kind,
            length: u64::from_le_bytes(length),
        })
    }
}

/// A whole message from its kind and payload.
pub fn message(kind: MessageKind, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(FRAME_SIZE + payload.len());
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(kind as u16).to_le_bytes());
    bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
    bytes.extend_from_slice(payload);
    bytes
}

#[cfg(test)]
mod tests;
