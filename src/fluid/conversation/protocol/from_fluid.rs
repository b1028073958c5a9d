//! What the fluid says: what may come when, and how its bytes are read.

use super::{MAX_FAILURE_TEXT, MessageKind, ProtocolError, WireFrame};
use crate::Vec3;
use crate::fluid::FluidInterface;

/// Longest HELLO, bytes: a wall of about ten million points.
pub const MAX_HELLO: u64 = 1 << 30;

/// Longest state that a fluid may hand over, bytes.
pub const MAX_STATE: u64 = 1 << 28;

const HELLO_HEAD: u64 = 48;
const ACCEPTED_HEAD: u64 = 24;
const OF_AN_OPENING: u64 = 24;
const SOLVED_HEAD: u64 = 24;
/// Most openings, and most bytes of the name of one.
const MAX_OPENINGS: u32 = 64;
const MAX_NAME: u32 = 64;
/// Flag of an opening: a model with a pressure of its own is downstream of it.
const HAS_MODEL: u32 = 1;

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
    pub fn kind(&self) -> MessageKind {
        match self {
            FromFluid::Hello(_) => MessageKind::Hello,
            FromFluid::Solved(_) => MessageKind::Solved,
            FromFluid::Accepted(_) => MessageKind::Accepted,
            FromFluid::Failure(_) => MessageKind::Failure,
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
    /// Volume of its whole domain at the start, m³.
    pub volume: f64,
    /// Volume of the part of it whose wall is rigid, m³.
    pub rigid_volume: f64,
    /// Its wall.
    pub interface: FluidInterface,
    /// Where it enters or leaves its domain, the inlet first.
    pub openings: Vec<OpeningTerms>,
}

/// An opening of the fluid, as HELLO introduces it.
#[derive(Debug, Clone, PartialEq)]
pub struct OpeningTerms {
    /// Its name.
    pub name: String,
    /// Whether a model with a pressure of its own, such as a windkessel, is downstream of it.
    pub has_model: bool,
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
    pub volume: f64,
    pub wall_velocity_mismatch: f64,
    /// In the order of HELLO.
    pub openings: Vec<OpeningReport>,
    pub wall_shear: Vec<Vec3>,
    /// With this the fluid can be taken up again at the end of the step; empty if it was not asked for.
    pub state: Vec<u8>,
}

/// What ACCEPTED says of an opening; the fields are those of [`crate::fluid::OpeningReport`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct OpeningReport {
    pub flow: f64,
    pub mean_pressure: f64,
    /// Zero without a model.
    pub model_pressure: f64,
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
        /// Openings.
        openings: usize,
        /// Whether a state was asked for.
        with_state: bool,
    },
}

impl Expected {
    fn kind(self) -> MessageKind {
        match self {
            Expected::Hello => MessageKind::Hello,
            Expected::Solved { .. } => MessageKind::Solved,
            Expected::Accepted { .. } => MessageKind::Accepted,
        }
    }

    /// Refuses a frame whose payload must not be read.
    pub fn check(self, frame: WireFrame) -> Result<(), ProtocolError> {
        let wrong_length = |expected: String| {
            Err(ProtocolError::Length {
                kind: frame.kind,
                expected,
                found: frame.length,
            })
        };
        if frame.kind == MessageKind::Failure {
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
            Expected::Accepted {
                faces,
                openings,
                with_state,
            } => {
                let least = ACCEPTED_HEAD + OF_AN_OPENING * openings as u64 + 24 * faces as u64;
                if with_state && (least..=least + MAX_STATE).contains(&frame.length) {
                    return Ok(());
                }
                least
            }
        };
        if frame.length == exact {
            Ok(())
        } else {
            wrong_length(exact.to_string())
        }
    }
}

