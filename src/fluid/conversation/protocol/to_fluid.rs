//! What the driver says, and its bytes.

use super::{MAX_FAILURE_TEXT, MessageKind, message};
use crate::Vec3;

/// What the driver says.
#[derive(Debug, Clone, PartialEq)]
pub enum ToFluid<'a> {
    /// The hello was understood; these numbers must be the fluid's own.
    Welcome {
        /// Time at which the run starts, s.
        start_time: f64,
        /// Time step, s.
        time_step: f64,
        /// Points of the interface.
        points: u32,
        /// Faces of the interface.
        faces: u32,
        /// The state to take up, as an ACCEPTED gave it; empty for a fluid that starts as it is.
        state: &'a [u8],
    },
    /// Solve the current time step (or open the next) for a trial displacement.
    Solve {
        /// Most outer correctors before the answer.
        max_correctors: u32,
        /// Start from the fields of the last accepted step instead of the last trial's.
        from_old_state: bool,
        /// Answer earlier once the first pressure residual of a corrector is below this.
        pressure_residual: f64,
        /// Length of the time step, s.
        time_step: f64,
        /// Displacement of the interface's points, m.
        displacement: &'a [Vec3],
    },
    /// Keep the last trial.
    Accept {
        /// Make it a state that can be taken up again.
        write: bool,
    },
    /// A state is not needed any more.
    Discard {
        /// As an ACCEPTED gave it.
        state: &'a [u8],
    },
    /// End.
    Stop,
    /// The driver ends, and why.
    Failure(&'a str),
}

impl ToFluid<'_> {
    /// The whole message.
    pub fn encode(&self) -> Vec<u8> {
        let mut payload = Vec::new();
        let kind = match *self {
            ToFluid::Welcome {
                start_time,
                time_step,
                points,
                faces,
                state,
            } => {
                put_f64(&mut payload, start_time);
                put_f64(&mut payload, time_step);
                put_u32(&mut payload, points);
                put_u32(&mut payload, faces);
                payload.extend_from_slice(state);
                MessageKind::Welcome
            }
            ToFluid::Solve {
                max_correctors,
                from_old_state,
                pressure_residual,
                time_step,
                displacement,
            } => {
                put_u32(&mut payload, max_correctors);
                put_u32(&mut payload, u32::from(from_old_state));
                put_f64(&mut payload, pressure_residual);
                put_f64(&mut payload, time_step);
                put_vectors(&mut payload, displacement);
                MessageKind::Solve
            }
            ToFluid::Accept { write } => {
                put_u32(&mut payload, u32::from(write));
                MessageKind::Accept
            }
            ToFluid::Discard { state } => {
                payload.extend_from_slice(state);
                MessageKind::Discard
            }
            ToFluid::Stop => MessageKind::Stop,
            ToFluid::Failure(text) => {
                let mut end = text.len().min(MAX_FAILURE_TEXT as usize);
                while !text.is_char_boundary(end) {
                    end -= 1;
                }
                payload.extend_from_slice(&text.as_bytes()[..end]);
                MessageKind::Failure
            }
        };
        message(kind, &payload)
    }
}

pub(super) fn put_u32(bytes: &mut Vec<u8>, value: u32) {
    bytes.extend_from_slice(&value.to_le_bytes());
}

pub(super) fn put_f64(bytes: &mut Vec<u8>, value: f64) {
    bytes.extend_from_slice(&value.to_le_bytes());
}

pub(super) fn put_vectors(bytes: &mut Vec<u8>, values: &[Vec3]) {
    bytes.reserve(24 * values.len());
    for component in values.iter().flat_map(|v| v.iter()) {
        put_f64(bytes, *component);
    }
}
