//! The conversation with a fluid: handshake, then solve and accept.

use super::protocol::{
    Accepted, Expected, FromFluid, Hello, MessageKind, OpeningTerms, ProtocolError, Solved, ToFluid,
};
use super::transport::{Patience, Transport, TransportError};
use crate::Vec3;
use crate::fluid::{FluidEffort, FluidInterface, FluidStep, OpeningReport};
use fsi_numerics::twelve_digits;

/// What the driver knows of the problem before the fluid has said a word.
#[derive(Debug, Clone, PartialEq)]
pub struct Terms {
    /// Time at which the run starts, s.
    pub start_time: f64,
    /// Time step, s.
    pub time_step: f64,
    /// The wall, if the driver made the mesh. Positions may differ by 1e-9 of its largest coordinate.
    pub interface: Option<FluidInterface>,
}

impl Terms {
    /// What of the fluid's HELLO does not fit.
    fn differences(&self, hello: &Hello) -> Vec<String> {
        let mut differences = Vec::new();
        if (hello.start_time - self.start_time).abs() > 1e-6 * self.time_step {
            differences.push(format!(
                "start time {} s here, {} s there",
                self.start_time, hello.start_time
            ));
        }
        if (hello.time_step - self.time_step).abs() > 1e-9 * self.time_step {
            differences.push(format!(
                "time step {} s here, {} s there",
                self.time_step, hello.time_step
            ));
        }
        if let Some(mine) = &self.interface {
            differences.extend(interface_differences(mine, &hello.interface));
        }
        differences
    }
}

fn interface_differences(mine: &FluidInterface, its: &FluidInterface) -> Vec<String> {
    if mine.points.len() != its.points.len() {
        return vec![format!(
            "{} points here, {} there",
            mine.points.len(),
            its.points.len()
        )];
    }
    if mine.faces.len() != its.faces.len() {
        return vec![format!(
            "{} faces here, {} there",
            mine.faces.len(),
            its.faces.len()
        )];
    }
    let size = mine.points.iter().map(|x| x.amax()).fold(0.0, f64::max);
    let mut differences = Vec::new();
    if let Some((i, (a, b))) = mine
        .points
        .iter()
        .zip(&its.points)
        .enumerate()
        .find(|(_, (a, b))| (*a - *b).amax() > 1e-9 * size)
    {
        differences.push(format!(
            "point {i} at ({}, {}, {}) m here, ({}, {}, {}) m there",
            a[0], a[1], a[2], b[0], b[1], b[2]
        ));
    }
    if let Some((i, (a, b))) = mine
        .faces
        .iter()
        .zip(&its.faces)
        .enumerate()
        .find(|(_, (a, b))| a != b)
    {
        differences.push(format!("face {i} with points {a:?} here, {b:?} there"));
    }
    differences
}

/// A connection on which the handshake has succeeded.
pub struct Session {
    transport: Transport,
    interface: FluidInterface,
    openings: Vec<OpeningTerms>,
    volumes: [f64; 2],
}

impl Session {
    /// Hears the fluid's HELLO, compares it with the driver's terms, and answers WELCOME, with the `state` that the
    /// fluid is to take up (empty: the one that it starts in), or FAILURE.
    pub fn shake_hands(
        mut transport: Transport,
        terms: &Terms,
        state: &[u8],
        patience: &mut Patience,
    ) -> Result<Self, TransportError> {
        let heard = hear_hello(&mut transport, terms, patience);
        let hello = or_refuse(heard, &mut transport, patience)?;
        let welcome = ToFluid::Welcome {
            start_time: terms.start_time,
            time_step: terms.time_step,
            points: hello.interface.points.len() as u32,
            faces: hello.interface.faces.len() as u32,
            state,
        };
        transport.send(&welcome.encode(), patience)?;
        Ok(Self {
            transport,
            interface: hello.interface,
            openings: hello.openings,
            volumes: [hello.volume, hello.rigid_volume],
        })
    }

    /// The wall as the fluid sees it.
    pub fn interface(&self) -> &FluidInterface {
        &self.interface
    }

    /// Volumes at the start, m³: of the whole domain, and of the part of it whose wall is rigid.
    pub fn volumes(&self) -> [f64; 2] {
        self.volumes
    }

