use super::to_fluid::{put_f64, put_u32, put_vectors};
use super::*;
use crate::Vec3;
use proptest::prelude::*;

fn hello_payload(points: u32, faces: &[&[u32]], centres: u32) -> Vec<u8> {
    let mut payload = Vec::new();
    for number in [0.0, 0.002, 3e-6, 1e-6] {
        put_f64(&mut payload, number);
    }
    let vertices: usize = faces.iter().map(|face| face.len()).sum();
    for n in [points, faces.len() as u32, vertices as u32, 2] {
        put_u32(&mut payload, n);
    }
    put_vectors(
        &mut payload,
        &vec![Vec3::new(1.0, 2.0, 3.0); points as usize],
    );
    for face in faces {
        put_u32(&mut payload, face.len() as u32);
    }
    for vertex in faces.iter().copied().flatten() {
        put_u32(&mut payload, *vertex);
    }
    put_vectors(&mut payload, &vec![Vec3::zeros(); centres as usize]);
    for (flags, name) in [(0, "inlet"), (1, "outlet")] {
        put_opening(&mut payload, flags, name.as_bytes());
    }
    payload
}

fn put_opening(payload: &mut Vec<u8>, flags: u32, name: &[u8]) {
    put_u32(payload, flags);
    put_u32(payload, name.len() as u32);
    payload.extend_from_slice(name);
}

fn decode_hello(payload: &[u8]) -> Result<FromFluid, ProtocolError> {
    Expected::Hello.decode(MessageKind::Hello, payload)
}

#[test]
fn the_welcome_of_the_documentation() {
    let welcome = ToFluid::Welcome {
        start_time: 0.0,
        time_step: 0.002,
        points: 3,
        faces: 1,
        state: &[],
    }
    .encode();
    let hex: Vec<_> = welcome.iter().map(|byte| format!("{byte:02x}")).collect();
    let documented = include_str!("../../../../of-adapter/PROTOCOL.md");
    let start = documented
        .find("46 53 49 50  03 00")
        .expect("the example is there");
    let listed = documented[start..].lines().take(4).flat_map(|line| {
        line.split_whitespace()
            .take_while(|word| word.len() == 2 && u8::from_str_radix(word, 16).is_ok())
    });
    assert_eq!(hex, listed.collect::<Vec<_>>());
}

#[test]
fn a_hello_is_understood() {
    let payload = hello_payload(4, &[&[0, 1, 2], &[0, 1, 2, 3]], 2);
    let FromFluid::Hello(hello) = decode_hello(&payload).unwrap() else {
        panic!("a HELLO")
    };
    assert_eq!(hello.time_step, 0.002);
    assert_eq!(hello.interface.points[3], Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(hello.interface.faces, vec![vec![0, 1, 2], vec![0, 1, 2, 3]]);
    assert_eq!([hello.volume, hello.rigid_volume], [3e-6, 1e-6]);
    let openings = hello.openings.iter().map(|o| (&*o.name, o.has_model));
    assert_eq!(
        openings.collect::<Vec<_>>(),
        [("inlet", false), ("outlet", true)]
    );
}

#[test]
fn a_hello_that_does_not_add_up_is_refused() {
    let refused = |payload: &[u8]| decode_hello(payload).unwrap_err().to_string();
    assert!(refused(&hello_payload(3, &[&[0, 1, 3]], 1)).contains("has vertex 3 of 3 points"));
    assert!(refused(&hello_payload(3, &[&[0, 1]], 1)).contains("at least 3"));
    assert!(refused(&hello_payload(3, &[&[0, 1, 2]], 0)).contains("bytes, expected"));
    // openings
    let good = hello_payload(3, &[&[0, 1, 2]], 1);
    let without = &good[..good.len() - (8 + 5) - (8 + 6)];
    let with = |flags, name: &[u8]| {
        let mut payload = without.to_vec();
        put_opening(&mut payload, 0, b"a");
        put_opening(&mut payload, flags, name);
        refused(&payload)
    };
    assert!(with(2, b"b").contains("opening 1 has unknown flags 2"));
    assert!(with(0, b"").contains("a name of 0 bytes"));
    assert!(with(0, &[b'x'; 65]).contains("a name of 65 bytes"));
    assert!(with(0, b"\x1b[2J").contains("a name that is not text"));
    assert!(with(0, b"\xff").contains("a name that is not text"));
    assert!(refused(without).contains("those of 2 openings"));
    // counts that promise far more than there is
    let mut payload = hello_payload(3, &[&[0, 1, 2]], 1);
    payload[32..36].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refused(&payload).contains("bytes, expected"));
    // sizes of faces whose sum is not the number of vertices
    let mut payload = hello_payload(3, &[&[0, 1, 2], &[0, 1, 2]], 2);
    payload[48 + 72..48 + 76].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refused(&payload).contains("announces 6 vertices"));
}

#[test]
fn non_finite_numbers_are_refused_with_their_place() {
    let mut payload = vec![0; 24];
    put_vectors(
        &mut payload,
        &[Vec3::zeros(), Vec3::new(0.0, f64::NAN, 0.0)],
    );
    let decode =
        |payload: &[u8]| Expected::Solved { faces: 2 }.decode(MessageKind::Solved, payload);
    let error = decode(&payload).unwrap_err();
    assert_eq!(
        error.to_string(),
        "SOLVED of the fluid holds a traction of face 1 that is not finite"
    );
    payload[16..24].copy_from_slice(&f64::INFINITY.to_le_bytes());
    assert!(
        decode(&payload)
            .unwrap_err()
            .to_string()
            .contains("pressure residual")
    );
}

