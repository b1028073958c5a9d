//! The input of `fsi-driver solid`.
#![no_main]

use fsi_driver::analysis::solid_file::SolidFile;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &[u8]| {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let file = folder.path().join("solid.toml");
    std::fs::write(&file, text).unwrap();
    if let Err(errors) = SolidFile::load(&file) {
        assert!(!errors.to_string().is_empty());
    }
});
