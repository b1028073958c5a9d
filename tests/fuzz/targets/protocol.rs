//! The stream of bytes that a fluid sends: frames are checked against what may come, payloads decoded.
#![no_main]

use fsi_driver::fluid::conversation::protocol::{Expected, FRAME_SIZE, WireFrame, FromFluid};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut rest = bytes;
    let mut expected = Expected::Hello;
    let (mut faces, mut openings) = (0, 0);
    while let Some((head, after)) = rest.split_first_chunk::<FRAME_SIZE>() {
        let Ok(frame) = WireFrame::decode(head) else { return };
        if expected.check(frame).is_err() {
            return;
        }
        let Some((payload, after)) = after.split_at_checked(frame.length as usize) else {
            return;
        };
        let Ok(message) = expected.decode(frame.kind, payload) else { return };
        expected = match message {
            FromFluid::Hello(hello) => {
                (faces, openings) = (hello.interface.faces.len(), hello.openings.len());
                Expected::Solved { faces }
            }
            FromFluid::Solved(_) => Expected::Accepted { faces, openings, with_state: true },
            FromFluid::Accepted(_) => Expected::Solved { faces },
            FromFluid::Failure(_) => return,
        };
        rest = after;
    }
});
