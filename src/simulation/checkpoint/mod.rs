//! Everything that a simulation consists of at the end of a time step, in a file: a run that resumes there repeats the
//! uninterrupted one to the bit.
//!
//! A fluid may keep its state in files of its own; a checkpoint names them with their lengths and checksums
//! ([`FileFingerprint`]), as it does for the tables, and counts as whole only if they all are what they were.

mod store;

pub use store::{Found, Store, StoreError};

use super::clock::ClockReading;
use super::totals::Totals;
use crate::case::CaseIdentity;
use crate::coupling::acceptance::Balance;
use crate::coupling::fixed_point;
use crate::files::FileFingerprint;
use crate::fluid::FluidMemory;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// The state of a simulation after an accepted time step, or before the first; `S` is that of the structure, `O` that
/// of the observer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Checkpoint<S, O> {
    /// The case.
    pub case: CaseIdentity,
    /// The files that the checkpoint stands on.
    pub files: Vec<FileFingerprint>,
    /// Where it is in time.
    pub clock: ClockReading,
    /// The figures so far.
    pub totals: Totals,
    /// The fluid; its files are named from the folder of the run.
    pub fluid: FluidMemory,
    /// The structure.
    pub structure: S,
    /// The coupling.
    pub coupling: fixed_point::FixedPointMemory,
    /// The fluid's mass.
    pub balance: Balance,
    /// Tables and series.
    pub observer: O,
}

impl<S, O> Checkpoint<S, O> {
    /// Number of accepted time steps.
    pub fn step(&self) -> usize {
        self.clock.steps
    }

    /// Time at the end of the last accepted step, s.
    pub fn time(&self) -> f64 {
        self.totals.time_s
    }
}

/// Version of the file format: another one is refused.
const VERSION: u32 = 14;
const MAGIC: &[u8; 8] = b"FSICHECK";
/// Magic, version, checksum and length of what follows.
const HEAD: usize = 8 + 4 + 4 + 8;

/// Why some bytes are not a checkpoint.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DecodeError {
    /// Not a checkpoint at all.
    #[error("it is not a checkpoint")]
    Foreign,
    /// Written by another version of the program.
    #[error("its format is version {found}, this program reads version {VERSION}")]
    Version {
        /// Its version.
        found: u32,
    },
    /// Its end is missing, or something follows.
    #[error("it has {found} bytes instead of {expected}")]
    Length {
        /// Bytes that it should have.
        expected: u64,
        /// Bytes that it has.
        found: u64,
    },
    /// Bytes have changed.
    #[error("its checksum is wrong")]
    Checksum,
    /// It was written wrongly.
    #[error("its contents make no sense: {0}")]
    Contents(String),
}

/// The bytes of a file with these contents, whatever they are.
pub fn with_head(payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + payload.len());
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(crc32fast::hash(payload).to_le_bytes());
    bytes.extend((payload.len() as u64).to_le_bytes());
    bytes.extend(payload);
    bytes
}

impl<S: Serialize, O: Serialize> Checkpoint<S, O> {
    /// The bytes of a file.
    pub fn encode(&self) -> Vec<u8> {
        let payload = postcard::to_stdvec(self).expect("plain data can be written");
        with_head(&payload)
    }
}

impl<S: DeserializeOwned, O: DeserializeOwned> Checkpoint<S, O> {
    /// Reads the bytes of a file, which may be anything.
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        let Some((head, payload)) = bytes.split_at_checked(HEAD) else {
            return Err(DecodeError::Foreign);
        };
        if &head[..8] != MAGIC {
            return Err(DecodeError::Foreign);
        }
        let word =
            |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        if word(8) != VERSION {
            return Err(DecodeError::Version { found: word(8) });
        }
        let expected = u64::from(word(16)) | u64::from(word(20)) << 32;
        let found = payload.len() as u64;
        if found != expected {
            return Err(DecodeError::Length { expected, found });
        }
        if crc32fast::hash(payload) != word(12) {
            return Err(DecodeError::Checksum);
        }
        match postcard::take_from_bytes(payload) {
            Ok((checkpoint, [])) => Ok(checkpoint),
            Ok((_, rest)) => Err(DecodeError::Contents(format!(
                "{} bytes are left over",
                rest.len()
            ))),
            Err(error) => Err(DecodeError::Contents(error.to_string())),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
