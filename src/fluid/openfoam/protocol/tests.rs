use super::to_fluid::{put_f64, put_u32, put_vectors};
use super::*;
use crate::Vec3;
use proptest::prelude::*;

fn hello_payload(points: u32, faces: &[&[u32]], centres: u32) -> Vec<u8> {
    let mut payload = Vec::new();
    put_f64(&mut payload, 0.0);
    put_f64(&mut payload, 0.002);
    let vertices: usize = faces.iter().map(|face| face.len()).sum();
    for n in [points, faces.len() as u32, vertices as u32, 0] {
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
    payload
}

#[test]
fn the_welcome_of_the_documentation() {
    let welcome = ToFluid::Welcome {
        start_time: 0.0,
        time_step: 0.002,
        points: 3,
        faces: 1,
    }
    .encode();
    let hex: Vec<_> = welcome.iter().map(|byte| format!("{byte:02x}")).collect();
    let documented = include_str!("../../../../of-adapter/PROTOCOL.md");
    let start = documented
        .find("46 53 49 50  02 00")
        .expect("the example is there");
    let listed = documented[start..].lines().take(4).flat_map(|line| {
        line.split_whitespace()
            .take_while(|word| word.len() == 2 && u8::from_str_radix(word, 16).is_ok())
    });
    assert_eq!(hex, listed.collect::<Vec<_>>());
}

#[test]
fn a_hello_is_understood() {
    let FromFluid::Hello(hello) = decode(
        Kind::Hello,
        &hello_payload(4, &[&[0, 1, 2], &[0, 1, 2, 3]], 2),
    )
    .unwrap() else {
        panic!("a HELLO")
    };
    assert_eq!(hello.time_step, 0.002);
    assert_eq!(hello.interface.points[3], Vec3::new(1.0, 2.0, 3.0));
    assert_eq!(hello.interface.faces, vec![vec![0, 1, 2], vec![0, 1, 2, 3]]);
}

#[test]
fn a_hello_that_does_not_add_up_is_refused() {
    let refused = |payload: &[u8]| decode(Kind::Hello, payload).unwrap_err().to_string();
    assert!(refused(&hello_payload(3, &[&[0, 1, 3]], 1)).contains("has vertex 3 of 3 points"));
    assert!(refused(&hello_payload(3, &[&[0, 1]], 1)).contains("at least 3"));
    assert!(refused(&hello_payload(3, &[&[0, 1, 2]], 0)).contains("bytes, expected"));
    // counts that promise far more than there is
    let mut payload = hello_payload(3, &[&[0, 1, 2]], 1);
    payload[16..20].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refused(&payload).contains("bytes, expected"));
    // sizes of faces whose sum is not the number of vertices
    let mut payload = hello_payload(3, &[&[0, 1, 2], &[0, 1, 2]], 2);
    payload[32 + 72..32 + 76].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refused(&payload).contains("announces 6 vertices"));
}

#[test]
fn numbers_that_are_none_are_refused_with_their_place() {
    let mut payload = vec![0; 24];
    put_vectors(
        &mut payload,
        &[Vec3::zeros(), Vec3::new(0.0, f64::NAN, 0.0)],
    );
    let error = decode(Kind::Solved, &payload).unwrap_err();
    assert_eq!(
        error.to_string(),
        "SOLVED of the fluid holds a traction of face 1 that is not finite"
    );
    payload[16..24].copy_from_slice(&f64::INFINITY.to_le_bytes());
    assert!(
        decode(Kind::Solved, &payload)
            .unwrap_err()
            .to_string()
            .contains("pressure residual")
    );
}

#[test]
fn a_report_brings_load_and_wall_shear_of_each_face() {
    let mut payload = Vec::new();
    (1..=8).for_each(|i| put_f64(&mut payload, f64::from(i)));
    let [load, shear] = [1.0, 2.0].map(|x| vec![Vec3::new(x, 0.0, -x); 3]);
    put_vectors(&mut payload, &load);
    put_vectors(&mut payload, &shear);
    let frame = WireFrame {
        kind: Kind::Accepted,
        length: payload.len() as u64,
    };
    assert_eq!(Expected::Accepted { faces: 3 }.check(frame), Ok(()));
    let FromFluid::Accepted(accepted) = decode(Kind::Accepted, &payload).unwrap() else {
        panic!("a report")
    };
    assert_eq!((accepted.tractions, accepted.wall_shear), (load, shear));

    // As many bytes as an odd number of vectors: one of the two fields is too short.
    let refused = decode(Kind::Accepted, &payload[..payload.len() - 24]);
    assert!(refused.is_err());
    let at = payload.len() - 8;
    payload[at..].copy_from_slice(&f64::NAN.to_le_bytes());
    let refused = decode(Kind::Accepted, &payload).unwrap_err().to_string();
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
        WireFrame::decode(&frame(9, VERSION, 0)),
        Err(ProtocolError::UnknownKind(9))
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
    let decoded = decode(Kind::Failure, b"\x1b[2Jgone\xff\nwhy").unwrap();
    assert_eq!(
        decoded,
        FromFluid::Failure(" [2Jgone\u{fffd}\nwhy".to_owned())
    );
}

proptest! {
    /// Whatever comes, decoding ends with a value or an error, and a value has as many entries as bytes can hold.
    #[test]
    fn garbage_never_panics(number in 0_u16..10, payload in prop::collection::vec(any::<u8>(), 0..400)) {
        if let Some(kind) = Kind::from_number(number) {
            let _ = decode(kind, &payload);
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
        let _ = decode(Kind::Hello, &payload);
    }

    #[test]
    fn frames_never_panic(bytes in any::<[u8; FRAME_SIZE]>(), faces in 0_usize..1000) {
        if let Ok(frame) = WireFrame::decode(&bytes) {
            let _ = Expected::Accepted { faces }.check(frame);
        }
    }
}