#[test]
fn a_report_holds_openings_wall_shear_and_the_state() {
    let mut payload = Vec::new();
    (1..=9).for_each(|i| put_f64(&mut payload, f64::from(i)));
    let shear = vec![Vec3::new(2.0, 0.0, -2.0); 3];
    put_vectors(&mut payload, &shear);
    let with_vectors = payload.len();
    payload.extend_from_slice(b"a state");
    let expected = |with_state| Expected::Accepted {
        faces: 3,
        openings: 2,
        with_state,
    };
    let check = |with_state, length: usize| {
        let frame = WireFrame {
            kind: MessageKind::Accepted,
            length: length as u64,
        };
        expected(with_state).check(frame).is_ok()
    };
    assert!(check(true, payload.len()) && check(true, with_vectors));
    assert!(check(false, with_vectors) && !check(false, payload.len()));
    assert!(!check(true, with_vectors - 1));
    assert!(!check(true, with_vectors + MAX_STATE as usize + 1));

    let decode = |payload: &[u8]| expected(true).decode(MessageKind::Accepted, payload);
    let FromFluid::Accepted(accepted) = decode(&payload).unwrap() else {
        panic!("a report")
    };
    assert_eq!(accepted.wall_shear, shear);
    assert_eq!(accepted.state, b"a state");
    let second = accepted.openings[1];
    assert_eq!(
        [second.flow, second.mean_pressure, second.model_pressure],
        [7.0, 8.0, 9.0]
    );

    assert!(decode(&payload[..with_vectors - 24]).is_err());
    payload[with_vectors - 8..with_vectors].copy_from_slice(&f64::NAN.to_le_bytes());
    let refused = decode(&payload).unwrap_err().to_string();
    assert!(refused.contains("wall shear stress of face 2"), "{refused}");
}

#[test]
fn frames_that_do_not_belong_are_refused() {
    let frame = |kind: u16, version: u16, length: u64| {
        let mut bytes = [0; FRAME_SIZE];
        bytes[..4].copy_from_slice(b"FSIP");
        bytes[4..6].copy_from_slice(&version.to_le_bytes());
        bytes[6..8].copy_from_slice(&kind.to_le_bytes());
        bytes[8..].copy_from_slice(&length.to_le_bytes());
        bytes
    };
    assert_eq!(
        WireFrame::decode(b"HTTP/1.1 200 OK\r"),
        Err(ProtocolError::Foreign)
    );
    assert_eq!(
        WireFrame::decode(&frame(4, 1, 0)),
        Err(ProtocolError::Version { found: 1 })
    );
    assert_eq!(
        WireFrame::decode(&frame(10, VERSION, 0)),
        Err(ProtocolError::UnknownKind(10))
    );
    let expected = Expected::Solved { faces: 2 };
    assert_eq!(
        expected.check(WireFrame::decode(&frame(4, VERSION, 72)).unwrap()),
        Ok(())
    );
    assert!(
        expected
            .check(WireFrame::decode(&frame(4, VERSION, u64::MAX)).unwrap())
            .is_err()
    );
    assert!(
        expected
            .check(WireFrame::decode(&frame(6, VERSION, 72)).unwrap())
            .is_err()
    );
    assert!(
        expected
            .check(WireFrame::decode(&frame(8, VERSION, 4097)).unwrap())
            .is_err()
    );
    assert!(
        Expected::Hello
            .check(WireFrame::decode(&frame(1, VERSION, MAX_HELLO + 1)).unwrap())
            .is_err()
    );
}

#[test]
fn a_failure_cannot_disturb_a_terminal() {
    let decoded = Expected::Hello.decode(MessageKind::Failure, b"\x1b[2Jgone\xff\nwhy");
    let decoded = decoded.unwrap();
    assert_eq!(
        decoded,
        FromFluid::Failure(" [2Jgone\u{fffd}\nwhy".to_owned())
    );
}

proptest! {
    /// Whatever comes, decoding ends with a value or an error, and a value has as many entries as bytes can hold.
    #[test]
    fn garbage_never_panics(
        number in 0_u16..11,
        payload in prop::collection::vec(any::<u8>(), 0..400),
        faces in 0_usize..8,
        openings in 0_usize..4,
    ) {
        if let Some(kind) = MessageKind::from_number(number) {
            for expected in [
                Expected::Hello,
                Expected::Solved { faces },
                Expected::Accepted { faces, openings, with_state: true },
            ] {
                let _ = expected.decode(kind, &payload);
            }
        }
    }

    /// The same with counts that are plausible, so that the inner parts are reached.
    #[test]
    fn mutilated_hellos_never_panic(at in 0_usize..300, byte in any::<u8>(), cut in 0_usize..300) {
        let mut payload = hello_payload(4, &[&[0, 1, 2], &[0, 1, 2, 3]], 2);
        if at < payload.len() {
            payload[at] = byte;
        }
        payload.truncate(cut.max(1));
        let _ = decode_hello(&payload);
    }

    #[test]
    fn frames_never_panic(bytes in any::<[u8; FRAME_SIZE]>(), faces in 0_usize..1000) {
        if let Ok(frame) = WireFrame::decode(&bytes) {
            let _ = Expected::Accepted { faces, openings: 2, with_state: false }.check(frame);
        }
    }
}
