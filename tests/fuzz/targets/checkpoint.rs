//! Checkpoints: as they come, and with a head that is right, so that the contents are reached.
#![no_main]

use fsi_driver::pfem::solution::structure;
use fsi_driver::simulation::checkpoint::{self, with_head};
use libfuzzer_sys::fuzz_target;

type Checkpoint = checkpoint::Checkpoint<structure::StructureMemory, ()>;

fuzz_target!(|bytes: &[u8]| {
    let _ = Checkpoint::decode(bytes);
    let with_head = with_head(bytes);
    if let Ok(checkpoint) = Checkpoint::decode(&with_head) {
        let again = Checkpoint::decode(&checkpoint.encode());
        assert!(again.is_ok(), "what was read can be written: {again:?}");
    }
});