    /// Sends a trial displacement at the end of a step of the length `time_step` (s) and waits for its tractions.
    pub fn solve(
        &mut self,
        displacement: &[Vec3],
        time_step: f64,
        effort: FluidEffort,
        patience: &mut Patience,
    ) -> Result<Solved, TransportError> {
        if displacement.len() != self.interface.points.len() {
            let (found, expected) = (displacement.len(), self.interface.points.len());
            return Err(ProtocolError::Mismatch(format!(
                "{found} displacements for {expected} points"
            ))
            .into());
        }
        if let Some(i) = displacement
            .iter()
            .position(|u| !u.iter().all(|c| c.is_finite()))
        {
            return Err(ProtocolError::Mismatch(format!(
                "the displacement of point {i} is not finite"
            ))
            .into());
        }
        let solve = ToFluid::Solve {
            max_correctors: effort.max_sweeps.max(1),
            from_old_state: effort.from_old_state,
            pressure_residual: effort.residual,
            time_step,
            displacement,
        };
        self.transport.send(&solve.encode(), patience)?;
        match self.receive(
            Expected::Solved {
                faces: self.interface.faces.len(),
            },
            patience,
        )? {
            FromFluid::Solved(solved) => Ok(solved),
            other => Err(unexpected(MessageKind::Solved, &other)),
        }
    }

    /// Keeps the last trial and waits for the report of the step, and for the state if it is to be made one.
    pub fn accept(
        &mut self,
        write: bool,
        patience: &mut Patience,
    ) -> Result<Accepted, TransportError> {
        self.transport
            .send(&ToFluid::Accept { write }.encode(), patience)?;
        match self.receive(
            Expected::Accepted {
                faces: self.interface.faces.len(),
                openings: self.openings.len(),
                with_state: write,
            },
            patience,
        )? {
            FromFluid::Accepted(accepted) => Ok(accepted),
            other => Err(unexpected(MessageKind::Accepted, &other)),
        }
    }

    /// What ACCEPTED says, in the driver's terms.
    pub fn step(&self, accepted: Accepted) -> FluidStep {
        let openings = self.openings.iter().zip(&accepted.openings);
        let openings = openings.map(|(terms, report)| OpeningReport {
            name: terms.name.clone(),
            flow: report.flow,
            mean_pressure: report.mean_pressure,
            model_pressure: terms.has_model.then_some(report.model_pressure),
        });
        FluidStep {
            time: twelve_digits(accepted.time),
            openings: openings.collect(),
            volume: accepted.volume,
            wall_shear: accepted.wall_shear,
            wall_velocity_mismatch: accepted.wall_velocity_mismatch,
            ..FluidStep::default()
        }
    }

    /// Tells the fluid that a state is not needed any more.
    pub fn discard(&mut self, state: &[u8], patience: &mut Patience) -> Result<(), TransportError> {
        self.transport
            .send(&ToFluid::Discard { state }.encode(), patience)
    }

    /// Sends bytes that need not be a message, to see what the fluid makes of them.
    pub(super) fn send_anything(
        &mut self,
        bytes: &[u8],
        patience: &mut Patience,
    ) -> Result<(), TransportError> {
        self.transport.send(bytes, patience)
    }

    /// Closes the connection without a word.
    pub(super) fn disconnect(&mut self) {
        self.transport.close();
    }

    /// Asks the fluid to end.
    pub fn stop(&mut self, patience: &mut Patience) -> Result<(), TransportError> {
        self.transport.send(&ToFluid::Stop.encode(), patience)
    }

    fn receive(
        &mut self,
        expected: Expected,
        patience: &mut Patience,
    ) -> Result<FromFluid, TransportError> {
        let received = self.transport.receive(expected, patience);
        or_refuse(received, &mut self.transport, patience)
    }
}

fn unexpected(expected: MessageKind, found: &FromFluid) -> TransportError {
    ProtocolError::Unexpected {
        expected,
        found: found.kind(),
    }
    .into()
}

fn hear_hello(
    transport: &mut Transport,
    terms: &Terms,
    patience: &mut Patience,
) -> Result<Hello, TransportError> {
    let hello = match transport.receive(Expected::Hello, patience)? {
        FromFluid::Hello(hello) => hello,
        other => return Err(unexpected(MessageKind::Hello, &other)),
    };
    let differences = terms.differences(&hello);
    if differences.is_empty() {
        Ok(hello)
    } else {
        Err(ProtocolError::Mismatch(differences.join("; ")).into())
    }
}

/// Tells the fluid why, if it broke the protocol.
fn or_refuse<T>(
    result: Result<T, TransportError>,
    transport: &mut Transport,
    patience: &mut Patience,
) -> Result<T, TransportError> {
    if let Err(TransportError::Protocol(error)) = &result
        && !matches!(error, ProtocolError::Failure(_))
    {
        // The fluid may be beyond hearing; the error that is returned says what matters.
        let _ = transport.send(&ToFluid::Failure(&error.to_string()).encode(), patience);
    }
    result
}
