//! Checkpoints: as they come, and with a head that is right, so that the contents are reached.
#![no_main]

use fsi_driver::checkpoint::Checkpoint;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = Checkpoint::decode(bytes);
    let with_head = Checkpoint::with_head(bytes);
    if let Ok(checkpoint) = Checkpoint::decode(&with_head) {
        let again = Checkpoint::decode(&checkpoint.encode());
        assert!(again.is_ok(), "what was read can be written: {again:?}");
    }
});
