use super::*;
use crate::fluid::conversation::protocol::{MessageKind, ToFluid, message};

fn with_patience<T>(limit: Duration, action: impl FnOnce(&mut Patience) -> T) -> T {
    let interrupt = AtomicBool::new(false);
    action(&mut Patience::new(limit, &interrupt, &mut || false))
}

/// A fluid that writes `bytes` and falls silent; what the driver makes of it.
fn hear(bytes: &[u8], expected: Expected) -> Result<FromFluid, TransportError> {
    let listener = Listener::socket().unwrap();
    let mut fluid = UnixStream::connect(listener.address()).unwrap();
    fluid.write_all(bytes).unwrap();
    with_patience(Duration::from_millis(200), |patience| {
        listener.accept(patience)?.receive(expected, patience)
    })
}

#[test]
fn a_message_arrives() {
    let solved = message(MessageKind::Solved, &[0; 48]);
    assert!(matches!(
        hear(&solved, Expected::Solved { faces: 1 }),
        Ok(FromFluid::Solved(_))
    ));
}

#[test]
fn a_promise_of_a_gigabyte_is_not_believed() {
    let mut hello = message(MessageKind::Hello, &[0; 100]);
    hello[8..16].copy_from_slice(&(1_u64 << 30).to_le_bytes());
    assert!(matches!(
        hear(&hello, Expected::Hello),
        Err(TransportError::TimedOut(_))
    ));
    hello[8..16].copy_from_slice(&(1_u64 << 62).to_le_bytes());
    assert!(matches!(
        hear(&hello, Expected::Hello),
        Err(TransportError::Protocol(_))
    ));
}

#[test]
fn a_failure_is_an_error_with_its_text() {
    let error = hear(
        &message(MessageKind::Failure, b"no such patch"),
        Expected::Hello,
    )
    .unwrap_err();
    assert_eq!(error.to_string(), "the fluid reports: no such patch");
}

#[test]
fn a_closed_socket_is_noticed() {
    let listener = Listener::socket().unwrap();
    drop(UnixStream::connect(listener.address()).unwrap());
    let heard = with_patience(Duration::from_secs(5), |patience| {
        listener
            .accept(patience)?
            .receive(Expected::Hello, patience)
    });
    assert!(matches!(heard, Err(TransportError::Closed)));
}

#[test]
fn the_socket_is_private_and_removed_with_the_driver() {
    let listener = Listener::socket().unwrap();
    let address = listener.address();
    let mode = fs::metadata(address.parent().unwrap())
        .unwrap()
        .permissions()
        .mode();
    assert_eq!(mode & 0o777, 0o700);
    drop(listener);
    assert!(!address.parent().unwrap().exists());
}

#[test]
fn files_are_whole_or_not_there() {
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("exchange");
    let listener = Listener::files(&folder).unwrap();
    let mut transport =
        with_patience(Duration::from_secs(1), |patience| listener.accept(patience)).unwrap();
    with_patience(Duration::from_secs(1), |patience| {
        transport.send(&ToFluid::Stop.encode(), patience)
    })
    .unwrap();
    assert_eq!(
        fs::read(folder.join("00000001.driver")).unwrap(),
        ToFluid::Stop.encode()
    );

    let expected = Expected::Solved { faces: 1 };
    let solved = message(MessageKind::Solved, &[0; 48]);
    let mut hear = |limit| with_patience(limit, |patience| transport.receive(expected, patience));
    fs::write(folder.join("00000001.fluid.partial"), &solved[..20]).unwrap();
    assert!(matches!(
        hear(Duration::from_millis(150)),
        Err(TransportError::TimedOut(_))
    ));
    // that wait has used up the first name
    fs::write(folder.join("00000002.fluid"), &solved[..40]).unwrap();
    assert!(
        hear(Duration::from_secs(1))
            .unwrap_err()
            .to_string()
            .contains("SOLVED of the fluid has 24 bytes")
    );
    fs::write(folder.join("00000003.fluid"), &solved).unwrap();
    assert!(hear(Duration::from_secs(1)).is_ok());
    assert!(!folder.join("00000003.fluid").exists());
}
