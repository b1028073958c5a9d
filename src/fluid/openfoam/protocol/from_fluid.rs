//! What the fluid says: what may come when, and how its bytes are read.

use super::{Kind, MAX_FAILURE_TEXT, ProtocolError, WireFrame};
use crate::Vec3;
use crate::fluid::FluidInterface;

/// Longest HELLO, bytes: a wall of about ten million points.
pub const MAX_HELLO: u64 = 1 << 30;

const HELLO_HEAD: u64 = 32;
const ACCEPTED_HEAD: u64 = 64;
const SOLVED_HEAD: u64 = 24;

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
    pub wall_shear: Vec<Vec3>,
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
    pub fn check(self, frame: WireFrame) -> Result<(), ProtocolError> {
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
            Expected::Accepted { faces } => ACCEPTED_HEAD + 48 * faces as u64,
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
            tractions: reader.vectors(reader.rest.len() / 48, "traction of face")?,
            wall_shear: reader.vectors(
                payload.len().saturating_sub(ACCEPTED_HEAD as usize) / 48,
                "wall shear stress of face",
            )?,
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
