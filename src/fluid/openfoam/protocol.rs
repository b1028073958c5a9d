//! The messages of `of-adapter/PROTOCOL.md` and their bytes.
//!
//! Nothing that was received is trusted: [`Frame::decode`] looks at the sixteen bytes before the payload,
//! [`Expected::check`] compares the announced length with the one the message must have in this session, and only then
//! is the payload read and decoded, every number of which must be finite.

use crate::Vec3;
use crate::fluid::FluidInterface;

/// Version of `PROTOCOL.md` that this module implements.
pub const VERSION: u16 = 1;
/// Bytes before the payload.
pub const FRAME_SIZE: usize = 16;
/// Longest text of a FAILURE, bytes.
pub const MAX_FAILURE_TEXT: u64 = 4096;
/// Longest HELLO, bytes: a wall of about ten million points.
pub const MAX_HELLO: u64 = 1 << 30;

const MAGIC: [u8; 4] = *b"FSIP";
const HELLO_HEAD: u64 = 32;
const ACCEPTED_HEAD: u64 = 64;
const SOLVED_HEAD: u64 = 24;

/// Kinds of messages by their number on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Kind {
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
}

impl Kind {
    fn from_number(number: u16) -> Option<Self> {
        use Kind::*;
        [
            Hello, Welcome, Solve, Solved, Accept, Accepted, Stop, Failure,
        ]
        .into_iter()
        .find(|&kind| kind as u16 == number)
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&format!("{self:?}").to_uppercase())
    }
}

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
        /// Leave the fields on disk.
        write: bool,
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
            } => {
                put_f64(&mut payload, start_time);
                put_f64(&mut payload, time_step);
                put_u32(&mut payload, points);
                put_u32(&mut payload, faces);
                Kind::Welcome
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
                Kind::Solve
            }
            ToFluid::Accept { write } => {
                put_u32(&mut payload, u32::from(write));
                Kind::Accept
            }
            ToFluid::Stop => Kind::Stop,
            ToFluid::Failure(text) => {
                let mut end = text.len().min(MAX_FAILURE_TEXT as usize);
                while !text.is_char_boundary(end) {
                    end -= 1;
                }
                payload.extend_from_slice(&text.as_bytes()[..end]);
                Kind::Failure
            }
        };
        message(kind, &payload)
    }
}

/// What the fluid says.
#[derive(Debug, Clone, PartialEq)]
pub enum FromFluid {
    /// Who it is.
    Hello(Hello),
    /// Its answer to a trial.
    Solved(Solved),
    /// Its report of a finished step.
    Accepted(Accepted),
    /// Why it ends.
    Failure(String),
}

impl FromFluid {
    /// Its kind.
    pub fn kind(&self) -> Kind {
        match self {
            FromFluid::Hello(_) => Kind::Hello,
            FromFluid::Solved(_) => Kind::Solved,
            FromFluid::Accepted(_) => Kind::Accepted,
            FromFluid::Failure(_) => Kind::Failure,
        }
    }
}

/// The fluid introduces itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Hello {
    /// Time at which it starts, s.
    pub start_time: f64,
    /// Its time step, s.
    pub time_step: f64,
    /// Its wall.
    pub interface: FluidInterface,
}

/// The fluid's answer to a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// Outer correctors that were spent on this trial.
    pub correctors: u32,
    /// Time at the end of the step, s.
    pub time: f64,
    /// First pressure residual of the last corrector.
    pub pressure_residual: f64,
    /// Load on the wall per deformed area, Pa, one vector a face.
    pub tractions: Vec<Vec3>,
}

/// The fluid's report of a finished step; the fields are those of [`crate::fluid::FluidStep`].
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
pub struct Accepted {
    pub time: f64,
    pub inflow: f64,
    pub outflow: f64,
    pub inlet_pressure: f64,
    pub outlet_pressure: f64,
    pub windkessel_pressure: f64,
    pub volume: f64,
    pub wall_velocity_mismatch: f64,
    pub tractions: Vec<Vec3>,
}

/// Why a message was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProtocolError {
    /// Not a message at all.
    #[error("the fluid sent bytes that are no message")]
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
        expected: Kind,
        /// What came.
        found: Kind,
    },
    /// A payload of the wrong length.
    #[error("{kind} of the fluid has {found} bytes, expected {expected}")]
    Length {
        /// The message.
        kind: Kind,
        /// Bytes it must have.
        expected: String,
        /// Bytes it announces or has.
        found: u64,
    },
    /// Infinite or not a number.
    #[error("{kind} of the fluid holds a {what} that is not finite")]
    NotFinite {
        /// The message.
        kind: Kind,
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
    /// Driver and fluid mean different problems.
    #[error("driver and fluid do not fit: {0}")]
    Mismatch(String),
    /// The fluid gave up.
    #[error("the fluid reports: {0}")]
    Failure(String),
}