impl Expected {
    /// Decodes the payload of a message that has passed [`Expected::check`].
    pub fn decode(self, kind: MessageKind, payload: &[u8]) -> Result<FromFluid, ProtocolError> {
        let mut reader = Reader {
            kind,
            rest: payload,
            length: payload.len() as u64,
        };
        let message = match (kind, self) {
            (MessageKind::Failure, _) => {
                FromFluid::Failure(printable(std::mem::take(&mut reader.rest)))
            }
            (MessageKind::Hello, Expected::Hello) => FromFluid::Hello(hello(&mut reader)?),
            (MessageKind::Solved, Expected::Solved { faces }) => {
                let correctors = reader.u32()?;
                reader.u32()?;
                FromFluid::Solved(Solved {
                    correctors,
                    time: reader.f64("time")?,
                    pressure_residual: reader.f64("pressure residual")?,
                    tractions: reader.vectors(faces, "traction of face")?,
                })
            }
            (
                MessageKind::Accepted,
                Expected::Accepted {
                    faces, openings, ..
                },
            ) => FromFluid::Accepted(accepted(&mut reader, faces, openings)?),
            (found, expected) => {
                return Err(ProtocolError::Unexpected {
                    expected: expected.kind(),
                    found,
                });
            }
        };
        if reader.rest.is_empty() {
            Ok(message)
        } else {
            Err(reader.wrong_length("as announced within"))
        }
    }
}

fn accepted(reader: &mut Reader, faces: usize, openings: usize) -> Result<Accepted, ProtocolError> {
    Ok(Accepted {
        time: reader.f64("time")?,
        volume: reader.f64("volume")?,
        wall_velocity_mismatch: reader.f64("wall velocity mismatch")?,
        openings: (0..openings)
            .map(|i| {
                Ok(OpeningReport {
                    flow: reader.f64(&format!("flow of opening {i}"))?,
                    mean_pressure: reader.f64(&format!("mean pressure of opening {i}"))?,
                    model_pressure: reader.f64(&format!("model pressure of opening {i}"))?,
                })
            })
            .collect::<Result<_, ProtocolError>>()?,
        wall_shear: reader.vectors(faces, "wall shear stress of face")?,
        state: std::mem::take(&mut reader.rest).to_vec(),
    })
}

fn hello(reader: &mut Reader) -> Result<Hello, ProtocolError> {
    let start_time = reader.f64("start time")?;
    let time_step = reader.f64("time step")?;
    let volume = reader.f64("volume")?;
    let rigid_volume = reader.f64("rigid volume")?;
    let [points, faces, vertices, openings] =
        [reader.u32()?, reader.u32()?, reader.u32()?, reader.u32()?];
    let least =
        HELLO_HEAD + 24 * u64::from(points) + 28 * u64::from(faces) + 4 * u64::from(vertices);
    if openings > MAX_OPENINGS || reader.length < least + 8 * u64::from(openings) {
        return Err(reader.wrong_length(&format!(
            "{least} and those of {openings} openings, at most {MAX_OPENINGS}"
        )));
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
    let openings = (0..openings as usize)
        .map(|i| opening(reader, i))
        .collect::<Result<Vec<_>, _>>()?;
    let interface = FluidInterface {
        points: point_positions,
        faces: faces_of_points,
        face_centres,
    };
    Ok(Hello {
        start_time,
        time_step,
        volume,
        rigid_volume,
        interface,
        openings,
    })
}

fn opening(reader: &mut Reader, opening: usize) -> Result<OpeningTerms, ProtocolError> {
    let refused = |reason: String| ProtocolError::Opening { opening, reason };
    let flags = reader.u32()?;
    if flags & !HAS_MODEL != 0 {
        return Err(refused(format!("has unknown flags {flags}")));
    }
    let length = reader.u32()?;
    if !(1..=MAX_NAME).contains(&length) {
        return Err(refused(format!(
            "has a name of {length} bytes, expected 1 to {MAX_NAME}"
        )));
    }
    let name = std::str::from_utf8(reader.bytes(length as usize)?)
        .ok()
        .filter(|name| !name.chars().any(char::is_control));
    let name = name.ok_or_else(|| refused("has a name that is not text".into()))?;
    Ok(OpeningTerms {
        name: name.to_owned(),
        has_model: flags & HAS_MODEL != 0,
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
    kind: MessageKind,
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

    fn bytes(&mut self, n: usize) -> Result<&[u8], ProtocolError> {
        let (bytes, rest) = self
            .rest
            .split_at_checked(n)
            .ok_or_else(|| self.wrong_length("more"))?;
        self.rest = rest;
        Ok(bytes)
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
