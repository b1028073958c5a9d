//! The stream of bytes that a fluid sends: frames are checked against what may come, payloads decoded.
#![no_main]

use fsi_driver::fluid::openfoam::protocol::{Expected, FRAME_SIZE, WireFrame, FromFluid, decode};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut rest = bytes;
    let mut expected = Expected::Hello;
    while let Some((head, after)) = rest.split_first_chunk::<FRAME_SIZE>() {
        let Ok(frame) = WireFrame::decode(head) else { return };
        if expected.check(frame).is_err() {
            return;
        }
        let Some((payload, after)) = after.split_at_checked(frame.length as usize) else {
            return;
        };
        let faces = match decode(frame.kind, payload) {
            Ok(FromFluid::Hello(hello)) => hello.interface.faces.len(),
            Ok(FromFluid::Solved(solved)) => solved.tractions.len(),
            Ok(FromFluid::Accepted(accepted)) => accepted.tractions.len(),
            Ok(FromFluid::Failure(_)) | Err(_) => return,
        };
        expected = match expected {
            Expected::Solved { .. } => Expected::Accepted { faces },
            Expected::Hello | Expected::Accepted { .. } => Expected::Solved { faces },
        };
        rest = after;
    }
});