/// The sixteen bytes before the payload.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// Kind of the message.
    pub kind: Kind,
    /// Length of the payload, bytes; not yet checked.
    pub length: u64,
}

impl Frame {
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
        let kind = Kind::from_number(number).ok_or(ProtocolError::UnknownKind(number))?;
        let mut length = [0; 8];
        length.copy_from_slice(&bytes[8..]);
        Ok(Self {
            kind,
            length: u64::from_le_bytes(length),
        })
    }
}

/// The one message that may come now, apart from FAILURE.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Expected {
    /// At the start.
    Hello,
    /// After SOLVE, for a wall of that many faces.
    Solved {
        /// Faces of the interface.
        faces: usize,
    },
    /// After ACCEPT, for a wall of that many faces.
    Accepted {
        /// Faces of the interface.
        faces: usize,
    },
}

impl Expected {
    fn kind(self) -> Kind {
        match self {
            Expected::Hello => Kind::Hello,
            Expected::Solved { .. } => Kind::Solved,
            Expected::Accepted { .. } => Kind::Accepted,
        }
    }

    /// Refuses a frame whose payload must not be read.
    pub fn check(self, frame: Frame) -> Result<(), ProtocolError> {
        let wrong_length = |expected: String| {
            Err(ProtocolError::Length {
                kind: frame.kind,
                expected,
                found: frame.length,
            })
        };
        if frame.kind == Kind::Failure {
            return if frame.length <= MAX_FAILURE_TEXT {
                Ok(())
            } else {
                wrong_length(format!("at most {MAX_FAILURE_TEXT}"))
            };
        }
        if frame.kind != self.kind() {
            return Err(ProtocolError::Unexpected {
                expected: self.kind(),
                found: frame.kind,
            });
        }
        let exact = match self {
            Expected::Hello if (HELLO_HEAD..=MAX_HELLO).contains(&frame.length) => return Ok(()),
            Expected::Hello => return wrong_length(format!("{HELLO_HEAD} to {MAX_HELLO}")),
            Expected::Solved { faces } => SOLVED_HEAD + 24 * faces as u64,
            Expected::Accepted { faces } => ACCEPTED_HEAD + 24 * faces as u64,
        };
        if frame.length == exact {
            Ok(())
        } else {
            wrong_length(exact.to_string())
        }
    }
}

/// Decodes a payload whose frame has passed [`Expected::check`].
pub fn decode(kind: Kind, payload: &[u8]) -> Result<FromFluid, ProtocolError> {
    let mut reader = Reader {
        kind,
        rest: payload,
        length: payload.len() as u64,
    };
    let message = match kind {
        Kind::Hello => FromFluid::Hello(hello(&mut reader)?),
        Kind::Solved => {
            let correctors = reader.u32()?;
            reader.u32()?;
            let time = reader.f64("time")?;
            let pressure_residual = reader.f64("pressure residual")?;
            let tractions = reader.vectors(reader.rest.len() / 24, "traction of face")?;
            FromFluid::Solved(Solved {
                correctors,
                time,
                pressure_residual,
                tractions,
            })
        }
        Kind::Accepted => FromFluid::Accepted(Accepted {
            time: reader.f64("time")?,
            inflow: reader.f64("inflow")?,
            outflow: reader.f64("outflow")?,
            inlet_pressure: reader.f64("inlet pressure")?,
            outlet_pressure: reader.f64("outlet pressure")?,
            windkessel_pressure: reader.f64("windkessel pressure")?,
            volume: reader.f64("volume")?,
            wall_velocity_mismatch: reader.f64("wall velocity mismatch")?,
            tractions: reader.vectors(reader.rest.len() / 24, "traction of face")?,
        }),
        Kind::Failure => FromFluid::Failure(printable(std::mem::take(&mut reader.rest))),
        kind => {
            return Err(ProtocolError::Unexpected {
                expected: Kind::Solved,
                found: kind,
            });
        }
    };
    if reader.rest.is_empty() {
        Ok(message)
    } else {
        Err(reader.wrong_length("as announced within"))
    }
}

