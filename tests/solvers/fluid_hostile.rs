//! A hostile driver against the adapter in the real OpenFOAM: whatever it sends, the solver says what is wrong, to it
//! and in the log, and ends.

use crate::fluid_support::*;
use fsi_driver::Vec3;
use fsi_driver::fluid::Fluid;
use fsi_driver::fluid::conversation::protocol::{
    FRAME_SIZE, MessageKind, ToFluid, WireFrame, message,
};
use fsi_driver::fluid::openfoam::Connection;
use fsi_driver::fluid::openfoam::{Programs, install};
use fsi_driver::processes::Process;
use rustix::process::Signal;
use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::time::Duration;

fn read_message(stream: &mut UnixStream) -> Option<(MessageKind, Vec<u8>)> {
    let mut head = [0; FRAME_SIZE];
    stream.read_exact(&mut head).ok()?;
    let frame = WireFrame::decode(&head).unwrap();
    let mut payload = vec![0; frame.length as usize];
    stream.read_exact(&mut payload).ok()?;
    Some((frame.kind, payload))
}

/// Sends `messages` after the HELLO and disconnects if `then_close`; returns the solver's FAILURE (if any) and its log.
fn attack(channel: &Channel, messages: &[Vec<u8>], then_close: bool) -> (String, String) {
    let folder = tempfile::tempdir().unwrap();
    let address = folder.path().join("fluid");
    let listener = UnixListener::bind(&address).unwrap();
    let library = install::check(1).unwrap();
    Connection {
        library: Some(&library),
        transport: "socket",
        address: &address,
        start_time: 0.0,
    }
    .write(channel.case())
    .unwrap();
    let command = Programs::new(channel.case(), &[&library]).command("pimpleFoam");
    let mut process = Process::start(command, &channel.settings.log, Signal::KILL).unwrap();
    let (mut stream, _) = listener.accept().unwrap();
    assert_eq!(read_message(&mut stream).unwrap().0, MessageKind::Hello);
    for message in messages {
        stream.write_all(message).unwrap();
    }
    let mut failure = String::new();
    if then_close {
        drop(stream);
    } else if let Some((kind, payload)) = read_message(&mut stream) {
        assert_eq!(kind, MessageKind::Failure);
        failure = String::from_utf8(payload).unwrap();
    }
    assert!(process.wait(Duration::from_secs(10)), "the solver must end");
    assert!(!process.succeeded());
    (
        failure,
        std::fs::read_to_string(&channel.settings.log).unwrap(),
    )
}

#[test]
#[cfg_attr(not(feature = "openfoam"), ignore = "needs OpenFOAM")]
fn a_hostile_driver_is_refused_with_the_reason() {
    let channel = Channel::new(false);
    let interface = channel.start().interface().clone();
    let (points, faces) = (interface.points.len() as u32, interface.faces.len() as u32);
    let welcome = |time_step, points| {
        ToFluid::Welcome {
            start_time: 0.0,
            time_step,
            points,
            faces,
            state: &[],
        }
        .encode()
    };
    let good = welcome(STEP, points);
    let still = vec![Vec3::zeros(); interface.points.len()];
    let solve = |displacement: &[Vec3], max_correctors, time_step| {
        ToFluid::Solve {
            max_correctors,
            from_old_state: false,
            pressure_residual: 0.0,
            time_step,
            displacement,
        }
        .encode()
    };
    let mut nan = still.clone();
    nan[7][1] = f64::NAN;
    let mut strange_flags = solve(&still, 1, STEP);
    strange_flags[FRAME_SIZE + 4] = 0x80;
    let with = |at: usize, byte: u8| {
        let mut message = good.clone();
        message[at] = byte;
        message
    };
    let cases: Vec<(Vec<Vec<u8>>, &str)> = vec![
        (
            vec![b"GET / HTTP/1.1\r\nHost: here\r\n\r\n".to_vec()],
            "bytes that are not a message",
        ),
        (
            vec![with(4, 1)],
            "speaks protocol version 1, this adapter speaks 3",
        ),
        (vec![with(6, 77)], "unknown kind 77"),
        (
            vec![with(14, 0x40)],
            "expected the driver's WELCOME of 24 bytes",
        ),
        (vec![with(FRAME_SIZE + 7, 0x7f), vec![]], "start time"),
        (
            vec![welcome(0.001, points)],
            "time step 0.001 s there, 0.002 s here",
        ),
        (
            vec![welcome(f64::NAN, points)],
            "time step that is not finite",
        ),
        (vec![welcome(STEP, points + 1)], "points there"),
        (
            vec![message(MessageKind::Failure, b"changed my mind")],
            "changed my mind",
        ),
        (
            vec![good.clone(), ToFluid::Accept { write: true }.encode()],
            "ACCEPT between two time steps",
        ),
        (
            vec![good.clone(), message(MessageKind::Hello, &[])],
            "HELLO between two time steps",
        ),
        (
            vec![good.clone(), solve(&nan, 1, STEP)],
            "displacement of point 7 whose component y is not finite",
        ),
        (
            vec![good.clone(), solve(&still[1..], 1, STEP)],
            "bytes, expected",
        ),
        (vec![good.clone(), solve(&still, 0, STEP)], "0 correctors"),
        (
            vec![good.clone(), solve(&still, 1, -1.0)],
            "time step of -1 s",
        ),
        (
            vec![good.clone(), strange_flags],
            "flags that this version does not know",
        ),
    ];
    for (messages, reason) in cases {
        let (failure, log) = attack(&channel, &messages, false);
        assert!(
            failure.contains(reason),
            "to the driver: '{failure}', expected '{reason}'"
        );
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            words(&log).contains(&words(reason)),
            "in the log: '{reason}'\n{log}"
        );
    }
    for messages in [
        vec![],
        vec![good.clone()],
        vec![good[..10].to_vec()],
        vec![good.clone(), vec![b'F'; 3]],
    ] {
        let (_, log) = attack(&channel, &messages, true);
        assert!(
            log.contains("the driver has closed the connection"),
            "{log}"
        );
    }
}