fn hello(reader: &mut Reader) -> Result<Hello, ProtocolError> {
    let start_time = reader.f64("start time")?;
    let time_step = reader.f64("time step")?;
    let [points, faces, vertices, _] = [reader.u32()?, reader.u32()?, reader.u32()?, reader.u32()?];
    let expected =
        HELLO_HEAD + 24 * u64::from(points) + 28 * u64::from(faces) + 4 * u64::from(vertices);
    if reader.length != expected {
        return Err(reader.wrong_length(&expected.to_string()));
    }
    let point_positions = reader.vectors(points as usize, "position of point")?;
    let sizes = (0..faces)
        .map(|_| reader.u32())
        .collect::<Result<Vec<_>, _>>()?;
    if sizes.iter().map(|&size| u64::from(size)).sum::<u64>() != u64::from(vertices) {
        return Err(ProtocolError::Mismatch(format!(
            "HELLO announces {vertices} vertices, its faces have others"
        )));
    }
    let mut faces_of_points = Vec::with_capacity(sizes.len());
    for (face, &size) in sizes.iter().enumerate() {
        let corners = (0..size)
            .map(|_| reader.u32())
            .collect::<Result<Vec<_>, _>>()?;
        if size < 3 {
            return Err(ProtocolError::Face {
                face,
                reason: format!("has {size} vertices, at least 3 are needed"),
            });
        }
        if let Some(vertex) = corners.iter().find(|&&vertex| vertex >= points) {
            return Err(ProtocolError::Face {
                face,
                reason: format!("has vertex {vertex} of {points} points"),
            });
        }
        faces_of_points.push(corners);
    }
    let face_centres = reader.vectors(faces as usize, "centre of face")?;
    let interface = FluidInterface {
        points: point_positions,
        faces: faces_of_points,
        face_centres,
    };
    Ok(Hello {
        start_time,
        time_step,
        interface,
    })
}

/// Text of the other end without what could disturb a terminal.
fn printable(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes)
        .chars()
        .map(|c| if c.is_control() && c != '\n' { ' ' } else { c })
        .collect()
}

struct Reader<'a> {
    kind: Kind,
    rest: &'a [u8],
    length: u64,
}

impl Reader<'_> {
    fn wrong_length(&self, expected: &str) -> ProtocolError {
        ProtocolError::Length {
            kind: self.kind,
            expected: expected.to_owned(),
            found: self.length,
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], ProtocolError> {
        let (bytes, rest) = self
            .rest
            .split_first_chunk::<N>()
            .ok_or_else(|| self.wrong_length("more"))?;
        self.rest = rest;
        Ok(*bytes)
    }

    fn u32(&mut self) -> Result<u32, ProtocolError> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    fn f64(&mut self, what: &str) -> Result<f64, ProtocolError> {
        let value = f64::from_le_bytes(self.take()?);
        if value.is_finite() {
            Ok(value)
        } else {
            Err(ProtocolError::NotFinite {
                kind: self.kind,
                what: what.to_owned(),
            })
        }
    }

    /// `n` must have been compared with the length of the payload.
    fn vectors(&mut self, n: usize, what: &str) -> Result<Vec<Vec3>, ProtocolError> {
        let mut values = Vec::with_capacity(n.min(self.rest.len() / 24));
        for i in 0..n {
            let mut v = Vec3::zeros();
            for d in 0..3 {
                v[d] = f64::from_le_bytes(self.take()?);
            }
            if !v.iter().all(|c| c.is_finite()) {
                return Err(ProtocolError::NotFinite {
                    kind: self.kind,
                    what: format!("{what} {i}"),
                });
            }
            values.push(v);
        }
        Ok(values)
    }
}

/// A whole message from its kind and payload.
pub fn message(kind: Kind, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(FRAME_SIZE + payload.len());
    bytes.extend_from_slice(&MAGIC);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&(kind as u16).to_le_bytes());
    bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
    bytes.extend_from_slice(payload);
    bytes
}

fn put_u32(bytes: &mut Vec<u8>, value: u32) {
    bytes.extend_from_slice(&value.to_le_bytes());
}

fn put_f64(bytes: &mut Vec<u8>, value: f64) {
    bytes.extend_from_slice(&value.to_le_bytes());
}

fn put_vectors(bytes: &mut Vec<u8>, values: &[Vec3]) {
    bytes.reserve(24 * values.len());
    for component in values.iter().flat_map(|v| v.iter()) {
        put_f64(bytes, *component);
    }
}

#[cfg(test)]
mod tests;
